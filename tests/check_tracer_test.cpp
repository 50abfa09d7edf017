// SPDX-License-Identifier: MIT
#include <lightmesh/adapters/check_tracer.hpp>
#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

// Tracers that are right, and those that are wrong in one way each, over the same triangles.

namespace check_tracer_test {

namespace {

using lightmesh::Hit;
using lightmesh::Segment;
using Triangle = std::array<glm::vec3, 3>;

/// What of a tracer can be wrong.
enum class Fault {
    none,
    box_times_infinity,
    box_strict,
    one_sided,
    inclusive_origin,
    inclusive_target,
    normalised,
    t_to_length,
    length_zero,
    epsilon_of_t,
    determinant,
};

/// The segment's t where it crosses the triangle, in double; Moeller and Trumbore.
std::optional<double> crossing(const Segment& s, const Triangle& triangle, Fault fault) {
    const glm::dvec3 origin(s.origin);
    glm::dvec3 way = glm::dvec3(s.target) - origin;
    const double length = glm::length(way);
    if (fault == Fault::normalised)
        way /= length;
    const glm::dvec3 a(triangle[0]);
    const glm::dvec3 edge_1 = glm::dvec3(triangle[1]) - a;
    const glm::dvec3 edge_2 = glm::dvec3(triangle[2]) - a;
    const glm::dvec3 p = glm::cross(way, edge_2);
    const double determinant = glm::dot(edge_1, p);
    if (determinant == 0.0 || (fault == Fault::one_sided && determinant < 0.0) ||
        (fault == Fault::determinant && std::abs(determinant) < 1e-6))
        return std::nullopt;
    const double u = glm::dot(origin - a, p) / determinant;
    const glm::dvec3 q = glm::cross(origin - a, edge_1);
    const double v = glm::dot(way, q) / determinant;
    const double t = glm::dot(edge_2, q) / determinant;
    if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0))
        return std::nullopt;
    const double last = fault == Fault::t_to_length ? length : 1.0;
    const double first = fault == Fault::epsilon_of_t ? 1e-3 : 0.0;
    const bool is_after = fault == Fault::inclusive_origin ? t >= first : t > first;
    const bool is_before = fault == Fault::inclusive_target ? t <= last : t < last;
    return is_after && is_before ? std::optional(t) : std::nullopt;
}

/// The slab test that most tracers have: right if an empty product of zero and infinity is left out.
bool meets_box(const Segment& s, const glm::vec3& low, const glm::vec3& high, Fault fault) {
    float enter = -std::numeric_limits<float>::infinity();
    float leave = std::numeric_limits<float>::infinity();
    const glm::vec3 way = s.target - s.origin;
    for (int axis = 0; axis < 3; ++axis) {
        const float inverse = 1.0f / way[axis];
        if (way[axis] == 0.0f && fault != Fault::box_times_infinity) {
            if (s.origin[axis] < low[axis] || s.origin[axis] > high[axis])
                return false;
            continue;
        }
        const float a = low[axis] * inverse - s.origin[axis] * inverse;  // infinity - infinity
        const float b = high[axis] * inverse - s.origin[axis] * inverse;
        enter = (std::max)((std::min)(a, b), enter);
        leave = (std::min)((std::max)(a, b), leave);
        if (std::isnan(a) || std::isnan(b))
            return false;
    }
    const float margin = 1e-5f * (1.0f + std::abs(enter));  // The boxes are tested in float.
    return fault == Fault::box_strict ? enter < leave : enter - margin <= leave;
}

/// One box for each triangle.
struct Scene {
    std::vector<Triangle> triangles;
    Fault fault = Fault::none;

    std::optional<Hit> first(const Segment& s) const {
        std::optional<Hit> found;
        const float length = glm::length(s.target - s.origin);
        for (const Triangle& triangle : triangles) {
            if (fault == Fault::box_times_infinity || fault == Fault::box_strict) {
                const auto& [a, b, c] = triangle;
                if (!meets_box(s, glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)), fault))
                    continue;
            }
            const std::optional<double> t = crossing(s, triangle, fault);
            if (t && (!found || static_cast<float>(*t) * length < found->distance))
                found = Hit{static_cast<float>(*t) * length,
                            glm::normalize(glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]))};
        }
        return found;
    }

    bool occluded(const Segment& s) const {
        if (s.origin == s.target)
            return fault == Fault::length_zero;
        return first(s).has_value();
    }
};

