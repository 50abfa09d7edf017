// SPDX-License-Identifier: MIT
#include "kernels_that_run.hpp"
#include "random_scene.hpp"

#include <lightmesh/cache/kernels/kernels.hpp>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace cache_kernels_test {

namespace {

using namespace lightmesh::detail;

std::uint64_t bits_of(test::Random& random) {
    return random.next() | static_cast<std::uint64_t>(random.next()) << 32;
}

/// As the kernels' docs say, light by light. Returns whether the next level has to say something.
bool blend_one(std::uint32_t& found, std::uint32_t& left, const BlendLevel& level, std::size_t light) {
    const auto byte_of = [&](std::size_t record) {
        return static_cast<std::uint32_t>(level.values->octet(record, light / 8) >> light % 8 * 8 & 255u);
    };
    std::uint32_t sum = 64;
    std::uint32_t least = 255;
    std::uint32_t greatest = 0;
    for (std::size_t k = 0; k < level.taps; ++k) {
        const std::uint32_t byte = byte_of(level.records[k]);
        sum += level.weights[k] * byte;
        least = (std::min)(least, byte);
        greatest = (std::max)(greatest, byte);
    }
    const std::uint32_t value = sum >> 7;
    std::uint32_t beta = 0;
    if (!level.is_last) {
        std::uint32_t spread = 0;
        for (std::size_t k = 0; k < level.taps; ++k) {
            const std::uint32_t byte = byte_of(level.records[k]) << 8;
            const std::uint32_t difference = byte > value ? byte - value : value - byte;
            spread = (std::max)(spread, difference * level.spread_weight(k) >> 15);
        }
        spread = spread * (512 - ((std::min)(2 * value, one_value) >> 8)) >> 8;
        const std::uint32_t t =
            2 * std::clamp<std::uint32_t>((std::max)(spread, level.spread_low) - level.spread_low, 0,
                                          spread_range);
        beta = (t * t >> 15) * (3u * one_weight - 2 * t) >> 15;
        const std::uint32_t probe = byte_of(CellValues::centre);
        if ((probe == 0 && least > open_from) || (probe == 255 && greatest < closed_to) ||
            (probe == probe_sees_both && (least == 255 || greatest == 0)))
            beta = (std::max)(beta, level.window);
        for (std::size_t k = 0; k < level.taps; ++k)
            if (level.records[k] < CellValues::first_in_air &&
                (level.values->misses[level.records[k]] >> light & 1) != 0)
                beta = (std::max)(beta, (std::min)(8 * level.weights[k], std::uint32_t{one_weight}));
        if (greatest > 0)
            beta = (std::max)(beta, level.missing);
        beta = (std::max)(beta, level.force) * (level.fade >> 1) >> 14;
    }
    std::uint32_t rest = left * beta >> 15;
    rest = rest < 64 ? 0 : rest;
    found += (left - rest) * value;
    left = rest;
    return rest != 0;
}

}  // namespace

