// SPDX-License-Identifier: Apache-2.0
//
// Measures error and time of every trial on every scene. Pictures are held against the reference
// picture of their scene, which is drawn once and kept in the folder; rows go to tradeoff.csv there
// as they are measured. A row that stands there already is not measured again, so a sweep that was
// broken off goes on, and a larger one adds to a smaller one.
//
// Time is that of rendering, without encoding: first with nothing cached, then with every mesh at
// hand, the median of several runs. Photons have nothing to cache: one run is both.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "server/tradeoff/table.h"

namespace flare {

struct SweepPlan {
    std::vector<TradeoffScene> scenes;
    std::vector<Trial> trials;
    std::string folder;  // made if it is not there
    int runs = 3;        // with meshes at hand; fewer of a picture that takes long
};

struct SweepTools {
    ThreadPool& threads;
    CancelToken cancel;
    std::function<double()> now_ms;  // a monotonic clock
    std::function<double()> cpu_ms;  // processor time of all threads
    // Rows that are there, of how many, and what is measured next.
    std::function<void(int, int, const std::string&)> progress;
};

struct SweepOutcome {
    std::vector<TradeoffRow> rows;  // of the plan, in its order: scene by scene
    int wanted = 0;                 // fewer rows: it was cancelled; those that are there are here
    int measured = 0;               // of them just now
};

// Errors: the folder or its table cannot be read or written (code "io", or "bad_value" for a table
// that is none); a scene is refused by the renderer.
Result<SweepOutcome> RunSweep(const SweepPlan& plan, const SweepTools& tools);

// A file as a whole: beside it, then renamed. Code "io".
std::optional<Error> WriteWhole(const std::string& path, const std::string& bytes);

}  // namespace flare