/// The plain adapter.
struct Tracer {
    std::shared_ptr<const Scene> scene;

    bool occluded(const Segment& segment) const { return scene->occluded(segment); }
};

/// A tracer with all optional members.
struct FullTracer : Tracer {
    using Tracer::occluded;

    void occluded(std::span<const Segment> segments, std::span<std::uint8_t> hit) const {
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = occluded(segments[i]) ? 1 : 0;
    }
    std::optional<Hit> closest_hit(const Segment& segment) const { return scene->first(segment); }
};

/// Forgets what does not fill a packet of four.
struct WrongBatch : Tracer {
    using Tracer::occluded;

    void occluded(std::span<const Segment> segments, std::span<std::uint8_t> hit) const {
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = i < segments.size() / 4 * 4 && occluded(segments[i]) ? 1 : 0;
    }
};

/// Sets only what is blocked.
struct UnsetBatch : Tracer {
    using Tracer::occluded;

    void occluded(std::span<const Segment> segments, std::span<std::uint8_t> hit) const {
        for (std::size_t i = 0; i < segments.size(); ++i)
            if (occluded(segments[i]))
                hit[i] = 1;
    }
};

/// Keeps the ray in a place that all threads share; without a race, so that sanitizers are content.
struct SharedState : Tracer {
    std::shared_ptr<std::array<std::atomic<float>, 6>> ray =
        std::make_shared<std::array<std::atomic<float>, 6>>();
    std::shared_ptr<std::atomic<unsigned>> calls = std::make_shared<std::atomic<unsigned>>(0);

    bool occluded(const Segment& s) const {
        for (int axis = 0; axis < 3; ++axis) {
            (*ray)[static_cast<std::size_t>(axis)] = s.origin[axis];
            (*ray)[static_cast<std::size_t>(axis + 3)] = s.target[axis];
        }
        if (++*calls % 16 == 0)
            std::this_thread::yield();
        Segment shared{};
        for (int axis = 0; axis < 3; ++axis) {
            shared.origin[axis] = (*ray)[static_cast<std::size_t>(axis)];
            shared.target[axis] = (*ray)[static_cast<std::size_t>(axis + 3)];
        }
        return Tracer::occluded(shared);
    }
};

/// As most programs have it: the same in float, both tests.
struct FloatTracer : Tracer {
    bool occluded(const Segment& s) const {
        const glm::vec3 way = s.target - s.origin;
        return std::any_of(scene->triangles.begin(), scene->triangles.end(), [&](const Triangle& triangle) {
            const auto& [a, b, c] = triangle;
            if (!meets_box(s, glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)), Fault::none))
                return false;
            const glm::vec3 p = glm::cross(way, c - a);
            const float inverse = 1.0f / glm::dot(b - a, p);
            const float u = glm::dot(s.origin - a, p) * inverse;
            const glm::vec3 q = glm::cross(s.origin - a, b - a);
            const float v = glm::dot(way, q) * inverse;
            const float t = glm::dot(c - a, q) * inverse;
            return u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t > 0.0f && t < 1.0f;
        });
    }
};

/// Answers by turns.
struct Forgetful : Tracer {
    std::shared_ptr<std::atomic<unsigned>> calls = std::make_shared<std::atomic<unsigned>>(0);

    bool occluded(const Segment& segment) const { return Tracer::occluded(segment) && ++*calls % 8 != 0; }
};

/// closest_hit in the segment's parameter.
struct HitInParameter : Tracer {
    std::optional<Hit> closest_hit(const Segment& s) const {
        std::optional<Hit> hit = scene->first(s);
        if (hit)
            hit->distance /= glm::length(s.target - s.origin);
        return hit;
    }
};

struct HitWithLongNormal : Tracer {
    std::optional<Hit> closest_hit(const Segment& s) const {
        std::optional<Hit> hit = scene->first(s);
        if (hit)
            hit->normal *= 2.0f;
        return hit;
    }
};

/// A normal that is not the triangle's, as a shading normal is.
struct HitWithOtherNormal : Tracer {
    std::optional<Hit> closest_hit(const Segment& s) const {
        std::optional<Hit> hit = scene->first(s);
        if (hit)
            hit->normal = glm::normalize(hit->normal + glm::vec3(0.3f, 0.2f, 0.1f));
        return hit;
    }
};

