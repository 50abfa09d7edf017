// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache/snapshot_reader.hpp>
#include <lightmesh/gpu/upload.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/surface_point.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <variant>
#include <vector>

namespace lightmesh {

/// A point for which a shader did not know S of all lights, and asked.
struct CacheRequest {
    SurfacePoint point;    ///< as the shader was given it
    std::uint32_t id = 0;  ///< what the shader gave with it
    /// Whether the snapshot lacks records or values: `VisibilityCache::fill` finds them.
    bool lacks_values = false;
    /// Whether it takes rays that a cache does not keep: `VisibilityCache::visibility` has the answer.
    bool lacks_rays = false;
};

/// A cache as shaders read it (see cache.glsl): what to bind. Made from a `SnapshotView`, which has checked
/// all bytes. Lamp rows, with shaft rows or without, and blur rows alike; any number of lights and of levels.
///
///     CacheUpload upload{view};                                      // a SnapshotView of a cache
///     for (const UploadBuffer& buffer : upload.buffers())  ...       // create and bind them
///     ... and a request buffer, CacheUpload::empty_requests(1000), as requests_binding. After a run:
///     for (const CacheRequest& request : CacheUpload::requests(bytes))  ...
/// and those are what to fill the cache with, before the next snapshot.
class CacheUpload {
public:
    /// Number of `buffers`.
    static constexpr std::uint32_t buffer_count = 2;
    /// Of the request buffer, counted from LIGHTMESH_CACHE_BINDING.
    static constexpr std::uint32_t requests_binding = 2;

    /// `view` and its bytes must outlive this. Throws std::invalid_argument if it is of a mesh,
    /// std::length_error if it is too large for 32-bit indices, and std::bad_alloc.
    explicit CacheUpload(const SnapshotView& view) : CacheUpload(reader_of(view)) {}
    /// A view that is about to vanish is a mistake.
    explicit CacheUpload(SnapshotView&&) = delete;

    /// The buffers from LIGHTMESH_CACHE_BINDING on, all of their bytes: places with lights and settings, and
    /// values, which are bytes of the snapshot itself.
    std::array<UploadBuffer, buffer_count> buffers() const {
        return {UploadBuffer{0, std::as_bytes(std::span(words_))}, UploadBuffer{1, values_}};
    }

    /// Bytes of an empty request buffer with room for so many points: what is written to it before each run
    /// of a shader. Of a used one only the first 16 bytes need to be written anew. Throws
    /// std::invalid_argument for none, or more than 2^26.
    static std::vector<std::byte> empty_requests(std::size_t capacity) {
        detail::check_request_capacity(capacity);
        std::vector<std::byte> bytes(request_header + capacity * request_size);
        const auto room = static_cast<std::uint32_t>(capacity);
        std::memcpy(bytes.data() + sizeof room, &room, sizeof room);
        return bytes;
    }
    /// How many points have asked, also those for which there was no room. Throws std::invalid_argument if
    /// these are not the bytes of a request buffer.
    static std::size_t request_count(std::span<const std::byte> bytes) {
        std::array<std::uint32_t, 2> head{};
        if (bytes.size() >= request_header)
            std::memcpy(head.data(), bytes.data(), sizeof head);
        if (head[1] == 0 || bytes.size() != request_header + std::size_t{head[1]} * request_size)
            detail::throw_no_request_buffer();
        return head[0];
    }
    /// The points for which there was room, in no order. Throws as above, and std::bad_alloc.
    static std::vector<CacheRequest> requests(std::span<const std::byte> bytes) {
        std::vector<CacheRequest> found(
            (std::min)(request_count(bytes), (bytes.size() - request_header) / request_size));
        const std::byte* at = bytes.data() + request_header;
        for (CacheRequest& request : found) {
            std::array<float, request_size / sizeof(float)> v;
            std::memcpy(v.data(), at, request_size);
            at += request_size;
            const auto lacks = std::bit_cast<std::uint32_t>(v[11]);
            request = {.point = {.position = {v[0], v[1], v[2]},
                                 .normal = {v[4], v[5], v[6]},
                                 .footprint = v[3],
                                 .shading_normal = {v[8], v[9], v[10]}},
                       .id = std::bit_cast<std::uint32_t>(v[7]),
                       .lacks_values = (lacks & 1u) != 0,
                       .lacks_rays = (lacks & 2u) != 0};
        }
        return found;
    }

private:
    /// Four words, as shaders read them.
    using Word = std::array<std::uint32_t, 4>;

