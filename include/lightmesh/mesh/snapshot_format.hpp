// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/prefetch.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <variant>

/// One block of bytes that holds all of a mesh, and can stand anywhere in memory:
///
///     header | lights | levels | region slots | regions | bricks | tile indices | tiles | rows | words
///
/// Sections begin at multiples of 64 bytes. From the region slots on they hold what the levels know (see
/// `level.hpp`), level by level. Their structs are those of a live mesh (see `brick.hpp`), with the same
/// indices from one to the other, counted from where the level's own begin; regions stand in the order of
/// their keys, and all else in the order in which regions, bricks and cells name it, each part once: meshes
/// that know the same have the same bytes, and a reader takes no others.

namespace lightmesh::detail {

/// The place of a section.
struct SnapshotSection {
    std::uint64_t offset;  ///< from the first byte of the header
    std::uint64_t count;   ///< of its structs
};

enum SnapshotSectionName : std::size_t {
    lights_section,
    levels_section,
    region_slots_section,
    regions_section,
    bricks_section,
    tile_indices_section,
    tiles_section,
    rows_section,
    words_section,
    section_count
};

/// The sections of which each level has a part.
inline constexpr std::size_t first_level_section = region_slots_section;
inline constexpr std::size_t level_section_count = section_count - first_level_section;

/// A level but level 0, which is always there, and begins where the sections do.
struct SnapshotLevelRecord {
    std::uint64_t level;
    /// Of each section from `first_level_section` on the first struct of the level.
    std::array<std::uint64_t, level_section_count> first;
};

struct SnapshotHeader {
    static constexpr std::array<char, 8> right_magic{'l', 'i', 'g', 'h', 't', 'm', 's', 'h'};
    static constexpr std::uint32_t right_version = 3;
    static constexpr std::uint32_t right_byte_order = 0x01020304;

    std::array<char, 8> magic;
    std::uint32_t version;
    std::uint32_t byte_order;
    std::uint64_t size;      ///< of the whole block in bytes
    std::uint64_t checksum;  ///< of the whole block, this field taken for 0
    float radius;            ///< of level 0
    float quality;
    std::array<double, 3> origin;  ///< `Grid::origin` of level 0
    std::uint32_t short_test;
    std::uint32_t long_tests;  ///< `LongTest`: bits are merged only with those of the same kind
    std::uint32_t adaptive;    ///< 1 if long tests were found by samples, else 0
    float footprint_scale;
    std::uint32_t has_given_origin;  ///< 0 if the origin is the one that `Grid` chooses
    std::uint32_t unused;
    std::array<SnapshotSection, section_count> sections;
};

/// A light in a snapshot.
struct LightRecord {
    std::uint32_t kind;            ///< place in the variant
    std::array<float, 11> values;  ///< its members, in their order; 0 beyond them

    bool operator==(const LightRecord&) const = default;
};

inline LightRecord record_of(const Light& light) {
    LightRecord record{static_cast<std::uint32_t>(light.index()), {}};
    std::size_t size = 0;
    const auto add = [&](auto value) {
        if constexpr (std::is_same_v<decltype(value), glm::vec3>) {
            for (int axis = 0; axis < 3; ++axis)
                record.values[size++] = value[axis];
        } else {
            record.values[size++] = value;
        }
    };
    std::visit(
        [&](const auto& kind) {
            using Kind = std::remove_cvref_t<decltype(kind)>;
            if constexpr (std::is_same_v<Kind, PointLight>)
                add(kind.position), add(kind.range), add(kind.radius);
            else if constexpr (std::is_same_v<Kind, DirectionalLight>)
                add(kind.direction), add(kind.angular_radius);
            else if constexpr (std::is_same_v<Kind, SpotLight>)
                add(kind.position), add(kind.axis), add(kind.cone), add(kind.range), add(kind.radius);
            else
                add(kind.position), add(kind.half_u), add(kind.half_v), add(kind.range);
        },
        light);
    return record;
}

/// The inverse of `record_of`, for kinds that exist.
inline Light light_of(const LightRecord& record) {
    const auto& v = record.values;
    const auto vector = [&v](std::size_t first) {
        return glm::vec3(v[first], v[first + 1], v[first + 2]);
    };
    switch (record.kind) {
    case 0:
        return PointLight{vector(0), v[3], v[4]};
    case 1:
        return DirectionalLight{vector(0), v[3]};
    case 2:
        return SpotLight{vector(0), vector(3), v[6], v[7], v[8]};
    default:
        return RectLight{vector(0), vector(3), vector(6), v[9]};
    }
}

/// A sum over 64-bit words in eight lanes, so that it runs at the speed of memory. Each step is a bijection:
/// a single word that differs always shows.
inline std::uint64_t checksum_of(std::span<const std::byte> bytes) {
    constexpr std::uint64_t factor = 0x9e3779b97f4a7c15u;
    constexpr std::size_t lines_ahead = 32;
    const std::byte* at = bytes.data();
    const auto add = [&at](std::uint64_t& lane, std::size_t index) {
        std::uint64_t word;
        std::memcpy(&word, at + 8 * index, 8);
        lane = ((lane ^ word) * factor) ^ (lane >> 32);
    };
    // No array and no loop: of these compilers make vectors, which have no such product.
    std::uint64_t a = 1, b = 2, c = 3, d = 4, e = 5, f = 6, g = 7, h = 8;
    std::size_t left = bytes.size();
    for (; left >= 64; left -= 64, at += 64) {
        prefetch(at + (std::min)(64 * lines_ahead, left));
        add(a, 0), add(b, 1), add(c, 2), add(d, 3), add(e, 4), add(f, 5), add(g, 6), add(h, 7);
    }
    const std::array<std::uint64_t, 8> lanes{a, b, c, d, e, f, g, h};
    std::array<std::uint64_t, 8> rest{};
    if (left != 0)
        std::memcpy(rest.data(), at, left);
    std::uint64_t sum = bytes.size();
    for (std::size_t lane = 0; lane < 8; ++lane) {
        const std::uint64_t last = (lanes[lane] ^ rest[lane]) * factor;
        sum = (sum ^ last ^ last >> 29) * factor;
    }
    return sum ^ sum >> 32;
}

/// The checksum of a block whose header is `header`.
template <class Header>
std::uint64_t checksum_of(Header header, std::span<const std::byte> block) {
    header.checksum = 0;
    const std::uint64_t of_header = checksum_of(std::as_bytes(std::span<const Header>(&header, 1)));
    return (of_header ^ 0x5851f42d4c957f2du) * 3 + checksum_of(block.subspan(sizeof header));
}

}  // namespace lightmesh::detail