/// Any surface, not the first.
struct AnyHit : Tracer {
    std::optional<Hit> closest_hit(const Segment& s) const {
        const std::optional<Hit> back = scene->first({s.target, s.origin});
        return back ? std::optional(Hit{glm::length(s.target - s.origin) - back->distance, back->normal})
                    : back;
    }
};

/// Blocked by more than closest_hit knows.
struct HitFromOneSide : Tracer {
    std::optional<Hit> closest_hit(const Segment& s) const {
        const std::optional<Hit> hit = scene->first(s);
        return hit && glm::dot(hit->normal, s.target - s.origin) < 0.0f ? hit : std::nullopt;
    }
};

struct Thrower : Tracer {
    bool occluded(const Segment&) const { throw std::runtime_error("no device"); }
};

/// A hall of 12 by 8 by 4 with a wall, a box and boards that hang in it at all angles.
std::vector<Triangle> hall() {
    std::vector<Triangle> scene;
    const auto quad = [&](const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v) {
        scene.push_back({corner, corner + u, corner + u + v});
        scene.push_back({corner, corner + u + v, corner + v});
    };
    quad({-6.0f, -4.0f, 0.0f}, {12.0f, 0.0f, 0.0f}, {0.0f, 8.0f, 0.0f});
    quad({-6.0f, -4.0f, 4.0f}, {12.0f, 0.0f, 0.0f}, {0.0f, 8.0f, 0.0f});
    quad({-1.5f, -4.0f, 0.0f}, {0.0f, 5.0f, 0.0f}, {0.0f, 0.0f, 4.0f});
    quad({2.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f}, {0.0f, 0.0f, 2.0f});
    quad({4.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f}, {0.0f, 0.0f, 2.0f});
    quad({2.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f});
    quad({2.0f, 2.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f});
    quad({2.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f});
    for (int i = 0; i < 5; ++i) {
        const float x = 2.0f * static_cast<float>(i) - 4.5f;
        quad({x, -3.0f + 0.7f * static_cast<float>(i), 1.0f}, {1.0f, 0.4f, 0.3f}, {-0.5f, 1.2f, 1.1f});
    }
    return scene;
}

constexpr lightmesh::Bounds hall_bounds{{-6.0f, -4.0f, 0.0f}, {6.0f, 4.0f, 4.0f}};

template <class Adapter>
Adapter make(std::span<const Triangle> triangles, Fault fault) {
    Adapter adapter;
    adapter.scene = std::make_shared<const Scene>(
        Scene{std::vector<Triangle>(triangles.begin(), triangles.end()), fault});
    return adapter;
}

template <class Adapter = Tracer>
std::vector<std::string> faults_in_hall(Fault fault = Fault::none) {
    return lightmesh::check_tracer(make<Adapter>(hall(), fault), hall_bounds);
}

template <class Adapter = Tracer>
std::vector<std::string> faults_of_factory(Fault fault = Fault::none) {
    return lightmesh::check_tracer(
        [&](std::span<const Triangle> triangles) { return make<Adapter>(triangles, fault); });
}

/// Whether one of the sentences says this, with how many of how many and an example.
bool says(const std::vector<std::string>& sentences, const std::string& what) {
    const bool is_said = std::any_of(sentences.begin(), sentences.end(), [&](const std::string& sentence) {
        return sentence.find(what) != std::string::npos && sentence.find(" of ") != std::string::npos &&
               sentence.find("for example from (") != std::string::npos;
    });
    for (const std::string& sentence : sentences)
        if (!is_said)
            MESSAGE(sentence);
    return is_said;
}

}  // namespace

TEST_CASE("check_tracer has nothing to say about right tracers") {
    const std::vector<std::string> none;
    CHECK(faults_in_hall() == none);
    CHECK(faults_in_hall<FullTracer>() == none);
    CHECK(faults_in_hall<FloatTracer>() == none);
    CHECK(faults_of_factory<FloatTracer>() == none);
    CHECK(faults_of_factory() == none);
    CHECK(faults_of_factory<FullTracer>() == none);
}

TEST_CASE("check_tracer: a hall far from the origin, tiny or huge, is as right") {
    for (const float scale : {1e-6f, 1e6f}) {
        for (const glm::vec3 shift : {glm::vec3(0.0f), glm::vec3(1e3f, -2e3f, 5e2f), glm::vec3(1e5f)}) {
            std::vector<Triangle> triangles = hall();
            for (Triangle& triangle : triangles)
                for (glm::vec3& corner : triangle)
                    corner = scale * (corner + shift);
            const lightmesh::Bounds bounds{scale * (hall_bounds.low + shift),
                                           scale * (hall_bounds.high + shift)};
            for (const std::string& sentence :
                 lightmesh::check_tracer(make<FullTracer>(triangles, Fault::none), bounds))
                FAIL_CHECK(sentence);
        }
    }
}

