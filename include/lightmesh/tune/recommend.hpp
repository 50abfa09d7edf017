// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/tune/candidate.hpp>
#include <lightmesh/tune/measure.hpp>
#include <lightmesh/tune/require.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace lightmesh::tune {

/// Which frame a user pays for.
enum class Frame {
    first,  ///< a single picture: mesh or cache is filled while it is rendered
    later,  ///< a camera that moves through a scene at rest: mesh or cache is filled already
};

/// The limits and the wish of a user. All limits are inclusive; infinity stands for none.
struct Wishes {
    /// For all lights, on one thread.
    double ns_per_point = std::numeric_limits<double>::infinity();
    /// Wall-clock time of all shadows of a frame.
    double seconds_per_frame = std::numeric_limits<double>::infinity();
    /// Of S: of a mesh to a converged one of the same radius, of a cache to lamps of 256 rays.
    double mean_absolute_error = std::numeric_limits<double>::infinity();
    double bytes = std::numeric_limits<double>::infinity();  ///< of a whole frame
    Frame frame = Frame::first;                              ///< that the limits of time are for
    /// Threads that the user's renderer shares a frame among: `seconds_per_frame` is wall-clock time, shared
    /// evenly; `ns_per_point` stays that of one thread.
    double threads = 1.0;
    /// Only light meshes of this radius: how soft their shadows are is a matter of looks first. Caches, whose
    /// shadows are as soft as the lamps make them, compete as well.
    std::optional<float> radius{};
};

/// Mean absolute error that is asked for if neither time nor error is limited.
inline constexpr double default_error = 0.05;

/// A step of a picture of 8 bits: what is less cannot be seen, and is not worth time that nobody limits.
inline constexpr double invisible_error = 1.0 / 255.0;

/// The choice, and why.
struct Recommendation {
    std::optional<Measurement> choice;  ///< nothing if no candidate is good enough
    std::string reason;                 ///< for people, one to three sentences
    /// What `choice` was held against: the best mesh if that is a cache, the best cache if it is a mesh.
    /// Nothing where only one of the two was measured, or keeps within the limits.
    std::optional<Measurement> other{};
};

/// Seconds of one thread for a frame of a candidate.
inline double frame_seconds(const Measurement& m, Frame frame) {
    return frame == Frame::first ? m.frame.cold_seconds : m.frame.warm_seconds;
}

/// The same per surface point, in nanoseconds.
inline double ns_per_point(const Measurement& m, Frame frame) {
    return 1e9 * frame_seconds(m, frame) / static_cast<double>(m.points_per_frame);
}

namespace detail {

/// True if a measurement can be compared at all: its frame has points, its numbers are finite.
inline bool is_usable(const Measurement& m) {
    return m.points_per_frame > 0 && std::isfinite(m.frame.cold_seconds) &&
           std::isfinite(m.frame.warm_seconds) && std::isfinite(m.frame.bytes) &&
           std::isfinite(m.mean_absolute_error) && std::isfinite(m.lamp_error);
}

inline void check_wish(double value, const char* name) {
    detail::require(value > 0.0, name, value, "greater than 0");
}

inline void check_wishes(const Wishes& wishes) {
    check_wish(wishes.ns_per_point, "Wishes::ns_per_point");
    check_wish(wishes.seconds_per_frame, "Wishes::seconds_per_frame");
    check_wish(wishes.bytes, "Wishes::bytes");
    check_wish(wishes.threads, "Wishes::threads");
    detail::require(wishes.mean_absolute_error >= 0.0, "Wishes::mean_absolute_error",
                    wishes.mean_absolute_error, "0 or more");
}

inline bool is_fast_enough(const Measurement& m, const Wishes& wishes) {
    return ns_per_point(m, wishes.frame) <= wishes.ns_per_point &&
           frame_seconds(m, wishes.frame) / wishes.threads <= wishes.seconds_per_frame;
}

/// Numbers for people: four digits are more than a measurement is worth.
inline std::string rounded(double value) {
    std::ostringstream text;
    text.precision(value >= 1000.0 && value < 1e6 ? 0 : 3);
    if (value >= 1000.0 && value < 1e6)
        text << std::fixed;
    text << value;
    return text.str();
}

/// "850 ns", "11.2 µs": with the unit that fits, in UTF-8.
inline std::string duration_text(double seconds) {
    if (seconds < 1e-6)
        return rounded(1e9 * seconds) + " ns";
    if (seconds < 1e-3)
        return rounded(1e6 * seconds) + " \xC2\xB5s";
    return seconds < 1.0 ? rounded(1e3 * seconds) + " ms" : rounded(seconds) + " s";
}

inline std::string time_text(const Measurement& m, const Wishes& wishes) {
    return duration_text(1e-9 * ns_per_point(m, wishes.frame)) + " a point and thread, " +
           duration_text(frame_seconds(m, wishes.frame) / wishes.threads) + " a frame";
}

inline std::string error_text(const Measurement& m) {
    return rounded(100.0 * m.mean_absolute_error) + " % mean absolute error";
}

inline std::string bytes_text(double bytes) {
    return rounded(bytes / 1e6) + " MB";
}

/// The least by `key`; ties go to the one that comes first.
template <class Key>
const Measurement& least(const std::vector<Measurement>& among, Key&& key) {
    return *std::min_element(among.begin(), among.end(),
                             [&](const Measurement& a, const Measurement& b) { return key(a) < key(b); });
}

/// Keeps what is good enough. If nothing is, leaves `among` alone, says so with the best that there is, and
/// returns false.
template <class Good, class Key, class Text>
bool narrow(std::vector<Measurement>& among, Good&& good, Key&& key, Text&& text, const std::string& wish,
            std::string& reason) {
    std::vector<Measurement> kept;
    std::copy_if(among.begin(), among.end(), std::back_inserter(kept), good);
    if (kept.empty()) {
        const Measurement& best = least(among, key);
        reason = "No candidate " + wish + "; the nearest is " + describe(best.candidate) + " with " +
                 text(best) + ".";
        return false;
    }
    among = std::move(kept);
    return true;
}

}  // namespace detail

