// SPDX-License-Identifier: Apache-2.0
#include "core/render/quality_search.h"

#include <algorithm>
#include <cmath>

#include "core/render/quality.h"
#include "core/render/scene_survey.h"

namespace flare {
namespace {

constexpr int kMostAttempts = 4;

// Three digits, downwards: short to write, and found again by who asks for it.
double Rounded(double tolerance) {
    const double digit = std::pow(10.0, std::floor(std::log10(tolerance)) - 2.0);
    const double rounded = std::floor(tolerance / digit + 1e-6) * digit;
    // As the decimal reads, not as the product does.
    return std::clamp(std::stod(std::to_string(rounded)), kMinTolerance, kMaxTolerance);
}

// The coarsest tolerance, at most `coarsest`, whose surveyed estimate keeps the error; else the
// finest.
double CoarsestWithin(const SceneSurvey& survey, double max_error, double coarsest) {
    constexpr double kStep = 0.95;
    for (double tolerance = coarsest; tolerance > kMinTolerance; tolerance *= kStep) {
        const double rounded = Rounded(tolerance);
        if (survey.At(rounded).rel_l1 <= max_error) return rounded;
    }
    return kMinTolerance;
}

// The finest tolerance that should take no longer, if a picture at `known` took `took_ms`.
double FinestWithin(double ms, double took_ms, double known) {
    double tolerance = known;
    while (tolerance > kMinTolerance) {
        const double next = Rounded(std::max(kMinTolerance, 0.95 * tolerance));
        if (took_ms * RelativeCost(next) / RelativeCost(known) > ms) break;
        tolerance = next;
    }
    return tolerance;
}

class Search {
  public:
    Search(const FlareRequest& request, const RenderContext& context, const PlanRenderer& render)
        : request_(request), context_(context), render_(render), started_ms_(context.now_ms()) {}

    Result<Rendering> ToError(double asked) {
        const double max_error = kErrorMargin * asked;
        double tolerance = Rounded(std::min(kMaxTolerance, max_error));
        Survey(max_error, tolerance);
        for (int attempt = 0;; ++attempt) {
            Result<Rendering> rendering = Draw(tolerance, context_);
            if (!rendering) return rendering;
            const double estimate = rendering->report.facts.estimated_error.rel_l1;
            if (estimate <= max_error || tolerance <= kMinTolerance ||
                attempt + 1 == kMostAttempts) {
                return Finished(std::move(*rendering));
            }
            tolerance = Rounded(std::max(kMinTolerance, 0.85 * tolerance * max_error / estimate));
        }
    }

    Result<Rendering> InTime(double budget_ms) {
        const double end_ms = started_ms_ + kGuard * budget_ms;
        double tolerance = kMaxTolerance;
        Result<Rendering> best = Draw(tolerance, context_);
        if (!best) return best;
        double took_ms = context_.now_ms() - started_ms_;
        for (int attempt = 1; attempt < kMostAttempts; ++attempt) {
            const double began_ms = context_.now_ms();
            const double left_ms = end_ms - began_ms;
            const double next = FinestWithin(kFill * left_ms, took_ms, tolerance);
            if (next > kWorthwhile * tolerance) break;
            const RenderContext guarded{
                context_.threads, context_.meshes,
                context_.cancel.OrWhen([&] { return context_.now_ms() > end_ms; }),
                context_.now_ms};
            Result<Rendering> finer = Draw(next, guarded);
            if (!finer) {
                if (context_.cancel.cancelled()) return finer;
                ++overruns_;
                break;
            }
            best = std::move(finer);
            tolerance = next;
            took_ms = context_.now_ms() - began_ms;
        }
        return Finished(std::move(*best));
    }

  private:
    static constexpr double kGuard = 0.95;      // of the budget, at which a plan is called off
    static constexpr double kFill = 0.8;        // of the time left that a plan is expected to take
    static constexpr double kWorthwhile = 0.8;  // of the tolerance that a finer plan must reach

    void Survey(double max_error, double& tolerance) {
        double coarsest = kMaxTolerance;
        for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
            const SceneSurvey survey(request_, tolerance, context_);
            // What one survey has shown to be too coarse, the next, of finer meshes, cannot know.
            tolerance = coarsest = CoarsestWithin(survey, max_error, coarsest);
            if (context_.cancel.cancelled() || survey.Covers(tolerance)) return;
        }
    }

    Result<Rendering> Draw(double tolerance, const RenderContext& context) {
        FlareRequest plan = request_;
        plan.quality = Quality::Tolerance(tolerance);
        ++drawn_;
        return render_(plan, context);
    }

    Rendering Finished(Rendering rendering) const {
        SearchWork& search = rendering.report.work.search.emplace();
        search.pictures = drawn_;
        search.overruns = overruns_;
        search.total_ms = context_.now_ms() - started_ms_;
        return rendering;
    }

    const FlareRequest& request_;
    const RenderContext& context_;
    const PlanRenderer& render_;
    double started_ms_;
    std::uint64_t drawn_ = 0, overruns_ = 0;
};

}  // namespace

Result<Rendering> RenderSearched(const FlareRequest& request, const RenderContext& context,
                                 const PlanRenderer& render) {
    Search search(request, context, render);
    return request.quality.max_error ? search.ToError(*request.quality.max_error)
                                     : search.InTime(*request.quality.time_budget_ms);
}

}  // namespace flare
