// SPDX-License-Identifier: Apache-2.0
#include "core/optics/lens_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/units.h"
#include "core/optics/paraxial.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

// Two sections may focus at different places; unit focusing moves the sensor by the mean.
constexpr std::array<Section, 2> kSections = {Section::kX, Section::kY};

// Where the tables are read: log of the nominal focal length, and 1 / focus distance (1/m).
struct Position {
    double log_focal = 0.0;
    double per_m = 0.0;
};

std::vector<double> Mapped(const std::vector<double>& from, double (*map)(double)) {
    std::vector<double> to(from.size());
    std::transform(from.begin(), from.end(), to.begin(), map);
    return to;
}

double Reciprocal(double value) {
    return 1.0 / value;  // 0 for infinity
}

double Logarithm(double value) {
    return std::log(value);
}

class StateSetter {
  public:
    explicit StateSetter(const Lens& base)
        : base_(base),
          file_(base.prescription()),
          table_(file_.states),
          log_focal_(Mapped(table_.focal_mm, Logarithm)),
          per_m_(Mapped(table_.focus_m, Reciprocal)) {}

    Result<LensInState> Run(const LensState& wanted) {
        ClampZoom(wanted.zoom_mm);
        ClampTabledFocus(wanted.focus_m);
        Result<Prescription> at = table_.empty() ? Result<Prescription>(file_) : AtState();
        if (!at) return at.error();
        Result<std::shared_ptr<const Lens>> lens = Lens::Build(*at);
        if (!lens) return lens.error();
        if (wanted.focus_m && table_.focus_m.empty()) {
            at->focus_shift_mm = UnitFocusShift(**lens, *wanted.focus_m);
            lens = Lens::Build(*at);
            if (!lens) return lens.error();
        }
        out_.lens = *lens;
        return std::move(out_);
    }

  private:
    void Clamp(const char* field, double from, double to) {
        out_.clamped.push_back({field, from, to});
    }

    void ClampZoom(std::optional<double> wanted) {
        if (table_.focal_mm.empty()) {
            const double only = file_.design_focal_mm.value_or(base_.first_order().efl_mm);
            if (wanted && *wanted != only) Clamp("zoom_mm", *wanted, only);
            return;
        }
        const double zoom = wanted.value_or(table_.focal_mm.front());
        const double set = std::clamp(zoom, table_.focal_mm.front(), table_.focal_mm.back());
        if (set != zoom) Clamp("zoom_mm", zoom, set);
        out_.state.zoom_mm = set;
    }

    void ClampTabledFocus(std::optional<double> wanted) {
        if (!wanted) return;
        out_.state.focus_m = *wanted;
        if (table_.focus_m.empty() || *wanted >= table_.focus_m.back()) return;
        out_.state.focus_m = table_.focus_m.back();
        Clamp("focus_m", *wanted, table_.focus_m.back());
    }

    // The file's numbers at a position, the tables read as they are.
    Prescription Read(const Position& position) const {
        Prescription at = file_;
        at.states = {};
        for (const StateTable::Row& row : table_.gaps) {
            SurfacePrescription& surface = at.surfaces[static_cast<std::size_t>(row.surface)];
            surface.gap_mm = ValueAt(row, position);
            surface.gap_given = true;
        }
        for (const StateTable::Row& row : table_.semi_diameters) {
            at.surfaces[static_cast<std::size_t>(row.surface)].semi_diameter_mm =
                ValueAt(row, position);
        }
        return at;
    }

    double ValueAt(const StateTable::Row& row, const Position& position) const {
        const std::size_t columns = table_.focus_positions();
        std::vector<double> over_zoom;
        for (std::size_t zoom = 0; zoom < table_.zoom_positions(); ++zoom) {
            const auto first = row.values.begin() + static_cast<std::ptrdiff_t>(zoom * columns);
            over_zoom.push_back(
                columns == 1
                    ? *first
                    : MonotoneAt(per_m_, {first, first + static_cast<std::ptrdiff_t>(columns)},
                                 position.per_m));
        }
        return over_zoom.size() == 1 ? over_zoom.front()
                                     : MonotoneAt(log_focal_, over_zoom, position.log_focal);
    }

