// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/lightmesh.hpp>
#include <lightmesh/support/rounded.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// Values are the same to the bit whatever compiler, optimisation and processor: they are held against sums
// that are written here. One that differs because values were meant to change is printed, and takes the old
// one's place if all builds print it (see `tests/run.sh`, and `lightmesh-fused-values` in CMakeLists.txt).

namespace values_test {

namespace {

using lightmesh::ShortTest;
using lightmesh::detail::rounded;

/// FNV-1a over 32-bit words.
class Sum {
public:
    void add(std::uint32_t word) { sum_ = (sum_ ^ word) * 0x100000001b3u; }
    void add(float value) { add(std::bit_cast<std::uint32_t>(value)); }
    void add(const glm::vec3& v) {
        add(v.x);
        add(v.y);
        add(v.z);
    }
    std::uint64_t value() const { return sum_; }

private:
    std::uint64_t sum_ = 0xcbf29ce484222325u;
};

/// A floor and some boxes, of planes across the axes: each step of the arithmetic is rounded by itself. Of
/// all other segments one in 16 is blocked, by chance of all bits of its ends, if `is_grainy`: then the last
/// of them matters.
struct Boxes {
    bool is_grainy = false;

    static constexpr std::array<lightmesh::Bounds, 4> boxes{{{{-16, -16, -1}, {16, 16, 0}},
                                                             {{-1.5f, -1, 0}, {-0.5f, 1.25f, 1.75f}},
                                                             {{0.75f, -2, 0}, {1.5f, -0.5f, 0.625f}},
                                                             {{-2, 2, 1.125f}, {2, 2.5f, 1.25f}}}};

    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& s) const {
        const glm::dvec3 from(s.origin);
        const glm::dvec3 way = glm::dvec3(s.target) - from;
        double nearest = 1.0;
        int side = -1;
        for (const lightmesh::Bounds& box : boxes)
            for (int axis = 0; axis < 3; ++axis)
                for (const glm::vec3* corner : {&box.low, &box.high}) {
                    const double t = (static_cast<double>((*corner)[axis]) - from[axis]) / way[axis];
                    if (!(t > 0.0 && t < nearest))
                        continue;
                    const glm::dvec3 at = from + rounded(t * way);
                    bool is_in = true;
                    for (int other = 0; other < 3; ++other)
                        is_in &= other == axis || (at[other] >= static_cast<double>(box.low[other]) &&
                                                   at[other] <= static_cast<double>(box.high[other]));
                    if (is_in) {
                        nearest = t;
                        side = axis;
                    }
                }
        if (side < 0)
            return std::nullopt;
        glm::vec3 normal(0.0f);
        normal[side] = 1.0f;
        const glm::dvec3 squares = rounded(way * way);
        const double length = std::sqrt(squares.x + squares.y + squares.z);
        return lightmesh::Hit{static_cast<float>(nearest * length), normal};
    }

    bool occluded(const lightmesh::Segment& s) const {
        if (closest_hit(s))
            return true;
        Sum sum;
        sum.add(s.origin);
        sum.add(s.target);
        return is_grainy && (sum.value() >> 40) % 16 == 0;
    }
};

/// Multiples of 2^-10 from -range to range: exact.
float number(test::Random& random, int range) {
    return static_cast<float>(static_cast<int>(random.below(static_cast<std::size_t>(range) * 2048)) -
                              range * 1024) /
           1024.0f;
}

std::vector<lightmesh::Light> lights() {
    test::Random random(71);
    const auto vector = [&](int range) {
        const float x = number(random, range);
        const float y = number(random, range);
        return glm::vec3(x, y, number(random, range));
    };
    std::vector<lightmesh::Light> all;
    for (int i = 0; i < 14; ++i) {
        glm::vec3 at = vector(4);
        at.z = at.z < 0.0f ? 1.0f - at.z : 1.0f + at.z;
        const float size = static_cast<float>(i % 3) * 0.125f;
        all.emplace_back(lightmesh::PointLight{.position = at, .radius = size});
        all.emplace_back(lightmesh::PointLight{.position = at, .range = 2.5f, .radius = size});
        all.emplace_back(lightmesh::SpotLight{at, vector(3) - glm::vec3(0, 0, 5), 0.7f});
        all.emplace_back(lightmesh::DirectionalLight{vector(2) - glm::vec3(0, 0, 3)});
        // Far away: where floats are coarse, and beyond the grid.
        all.emplace_back(lightmesh::PointLight{.position = 65536.0f * at});
        all.emplace_back(lightmesh::PointLight{.position = 0x1p60f * at});
        all.emplace_back(
            lightmesh::RectLight{.position = at, .half_u = vector(1), .half_v = {0.5f, 0.375f, 0}});
    }
    return all;
}

std::vector<lightmesh::SurfacePoint> points(std::size_t count) {
    test::Random random(72);
    std::vector<lightmesh::SurfacePoint> all;
    while (all.size() < count) {
        const auto& box = Boxes::boxes[random.below(4)];
        const auto axis = static_cast<int>(random.below(3));
        lightmesh::SurfacePoint point;
        for (int other = 0; other < 3; ++other)
            point.position[other] = std::clamp(number(random, 3), box.low[other], box.high[other]);
        point.position[axis] = box.high[axis];
        // Of any length, and not quite across the surface.
        point.normal = {number(random, 1), number(random, 1), number(random, 1)};
        point.normal[axis] = 3.0f;
        all.push_back(point);
    }
    return all;
}

template <class Mesh>
std::uint64_t sum_of(const Mesh& mesh, std::size_t count) {
    Sum sum;
    std::vector<float> all(mesh.light_count());
    std::size_t between = 0;
    for (const lightmesh::SurfacePoint& point : points(count)) {
        mesh.visibility(point, all);
        for (const float lit : all) {
            sum.add(lit);
            between += lit > 0.0f && lit < 1.0f ? 1u : 0u;
        }
    }
    CHECK(between > count);
    return sum.value();
}

}  // namespace

TEST_CASE("a mesh has the same values whatever compiler and options it was built with") {
    struct Expected {
        ShortTest short_test;
        std::uint64_t smooth, grainy;
    };
    for (const Expected& expected :
         {Expected{ShortTest::exact, 12325293065515073879u, 5646277367616134389u},
          Expected{ShortTest::linked, 17600533078376434550u, 17907267227867137172u},
          Expected{ShortTest::none, 97685200855920833u, 16199275962621960502u}}) {
        for (const bool is_grainy : {false, true}) {
            CAPTURE(is_grainy);
            CAPTURE(static_cast<int>(expected.short_test));
            const lightmesh::Settings settings{
                .radius = 0.7f, .quality = 3.0f, .short_test = expected.short_test};
            const lightmesh::LightMesh mesh{Boxes{is_grainy}, lights(), settings};
            CHECK(sum_of(mesh, 300) == (is_grainy ? expected.grainy : expected.smooth));
        }
    }
}

TEST_CASE("a cache has the same values whatever compiler and options it was built with") {
    const lightmesh::VisibilityCache cache{Boxes{}, lights(), lightmesh::CacheSettings{.spacing = 0.3f}};
    CHECK(sum_of(cache, 200) == 18195433730110389525u);
    const lightmesh::VisibilityCache blur{
        lightmesh::LightMesh{Boxes{}, lights(), lightmesh::Settings{.radius = 0.7f, .quality = 3.0f}},
        lightmesh::CacheSettings{.spacing = 0.3f}};
    CHECK(sum_of(blur, 200) == 4669714354906066699u);
}

}  // namespace values_test
