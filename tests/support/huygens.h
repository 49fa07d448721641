// SPDX-License-Identifier: Apache-2.0
//
// Brute-force diffraction at the iris in the meridional plane: Huygens' sum over a line of places
// in the stop, each with the optical path of the exact rays that come to it from the light and go
// on from it through the rest of the ghost to one place on the sensor. No ABCD matrix, no Fresnel
// number.
#pragma once

#include <cmath>
#include <complex>
#include <optional>
#include <vector>

#include "core/base/units.h"
#include "core/tracing/stop_jacobian.h"

namespace flare::testing {

class MeridionalHuygens {
  public:
    MeridionalHuygens(const Lens& lens, const BounceSequence& sequence, std::size_t crossing,
                      double field_rad, double wavelength_nm)
        : list_(WriteOut(lens, sequence, wavelength_nm)),
          passage_(list_, crossing),
          bundle_(lens, field_rad, 0.0),
          k_per_mm_(2.0 * kPi / (wavelength_nm * 1e-6)) {}

    // The ray of the light that crosses the stop at x = stop_mm; y = 0 throughout.
    std::optional<double> PupilOf(double stop_mm) const {
        for (const double start :
             {bundle_.centre_u(), bundle_.centre_u() + 2.0, bundle_.centre_u() - 2.0}) {
            double u = start;
            for (int step = 0; step < 40; ++step) {
                const auto here = passage_.Trace(bundle_.At(u, 0.0));
                const auto next = passage_.Trace(bundle_.At(u + 1e-4, 0.0));
                if (!here || !next) break;
                const double miss = here->stop_mm.x - stop_mm;
                if (std::abs(miss) < 1e-11) return u;
                u -= miss / ((next->stop_mm.x - here->stop_mm.x) / 1e-4);
            }
        }
        return std::nullopt;
    }
    std::optional<StopJacobian> JacobianAt(double stop_mm) const {
        const auto u = PupilOf(stop_mm);
        return u ? passage_.At(bundle_, *u, 0.0) : std::nullopt;
    }

    // |sum|^2 at the sensor place where the light's ray through `middle_mm` lands, over stop places
    // from - to, in units of the same sum over the whole of middle -+ reach: what cutting off
    // there does. The far ends are faded out.
    std::optional<double> Relative(double middle_mm, double from_mm, double to_mm,
                                   double reach_mm) const {
        constexpr int kPlaces = 360;
        const auto u = PupilOf(middle_mm);
        if (!u) return std::nullopt;
        const auto chief = passage_.Trace(bundle_.At(*u, 0.0));
        std::complex<double> cut, whole;
        double pupil = *u;
        double angle = chief->angle.x;
        // From the middle outwards, so that each ray starts from its neighbour.
        for (const int side : {1, -1}) {
            pupil = *u;
            angle = chief->angle.x;
            for (int i = 0; i < kPlaces; ++i) {
                const double off = (i + 0.5) * reach_mm / kPlaces;
                const double stop = middle_mm + side * off;
                const auto path = Path(stop, chief->sensor_mm.x, pupil, angle);
                if (!path) return std::nullopt;
                const double fade =
                    off < 0.5 * reach_mm ? 1.0 : 0.5 - 0.5 * std::cos(2.0 * kPi * off / reach_mm);
                const double base = chief->path_to_stop_mm + chief->path_mm;
                const std::complex<double> wave =
                    fade * std::polar(1.0, k_per_mm_ * (*path - base));
                whole += wave;
                const double step = reach_mm / kPlaces;
                const double inside =
                    std::min(stop + 0.5 * step, to_mm) - std::max(stop - 0.5 * step, from_mm);
                cut += wave * std::min(1.0, std::max(0.0, inside / step));
            }
        }
        return std::norm(cut) / std::norm(whole);
    }

  private:
    // From the light by way of a place in the stop to a place on the sensor. `pupil` and `angle`
    // start the search, and are where it ended.
    std::optional<double> Path(double stop_mm, double sensor_mm, double& pupil,
                               double& angle) const {
        double to_stop = 0.0;
        for (int step = 0;; ++step) {
            const auto here = passage_.Trace(bundle_.At(pupil, 0.0));
            const auto next = passage_.Trace(bundle_.At(pupil + 1e-4, 0.0));
            if (!here || !next || step == 20) return std::nullopt;
            const double miss = here->stop_mm.x - stop_mm;
            to_stop = here->path_to_stop_mm;
            if (std::abs(miss) < 1e-10) break;
            pupil -= miss / ((next->stop_mm.x - here->stop_mm.x) / 1e-4);
        }
        for (int step = 0;; ++step) {
            const auto here = passage_.FromStop({stop_mm, 0.0}, {angle, 0.0});
            const auto next = passage_.FromStop({stop_mm, 0.0}, {angle + 1e-6, 0.0});
            if (!here || !next || step == 20) return std::nullopt;
            const double miss = here->sensor_mm.x - sensor_mm;
            if (std::abs(miss) < 1e-9) return to_stop + here->path_mm;
            angle -= miss / ((next->sensor_mm.x - here->sensor_mm.x) / 1e-6);
        }
    }

    InteractionList list_;
    StopPassage passage_;
    LightBundle bundle_;
    double k_per_mm_;
};

}  // namespace flare::testing