    struct Power {
        double efl_mm = 0.0, bfl_mm = 0.0;
    };
    Result<Power> PowerAt(const Position& position) const {
        Prescription at = Read(position);
        // Whatever the sensor's place: only the glass is asked.
        SurfacePrescription& last = at.surfaces[at.optical_count() - 1];
        last.gap_mm = 1.0;
        last.gap_given = true;
        const Result<std::shared_ptr<const Lens>> lens = Lens::Build(at);
        if (!lens) return lens.error();
        return Power{(*lens)->first_order().efl_mm, (*lens)->first_order().bfl_mm};
    }

    Result<Prescription> AtState() const {
        Position position;
        if (out_.state.focus_m && !table_.focus_m.empty()) {
            position.per_m = 1.0 / *out_.state.focus_m;
        }
        double sensor_correction = 0.0;
        const bool between = out_.state.zoom_mm.has_value() &&
                             std::find(table_.focal_mm.begin(), table_.focal_mm.end(),
                                       *out_.state.zoom_mm) == table_.focal_mm.end();
        if (out_.state.zoom_mm) position.log_focal = std::log(*out_.state.zoom_mm);
        if (between) {
            const Result<double> correction = PlaceBetween(position);
            if (!correction) return correction.error();
            sensor_correction = *correction;
        }
        Prescription at = Read(position);
        SurfacePrescription& last = at.surfaces[at.optical_count() - 1];
        if (last.gap_given) {
            last.gap_mm += sensor_correction;
        } else if (position.per_m > 0.0) {
            // Inner focusing: the sensor stays where it stands for infinity.
            const Result<Power> power = PowerAt({position.log_focal, 0.0});
            if (!power) return power.error();
            last.gap_mm = power->bfl_mm;
            last.gap_given = true;
        }
        return at;
    }

    // Moves a position between two zoom positions to where the focal length is met; returns by how
    // much the sensor must be moved to keep the picture in focus.
    Result<double> PlaceBetween(Position& position) const {
        std::vector<double> log_ratio, defocus;
        for (const double node : log_focal_) {
            const Result<Power> power = PowerAt({node, 0.0});
            if (!power) return power.error();
            if (!std::isfinite(power->efl_mm) || power->efl_mm <= 0.0) return 0.0;
            log_ratio.push_back(std::log(power->efl_mm) - node);
            defocus.push_back(GapAt(node) - power->bfl_mm);
        }
        const double asked = position.log_focal;
        const double wanted_efl = std::exp(asked + MonotoneAt(log_focal_, log_ratio, asked));
        const auto above = std::upper_bound(log_focal_.begin(), log_focal_.end(), asked);
        double lo = *(above - 1), hi = *above;
        Power power;
        for (int step = 0; step < 50 && lo < hi; ++step) {
            const double mid = 0.5 * (lo + hi);
            if (mid == lo || mid == hi) break;
            const Result<Power> found = PowerAt({mid, 0.0});
            if (!found) return found.error();
            power = *found;
            position.log_focal = mid;
            (power.efl_mm < wanted_efl ? lo : hi) = mid;
        }
        const double residual = MonotoneAt(log_focal_, defocus, asked);
        return power.bfl_mm + residual - GapAt(position.log_focal);
    }

    // The sensor's distance by the file, at infinity.
    double GapAt(double log_focal) const {
        return Read({log_focal, 0.0}).surfaces[file_.optical_count() - 1].gap_mm;
    }

    double UnitFocusShift(const Lens& lens, double focus_m) {
        double nearest_mm = 0.0;
        for (const Section section : kSections) {
            const double f = lens.first_order(section).efl_mm;
            if (!(f > 0.0) || std::isinf(f)) {
                out_.state.focus_m.reset();
                Clamp("focus_m", focus_m, std::numeric_limits<double>::infinity());
                return 0.0;
            }
            nearest_mm = std::max(nearest_mm, 4.0 * f + PrincipalGap(lens, section));
        }
        double focus_mm = focus_m * kMmPerMetre;
        if (focus_mm < nearest_mm) {
            focus_mm = nearest_mm;
            out_.state.focus_m = nearest_mm / kMmPerMetre;
            Clamp("focus_m", focus_m, *out_.state.focus_m);
        }
        double shift = 0.0;
        for (const Section section : kSections) {
            const double f = lens.first_order(section).efl_mm;
            const double s = focus_mm - PrincipalGap(lens, section);
            // s' = (s - root) / 2, written without the difference, or the square, of large
            // numbers.
            const double image = 2.0 * f / (1.0 + std::sqrt(std::max(0.0, 1.0 - 4.0 * f / s)));
            shift += 0.5 * (image - f);
        }
        return shift;
    }

