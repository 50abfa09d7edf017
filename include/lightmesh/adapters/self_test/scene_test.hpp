// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/self_test/finding.hpp>
#include <lightmesh/adapters/self_test/segments.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Threads that start together; joined whatever happens.
class TestThreads {
public:
    TestThreads() = default;
    TestThreads(const TestThreads&) = delete;
    TestThreads& operator=(const TestThreads&) = delete;
    ~TestThreads() { join(); }

    template <class Task>
    void add(Task task) {
        threads_.reserve(threads_.size() + 1);
        threads_.emplace_back([this, task] {
            started_.wait(false);
            task();
        });
    }

    void join() {
        started_ = true;
        started_.notify_all();
        for (std::thread& thread : threads_)
            thread.join();
        threads_.clear();
    }

private:
    std::atomic<bool> started_{false};
    std::vector<std::thread> threads_;
};

/// Tests a tracer of which nothing is known but where its scene is: its answers against each other.
template <Intersector Tracer>
class SceneTest {
public:
    SceneTest(const Tracer& tracer, const Bounds& scene) : tracer_(tracer), box_(test_bounds(scene)) {
        const float coordinate = (std::max)(largest_component(box_.low), largest_component(box_.high));
        rounding_share_ = 1e-3 + 0x1p-19 * static_cast<double>(coordinate / largest_size(box_));
        slanted_ = slanted_segments(numbers_, box_);
        straight_ = straight_segments(numbers_, box_);
    }

    std::vector<std::string> run() {
        ask_all();
        if (!test_again() || !test_that_any_is_blocked())
            return std::move(sentences_);
        test_length_zero();
        const bool straight_is_right = test_straight();
        test_lengths(straight_is_right);
        if constexpr (ClosestHitIntersector<Tracer>)
            test_closest_hit(straight_is_right);
        test_batches();
        test_threads();
        return std::move(sentences_);
    }

private:
    bool blocked(const Segment& segment) const { return tracer_.occluded(segment); }
    bool blocked(const glm::vec3& origin, const glm::vec3& target) const {
        return tracer_.occluded(Segment{origin, target});
    }

    void ask_all() {
        segments_ = slanted_;
        segments_.insert(segments_.end(), straight_.begin(), straight_.end());
        for (const Segment& segment : segments_)
            hit_.push_back(blocked(segment) ? 1 : 0);
    }

    /// The same on the same thread, the last first.
    bool test_again() {
        Finding again;
        for (std::size_t i = segments_.size(); i-- > 0;)
            again.add(blocked(segments_[i]) != (hit_[i] == 1), segments_[i]);
        if (again.wrong > 0)
            sentences_.push_back(again.sentence("segments have another answer when they are asked again",
                                                "answers must depend on nothing but the segment"));
        return again.wrong == 0;
    }

    bool test_that_any_is_blocked() {
        if (std::find(hit_.begin(), hit_.end(), 1) != hit_.end())
            return true;
        sentences_.push_back("lightmesh: none of " + grouped(hit_.size()) +
                             " segments in the Bounds is blocked: nothing could be tested; are they the "
                             "Bounds of the scene, in its units?");
        return false;
    }

    void test_length_zero() {
        Finding points;
        for (std::size_t i = 0; i < segments_.size(); i += 8)
            points.add(blocked(segments_[i].origin, segments_[i].origin),
                       {segments_[i].origin, segments_[i].origin});
        if (points.wrong > 0)
            sentences_.push_back(
                points.sentence("segments of length 0 are blocked", "nothing lies between their ends"));
    }

    /// Segments along an axis against the same ones tilted a little. Edges make about as many of them
    /// blocked as open; what is wrong with zeros does not. Returns whether those along an axis can be
    /// trusted.
    bool test_straight() {
        Finding missed;
        Finding invented;
        for (std::size_t i = 0; i < straight_.size(); ++i) {
            const bool is_blocked = hit_[slanted_.size() + i] == 1;
            if (blocked(tilted(straight_[i])))
                missed.add(!is_blocked, straight_[i]);
            else
                invented.add(is_blocked, straight_[i]);
        }
        const double most = (std::min)(0.03 + 8.0 * rounding_share_, 0.5);
        const auto is_too_many = [most](const Finding& a, const Finding& b) {
            return a.is_more_than(most) && a.wrong > 10 + 2 * b.wrong;
        };
        if (is_too_many(missed, invented))
            sentences_.push_back(missed.sentence(
                "axis-parallel segments are not blocked where the same ones tilted by 1e-4 are",
                "the tracer's box test fails for directions with zeros (0 * infinity)"));
        else if (is_too_many(invented, missed))
            sentences_.push_back(invented.sentence(
                "axis-parallel segments are blocked where the same ones tilted by 1e-4 are not",
                "the tracer's tests fail for directions with zeros"));
        else
            return true;
        return false;
    }

