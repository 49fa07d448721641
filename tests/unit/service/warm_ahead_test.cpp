// SPDX-License-Identifier: Apache-2.0
//
// A small lens with inner focusing, whose ring is turned by hand: what is traced ahead is what the
// next request finds, and no more than that.
#include "server/warm_ahead.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "server/cache/mesh_cache.h"
#include "server/translate/request_from_wire.h"
#include "tests/support/temporary_folder.h"

namespace flare {
namespace {

constexpr char kInner[] = "inner-triplet", kWhole[] = "textbook-cooke-triplet-50mm-f5";

class RingAhead : public testing::Test {
  protected:
    RingAhead() : lenses_(Lenses(folder_)) {
        EncoderConfig config;
        config.name = "ring";
        track_ = std::make_unique<EncoderTrack>(config, [](bool, const std::string&) {});
        Bound(std::size_t{1} << 30);
    }

    // The triplet as it is in the library, and one whose middle lens moves when it is focused.
    static LensLibrary Lenses(const test::TemporaryFolder& folder) {
        std::ifstream file(std::string(FLARE_SOURCE_DIR "/lenses/") + kWhole + ".toml");
        std::stringstream text;
        text << file.rdbuf();
        std::ofstream(folder / (std::string(kWhole) + ".toml")) << text.str();
        std::string inner = text.str();
        inner.replace(inner.find(kWhole), sizeof kWhole - 1, kInner);
        std::ofstream(folder / (std::string(kInner) + ".toml"))
            << inner << "\n[states]\nfocus_m = [inf, 1.0]\n[[states.gap]]\nsurface = 1\n"
            << "gap_mm = [6.00755, 6.3]\n";
        return *LensLibrary::Load(folder.path());
    }

    void Bound(std::size_t bytes) {
        ahead_ = std::make_unique<WarmAhead>(
            lenses_, [this](std::string_view) { return track_.get(); }, bytes);
    }
    wire::FlareRequest Request(const char* lens = kInner) const {
        wire::FlareRequest request;
        request.lens.name = lens;
        request.quality.preset = wire::Preset::kDraft;
        request.image.width = request.image.height = 8;
        request.image.sensor_width_mm = 36.0;
        request.lights.resize(1);
        request.lights[0].direction = {0.1, 0.05, 1.0};
        return request;
    }
    RingSteps Steps() const { return RingSteps::For(**lenses_.Find(kInner), Request()); }
    LensReading At(std::int64_t cell) const {
        LensReading reading;
        reading[LensAxis::kFocus] = 1.0;
        return Steps().Put({cell, 0}, reading);
    }
    // A little beside the middle of the cell, as rings stand.
    void Turn(std::int64_t cell, double f_number = 4.0) {
        EncoderSample sample;
        sample.time_s = now_s_;
        sample.stated[LensAxis::kFocus] =
            1.0 / ((static_cast<double>(cell) + 0.3) * Steps().focus_per_m());
        sample.stated[LensAxis::kIris] = f_number;
        track_->Add(sample);
    }
    void WorkUntilDone() {
        for (int i = 0; i < 10'000 && ahead_->Step(threads_, meshes_); ++i) {
        }
        EXPECT_FALSE(ahead_->Look(now_s_));
    }
    // The meshes of a state that a request would have to trace. Traces them.
    std::uint64_t Missing(std::int64_t cell) {
        wire::FlareRequest request = Request();
        request.lens.focus_m = At(cell)[LensAxis::kFocus];
        const auto work = *WarmWork::PlanFor(*RequestFromWire(request, lenses_));
        while (work->Step(threads_, meshes_, CancelToken())) {
        }
        return work->progress().mesh_misses;
    }
    // At cell 40, with all done there, and then one cell on.
    void Begin() {
        Turn(40);
        ahead_->Note("ring", Request(), At(39), now_s_);
        EXPECT_TRUE(ahead_->Look(now_s_));
        while (ahead_->Look(now_s_)) ahead_->Step(threads_, meshes_);
        Turn(41);
        now_s_ += 0.1;
        EXPECT_TRUE(ahead_->Look(now_s_));
    }