    // From the front to the rear principal plane, mm.
    static double PrincipalGap(const Lens& lens, Section section) {
        const Abcd whole = FrontToBack(lens, kLineD, section);
        const double f = lens.first_order(section).efl_mm;
        const double front = whole.d / whole.c + f;
        const double rear =
            lens.surfaces().back().vertex_z_mm + lens.first_order(section).bfl_mm - f;
        return rear - front;
    }

    const Lens& base_;
    const Prescription& file_;
    const StateTable& table_;
    std::vector<double> log_focal_, per_m_;
    LensInState out_;
};

}  // namespace

Result<LensInState> SetState(const std::shared_ptr<const Lens>& base, const LensState& wanted) {
    LensState state = wanted;
    if (state.focus_m && std::isinf(*state.focus_m)) state.focus_m.reset();
    // The lens as it stands needs no new one.
    if (!state.focus_m && !state.zoom_mm) {
        LensInState out;
        out.lens = base;
        if (!base->prescription().states.focal_mm.empty()) {
            out.state.zoom_mm = base->prescription().states.focal_mm.front();
        }
        return out;
    }
    return StateSetter(*base).Run(state);
}

namespace {

class StateFaultFinder {
  public:
    explicit StateFaultFinder(const Prescription& prescription)
        : prescription_(prescription), table_(prescription.states) {}

    std::vector<StateFault> Run() {
        if (table_.empty()) {
            if (!table_.gaps.empty() || !table_.semi_diameters.empty() ||
                !table_.f_number.empty()) {
                Add("states needs an axis: focal_mm, focus_m or both", table_.where);
            }
            return std::move(faults_);
        }
        CheckAxes();
        if (!faults_.empty()) return std::move(faults_);
        for (const StateTable::Row& row : table_.gaps) CheckRow(row, true);
        for (const StateTable::Row& row : table_.semi_diameters) CheckRow(row, false);
        return std::move(faults_);
    }

  private:
    void Add(const std::string& message, const std::string& where) {
        faults_.push_back({message, where});
    }

    void CheckAxes() {
        const std::vector<double>& focal = table_.focal_mm;
        const std::vector<double>& focus = table_.focus_m;
        for (const std::vector<double>* axis : {&focal, &focus}) {
            if (axis->size() == 1 || axis->size() > kMaxStatePositions) {
                Add("an axis of states has 2 to " + std::to_string(kMaxStatePositions) +
                        " positions, not " + std::to_string(axis->size()),
                    table_.where);
            }
        }
        for (std::size_t i = 0; i < focal.size(); ++i) {
            const double before = i == 0 ? 0.0 : focal[i - 1];
            if (!(focal[i] > before && focal[i] <= kMaxGapMm)) {
                Add("states.focal_mm must rise from above 0", table_.where);
                break;
            }
        }
        for (std::size_t i = 0; i < focus.size(); ++i) {
            const bool good = i == 0 ? std::isinf(focus[i]) && focus[i] > 0.0
                                     : focus[i] > 0.0 && focus[i] < focus[i - 1];
            if (!good) {
                Add("states.focus_m must begin with inf and fall, above 0", table_.where);
                break;
            }
        }
        if (!table_.f_number.empty() && table_.f_number.size() != table_.zoom_positions()) {
            Add("states.f_number has one value for each zoom position", table_.where);
        }
        for (const double n : table_.f_number) {
            if (!(n > 0.0 && std::isfinite(n))) {
                Add("states.f_number must be above 0", table_.where);
            }
        }
    }