    /// Parts, more than the whole, and the way back.
    void test_lengths(bool straight_is_right) {
        Finding parts;
        Finding starts;
        Finding longer;
        Finding far_away;
        Finding ways;
        const std::size_t count = straight_is_right ? segments_.size() : slanted_.size();
        for (std::size_t i = 0; i < count; ++i) {
            const Segment& s = segments_[i];
            const bool is_blocked = hit_[i] == 1;
            const glm::vec3 middle = place_on(s, numbers_.uniform(0.375f, 0.625f));
            parts.add((blocked(s.origin, middle) || blocked(middle, s.target)) != is_blocked, s);
            ways.add(blocked(reversed(s)) != is_blocked, s);
            if (!is_blocked)
                continue;
            starts.add(blocked(s.origin, place_on(s, 0x1p-12f)), s);
            longer.add(!blocked(s.origin, place_on(s, 2.0f)) || !blocked(place_on(s, -1.0f), s.target), s);
            const Segment distant{s.origin, place_on(s, 0x1p20f)};
            if (is_finite(distant.target))
                far_away.add(!blocked(distant), distant);
        }
        constexpr const char* rule = "the tracer gets the segment's length wrong: direction = target - "
                                     "origin is not normalised, and blockers count at 0 < t < 1";
        if (starts.is_clearly_more_than(0.05 + rounding_share_))
            sentences_.push_back(starts.sentence(
                "blocked segments stay blocked when they are cut to their first 4096th part", rule));
        else if (parts.is_clearly_more_than(rounding_share_))
            sentences_.push_back(parts.sentence(
                "segments are blocked where both of their halves are open, or open where a half is "
                "blocked",
                rule));
        else if (ways.is_clearly_more_than(rounding_share_))
            sentences_.push_back(
                ways.sentence("segments have another answer from their target to their origin",
                              "surfaces must block from both sides; is back-face culling on?"));
        else if (longer.is_clearly_more_than(rounding_share_))
            sentences_.push_back(longer.sentence("blocked segments are open when they are made longer",
                                                 "what blocks a part blocks the whole"));
        else if (far_away.is_clearly_more_than(0.01 + rounding_share_))
            sentences_.push_back(
                far_away.sentence("blocked segments are open when they are 2^20 times as long, as those to "
                                  "directional lights may be",
                                  "the tracer must add no epsilon to t, nor bound its distance"));
    }

    /// Grazing segments meet a surface where rounding says: some of 100 distances may differ.
    void test_closest_hit(bool straight_is_right) requires ClosestHitIntersector<Tracer> {
        Finding presence;
        Finding normals;
        Finding beyond;
        Finding distances;
        Finding parameters;
        const float rounding =
            largest_size(box_) * 0x1p-16f +
            (std::max)(largest_component(box_.low), largest_component(box_.high)) * 0x1p-17f;
        const std::size_t count = straight_is_right ? segments_.size() : slanted_.size();
        for (std::size_t i = 0; i < count; ++i) {
            const Segment& s = segments_[i];
            const std::optional<Hit> hit = tracer_.closest_hit(s);
            presence.add(hit.has_value() != (hit_[i] == 1), s);
            if (!hit || hit_[i] == 0)
                continue;
            const float length = glm::length(s.target - s.origin);
            normals.add(!(std::abs(glm::length(hit->normal) - 1.0f) <= 1e-3f), s);
            beyond.add(!(hit->distance >= 0.0f && hit->distance <= length + rounding), s);
            distances.add(!is_first(s, length, hit->distance, rounding), s);
            parameters.add(!is_first(s, length, hit->distance * length, rounding), s);
        }
        if (presence.is_clearly_more_than(rounding_share_))
            sentences_.push_back(presence.sentence("segments have a closest_hit where occluded says open, or "
                                                   "none where it says blocked",
                                                   "both must be about the same surfaces and the same ends"));
        if (normals.is_clearly_more_than(rounding_share_))
            sentences_.push_back(normals.sentence("normals of closest_hit are not of length 1",
                                                  "they must be unit geometric normals"));
        if (distances.is_clearly_more_than(0.03 + rounding_share_)) {
            if (!parameters.is_clearly_more_than(0.03 + rounding_share_))
                sentences_.push_back(
                    distances.sentence("distances of closest_hit are parameters t of the segment",
                                       "Hit::distance is in world units: t times the segment's length"));
            else
                sentences_.push_back(distances.sentence(
                    "distances of closest_hit are not those of the first surface by occluded",
                    "Hit::distance is from the segment's origin, in world units, to the "
                    "nearest surface"));
        } else if (beyond.is_clearly_more_than(rounding_share_)) {
            sentences_.push_back(beyond.sentence("distances of closest_hit are not within the segment",
                                                 "Hit::distance is from its origin, in world units"));
        }
    }

