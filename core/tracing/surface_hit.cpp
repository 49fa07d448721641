// SPDX-License-Identifier: Apache-2.0
//
// For a quadric Q(p) = c (x^2 + y^2 + (1 + k) z^2) - 2 z the line p' + t d gives
// A t^2 - 2 G t + F = 0, and where it crosses, -grad Q . d / 2 = G - A t = s sqrt(G^2 - A F) with
// s = +1 for a crossing from front to back. That is both the choice of the root and, divided by the
// length of the gradient, the cosine of incidence without cancellation. A cylinder is the same in
// the plane of its curvature.
#include "core/tracing/surface_hit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace flare {

namespace {

// The root of A t^2 - 2 G t + F = 0 where G - A t = s sqrt(G^2 - A F); and that square root.
struct Root {
    bool real = false;
    double t = 0.0;
    double crossing = 0.0;
};

Root Solve(double a, double g, double f, bool forward) {
    Root root;
    const double discriminant = g * g - a * f;
    if (!(discriminant >= 0.0)) return root;
    root.crossing = forward ? std::sqrt(discriminant) : -std::sqrt(discriminant);
    // Of the two forms of the root the one that adds numbers of equal sign.
    const bool same_sign = (g >= 0.0) == (root.crossing >= 0.0);
    const double denominator = same_sign ? g + root.crossing : a;
    if (denominator == 0.0) return root;
    root.t = same_sign ? f / denominator : (g - root.crossing) / denominator;
    root.real = std::isfinite(root.t);
    return root;
}

bool Finite(const Vec3d& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

SurfaceHit MeetQuadric(double c, double conic, bool forward, const Vec3d& p, const Vec3d& d) {
    SurfaceHit hit;
    const double k1 = 1.0 + conic;
    const double t0 = -p.dot(d);
    const Vec3d q = p + d * t0;  // nearest to the vertex
    // q.d vanishes but for rounding; keeping it makes G exact for far origins.
    const double g = d.z - c * (q.x * d.x + q.y * d.y + k1 * q.z * d.z);
    const double f = c * (q.x * q.x + q.y * q.y + k1 * q.z * q.z) - 2.0 * q.z;
    const Root root = Solve(c * (1.0 + conic * d.z * d.z), g, f, forward);
    if (!root.real) return hit;
    hit.distance = t0 + root.t;
    hit.point = q + d * root.t;
    hit.normal = Vec3d(-c * hit.point.x, -c * hit.point.y, 1.0 - c * k1 * hit.point.z);
    hit.cosine = root.crossing;
    // Beyond the equator, and on the other sheet of a hyperboloid, is no lens.
    if (!(hit.normal.z > 0.0)) return hit;
    if (conic != 0.0) {
        const double length = hit.normal.length();
        hit.normal /= length;
        hit.cosine /= length;
    }
    hit.met = std::isfinite(hit.distance) && Finite(hit.point);
    return hit;
}

// `axis` is the coordinate in which the cylinder is curved: 0 for x, 1 for y.
SurfaceHit MeetCylinder(double c, int axis, bool forward, const Vec3d& p, const Vec3d& d) {
    SurfaceHit hit;
    const double along2 = d[axis] * d[axis] + d.z * d.z;
    if (along2 == 0.0) return hit;
    const double t0 = -(p[axis] * d[axis] + p.z * d.z) / along2;
    const Vec3d q = p + d * t0;
    const double g = d.z - c * (q[axis] * d[axis] + q.z * d.z);
    const double f = c * (q[axis] * q[axis] + q.z * q.z) - 2.0 * q.z;
    const Root root = Solve(c * along2, g, f, forward);
    if (!root.real) return hit;
    hit.distance = t0 + root.t;
    hit.point = q + d * root.t;
    hit.normal = Vec3d(0.0, 0.0, 1.0 - c * hit.point.z);
    hit.normal[axis] = -c * hit.point[axis];
    hit.cosine = root.crossing;
    hit.met = hit.normal.z > 0.0 && std::isfinite(hit.distance) && Finite(hit.point);
    return hit;
}

// ---- Surfaces given by their sag ----

// Height of the line above the surface, and how fast it grows along the line.
struct Height {
    double value = 0.0, rate = 0.0;
};

class SagSearch {
  public:
    SagSearch(const SurfaceShape& shape, double semi_diameter_mm, bool forward, const Vec3d& p,
              const Vec3d& d)
        : shape_(shape),
          semi_(semi_diameter_mm),
          forward_(forward),
          t0_(-p.dot(d)),
          p_(p + d * t0_),
          d_(d) {}

    SurfaceHit Run() {
        double t = StartingPoint();
        if (!Newton(t) && !Search(t)) return {};
        return HitAt(t);
    }

  private:
    // The conic, or the sphere between a toroid's two curvatures; else the tangent plane.
    double StartingPoint() const {
        const double c = 0.5 * (shape_.curvature_x() + shape_.curvature_y());
        const SurfaceHit near = MeetQuadric(c, shape_.conic(), forward_, p_, d_);
        if (near.met) return near.distance;
        return d_.z != 0.0 ? -p_.z / d_.z : 0.0;
    }

    Height At(double t) const {
        const Vec3d q = p_ + d_ * t;
        const Vec2d slope = shape_.Slope(q.x, q.y);
        return {q.z - shape_.Sag(q.x, q.y), d_.z - slope.x * d_.x - slope.y * d_.y};
    }

    bool RightWay(double rate) const { return forward_ ? rate > 0.0 : rate < 0.0; }

    // True if t has become a root, crossed the right way, as exact as doubles allow.
    bool Newton(double& t) const {
        constexpr int kSteps = 30;
        Height height = At(t);
        if (std::isnan(height.value)) return false;
        for (int step = 0; step < kSteps; ++step) {
            if (!RightWay(height.rate) || std::abs(height.rate) < 1e-6) return false;
            double move = -height.value / height.rate;
            // Into the domain, and never uphill.
            Height next = At(t + move);
            for (int halving = 0; halving < 8 && !(std::abs(next.value) <= std::abs(height.value));
                 ++halving) {
                if (std::abs(height.value) < kSettled_mm) return true;
                move *= 0.5;
                next = At(t + move);
            }
            if (!(std::abs(next.value) <= std::abs(height.value))) return false;
            const bool settled =
                std::abs(next.value) < kSettled_mm && std::abs(move) < 4.0 * kSettled_mm;
            t += move;
            height = next;
            if (settled || height.value == 0.0) return RightWay(height.rate);
        }
        return std::abs(height.value) < kSettled_mm && RightWay(height.rate);
    }

    // Looks along the part of the line that is near the surface for the crossing nearest to t.
    bool Search(double& t) const {
        double lo = 0.0, hi = 0.0;
        if (!Interval(lo, hi)) return false;
        constexpr int kSteps = 128;
        std::optional<double> best;
        double before_t = lo;
        Height before = At(lo);
        for (int i = 1; i <= kSteps; ++i) {
            const double now_t = lo + (hi - lo) * i / kSteps;
            const Height now = At(now_t);
            // A line that grazes the surface crosses it twice within a step: look where it turns.
            if (before.rate * now.rate < 0.0) {
                const double turn_t = TurnBetween(before_t, now_t, before.rate > 0.0);
                const double turn = At(turn_t).value;
                Consider(before_t, before.value, turn_t, turn, t, best);
                Consider(turn_t, turn, now_t, now.value, t, best);
            } else {
                Consider(before_t, before.value, now_t, now.value, t, best);
            }
            before_t = now_t;
            before = now;
        }
        if (best) t = *best;
        return best.has_value();
    }

    // Is there a crossing between these, and is it nearer to t than the best one so far?
    void Consider(double lo, double at_lo, double hi, double at_hi, double t,
                  std::optional<double>& best) const {
        const bool crosses = forward_ ? at_lo <= 0.0 && at_hi > 0.0 : at_lo >= 0.0 && at_hi < 0.0;
        if (!crosses) return;
        const double root = Bisect(lo, hi);
        if (!best || std::abs(root - t) < std::abs(*best - t)) best = root;
    }

    // Where the height above the surface stops rising (or falling).
    double TurnBetween(double lo, double hi, bool rises) const {
        for (int i = 0; i < kHalvings; ++i) {
            const double mid = 0.5 * (lo + hi);
            ((At(mid).rate > 0.0) == rises ? lo : hi) = mid;
        }
        return 0.5 * (lo + hi);
    }

    double Bisect(double lo, double hi) const {
        for (int i = 0; i < kHalvings; ++i) {
            const double mid = 0.5 * (lo + hi);
            ((At(mid).value > 0.0) == forward_ ? hi : lo) = mid;
        }
        return 0.5 * (lo + hi);
    }

    // The part of the line within a cylinder around the clear aperture, between the planes that
    // bound the sag there.
    bool Interval(double& lo, double& hi) const {
        const double radius = std::min(1.25 * semi_, shape_.reach_mm() * (1.0 - 1e-9));
        lo = -std::numeric_limits<double>::infinity();
        hi = -lo;
        const double a = d_.x * d_.x + d_.y * d_.y;
        const double b = p_.x * d_.x + p_.y * d_.y;
        const double c = p_.x * p_.x + p_.y * p_.y - radius * radius;
        if (a > 0.0) {
            const double discriminant = b * b - a * c;
            if (!(discriminant > 0.0)) return false;
            lo = (-b - std::sqrt(discriminant)) / a;
            hi = (-b + std::sqrt(discriminant)) / a;
        } else if (c > 0.0) {
            return false;
        }
        const std::array<double, 2> sag = shape_.SagRange(radius);
        const double margin = 0.05 * (sag[1] - sag[0]) + 1e-6;
        if (d_.z != 0.0) {
            const double t0 = (sag[0] - margin - p_.z) / d_.z;
            const double t1 = (sag[1] + margin - p_.z) / d_.z;
            lo = std::max(lo, std::min(t0, t1));
            hi = std::min(hi, std::max(t0, t1));
        }
        return lo < hi && std::isfinite(lo) && std::isfinite(hi);
    }

    SurfaceHit HitAt(double t) const {
        SurfaceHit hit;
        hit.distance = t0_ + t;
        hit.point = p_ + d_ * t;
        const Vec2d slope = shape_.Slope(hit.point.x, hit.point.y);
        hit.normal = Vec3d(-slope.x, -slope.y, 1.0).normalized();
        hit.cosine = hit.normal.dot(d_);
        hit.met = std::isfinite(hit.distance) && std::isfinite(hit.cosine) && Finite(hit.point);
        return hit;
    }

    static constexpr double kSettled_mm = 1e-12;
    static constexpr int kHalvings = 80;  // from a step of the search to beyond the last digit

    const SurfaceShape& shape_;
    double semi_;
    bool forward_;
    double t0_;  // of the line's point nearest to the vertex, from which t counts here: a far
    Vec3d p_;    // origin costs no digits
    Vec3d d_;
};

}  // namespace

SurfaceHit MeetSurface(const SurfaceShape& shape, double semi_diameter_mm, bool forward,
                       const Vec3d& p, const Vec3d& d) {
    switch (shape.form()) {
        case SurfaceForm::kQuadric:
            return MeetQuadric(shape.curvature_x(), shape.conic(), forward, p, d);
        case SurfaceForm::kCylinderX:
            return MeetCylinder(shape.curvature_x(), 0, forward, p, d);
        case SurfaceForm::kCylinderY:
            return MeetCylinder(shape.curvature_y(), 1, forward, p, d);
        case SurfaceForm::kAsphere:
        case SurfaceForm::kToroid:
            break;
    }
    return SagSearch(shape, semi_diameter_mm, forward, p, d).Run();
}

}  // namespace flare
