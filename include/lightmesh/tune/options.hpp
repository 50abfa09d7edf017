// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/settings.hpp>
#include <lightmesh/tune/candidate.hpp>
#include <lightmesh/tune/require.hpp>
#include <lightmesh/tune/watch.hpp>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace lightmesh::tune {

struct Measurement;

/// Who does work that is not timed. The default does it one by one, on the calling thread.
struct Executor {
    std::size_t threads = 1;  ///< that `for_each` spreads its work over: for predictions
    /// Calls work(i) once for each i < count, in any order, on any threads, and returns when all is done. It
    /// must pass on an exception of the work.
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& work)> for_each =
        [](std::size_t count, const std::function<void(std::size_t)>& work) {
            for (std::size_t i = 0; i < count; ++i)
                work(i);
        };
};

/// Options of measuring.
struct Options {
    /// The settings that candidates of meshes leave open: `Settings::origin` and `Settings::scene_bounds`.
    Settings base;
    /// The number of samples that the error is measured at, spread evenly: they are queried with up to 8,600
    /// light points each.
    std::size_t reference_points = 256;
    /// The reference has converged when doubling its q, or the rays to a lamp, changes S by less than this,
    /// mean absolute.
    double reference_change = 0.001;
    /// Queries of a filled mesh or cache are repeated for at least so long; the fastest pass counts.
    double least_seconds = 0.05;
    /// For the reference. Everything that is timed runs on the calling thread alone.
    Executor executor;
};

/// The progress of a run.
struct Progress {
    std::size_t done = 0;   ///< candidates measured by now, those that were passed in included
    std::size_t total = 0;  ///< candidates, duplicates left out
    std::string task;       ///< what is being done, for people: "r 3, q 4, linked, rays"
    /// The candidate that has just been measured; null in all other calls. Each new one is shown once.
    const Measurement* latest = nullptr;
};

/// Called on the thread that called `run`, some ten times a second if the tracer allows, never while
/// something is timed. Returning false cancels the run.
using ProgressCallback = std::function<bool(const Progress&)>;

namespace detail {

/// Thrown and caught inside the library when a run is cancelled.
struct Cancelled {};

/// Asks the user's callback now and then whether to go on.
class Reporter {
public:
    explicit Reporter(ProgressCallback callback) : callback_(std::move(callback)) {}

    Progress progress;

    /// Throws `Cancelled`.
    void report() {
        last_ = Watch();
        if (callback_ && !callback_(progress))
            throw Cancelled{};
    }
    /// `report`, unless that was a moment ago.
    void poll() {
        if (last_.seconds() > 0.1)
            report();
    }

private:
    ProgressCallback callback_;
    Watch last_;
};

inline void check_options(const Options& options) {
    using detail::require;
    constexpr double most = (std::numeric_limits<double>::max)();
    require(options.reference_points >= 1, "Options::reference_points", options.reference_points,
            "at least 1");
    require(options.reference_change > 0.0 && options.reference_change <= most, "Options::reference_change",
            options.reference_change, "finite and greater than 0");
    require(options.least_seconds >= 0.0 && options.least_seconds <= most, "Options::least_seconds",
            options.least_seconds, "finite and not negative");
    require(options.executor.threads >= 1, "Executor::threads", options.executor.threads, "at least 1");
    if (!options.executor.for_each)
        throw std::invalid_argument("lightmesh: Executor::for_each is empty; it must be a function");
}

}  // namespace detail

}  // namespace lightmesh::tune