    test::TemporaryFolder folder_;
    LensLibrary lenses_;
    std::unique_ptr<EncoderTrack> track_;
    std::unique_ptr<WarmAhead> ahead_;
    ThreadPool threads_{1};
    MeshCache meshes_{std::size_t{1} << 30};
    double now_s_ = 100.0;
};

TEST_F(RingAhead, TracesWhatTheRingComesTo) {
    Begin();
    WorkUntilDone();
    EXPECT_EQ(ahead_->states("ring"), 6u);  // 40, 41 and four ahead
    for (const std::int64_t cell : {41, 42, 43, 44, 45}) EXPECT_EQ(Missing(cell), 0u) << cell;
    EXPECT_GT(Missing(46), 0u);
    EXPECT_GT(Missing(39), 0u);
    Turn(44);
    EXPECT_TRUE(ahead_->Look(now_s_ += 0.1));
    WorkUntilDone();
    EXPECT_EQ(Missing(48), 0u);
}

TEST_F(RingAhead, WhatWasRenderedIsThere) {
    Turn(40);
    ahead_->Note("ring", Request(), At(40), now_s_);
    EXPECT_FALSE(ahead_->Look(now_s_));
    Turn(41);
    EXPECT_TRUE(ahead_->Look(now_s_));
}

TEST_F(RingAhead, GivesUpWhatTheRingTurnsAwayFrom) {
    Begin();
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(ahead_->Step(threads_, meshes_));
    Turn(40);
    EXPECT_TRUE(ahead_->Look(now_s_ += 0.1));
    WorkUntilDone();
    EXPECT_EQ(Missing(36), 0u);
    EXPECT_GT(Missing(43), 0u);
    EXPECT_GT(Missing(45), 0u);
}

TEST_F(RingAhead, ARingThatRestsIsNotAhead) {
    Begin();
    now_s_ += WarmAhead::kTurning_s + 0.1;
    EXPECT_TRUE(ahead_->Look(now_s_));  // where it stands
    WorkUntilDone();
    EXPECT_EQ(Missing(41), 0u);
    EXPECT_GT(Missing(42), 0u);
}

TEST_F(RingAhead, TheIrisChangesNoMesh) {
    Begin();
    WorkUntilDone();
    const std::uint64_t before = meshes_.stats().misses;
    for (const double f_number : {4.5, 5.6, 8.0}) {
        Turn(41, f_number);
        EXPECT_FALSE(ahead_->Look(now_s_ += 0.1));
    }
    EXPECT_EQ(meshes_.stats().misses, before);
}

TEST_F(RingAhead, StopsAtInfinity) {
    Turn(1);
    ahead_->Note("ring", Request(), At(39), now_s_);
    while (ahead_->Look(now_s_)) ahead_->Step(threads_, meshes_);
    Turn(0);
    EXPECT_TRUE(ahead_->Look(now_s_ += 0.1));
    WorkUntilDone();
    EXPECT_EQ(ahead_->states("ring"), 2u);
}

TEST_F(RingAhead, HoldsNoMoreThanItsShareOfTheCache) {
    Bound(1);
    Begin();
    WorkUntilDone();
    EXPECT_EQ(ahead_->states("ring"), 2u);
    EXPECT_GT(Missing(41), 0u) << "left when it had come to its share";
    EXPECT_GT(Missing(42), 0u);
}

// As in the daemon: one thread reads the device, one asks, one looks, one works.
TEST_F(RingAhead, ServesItsThreadsAtOnce) {
    std::atomic<bool> stop = false;
    std::atomic<double> clock_s = now_s_;
    Turn(40);
    std::vector<std::thread> threads;
    threads.emplace_back([&] {
        while (!stop) ahead_->Note("ring", Request(), At(39), clock_s);
    });
    threads.emplace_back([&] {
        while (!stop) ahead_->Look(clock_s);
    });
    threads.emplace_back([&] {
        while (!stop) ahead_->Step(threads_, meshes_);
    });
    for (int i = 0; i < 200; ++i) {
        now_s_ += 0.01;
        clock_s = now_s_;
        Turn(40 + i / 50);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    stop = true;
    for (std::thread& thread : threads) thread.join();
    while (ahead_->Look(now_s_)) ahead_->Step(threads_, meshes_);
    for (const std::int64_t cell : {43, 44, 47}) EXPECT_EQ(Missing(cell), 0u) << cell;
}

TEST_F(RingAhead, NobodyAsksAnyMore) {
    Begin();
    EXPECT_FALSE(ahead_->Look(now_s_ + WarmAhead::kInterest_s + 0.1));
    EXPECT_FALSE(ahead_->Step(threads_, meshes_));
}

TEST_F(RingAhead, FollowsNoRingThatMeshesDoNotDependOn) {
    Turn(40);
    ahead_->Note("ring", Request(kWhole), At(39), now_s_);
    EXPECT_FALSE(ahead_->Look(now_s_));
    wire::FlareRequest many = Request();
    many.lights.resize(65, many.lights[0]);
    ahead_->Note("ring", many, At(39), now_s_);
    EXPECT_FALSE(ahead_->Look(now_s_));
    wire::FlareRequest pixel = Request(kWhole);
    pixel.lights[0].direction.reset();
    pixel.lights[0].pixel = {1.0, 2.0};
    ahead_->Note("ring", pixel, At(39), now_s_);
    EXPECT_TRUE(ahead_->Look(now_s_)) << "directions follow the focus";
}

}  // namespace
}  // namespace flare