/// The measurements that nothing of the same radius beats in both time and error: their indices in `results`,
/// radius by radius as they first appear, the fastest first. Caches are by themselves, as if of one radius.
/// Of equals the first counts. What is not finite is left out.
inline std::vector<std::size_t> pareto_frontier(std::span<const Measurement> results,
                                                Frame frame = Frame::first) {
    std::vector<float> radii;
    for (const Measurement& m : results)
        if (std::find(radii.begin(), radii.end(), radius_of(m.candidate)) == radii.end())
            radii.push_back(radius_of(m.candidate));
    std::vector<std::size_t> frontier;
    for (const float radius : radii) {
        std::vector<std::size_t> order;
        for (std::size_t i = 0; i < results.size(); ++i)
            if (radius_of(results[i].candidate) == radius && detail::is_usable(results[i]))
                order.push_back(i);
        std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return std::pair(frame_seconds(results[a], frame), results[a].mean_absolute_error) <
                   std::pair(frame_seconds(results[b], frame), results[b].mean_absolute_error);
        });
        double least_error = std::numeric_limits<double>::infinity();
        for (const std::size_t i : order) {
            if (results[i].mean_absolute_error < least_error) {
                least_error = results[i].mean_absolute_error;
                frontier.push_back(i);
            }
        }
    }
    return frontier;
}

