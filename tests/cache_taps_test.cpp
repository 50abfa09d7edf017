// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/cache/taps.hpp>
#include <lightmesh/support/vectors.hpp>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace cache_taps_test {

namespace {

using lightmesh::detail::CellSurface;
using lightmesh::detail::Fits;

glm::vec3 unit_vector(test::Random& random) {
    return lightmesh::detail::unit_or_zero(glm::vec3(random.direction()));
}

std::int32_t parts_of_256(double share) {
    return static_cast<std::int32_t>(256.0 * std::clamp(share, 0.0, 1.0));
}

TEST_CASE("records fit a point by their distance from its plane and by their normals") {
    test::Random random(61);
    std::size_t suspects = 0;
    std::size_t clear = 0;
    std::size_t whole = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        const double step = std::exp2(random.uniform(-6.0, 6.0));
        const glm::vec3 point(glm::dvec3(step * 100.0 * random.direction()));
        const glm::vec3 n = unit_vector(random);
        CellSurface surface;
        for (std::size_t k = 0; k < 4; ++k) {
            // On the point's plane, or beside it.
            const double height = random.below(2) == 0 ? 0.0 : step * random.uniform(-0.6, 0.6);
            glm::dvec3 offset = step * random.direction();
            offset += (height - glm::dot(offset, glm::dvec3(n))) * glm::dvec3(n);
            const glm::vec3 normal = random.below(4) == 0   ? glm::vec3(0.0f)
                                     : random.below(2) == 0 ? n
                                                            : unit_vector(random);
            surface.set(k, glm::vec3(glm::dvec3(point) + offset), normal);
        }
        const Fits fits = lightmesh::detail::fits_of(surface, point, n, step);
        bool all_fit = true;
        bool one_tells = false;
        bool none_contradicts = true;
        for (std::size_t k = 0; k < 4; ++k) {
            const glm::dvec3 away(surface.x[k] - point.x, surface.y[k] - point.y, surface.z[k] - point.z);
            const glm::dvec3 m(surface.normal_x[k], surface.normal_y[k], surface.normal_z[k]);
            const glm::dvec3 p(n);
            const double before = p.x * away.x + p.y * away.y + p.z * away.z;
            const double behind = m.x * away.x + m.y * away.y + m.z * away.z;
            const double cosine = p.x * m.x + p.y * m.y + p.z * m.z;
            const std::int32_t alike = parts_of_256((cosine - 0.65) * 10.0);
            const std::int32_t share =
                parts_of_256((0.45 * step - std::abs(before)) * (5.0 / step)) * alike >> 8;
            CHECK(fits.shares[k] == share);
            CHECK(fits.alike[k] == alike);
            const double largest = std::max({std::abs(point.x), std::abs(point.y), std::abs(point.z)});
            const double least = 0.003 * step + largest * 0x1p-21;
            const bool is_suspect = before > least && behind > least;
            const bool is_clear = before < -least || behind < -least || m == glm::dvec3(0.0);
            CHECK((fits.suspect >> k & 1u) == (is_suspect ? 1u : 0u));
            CHECK((fits.clear >> k & 1u) == (is_clear ? 1u : 0u));
            suspects += is_suspect ? 1 : 0;
            clear += is_clear ? 1 : 0;
            whole += share == 256 ? 1 : 0;
            all_fit &= share > 0;
            one_tells |= share == 256;
            none_contradicts &= share == 256 || is_clear;
        }
        CHECK(fits.are_enough() == (fits.suspect == 0 && (all_fit || (one_tells && none_contradicts))));
    }
    CHECK(suspects > 1000);
    CHECK(clear > 1000);
    CHECK(whole > 1000);
}

}  // namespace

}  // namespace cache_taps_test
