// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernels.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

// Every kernel that the compiler's flags allow against the plainest loops. Which these are is up to the
// flags.

namespace {

using lightmesh::detail::AxisEntries;
using lightmesh::detail::CellRow;

constexpr int most_bricks = lightmesh::detail::Hemisphere::max_bricks_per_axis;

struct Entries {
    std::array<std::int32_t, 4 * most_bricks> x;
    std::array<std::int32_t, 4> y, z;

    Entries(test::Random& random, double limit) {
        for (auto* values : {y.data(), z.data()})
            for (int i = 0; i < 4; ++i)
                values[i] = static_cast<std::int32_t>(random.uniform(-limit, limit));
        for (std::int32_t& value : x)
            value = static_cast<std::int32_t>(random.uniform(-limit, limit));
    }
    AxisEntries pointers() const { return {x.data(), y.data(), z.data()}; }
};

std::uint64_t plain_mask(const Entries& square, const Entries& height, std::int32_t radius,
                         std::int32_t lowest, std::size_t brick) {
    std::uint64_t mask = 0;
    for (std::size_t z = 0; z < 4; ++z)
        for (std::size_t y = 0; y < 4; ++y)
            for (std::size_t x = 0; x < 4; ++x) {
                const std::size_t at = 4 * brick + x;
                const bool inside = square.x[at] + square.y[y] + square.z[z] < radius &&
                                    height.x[at] + height.y[y] + height.z[z] > lowest;
                const int bit =
                    lightmesh::detail::bit_of(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
                if (inside)
                    mask |= std::uint64_t{1} << bit;
            }
    return mask;
}

template <class Kernel>
void check_row_masks() {
    test::Random random(61);
    for (int round = 0; round < 300; ++round) {
        // From a few units, where ties abound, to the greatest that a hemisphere makes.
        const double limit = round % 3 == 0 ? 4.0 : round % 3 == 1 ? 1e5 : 4.6e8;
        const Entries square(random, limit);
        const Entries height(random, limit);
        const auto radius = static_cast<std::int32_t>(random.uniform(-limit, 1.2 * limit));
        const auto lowest = static_cast<std::int32_t>(random.uniform(-limit, limit));
        for (int bricks = 1; bricks <= most_bricks; ++bricks) {
            std::array<std::uint64_t, most_bricks + 1> masks{};
            masks[static_cast<std::size_t>(bricks)] = 0x1234;
            Kernel::row_masks(square.pointers(), height.pointers(), radius, lowest, bricks, masks.data());
            for (std::size_t b = 0; b < static_cast<std::size_t>(bricks); ++b)
                CHECK(masks[b] == plain_mask(square, height, radius, lowest, b));
            CHECK(masks[static_cast<std::size_t>(bricks)] == 0x1234);
        }
    }
}

template <class Kernel>
void check_add_lit() {
    test::Random random(62);
    std::vector<std::uint8_t> store(64 * 1000);
    for (std::uint8_t& byte : store)
        byte = static_cast<std::uint8_t>(random.below(8) == 0 ? 0xff : random.next());
    for (const int row_count : {0, 1, 2, 30, 31, 32, 61, 62, 63, 100, 264, 1000}) {
        std::vector<CellRow> rows;
        for (int r = 0; r < row_count; ++r) {
            const auto points = static_cast<std::uint8_t>(random.below(4) == 0 ? 0xff : random.next());
            rows.push_back({store.data() + 64 * random.below(1000), points});
        }
        for (std::uint32_t groups = 0; groups < 256; groups += groups < 16 ? 1 : 13) {
            for (const std::uint32_t mask : {groups, 255 - groups}) {
                std::array<std::uint16_t, 64> counts;
                for (std::uint16_t& count : counts)
                    count = static_cast<std::uint16_t>(random.below(5000));
                std::array<std::uint16_t, 64> expected = counts;
                for (std::size_t l = 0; l < 64; ++l) {
                    if ((mask >> (l / 8) & 1) == 0)
                        continue;
                    for (const CellRow& row : rows)
                        for (int bit = 0; bit < 8; ++bit)
                            expected[l] = static_cast<std::uint16_t>(expected[l] + (row.lit[l] & row.points) /
                                                                                       (1 << bit) % 2);
                }
                Kernel::add_lit(rows.data(), row_count, mask, counts.data());
                CHECK(counts == expected);
            }
        }
    }
}

}  // namespace

TEST_CASE("the portable kernel's masks are those of plain loops") {
    check_row_masks<lightmesh::detail::PortableKernel>();
}
TEST_CASE("the portable kernel's counts are those of plain loops") {
    check_add_lit<lightmesh::detail::PortableKernel>();
}

#if defined(LIGHTMESH_HAS_AVX2_KERNEL)
TEST_CASE("the AVX2 kernel's masks are those of plain loops") {
    check_row_masks<lightmesh::detail::Avx2Kernel>();
}
TEST_CASE("the AVX2 kernel's counts are those of plain loops") {
    check_add_lit<lightmesh::detail::Avx2Kernel>();
}
#endif

#if defined(LIGHTMESH_HAS_AVX512_KERNEL)
TEST_CASE("the AVX-512 kernel's masks are those of plain loops") {
    check_row_masks<lightmesh::detail::Avx512Kernel>();
}
TEST_CASE("the AVX-512 kernel's counts are those of plain loops") {
    check_add_lit<lightmesh::detail::Avx512Kernel>();
}
#endif
