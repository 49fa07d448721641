// SPDX-License-Identifier: Apache-2.0
//
// The search against renderers of its own that take the time, and leave the error, they are told
// to.
#include "core/render/quality_search.h"

#include <gtest/gtest.h>

#include "core/render/quality.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::RememberingMeshes;

// A clock that stands still but for what is drawn.
class Bench {
  public:
    // Milliseconds that a picture takes at a tolerance.
    std::function<double(double)> cost_ms;
    std::function<double(double)> error = [](double tolerance) { return tolerance; };
    std::vector<double> drawn;

    Result<Rendering> Search(const FlareRequest& request, CancelToken cancel = {}) {
        const RenderContext context{threads_, meshes_, cancel, [this] { return now_ms_; }};
        return RenderSearched(request, context,
                              [this](const FlareRequest& plan, const RenderContext& drawing) {
                                  return Draw(plan, drawing);
                              });
    }
    double now_ms() const { return now_ms_; }

  private:
    Result<Rendering> Draw(const FlareRequest& plan, const RenderContext& context) {
        const double tolerance = *plan.quality.tolerance;
        drawn.push_back(tolerance);
        now_ms_ += cost_ms ? cost_ms(tolerance) : 1.0;
        if (context.cancel.cancelled()) return Error{"cancelled", "", ""};
        Rendering rendering;
        rendering.quality = plan.quality;
        rendering.report.facts.estimated_error.rel_l1 = error(tolerance);
        return rendering;
    }

    ThreadPool threads_{1};
    RememberingMeshes meshes_;
    double now_ms_ = 1000.0;
};

FlareRequest Scene() {
    FlareRequest request;
    request.lens = testing::BuildLens(testing::SeedLens());
    request.f_number = 8.0;
    request.image.width = 64;
    request.image.height = 36;
    request.lights = {LightAt(6.0, 70.0)};
    return request;
}

TEST(TimeBudget, TakesTheFinestPlanThatFits) {
    FlareRequest request = Scene();
    for (const double unit_ms : {1.0, 30.0}) {
        for (const double budgets : {1.5, 3.0, 10.0, 40.0, 1000.0}) {
            Bench bench;
            bench.cost_ms = [&](double tolerance) { return unit_ms * RelativeCost(tolerance); };
            request.quality.time_budget_ms = budgets * unit_ms;
            const Result<Rendering> found = bench.Search(request);
            ASSERT_TRUE(found);
            EXPECT_LE(found->report.work.search->total_ms, budgets * unit_ms);
            EXPECT_EQ(found->report.work.search->pictures, bench.drawn.size());
            EXPECT_EQ(found->quality.tolerance, bench.drawn.back());
            // No plan of twice its cost would have fitted beside the first picture.
            const double cost = unit_ms * RelativeCost(*found->quality.tolerance);
            if (budgets >= 10.0 && *found->quality.tolerance > kMinTolerance) {
                EXPECT_GT(2.0 * cost, (budgets - 1.0) * unit_ms) << budgets;
            }
        }
    }
}

TEST(TimeBudget, GivesTheCoarsestPictureWhereNoneFits) {
    FlareRequest request = Scene();
    request.quality.time_budget_ms = 1.0;
    Bench bench;
    bench.cost_ms = [](double) { return 50.0; };
    const Result<Rendering> found = bench.Search(request);
    ASSERT_TRUE(found);
    EXPECT_EQ(bench.drawn, std::vector<double>{kMaxTolerance});
    EXPECT_EQ(found->quality.tolerance, kMaxTolerance);
}

TEST(TimeBudget, CallsOffAPlanThatOverruns) {
    FlareRequest request = Scene();
    request.quality.time_budget_ms = 1.0;
    Bench bench;
    bench.cost_ms = [&](double tolerance) { return tolerance < kMaxTolerance ? 5.0 : 0.01; };
    const Result<Rendering> found = bench.Search(request);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->quality.tolerance, kMaxTolerance);
    EXPECT_EQ(found->report.work.search->overruns, 1U);
    EXPECT_EQ(bench.drawn.size(), 2U);
}

TEST(TimeBudget, IsCancelledByItsCaller) {
    FlareRequest request = Scene();
    request.quality.time_budget_ms = 100.0;
    Bench bench;
    const CancelToken cancel;
    cancel.Cancel();
    const Result<Rendering> found = bench.Search(request, cancel);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, "cancelled");
}

TEST(MaxError, DrawsFinerUntilTheEstimateKeepsIt) {
    FlareRequest request = Scene();
    request.quality.max_error = 0.02;
    Bench bench;
    bench.error = [](double tolerance) { return 1.5 * tolerance; };
    const Result<Rendering> found = bench.Search(request);
    ASSERT_TRUE(found);
    EXPECT_LE(found->report.facts.estimated_error.rel_l1, kErrorMargin * 0.02);
    EXPECT_GT(*found->quality.tolerance, 0.4 * 0.02 / 1.5);
    EXPECT_GE(bench.drawn.size(), 1U);
}

TEST(MaxError, EndsAtTheFinestTolerance) {
    FlareRequest request = Scene();
    request.quality.max_error = 0.02;
    Bench bench;
    bench.error = [](double) { return 1.0; };
    const Result<Rendering> found = bench.Search(request);
    ASSERT_TRUE(found);
    EXPECT_LE(bench.drawn.size(), 4U);
    EXPECT_EQ(*found->quality.tolerance, bench.drawn.back());
    EXPECT_EQ(found->report.facts.estimated_error.rel_l1, 1.0);
}

}  // namespace
}  // namespace flare
