// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

/// The segments that a tracer is asked about to test it.

namespace lightmesh::detail {

/// The same numbers on every machine: SplitMix64 (Steele, Lea and Flood 2014).
class TestNumbers {
public:
    /// In [low, high].
    float uniform(float low, float high) {
        const float x = static_cast<float>(static_cast<double>(next() >> 11) * 0x1p-53);
        return low + (high - low) * x;
    }

    /// In 0 .. count - 1.
    int below(int count) { return static_cast<int>(next() % static_cast<std::uint64_t>(count)); }

    /// A multiple of 1/64 in [low, high): sums and products of a few of them are exact.
    float dyadic(int low, int high) {
        return static_cast<float>(64 * low + below(64 * (high - low))) / 64.0f;
    }

    glm::vec3 inside(const Bounds& box) {
        const float x = uniform(box.low.x, box.high.x);
        const float y = uniform(box.low.y, box.high.y);
        const float z = uniform(box.low.z, box.high.z);
        return {x, y, z};
    }

private:
    std::uint64_t next() {
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }

    std::uint64_t state_ = 11;
};

inline Segment reversed(const Segment& segment) {
    return {segment.target, segment.origin};
}

/// The point at t; 0 is the origin, 1 the target. Segments along an axis stay exactly so.
inline glm::vec3 place_on(const Segment& segment, float t) {
    return segment.origin + t * (segment.target - segment.origin);
}

/// The box somewhat larger, and never flat. Throws std::invalid_argument for a box that is none.
inline Bounds test_bounds(const Bounds& scene) {
    require(is_finite(scene.low), "Bounds::low", scene.low, "finite");
    require(is_finite(scene.high), "Bounds::high", scene.high, "finite");
    const glm::vec3 size = scene.high - scene.low;
    require(size.x >= 0.0f && size.y >= 0.0f && size.z >= 0.0f, "Bounds::high", scene.high,
            "at least Bounds::low in each coordinate");
    require(is_finite(size), "Bounds::high", scene.high, "at a finite distance from Bounds::low");
    const float coordinate = (std::max)(largest_component(scene.low), largest_component(scene.high));
    float margin = (std::max)(largest_component(size) / 16.0f, coordinate * 0x1p-18f);
    if (!(margin > 0.0f))
        margin = 1.0f;
    return {scene.low - margin, scene.high + margin};
}

inline float largest_size(const Bounds& box) {
    return largest_component(box.high - box.low);
}

inline constexpr std::size_t test_segment_count = 2048;  ///< of either kind

/// Half of them over all of the box, the others shorter, down to 1/64 of it.
inline std::vector<Segment> slanted_segments(TestNumbers& numbers, const Bounds& box) {
    std::vector<Segment> segments;
    for (std::size_t i = 0; i < test_segment_count; ++i) {
        const glm::vec3 origin = numbers.inside(box);
        const Segment whole{origin, numbers.inside(box)};
        segments.push_back(
            {origin, i % 2 == 0 ? whole.target : place_on(whole, std::exp2(-numbers.uniform(0.0f, 6.0f)))});
    }
    return segments;
}

/// The same exactly along an axis, each of the three in turn.
inline std::vector<Segment> straight_segments(TestNumbers& numbers, const Bounds& box) {
    std::vector<Segment> segments = slanted_segments(numbers, box);
    for (std::size_t i = 0; i < segments.size(); ++i) {
        Segment& segment = segments[i];
        const int axis = static_cast<int>(i / 2 % 3);
        const float end = segment.target[axis];
        segment.target = segment.origin;
        segment.target[axis] = end;
    }
    return segments;
}

inline constexpr float test_tilt = 1e-4f;

/// A segment along an axis, its target moved to the side by `test_tilt` of its length, or by as much as
/// floats can tell.
inline Segment tilted(const Segment& segment) {
    const glm::vec3 direction = segment.target - segment.origin;
    const float shift =
        (std::max)(largest_component(direction) * test_tilt, largest_component(segment.target) * 0x1p-21f);
    Segment result = segment;
    for (int axis = 0; axis < 3; ++axis)
        if (direction[axis] == 0.0f)
            result.target[axis] += shift;
    return result;
}

}  // namespace lightmesh::detail