    static constexpr std::size_t request_header = 16;
    static constexpr std::size_t request_size = 48;
    static constexpr std::uint32_t lights_are_directional = 1;
    static constexpr std::uint32_t lights_have_cones = 2;
    static constexpr std::uint32_t cones_are_wide = 4;
    static constexpr std::uint32_t lights_are_rectangles = 8;

    explicit CacheUpload(const detail::CacheReader& reader) : values_(std::as_bytes(reader.octets())) {
        const std::size_t keys = reader.records().size() + reader.aliases().size();
        const std::size_t slots = std::bit_ceil(2 * keys + 2);
        std::size_t tiles = 0;
        for (const detail::StoredRecord& record : reader.records())
            tiles += record.tile_count;
        const std::size_t slots_at = 3 + 5 * detail::Lattice::level_count;
        const std::size_t records_at = slots_at + slots;
        const std::size_t tiles_at = records_at + 2 * reader.records().size();
        const std::size_t lights_at = tiles_at + tiles;
        const std::size_t size = lights_at + 6 * reader.lamps().size();
        if (size > (std::numeric_limits<std::uint32_t>::max)() || 2 * keys + 2 > std::size_t{1} << 31 ||
            values_.size() / 4 > (std::numeric_limits<std::uint32_t>::max)())
            throw std::length_error("lightmesh: the cache is too large for a shader");
        words_.resize(size);
        const std::uint32_t finest = static_cast<std::uint32_t>(reader.lattice().finest_level()) |
                                     (reader.settings().exact_edges ? 256u : 0u) |
                                     (reader.settings().shaft_rows ? 512u : 0u);
        words_[0] = {word(reader.lamps().size()), word(reader.lamps().tile_count()), word(slots - 1), finest};
        words_[1] = {word(slots_at), word(records_at), word(tiles_at), word(lights_at)};
        add_lattice(reader.lattice());
        add_records(reader, {slots_at, slots, records_at, tiles_at});
        for (std::size_t i = 0; i < reader.lamps().size(); ++i)
            add_light(lights_at + 6 * i, reader.lamps().lamp(i), reader.user_lights()[i]);
    }

    /// Where sections begin.
    struct Sections {
        std::size_t slots, slot_count, records, tiles;
    };

    static const detail::CacheReader& reader_of(const SnapshotView& view) {
        const detail::CacheReader* reader = detail::SnapshotReaders::cache(view);
        if (reader == nullptr)
            throw std::invalid_argument("lightmesh: this snapshot is of a mesh, not of a cache");
        return *reader;
    }

    static std::uint32_t word(std::size_t value) { return static_cast<std::uint32_t>(value); }
    static std::uint32_t word(float value) { return std::bit_cast<std::uint32_t>(value); }
    static Word pair(double a, double b) {
        const auto x = std::bit_cast<std::uint64_t>(a);
        const auto y = std::bit_cast<std::uint64_t>(b);
        return {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(x >> 32),
                static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(y >> 32)};
    }
    static Word triple(const glm::vec3& v, std::uint32_t last) {
        return {word(v.x), word(v.y), word(v.z), last};
    }

