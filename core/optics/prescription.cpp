// SPDX-License-Identifier: Apache-2.0
#include "core/optics/prescription.h"

namespace flare {

namespace {

double CurvatureOf(double radius_mm) {
    return radius_mm == 0.0 ? 0.0 : 1.0 / radius_mm;
}

}  // namespace

std::string_view KindName(SurfaceKind kind) {
    switch (kind) {
        case SurfaceKind::kSphere:
            return "sphere";
        case SurfaceKind::kPlane:
            return "plane";
        case SurfaceKind::kAsphere:
            return "asphere";
        case SurfaceKind::kCylinderX:
            return "cylinder_x";
        case SurfaceKind::kCylinderY:
            return "cylinder_y";
        case SurfaceKind::kToroid:
            return "toroid";
        case SurfaceKind::kStop:
            return "stop";
        case SurfaceKind::kSensor:
            return "sensor";
    }
    return "sphere";
}

SurfaceShape ShapeOf(const SurfacePrescription& from) {
    const double curvature = CurvatureOf(from.radius_mm);
    switch (from.kind) {
        case SurfaceKind::kSphere:
            return SurfaceShape::Sphere(curvature);
        case SurfaceKind::kAsphere:
            return SurfaceShape::Asphere(curvature, from.conic, from.asphere);
        case SurfaceKind::kCylinderX:
            return SurfaceShape::CylinderX(curvature);
        case SurfaceKind::kCylinderY:
            return SurfaceShape::CylinderY(curvature);
        case SurfaceKind::kToroid:
            return SurfaceShape::Toroid(CurvatureOf(from.radius_x_mm),
                                        CurvatureOf(from.radius_y_mm));
        case SurfaceKind::kPlane:
        case SurfaceKind::kStop:
        case SurfaceKind::kSensor:
            break;
    }
    return {};
}

}  // namespace flare