namespace detail {

/// The recommendation among candidates that are all held against references of one kind.
inline Recommendation recommend_among(std::vector<Measurement> among, const Wishes& wishes) {
    const auto time = [&](const Measurement& m) {
        return frame_seconds(m, wishes.frame);
    };
    const auto error = [](const Measurement& m) {
        return m.mean_absolute_error;
    };
    const auto bytes = [](const Measurement& m) {
        return m.frame.bytes;
    };
    const auto say_time = [&](const Measurement& m) {
        return time_text(m, wishes);
    };

    Recommendation result;
    if (among.empty()) {
        result.reason = "There is no measured candidate to choose from.";
        return result;
    }
    const bool time_limited = std::isfinite(wishes.ns_per_point) || std::isfinite(wishes.seconds_per_frame);
    const bool error_limited = std::isfinite(wishes.mean_absolute_error);
    if (!narrow(
            among, [&](const Measurement& m) { return bytes(m) <= wishes.bytes; }, bytes,
            [&](const Measurement& m) { return bytes_text(bytes(m)); }, "fits " + bytes_text(wishes.bytes),
            result.reason))
        return result;
    if (!narrow(
            among, [&](const Measurement& m) { return error(m) <= wishes.mean_absolute_error; }, error,
            [](const Measurement& m) { return error_text(m); },
            std::string(std::isfinite(wishes.bytes) ? "that fits the memory " : "") + "is as exact as " +
                rounded(100.0 * wishes.mean_absolute_error) + " %",
            result.reason))
        return result;
    if (!narrow(
            among, [&](const Measurement& m) { return is_fast_enough(m, wishes); }, time, say_time,
            (error_limited || std::isfinite(wishes.bytes) ? "that keeps to the other limits is fast enough"
                                                          : "is fast enough"),
            result.reason))
        return result;

    const auto with_cost = [&](const Measurement& m) {
        return say_time(m) + ", " + error_text(m) + ", " + bytes_text(bytes(m)) + ".";
    };
    if (time_limited && !error_limited) {
        result.choice = least(among, error);
        result.reason = "The most exact that the time allows: " + with_cost(*result.choice);
    } else if (error_limited) {
        result.choice = least(among, time);
        result.reason = "The fastest that is exact enough: " + with_cost(*result.choice);
    } else {
        std::string none;
        const bool found = narrow(
            among, [&](const Measurement& m) { return error(m) <= default_error; }, error,
            [](const Measurement& m) { return error_text(m); }, "", none);
        const auto product = [&](const Measurement& m) {
            return time(m) * (std::max)(error(m), invisible_error);
        };
        const std::string limit = rounded(100.0 * default_error) + " %";
        result.choice = found ? least(among, product) : least(among, error);
        result.reason = (found ? "The best balance of time and error: "
                               : "None has an error of at most " + limit + ", so the most exact: ") +
                        with_cost(*result.choice);
    }
    return result;
}

/// Of a mesh and a cache that both keep within the limits.
inline Recommendation better_of(const Recommendation& mesh, const Recommendation& cache,
                                const Wishes& wishes) {
    const bool only_time_limited =
        (std::isfinite(wishes.ns_per_point) || std::isfinite(wishes.seconds_per_frame)) &&
        !std::isfinite(wishes.mean_absolute_error);
    const auto loss = [&](const Measurement& m) {
        const double error = (std::max)(m.lamp_error, invisible_error);
        return only_time_limited ? error : error * frame_seconds(m, wishes.frame);
    };
    const bool takes_cache = loss(*cache.choice) <= loss(*mesh.choice);
    Recommendation result = takes_cache ? cache : mesh;
    const Measurement& other = takes_cache ? *mesh.choice : *cache.choice;
    const auto percent = [](double error) {
        return rounded(100.0 * error) + " %";
    };
    const double times = frame_seconds(*result.choice, wishes.frame) / frame_seconds(other, wishes.frame);
    result.reason += std::string(takes_cache ? " Take a cache rather than a mesh: the best mesh ("
                                             : " Take a mesh rather than a cache: the best cache (") +
                     describe(other.candidate) + ") differs from lamps of their sizes by " +
                     percent(other.lamp_error) + ", this one by " + percent(result.choice->lamp_error) +
                     ", in " + rounded(times) + " times the time.";
    result.other = other;
    return result;
}

}  // namespace detail

/// Chooses what to use. Light meshes and caches are judged by themselves first, among those that keep within
/// all limits: the most exact if there is a limit to the time but none to the error; the fastest if there is
/// one to the error. If neither is limited, the best balance: of those with an error of at most
/// `default_error` the one with the least product of time and error, so that all others lose more of the one
/// than they gain of the other (an error below `invisible_error` counts as that); or the most exact if none
/// is that exact. Then the chosen mesh and the chosen cache are held against each other: the less product of
/// time and `Measurement::lamp_error` wins, or where only the time is limited the less lamp error; the reason
/// says by how much, and `Recommendation::other` is the one that lost. Measurements that are not finite are
/// never chosen. Without `Wishes::radius`, all radii compete, each with the error to its own reference.
///
/// Throws std::invalid_argument that names the value for a wish that is NaN, negative or (but for the error)
/// 0.
inline Recommendation recommend(std::span<const Measurement> results, const Wishes& wishes) {
    detail::check_wishes(wishes);
    std::vector<Measurement> meshes;
    std::vector<Measurement> caches;
    for (const Measurement& m : results)
        if (detail::is_usable(m)) {
            if (is_cache(m.candidate))
                caches.push_back(m);
            else if (!wishes.radius || m.candidate.radius == *wishes.radius)
                meshes.push_back(m);
        }
    if (caches.empty())
        return detail::recommend_among(std::move(meshes), wishes);
    if (meshes.empty())
        return detail::recommend_among(std::move(caches), wishes);
    const Recommendation mesh = detail::recommend_among(meshes, wishes);
    const Recommendation cache = detail::recommend_among(caches, wishes);
    if (mesh.choice && cache.choice)
        return detail::better_of(mesh, cache, wishes);
    if (mesh.choice || cache.choice) {
        Recommendation result = mesh.choice ? mesh : cache;
        result.reason +=
            mesh.choice ? " No cache keeps within the limits." : " No mesh keeps within the limits.";
        return result;
    }
    meshes.insert(meshes.end(), caches.begin(), caches.end());
    return detail::recommend_among(std::move(meshes), wishes);
}

}  // namespace lightmesh::tune