    void add_lattice(const detail::Lattice& lattice) {
        words_[2] = pair(lattice.step(lattice.finest_level()) * (detail::Lattice::max_index - 64.0), 0.0);
        for (int level = 0; level < detail::Lattice::level_count; ++level) {
            const double step = lattice.step(level);
            const glm::dvec3 origin = lattice.origin(level);
            const std::size_t at = 3 + 5 * static_cast<std::size_t>(level);
            words_[at] = pair(step, 1.0 / step);
            words_[at + 1] = pair(origin.x, origin.y);
            words_[at + 2] = pair(origin.z, 0.45 * step);
            words_[at + 3] = pair(5.0 / step, 0.003 * step);
            words_[at + 4] = {word(0.002f * static_cast<float>(step)),
                              word(static_cast<float>(step * 0x1p-14)), 0, 0};
        }
    }

    void add_records(const detail::CacheReader& reader, const Sections& at) {
        std::size_t tiles = 0;
        for (std::size_t i = 0; i < reader.records().size(); ++i) {
            const detail::StoredRecord& stored = reader.records()[i];
            detail::Record record;
            detail::CacheReader::copy(stored, record);
            const detail::Facing facing = stored.key.facing();
            const detail::Column column =
                detail::column_of(reader.lattice(), stored.key, record, facing, false);
            const auto half = [&](int k) {
                return std::uint32_t{static_cast<std::uint16_t>(stored.normal[static_cast<std::size_t>(k)])};
            };
            const std::uint32_t index = static_cast<std::uint32_t>(column.key.index()[facing.axis]) << 1 |
                                        (record.is_on_surface() ? 1u : 0u);
            words_[at.records + 2 * i] = triple(column.position, half(0) | half(1) << 16);
            words_[at.records + 2 * i + 1] = {half(2) | std::uint32_t{stored.links} << 16, index, word(tiles),
                                              stored.tile_count};
            for (const detail::StoredTile& tile : reader.tiles_of(stored))
                words_[at.tiles + tiles++] = {tile.tile | detail::octets_of(tile.known) << 24,
                                              tile.first_octet, static_cast<std::uint32_t>(tile.known),
                                              static_cast<std::uint32_t>(tile.known >> 32)};
            add_key(at, stored.key, i);
        }
        for (const detail::StoredAlias& alias : reader.aliases())
            add_key(at, alias.key, alias.record);
    }

    void add_key(const Sections& at, const detail::RecordKey& key, std::size_t record) {
        const auto& w = key.words;
        std::uint32_t hash = w[0] * 0x8da6b343u + w[1] * 0xd8163841u + w[2] * 0xcb1ab31fu;
        hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
        hash ^= hash >> 13;
        while (words_[at.slots + (hash & (at.slot_count - 1))][3] != 0)
            ++hash;
        words_[at.slots + (hash & (at.slot_count - 1))] = {w[0], w[1], w[2], word(record + 1)};
    }

    void add_light(std::size_t at, const detail::Lamp& lamp, const Light& light) {
        const detail::LightShape& shape = lamp.shape();
        std::uint32_t kind = shape.is_directional ? lights_are_directional : 0;
        if (!shape.cone.is_everything)
            kind |= lights_have_cones | (shape.cone.is_wide ? cones_are_wide : 0);
        if (const auto* rectangle = std::get_if<RectLight>(&light)) {
            kind |= lights_are_rectangles;
            words_[at + 4] = triple(rectangle->half_u, 0);
            words_[at + 5] = triple(rectangle->half_v, 0);
        }
        words_[at] = triple(shape.at, kind);
        words_[at + 1] = pair(0.0, lamp.extent());
        words_[at + 1][0] = word(shape.reaches_nothing() ? -1.0f : shape.range);
        words_[at + 2] = pair(shape.cone.axis.x, shape.cone.axis.y);
        words_[at + 3] = pair(shape.cone.axis.z, shape.cone.tangent_squared);
    }

    std::vector<Word> words_;
    std::span<const std::byte> values_;
};

}  // namespace lightmesh