    /// True if `occluded` agrees that the first surface is at this distance.
    bool is_first(const Segment& s, float length, float distance, float rounding) const {
        const float band = rounding + 1e-3f * distance;
        const auto is_blocked_before = [&](float end) {
            return blocked(s.origin, place_on(s, end / length));
        };
        return distance >= 0.0f && distance <= length + rounding &&
               (distance <= band || !is_blocked_before(distance - band)) &&
               (distance + band >= length || is_blocked_before(distance + band));
    }

    /// All segments in calls of 1 to 64.
    void ask_in_batches(std::span<std::uint8_t> hit) const requires BatchIntersector<Tracer> {
        std::size_t size = 0;
        for (std::size_t first = 0; first < segments_.size(); first += size) {
            size = (std::min)(size % 64 + 1, segments_.size() - first);
            tracer_.occluded(std::span<const Segment>(segments_).subspan(first, size),
                             hit.subspan(first, size));
        }
    }

    void test_batches() {
        if constexpr (BatchIntersector<Tracer>) {
            constexpr std::uint8_t unset = 0xa5;
            batch_hit_.assign(segments_.size(), unset);
            ask_in_batches(batch_hit_);
            Finding values;
            Finding answers;
            for (std::size_t i = 0; i < segments_.size(); ++i) {
                values.add(batch_hit_[i] > 1, segments_[i]);
                answers.add((batch_hit_[i] != 0) != (hit_[i] == 1), segments_[i]);
            }
            if (values.wrong > 0)
                sentences_.push_back(
                    values.sentence("places of a batch are set to neither 0 nor 1 or not at all",
                                    "occluded for many segments must set each hit[i] to 1 or 0"));
            else if (answers.is_clearly_more_than(rounding_share_))
                sentences_.push_back(
                    answers.sentence("segments have another answer in a batch of 1 to 64 than alone",
                                     "hit[i] must depend on segments[i] only, as for one segment"));
        }
    }

    void test_threads() {
        constexpr std::size_t thread_count = 4;
        struct Result {
            Finding single;
            Finding batch;
            std::exception_ptr error;
        };
        std::array<Result, thread_count> results;
        TestThreads threads;
        for (std::size_t thread = 0; thread < thread_count; ++thread) {
            threads.add([this, &result = results[thread], thread] {
                try {
                    ask_on_thread(thread * segments_.size() / thread_count, result.single, result.batch);
                } catch (...) {
                    result.error = std::current_exception();
                }
            });
        }
        threads.join();
        Finding single;
        Finding batch;
        for (const Result& result : results) {
            if (result.error)
                std::rethrow_exception(result.error);
            single.add(result.single);
            batch.add(result.batch);
        }
        constexpr const char* rule = "many threads call it at once, without a lock: it must share no state";
        if (single.wrong > 0)
            sentences_.push_back(single.sentence("answers differ when 4 threads ask at once", rule));
        if (batch.wrong > 0)
            sentences_.push_back(
                batch.sentence("answers of batches differ when 4 threads ask at once", rule));
    }

    void ask_on_thread(std::size_t first, Finding& single, [[maybe_unused]] Finding& batch) const {
        for (std::size_t i = 0; i < segments_.size(); ++i) {
            const std::size_t at = (first + i) % segments_.size();
            single.add(blocked(segments_[at]) != (hit_[at] == 1), segments_[at]);
        }
        if constexpr (BatchIntersector<Tracer>) {
            std::vector<std::uint8_t> hit = batch_hit_;
            ask_in_batches(hit);
            for (std::size_t i = 0; i < segments_.size(); ++i)
                batch.add(hit[i] != batch_hit_[i], segments_[i]);
        }
    }

    const Tracer& tracer_;
    Bounds box_;
    /// Of segments that come so near to an edge that rounding decides: 1 in 1000, more where floats are so
    /// far from the origin that they cannot tell small things apart.
    double rounding_share_;
    TestNumbers numbers_;
    std::vector<Segment> slanted_;
    std::vector<Segment> straight_;
    std::vector<Segment> segments_;        ///< both
    std::vector<std::uint8_t> hit_;        ///< for each, asked alone
    std::vector<std::uint8_t> batch_hit_;  ///< for each, asked in batches
    std::vector<std::string> sentences_;
};

}  // namespace lightmesh::detail