    void CheckRow(const StateTable::Row& row, bool gap) {
        const std::size_t optical = prescription_.optical_count();
        if (row.surface < 0 || static_cast<std::size_t>(row.surface) >= optical) {
            Add("states names surface " + std::to_string(row.surface) + ", which the lens has not",
                row.where);
            return;
        }
        const std::vector<StateTable::Row>& rows = gap ? table_.gaps : table_.semi_diameters;
        const auto same = [&](const StateTable::Row& other) {
            return other.surface == row.surface;
        };
        if (std::count_if(rows.begin(), rows.end(), same) > 1) {
            Add("states names surface " + std::to_string(row.surface) + " twice", row.where);
        }
        const std::size_t wanted = table_.zoom_positions() * table_.focus_positions();
        if (row.values.size() != wanted) {
            Add("states: surface " + std::to_string(row.surface) + " needs " +
                    std::to_string(wanted) + " values, not " + std::to_string(row.values.size()),
                row.where);
            return;
        }
        const double least = gap ? 0.0 : kMinLengthMm;
        const double most = gap ? kMaxGapMm : kMaxSemiDiameterMm;
        for (const double value : row.values) {
            if (!(value >= least && value <= most)) {
                Add("states: " + NumberText(value) + " mm of surface " +
                        std::to_string(row.surface) + " is not within " + NumberText(least) +
                        " .. " + NumberText(most) + " mm",
                    row.where);
                return;
            }
        }
        const SurfacePrescription& surface =
            prescription_.surfaces[static_cast<std::size_t>(row.surface)];
        const double own = gap ? surface.gap_mm : surface.semi_diameter_mm;
        if (gap && !surface.gap_given) {
            Add("states: the values of surface " + std::to_string(row.surface) + " begin with " +
                    NumberText(row.values.front()) + " mm but the surface itself has none",
                row.where);
        } else if (std::abs(own - row.values.front()) > 1e-9) {
            Add("states: the values of surface " + std::to_string(row.surface) + " begin with " +
                    NumberText(row.values.front()) + " mm but the surface itself has " +
                    NumberText(own) + " mm",
                row.where);
        }
    }

    const Prescription& prescription_;
    const StateTable& table_;
    std::vector<StateFault> faults_;
};

}  // namespace

std::vector<StateFault> FindStateFaults(const Prescription& prescription) {
    return StateFaultFinder(prescription).Run();
}

double MonotoneAt(const std::vector<double>& x, const std::vector<double>& y, double at) {
    const std::size_t n = x.size();
    if (at <= x.front()) return y.front();
    if (at >= x.back()) return y.back();
    // Slopes of the chords; then tangents: the mean of two chords of one sign, limited so that no
    // overshoot can arise, 0 at a turn (Fritsch & Carlson 1980, with their circle of radius 3).
    std::vector<double> chord(n - 1), tangent(n);
    for (std::size_t i = 0; i + 1 < n; ++i) chord[i] = (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
    tangent.front() = chord.front();
    tangent.back() = chord.back();
    for (std::size_t i = 1; i + 1 < n; ++i) {
        tangent[i] = chord[i - 1] * chord[i] <= 0.0 ? 0.0 : 0.5 * (chord[i - 1] + chord[i]);
    }
    for (std::size_t i = 0; i + 1 < n; ++i) {
        if (chord[i] == 0.0) {
            tangent[i] = tangent[i + 1] = 0.0;
            continue;
        }
        const double a = tangent[i] / chord[i];
        const double b = tangent[i + 1] / chord[i];
        const double length = std::hypot(a, b);
        if (length <= 3.0) continue;
        tangent[i] = 3.0 / length * a * chord[i];
        tangent[i + 1] = 3.0 / length * b * chord[i];
    }
    const auto i =
        static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), at) - x.begin()) - 1;
    const double h = x[i + 1] - x[i];
    const double t = (at - x[i]) / h;
    const double u = 1.0 - t;
    return y[i] * u * u * (1.0 + 2.0 * t) + y[i + 1] * t * t * (1.0 + 2.0 * u) +
           h * t * u * (tangent[i] * u - tangent[i + 1] * t);
}

}  // namespace flare
