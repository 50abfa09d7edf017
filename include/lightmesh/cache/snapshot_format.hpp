// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/settings.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

/// One block of bytes that holds all that a cache knows, and can stand anywhere in memory:
///
///     header | lights | slots | records | aliases | tiles | octets
///
/// Sections begin at multiples of 64 bytes. Records and aliases stand in the order of their keys, tiles and
/// octets in the order of the records that they belong to: caches that know the same have the same bytes.

namespace lightmesh::detail {

enum CacheSectionName : std::size_t {
    cache_lights_section,
    cache_slots_section,
    cache_records_section,
    cache_aliases_section,
    cache_tiles_section,
    cache_octets_section,
    cache_section_count
};

/// The way that records found their surfaces: values are merged only with those of the same kind.
enum class HitKind : std::uint32_t { closest_hit, bisected };

template <Intersector Tracer>
constexpr HitKind hit_kind() {
    return ClosestHitIntersector<Tracer> ? HitKind::closest_hit : HitKind::bisected;
}

/// The values that rows hold.
struct RowSource {
    std::uint32_t is_mesh = 0;  ///< 1: S of a light mesh, which has what follows; else 0, as all of it
    std::uint32_t long_tests = 0;
    std::uint32_t short_test = 0;
    std::uint32_t adaptive = 0;  ///< 1: adaptive long tests
    float radius = 0.0f;
    float quality = 0.0f;
    std::uint32_t has_origin = 0;
    std::array<float, 3> origin{};

    RowSource() = default;
    RowSource(const Settings& settings, LongTest kind)
        : is_mesh(1), long_tests(static_cast<std::uint32_t>(kind)),
          short_test(static_cast<std::uint32_t>(settings.short_test)),
          adaptive(settings.adaptive_long_tests ? 1 : 0), radius(settings.radius), quality(settings.quality) {
        if (std::isnan(settings.origin.x))
            return;
        has_origin = 1;
        origin = {settings.origin.x, settings.origin.y, settings.origin.z};
    }

    Settings settings() const {
        Settings of_mesh;
        if (is_mesh == 0)
            return of_mesh;
        of_mesh.radius = radius;
        of_mesh.quality = quality;
        of_mesh.short_test = static_cast<ShortTest>(short_test);
        of_mesh.adaptive_long_tests = adaptive != 0;
        if (has_origin != 0)
            of_mesh.origin = {origin[0], origin[1], origin[2]};
        return of_mesh;
    }

    bool operator==(const RowSource&) const = default;
};

struct CacheHeader {
    static constexpr std::array<char, 8> right_magic{'l', 'i', 'g', 'h', 't', 'c', 'c', 'h'};
    static constexpr std::uint32_t right_version = 8;
    static constexpr std::uint32_t right_byte_order = SnapshotHeader::right_byte_order;

    std::array<char, 8> magic;
    std::uint32_t version;
    std::uint32_t byte_order;
    std::uint64_t size;      ///< of the whole block in bytes
    std::uint64_t checksum;  ///< of the whole block, this field taken for 0
    float spacing;
    std::int32_t detail;
    std::int32_t lamp_rays;
    std::uint32_t exact_edges;
    std::uint32_t has_origin;  ///< 0: the default
    std::array<float, 3> origin;
    std::uint32_t hits;  ///< `HitKind`
    RowSource row_source;
    std::uint32_t shaft_rows;
    std::array<SnapshotSection, cache_section_count> sections;
};

struct StoredRecord {
    RecordKey key;
    float fall;
    std::array<std::int16_t, 3> normal;
    std::uint16_t links;
    std::uint32_t first_tile;
    std::uint32_t tile_count;
};

/// A key that leads to a record with another key.
struct StoredAlias {
    RecordKey key;
    std::uint32_t record;
};

/// The values of a tile of lights, as far as they are known: those of the octets that have known lights stand
/// side by side. Bytes of lights that are not known are 0.
struct StoredTile {
    std::uint32_t tile;
    std::uint32_t first_octet;
    std::uint64_t known;
};

/// Slots hold 0, an index of a record plus one, or with this bit that of an alias.
inline constexpr std::uint32_t stored_alias_bit = 1u << 31;

/// True if bytes begin as a cache's snapshot does.
inline bool is_cache_snapshot(std::span<const std::byte> bytes) {
    return bytes.size() >= CacheHeader::right_magic.size() &&
           std::memcmp(bytes.data(), CacheHeader::right_magic.data(), CacheHeader::right_magic.size()) == 0;
}

}  // namespace lightmesh::detail
