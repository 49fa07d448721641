// SPDX-License-Identifier: Apache-2.0
#include "core/base/chromaticities.h"

namespace flare {
namespace {

struct Matrix {
    Vec3d row[3];

    Vec3d operator*(const Vec3d& v) const { return {row[0].dot(v), row[1].dot(v), row[2].dot(v)}; }
    Vec3d Column(int c) const { return {row[0][c], row[1][c], row[2][c]}; }
    Matrix operator*(const Matrix& m) const {
        Matrix product;
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) product.row[r][c] = row[r].dot(m.Column(c));
        }
        return product;
    }
    // Cramer's rule.
    Matrix Inverse() const {
        const Vec3d a = Column(0), b = Column(1), c = Column(2);
        const double volume = a.dot(b.cross(c));
        return {{b.cross(c) / volume, c.cross(a) / volume, a.cross(b) / volume}};
    }
};

Matrix Diagonal(const Vec3d& d) {
    return {{{d.x, 0.0, 0.0}, {0.0, d.y, 0.0}, {0.0, 0.0, d.z}}};
}

// XYZ with Y = 1.
Vec3d XyzOf(const Vec2d& xy) {
    return {xy.x / xy.y, 1.0, (1.0 - xy.x - xy.y) / xy.y};
}

// SMPTE RP 177: columns are the primaries, scaled so that (1, 1, 1) is the white.
Matrix XyzFromRgb(const Chromaticities& space) {
    const auto column = [](const Vec2d& xy) { return Vec3d(xy.x, xy.y, 1.0 - xy.x - xy.y); };
    const Vec3d r = column(space.red), g = column(space.green), b = column(space.blue);
    const Matrix primaries{{{r.x, g.x, b.x}, {r.y, g.y, b.y}, {r.z, g.z, b.z}}};
    return primaries * Diagonal(primaries.Inverse() * XyzOf(space.white));
}

Matrix Bradford(const Vec2d& from_white, const Vec2d& to_white) {
    const Matrix cones{
        {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};
    const Vec3d from = cones * XyzOf(from_white);
    const Vec3d to = cones * XyzOf(to_white);
    return cones.Inverse() * Diagonal({to.x / from.x, to.y / from.y, to.z / from.z}) * cones;
}

}  // namespace

const Chromaticities& Rec709Chromaticities() {
    static const Chromaticities space{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
    return space;
}

const Chromaticities& Ap0Chromaticities() {
    static const Chromaticities space{
        {0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, {0.32168, 0.33767}};
    return space;
}

const Chromaticities& Ap1Chromaticities() {
    static const Chromaticities space{
        {0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};
    return space;
}

RgbMap::RgbMap(const Chromaticities& from, const Chromaticities& to) {
    const Matrix map = XyzFromRgb(to).Inverse() * Bradford(from.white, to.white) * XyzFromRgb(from);
    for (int r = 0; r < 3; ++r) row_[r] = map.row[r];
}

}  // namespace flare
