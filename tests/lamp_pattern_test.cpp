// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lamp_pattern.hpp>
#include <lightmesh/cache/record.hpp>

#include <doctest/doctest.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <set>
#include <vector>

namespace lamp_pattern_test {

namespace {

using lightmesh::detail::disc_point;
using lightmesh::detail::Facing;
using lightmesh::detail::hash_of;
using lightmesh::detail::RecordKey;
using lightmesh::detail::RecordKind;
using lightmesh::detail::square_point;
using lightmesh::detail::turn_of;

/// The part of the unit disc that lies beyond a straight edge at a distance from its centre, -1 to 1.
double share_beyond(double distance) {
    return (std::acos(distance) - distance * std::sqrt(1.0 - distance * distance)) / std::numbers::pi;
}

/// By how much the share of points beyond an edge is wrong, for edges in all directions at all distances.
double error_of(const std::vector<glm::dvec2>& points) {
    constexpr int directions = 256;
    constexpr int distances = 200;
    double sum = 0.0;
    for (int i = 0; i < directions; ++i) {
        const double angle = 2.0 * std::numbers::pi * (i + 0.5) / directions;
        for (int k = 0; k < distances; ++k) {
            const double distance = 2.0 * (k + 0.5) / distances - 1.0;
            const auto beyond = std::ranges::count_if(points, [&](const glm::dvec2& p) {
                return p.x * std::cos(angle) + p.y * std::sin(angle) > distance;
            });
            const double error =
                static_cast<double>(beyond) / static_cast<double>(points.size()) - share_beyond(distance);
            sum += error * error;
        }
    }
    return std::sqrt(sum / (directions * distances));
}

std::vector<glm::dvec2> first_points(std::size_t count, std::uint32_t turn) {
    std::vector<glm::dvec2> points;
    for (std::size_t i = 0; i < count; ++i)
        points.push_back(disc_point(i, turn_of(turn)));
    return points;
}

/// The bits that turn the patterns of a record, as `CacheStore::look_of` takes them.
std::uint32_t bits_of(const glm::ivec3& index, const Facing& facing, int level) {
    RecordKey key(index, RecordKind::fallen, facing, level);
    key.words[static_cast<std::size_t>(facing.axis)] &= ~RecordKey::index_mask;
    return static_cast<std::uint32_t>(hash_of(key) >> 32);
}

/// The lattice point beside another one in a plane across its facing.
glm::ivec3 beside(const glm::ivec3& index, const Facing& facing, int step) {
    glm::ivec3 other = index;
    other[(facing.axis + 1 + step % 2) % 3] += step / 2 % 2 == 0 ? 1 : 2;
    return other;
}

}  // namespace

TEST_CASE("lamp patterns: edges split the points of a disc as they split its area") {
    for (const std::uint32_t turn : {0u, 1234u, 4095u}) {
        CAPTURE(turn);
        CHECK(error_of(first_points(16, turn)) < 0.034);
        CHECK(error_of(first_points(32, turn)) < 0.022);
        CHECK(error_of(first_points(64, turn)) < 0.014);
        CHECK(error_of(first_points(128, turn)) < 0.0075);
        CHECK(error_of(first_points(256, turn)) < 0.0045);
    }
    // What random points of a disc do.
    test::Random random(3);
    double square = 0.0;
    for (int turn = 0; turn < 40; ++turn) {
        std::vector<glm::dvec2> points;
        while (points.size() < 16) {
            const glm::dvec2 p(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
            if (p.x * p.x + p.y * p.y < 1.0)
                points.push_back(p);
        }
        square += error_of(points) * error_of(points) / 40.0;
    }
    CHECK(std::sqrt(square) == doctest::Approx(0.095).epsilon(0.06));
    for (const glm::dvec2& p : first_points(256, 77))
        CHECK(p.x * p.x + p.y * p.y <= 1.0 + 1e-6);
}

TEST_CASE("lamp patterns: points of a square lie one in each cell, however they are shifted") {
    test::Random random(4);
    for (int turn = 0; turn < 50; ++turn) {
        const std::uint32_t bits = turn == 0 ? 0u : random.next();
        for (const int side : {4, 16}) {
            std::set<int> cells;
            for (int i = 0; i < side * side; ++i) {
                const glm::dvec2 p = square_point(static_cast<std::uint32_t>(i), bits);
                REQUIRE(std::abs(p.x) < 1.0);
                REQUIRE(std::abs(p.y) < 1.0);
                cells.insert(static_cast<int>(0.5 * (p.x + 1.0) * side) * side +
                             static_cast<int>(0.5 * (p.y + 1.0) * side));
            }
            CHECK(cells.size() == static_cast<std::size_t>(side * side));
        }
    }
}

TEST_CASE("lamp patterns: turns lie evenly around the circle") {
    std::vector<double> angles;
    for (std::uint32_t bits = 0; bits < 4096; ++bits) {
        const glm::dvec2 turn = turn_of(bits);
        CHECK(turn.x * turn.x + turn.y * turn.y == doctest::Approx(1.0).epsilon(1e-12));
        angles.push_back(std::atan2(turn.y, turn.x));
    }
    std::ranges::sort(angles);
    double widest = angles.front() + 2.0 * std::numbers::pi - angles.back();
    for (std::size_t i = 1; i < angles.size(); ++i)
        widest = std::max(widest, angles[i] - angles[i - 1]);
    // They are even in the tangent of a half angle.
    CHECK(widest < 1.1 * 2.0 * std::numbers::pi / 4096.0);
}

TEST_CASE("lamp patterns: what neighbouring records miss of a lamp has nothing to do with each other") {
    constexpr int side = 24;
    // The edge of a shadow, across a lamp.
    const auto error_at = [](std::uint32_t bits) {
        const auto points = first_points(16, bits);
        const auto beyond =
            std::ranges::count_if(points, [](const glm::dvec2& p) { return 0.6 * p.x + 0.8 * p.y > 0.3; });
        return static_cast<double>(beyond) / 16.0 - share_beyond(0.3);
    };
    for (const int level : {9, 11})
        for (int axis = 0; axis < 3; ++axis)
            for (int step = 0; step < 4; ++step) {
                const Facing facing{axis, step % 2 == 0 ? 1.0f : -1.0f};
                CAPTURE(level);
                CAPTURE(axis);
                CAPTURE(step);
                std::array<std::complex<double>, 3> turns{};
                std::array<int, 16> shifts{};
                double products = 0.0;
                double squares = 0.0;
                double pairs = 0.0;
                for (int x = 0; x < side; ++x)
                    for (int y = 0; y < side; ++y) {
                        glm::ivec3 index(0);
                        index[(axis + 1) % 3] = x - side / 2;
                        index[(axis + 2) % 3] = y - side / 2;
                        const std::uint32_t bits = bits_of(index, facing, level);
                        const std::uint32_t other = bits_of(beside(index, facing, step), facing, level);
                        const glm::dvec2 a = turn_of(bits);
                        const glm::dvec2 b = turn_of(other);
                        const auto between =
                            std::complex<double>(a.x, a.y) * std::conj(std::complex<double>(b.x, b.y));
                        for (std::size_t k = 0; k < turns.size(); ++k)
                            turns[k] += std::pow(between, static_cast<double>(1 << 2 * k));
                        ++shifts[(bits ^ other) >> 12 & 15u];
                        products += error_at(bits) * error_at(other);
                        squares += error_at(bits) * error_at(bits);
                        pairs += 1.0;
                    }
                // Of independent turns these are 1 / sqrt(pairs), and the numbers of shifts a sixteenth.
                for (const std::complex<double>& turn : turns)
                    CHECK(std::abs(turn) / pairs < 3.5 / std::sqrt(pairs));
                CHECK(std::abs(products / squares) < 4.0 / std::sqrt(pairs));
                double chi_square = 0.0;
                for (const int count : shifts)
                    chi_square += (count - pairs / 16.0) * (count - pairs / 16.0) / (pairs / 16.0);
                CHECK(chi_square < 44.0);  // one of 10,000 by chance
            }
}

}  // namespace lamp_pattern_test