TEST_CASE("kernels of the cache blend as a plain loop over lights does, to the bit") {
    test::Random random(7);
    for (const CacheKernels* kernels : test::cache_kernels_that_run()) {
        CAPTURE(kernels->name);
        for (int trial = 0; trial < 3000; ++trial) {
            CellValues values;
            values.begin(0);
            // Rows that often agree, as real ones do, and are often all dark or all lit.
            for (std::size_t o = 0; o < 8; ++o) {
                const auto any = [&] {
                    const std::size_t kind = random.below(4);
                    return kind == 0 ? 0u : kind == 1 ? ~std::uint64_t{0} : bits_of(random);
                };
                const std::uint64_t common = any();
                for (RowBytes& row : values.rows)
                    row.octets[o] = random.below(3) > 0 ? common : any();
            }
            for (std::size_t o = 0; o < 8; ++o)
                if (random.below(2) == 0)
                    values.rows[CellValues::centre].octets[o] = 0x7f'00'ff'7f'80'7f'00'ffu;
            BlendLevel level;
            level.values = &values;
            level.taps = 1 + random.below(8);
            std::uint32_t weight_left = one_weight;
            for (std::size_t k = 0; k < level.taps; ++k) {
                const bool is_last = k + 1 == level.taps;
                const auto weight =
                    is_last ? weight_left : static_cast<std::uint32_t>(random.below(weight_left + 1));
                weight_left -= weight;
                level.set(k, k, weight);
            }
            level.pad();
            level.is_last = random.below(4) == 0;
            for (std::size_t k = 0; k < CellValues::first_in_air; ++k)
                values.misses[k] = random.below(2) == 0 ? 0 : bits_of(random) & bits_of(random);
            for (std::size_t k = 0; k < (std::min)(level.taps, CellValues::first_in_air); ++k)
                level.misses |= values.misses[k];
            level.window =
                random.below(2) == 0 ? 0 : static_cast<std::uint32_t>(random.below(one_weight + 1));
            level.missing =
                random.below(2) == 0 ? 0 : static_cast<std::uint32_t>(random.below(one_weight + 1));
            level.spread_low = spread_lows[random.below(3)];
            level.force = random.below(4) == 0 ? one_weight : 0;
            level.fade =
                static_cast<std::uint32_t>(random.below(2) == 0 ? one_weight : random.below(one_weight + 1));

            // Many lights, or a few, which kernels may handle otherwise.
            const bool are_few = random.below(3) == 0;
            const auto one_bit = [&] {
                return std::uint64_t{1} << random.below(64);
            };
            const std::uint64_t lights =
                are_few ? one_bit() | one_bit() | one_bit() : bits_of(random) & bits_of(random);
            Blend blend;
            kernels->start(blend, lights);
            const std::uint64_t given = are_few ? lights & one_bit() : lights & bits_of(random);
            kernels->give_to_first(blend, values, given);
            const std::uint64_t asked = lights & ~given;
            const std::uint64_t next = kernels->blend_level(blend, asked, level);

            std::array<float, lamps_per_tile> lit;
            const auto count = 1 + random.below(64);
            kernels->write_blend(blend, std::span<float>(lit).first(count));
            for (std::size_t l = 0; l < lamps_per_tile; ++l) {
                std::uint32_t found = 0;
                std::uint32_t left = (lights >> l & 1) != 0 ? one_weight : 0;
                bool is_next = false;
                if ((given >> l & 1) != 0)
                    found = static_cast<std::uint32_t>(values.octet(0, l / 8) >> l % 8 * 8 & 255u) << 23;
                else if ((asked >> l & 1) != 0)
                    is_next = blend_one(found, left, level, l);
                CAPTURE(l);
                const std::uint32_t blended = blend.found[l / 8][l % 8];
                REQUIRE(blended == found);
                REQUIRE(((next >> l & 1) != 0) == is_next);
                if (l < count)
                    REQUIRE(lit[l] == static_cast<float>(found) * (1.0f / (65280.0f * 32768.0f)));
            }
        }
    }
}

TEST_CASE("kernels of the cache find the same lights in reach as exact sums do") {
    test::Random random(8);
    for (int trial = 0; trial < 200; ++trial) {
        LampColumns lamps;
        const auto size = 1 + random.below(64);
        const bool has_ranges = trial % 2 == 0;
        for (std::size_t l = 0; l < size; ++l) {
            if (random.below(5) == 0) {
                lamps.set(l, Lamp(lightmesh::DirectionalLight{.direction = glm::vec3(random.direction())}));
                continue;
            }
            lightmesh::PointLight light{.position =
                                            glm::vec3(random.in_box(test::Vec(-4.0), test::Vec(4.0)))};
            if (has_ranges)
                light.range = static_cast<float>(random.uniform(0.5, 6.0));
            lamps.set(l, Lamp(light));
        }
        const glm::vec3 point = glm::vec3(random.in_box(test::Vec(-4.0), test::Vec(4.0)));
        const glm::vec3 normal = random.below(4) == 0 ? glm::vec3(0, 0, 1) : glm::vec3(random.direction());
        std::uint64_t expected = 0;
        for (std::size_t l = 0; l < size; ++l) {
            const glm::dvec3 at(lamps.at_x[l], lamps.at_y[l], lamps.at_z[l]);
            const double near = lamps.w[l];
            const glm::dvec3 n(normal);
            const glm::dvec3 p(point);
            const double facing =
                n.x * at.x + n.y * at.y + n.z * at.z - near * (n.x * p.x + n.y * p.y + n.z * p.z);
            const glm::dvec3 way(glm::vec3(at - p));
            const bool in_range =
                near == 0.0 || way.x * way.x + way.y * way.y + way.z * way.z <= lamps.range_squared[l];
            expected |= std::uint64_t{facing >= 0.0 && in_range} << l;
        }
        for (const CacheKernels* kernels : test::cache_kernels_that_run()) {
            CAPTURE(kernels->name);
            const std::uint64_t mask = size < 64 ? (std::uint64_t{1} << size) - 1 : ~std::uint64_t{0};
            CHECK((kernels->find_reaching(lamps, size, point, normal) & mask) == expected);
        }
    }
}

}  // namespace cache_kernels_test