TEST_CASE("check_tracer: a box test that multiplies zero by infinity") {
    CHECK(says(faults_in_hall(Fault::box_times_infinity), "box test fails for directions with zeros"));
    CHECK(says(faults_of_factory(Fault::box_times_infinity), "box test fails for directions with zeros"));
}

TEST_CASE("check_tracer: a box test that loses flat boxes") {
    CHECK(says(faults_of_factory(Fault::box_strict), "loses boxes of thickness 0"));
}

TEST_CASE("check_tracer: surfaces that block from one side") {
    CHECK(says(faults_in_hall(Fault::one_sided), "surfaces must block from both sides"));
    CHECK(says(faults_of_factory(Fault::one_sided), "not blocked from one of its sides"));
}

TEST_CASE("check_tracer: inclusive ends") {
    CHECK(
        says(faults_of_factory(Fault::inclusive_origin), "exactly at their origin: both ends are exclusive"));
    CHECK(
        says(faults_of_factory(Fault::inclusive_target), "exactly at their target: both ends are exclusive"));
}

TEST_CASE("check_tracer: a length that is taken for another") {
    CHECK(says(faults_in_hall(Fault::normalised), "direction = target - origin is not normalised"));
    CHECK(says(faults_of_factory(Fault::normalised), "direction = target - origin is not normalised"));
    CHECK(says(faults_in_hall(Fault::t_to_length), "direction = target - origin is not normalised"));
    CHECK(says(faults_of_factory(Fault::t_to_length), "direction = target - origin is not normalised"));
}

TEST_CASE("check_tracer: segments of length 0, an epsilon, small triangles") {
    CHECK(says(faults_in_hall(Fault::length_zero), "segments of length 0 are blocked"));
    CHECK(says(faults_in_hall(Fault::epsilon_of_t), "must add no epsilon"));
    CHECK(says(faults_of_factory(Fault::epsilon_of_t), "must add no epsilon"));
    CHECK(says(faults_of_factory(Fault::determinant), "wrong at 1/1024 its size"));
}

TEST_CASE("check_tracer: batches that differ") {
    CHECK(says(faults_in_hall<WrongBatch>(), "in a batch of 1 to 64 than alone"));
    CHECK(says(faults_in_hall<UnsetBatch>(), "neither 0 nor 1 or not at all"));
}

TEST_CASE("check_tracer: state that threads share, answers that change") {
    CHECK(says(faults_in_hall<SharedState>(), "4 threads ask at once"));
    CHECK(says(faults_in_hall<Forgetful>(), "nothing but the segment"));
}

TEST_CASE("check_tracer: a closest_hit that does not fit") {
    CHECK(says(faults_in_hall<HitInParameter>(), "Hit::distance is in world units: t times"));
    CHECK(says(faults_in_hall<HitWithLongNormal>(), "not of length 1"));
    CHECK(says(faults_of_factory<HitWithOtherNormal>(), "not the sheet's"));
    CHECK(says(faults_in_hall<AnyHit>(), "nearest surface"));
    CHECK(says(faults_in_hall<HitFromOneSide>(), "where occluded says open, or none"));
}

TEST_CASE("check_tracer says when there is nothing to test, and refuses Bounds that are none") {
    const Tracer tracer = make<Tracer>(hall(), Fault::none);
    const lightmesh::Bounds elsewhere{glm::vec3(100.0f), glm::vec3(101.0f)};
    const std::vector<std::string> sentences = lightmesh::check_tracer(tracer, elsewhere);
    REQUIRE(sentences.size() == 1);
    CHECK(sentences[0].find("nothing could be tested") != std::string::npos);

    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_AS(lightmesh::check_tracer(tracer, {glm::vec3(0.0f), glm::vec3(nan)}),
                    std::invalid_argument);
    CHECK_THROWS_AS(lightmesh::check_tracer(tracer, {glm::vec3(1.0f), glm::vec3(0.0f)}),
                    std::invalid_argument);
    CHECK_THROWS_WITH(faults_in_hall<Thrower>(), "no device");
}

}  // namespace check_tracer_test
