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
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

namespace lightmesh {

/// A point for which a shader did not know S of all lights, and asked.
struct CacheRequest {
    SurfacePoint point;    ///< as the shader was given it
    std::uint32_t id = 0;  ///< what the shader gave with it
    /// True if the snapshot lacks records or values: `VisibilityCache::fill` finds them.
    bool lacks_values = false;
    /// True if it takes rays that a cache does not keep: `VisibilityCache::visibility` has the answer.
    bool lacks_rays = false;
};

/// A cache as shaders read it (see cache.glsl): what to bind, and what to write again when the cache has been
/// filled further, or has changed. Made from a `SnapshotView`, which has checked all bytes. Lamp rows, with
/// shaft rows or without, and blur rows alike; any number of lights and of levels.
///
///     CacheUpload upload{SnapshotView(bytes)};                       // of a cache
///     for (const UploadBuffer& buffer : upload.buffers())  ...       // create and bind them
///     ... and a request buffer, CacheUpload::empty_requests(1000), as requests_binding. After a run:
///     for (const CacheRequest& request : CacheUpload::requests(bytes))  ...
/// and those are what to fill the cache with, before the next snapshot:
///     for (const UploadRange& range : upload.update(SnapshotView(newer)))  ...    // write these
class CacheUpload {
public:
    /// Number of `buffers`.
    static constexpr std::uint32_t buffer_count = 4;
    /// Of the request buffer, counted from LIGHTMESH_CACHE_BINDING.
    static constexpr std::uint32_t requests_binding = 4;

    /// Throws std::invalid_argument if the view is of a mesh, std::length_error if the cache is too large for
    /// 32-bit indices, and std::bad_alloc.
    explicit CacheUpload(const SnapshotView& view) {
        // Where a record stands is no 0.
        records_pool_.take(2, words(records));
        words(octets).grow(1);
        update(view);
    }

    /// The buffers from LIGHTMESH_CACHE_BINDING on, all of their bytes. Valid until the next `update`.
    std::array<UploadBuffer, buffer_count> buffers() const {
        std::array<UploadBuffer, buffer_count> all;
        for (std::uint32_t i = 0; i < buffer_count; ++i)
            all[i] = {i, words_[i].bytes()};
        return all;
    }

    /// Takes what the view has in the place of what there was; records that both have stay where they are.
    /// Returns what is to be written to the buffers, in multiples of 256 bytes; valid until the next
    /// `update`. A buffer may have become larger: then all of it is among them, and it is to be created anew.
    /// The cost is that of reading the snapshot. Throws what the constructor throws, and has then changed
    /// nothing if the view is of a mesh.
    std::vector<UploadRange> update(const SnapshotView& view) {
        const detail::CacheReader& reader = reader_of(view);
        ++round_;
        for (const detail::StoredRecord& stored : reader.records())
            places_[stored.key].round = round_;
        remove_others();
        for (const detail::StoredRecord& stored : reader.records())
            set_record(reader, stored);
        set_slots(reader);
        set_head(reader);
        std::vector<UploadRange> ranges;
        for (std::uint32_t i = 0; i < buffer_count; ++i)
            words_[i].take_changes(i, ranges);
        return ranges;
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
    /// The number of points that have asked, also those for which there was no room. Throws
    /// std::invalid_argument if these are not the bytes of a request buffer.
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
    enum Buffer : std::size_t { head, slots, records, octets };

    /// Four words, as shaders read them.
    using Word = std::array<std::uint32_t, 4>;

    static constexpr std::size_t request_header = 16;
    static constexpr std::size_t request_size = 48;
    static constexpr std::uint32_t lights_are_directional = 1;
    static constexpr std::uint32_t lights_have_cones = 2;
    static constexpr std::uint32_t cones_are_wide = 4;
    static constexpr std::uint32_t lights_are_rectangles = 8;
    static constexpr std::uint32_t lights_have_range = 16;

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

    detail::UploadWords& words(Buffer buffer) { return words_[buffer]; }
    /// Of a buffer of these the one of this number.
    Word at(Buffer buffer, std::size_t number) const {
        const detail::UploadWords& from = words_[buffer];
        return {from[4 * number], from[4 * number + 1], from[4 * number + 2], from[4 * number + 3]};
    }
    void set(Buffer buffer, std::size_t number, const Word& word) {
        for (std::size_t i = 0; i < word.size(); ++i)
            words(buffer).set(4 * number + i, word[i]);
    }

    // ---- the head: settings, what levels have, lights

    static constexpr std::size_t level_at = 2;
    static constexpr std::size_t words_of_level = 5;
    static constexpr std::size_t more_of_levels_at = level_at + words_of_level * detail::Lattice::level_count;
    static constexpr std::size_t light_at = more_of_levels_at + detail::Lattice::level_count;
    static constexpr std::size_t words_of_light = 6;

    void set_head(const detail::CacheReader& reader) {
        words(head).grow(4 * (light_at + words_of_light * reader.lamps().size()));
        const std::uint32_t finest = static_cast<std::uint32_t>(reader.lattice().finest_level()) |
                                     (reader.settings().exact_edges ? 256u : 0u) |
                                     (reader.settings().shaft_rows ? 512u : 0u) |
                                     (has_origins_in_steps(reader.lattice()) ? 1024u : 0u);
        set(head, 0,
            {word(reader.lamps().size()), word(reader.lamps().tile_count()), word(slot_count_ - 1), finest});
        const detail::Lattice& lattice = reader.lattice();
        Word reach = pair(lattice.step(lattice.finest_level()) * (detail::Lattice::max_index - 64.0), 0.0);
        reach[2] = word(light_at);
        set(head, 1, reach);
        for (int level = 0; level < detail::Lattice::level_count; ++level)
            set_level(lattice, level);
        for (std::size_t i = 0; i < reader.lamps().size(); ++i)
            set_light(light_at + words_of_light * i, reader.lamps().lamp(i), reader.user_lights()[i]);
    }

    static std::uint32_t low(std::uint64_t bits) { return static_cast<std::uint32_t>(bits); }
    static std::uint32_t high(std::uint64_t bits) { return static_cast<std::uint32_t>(bits >> 32); }

    /// Farther from the origin its coordinates in steps of 2^-32 need more than 64 bits.
    static constexpr double most_steps = 0x1p30;

    static bool has_origins_in_steps(const detail::Lattice& lattice) {
        const int level = detail::Lattice::level_count - 1;
        const glm::dvec3& origin = lattice.origin(level);
        return (std::max)({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)}) /
                   lattice.step(level) <
               most_steps;
    }
    /// An origin's coordinate in steps, of 2^32, to within one.
    static std::uint64_t in_steps_of(double origin, double per_step) {
        const double steps = origin * per_step;
        if (!(std::abs(steps) < most_steps))
            return 0;
        const double lost = std::fma(origin, per_step, -steps);
        const double whole = std::floor(steps);
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(whole) * (std::int64_t{1} << 32) +
                                          std::llround((steps - whole + lost) * 0x1p32));
    }

    void set_level(const detail::Lattice& lattice, int level) {
        const double step = lattice.step(level);
        const glm::dvec3 origin = lattice.origin(level);
        const std::size_t at = level_at + words_of_level * static_cast<std::size_t>(level);
        std::array<std::uint64_t, 3> in_steps{};
        for (int axis = 0; axis < 3; ++axis)
            in_steps[static_cast<std::size_t>(axis)] = in_steps_of(origin[axis], 1.0 / step);
        set(head, at, pair(step, 1.0 / step));
        set(head, at + 1, pair(origin.x, origin.y));
        set(head, at + 2, pair(origin.z, 0.45 * step));
        set(head, at + 3, pair(5.0 / step, 0.003 * step));
        set(head, at + 4,
            {word(0.002f * static_cast<float>(step)), word(static_cast<float>(step * 0x1p-14)),
             low(in_steps[0]), high(in_steps[0])});
        set(head, more_of_levels_at + static_cast<std::size_t>(level),
            {low(in_steps[1]), high(in_steps[1]), low(in_steps[2]), high(in_steps[2])});
    }

    void set_light(std::size_t at, const detail::Lamp& lamp, const Light& light) {
        const detail::LightShape& shape = lamp.shape();
        std::uint32_t kind = shape.is_directional ? lights_are_directional : 0;
        if (!shape.cone.is_everything)
            kind |= lights_have_cones | (shape.cone.is_wide ? cones_are_wide : 0);
        std::array<glm::vec3, 2> half_sides{glm::vec3(0.0f), glm::vec3(0.0f)};
        if (const auto* rectangle = std::get_if<RectLight>(&light)) {
            kind |= lights_are_rectangles;
            half_sides = {rectangle->half_u, rectangle->half_v};
        }
        Word range = pair(0.0, lamp.extent());
        range[0] = word(shape.reaches_nothing() ? -1.0f : shape.range);
        kind |= shape.reaches_nothing() || shape.range < 1e19f ? lights_have_range : 0u;
        set(head, at, triple(shape.at, kind));
        set(head, at + 1, range);
        set(head, at + 2, pair(shape.cone.axis.x, shape.cone.axis.y));
        set(head, at + 3, pair(shape.cone.axis.z, shape.cone.tangent_squared));
        set(head, at + 4, triple(half_sides[0], 0));
        set(head, at + 5, triple(half_sides[1], 0));
    }

    // ---- records: two words each, then one for each tile of lights of which something is known

    static std::uint32_t hash_of(const detail::RecordKey& key) {
        return hash_of(Word{key.words[0], key.words[1], key.words[2], 0});
    }
    static std::uint32_t hash_of(const Word& w) {
        std::uint32_t hash = w[0] * 0x8da6b343u + w[1] * 0xd8163841u + w[2] * 0xcb1ab31fu;
        hash = (hash ^ hash >> 15) * 0x2c1b3c6du;
        return hash ^ hash >> 13;
    }

    struct KeyHash {
        std::size_t operator()(const detail::RecordKey& key) const { return hash_of(key); }
    };

    /// A record in its buffer.
    struct Place {
        std::uint32_t at = 0;  ///< 0: it has none
        std::uint32_t tiles = 0;
        std::uint64_t round = 0;  ///< of the last update that had it
    };

    static constexpr std::uint32_t record_head = 2;
    /// Pools count pairs.
    static std::uint32_t pairs_of(std::uint32_t tiles) { return 2 * (record_head + tiles); }
    static std::uint32_t size_of(const Word& tile) {
        return static_cast<std::uint32_t>(std::popcount(tile[0] >> 24));
    }

    void set_record(const detail::CacheReader& reader, const detail::StoredRecord& stored) {
        Place& place = places_.at(stored.key);
        const std::vector<Word> tiles = set_tiles(reader, stored, place);
        if (place.at == 0 || place.tiles != stored.tile_count) {
            if (place.at != 0)
                records_pool_.give_back(2 * place.at, pairs_of(place.tiles));
            place.at = records_pool_.take(pairs_of(stored.tile_count), words(records)) / 2;
            place.tiles = stored.tile_count;
            // Shaders read a tile along with the head, also where there is none.
            words(records).grow(4 * (std::size_t{place.at} + record_head + 1));
        }
        detail::Record record;
        detail::CacheReader::copy(stored, record);
        const detail::Facing facing = stored.key.facing();
        const detail::Column column = detail::column_of(reader.lattice(), stored.key, record, facing, false);
        const auto half = [&](int k) {
            return std::uint32_t{static_cast<std::uint16_t>(stored.normal[static_cast<std::size_t>(k)])};
        };
        const std::uint32_t index = static_cast<std::uint32_t>(column.key.index()[facing.axis]) << 1 |
                                    (record.is_on_surface() ? 1u : 0u);
        set(records, place.at, triple(column.position, half(0) | half(1) << 16));
        set(records, place.at + 1,
            {half(2) | std::uint32_t{stored.links} << 16, index, 0, stored.tile_count});
        for (std::size_t i = 0; i < tiles.size(); ++i)
            set(records, place.at + record_head + i, tiles[i]);
    }

    /// Writes the values of a record's tiles, over those of the same tiles if they are as many. Returns the
    /// words of the tiles.
    std::vector<Word> set_tiles(const detail::CacheReader& reader, const detail::StoredRecord& stored,
                                const Place& place) {
        std::vector<Word> old;
        for (std::uint32_t i = 0; i < place.tiles; ++i)
            old.push_back(at(records, place.at + record_head + i));
        std::vector<Word> tiles;
        const std::uint64_t* from = reader.octets().data();
        for (const detail::StoredTile& tile : reader.tiles_of(stored)) {
            Word now{tile.tile | detail::octets_of(tile.known) << 24, 0,
                     static_cast<std::uint32_t>(tile.known), static_cast<std::uint32_t>(tile.known >> 32)};
            const auto same = std::ranges::find_if(old, [&](const Word& was) {
                return (was[0] & 0xffffffu) == tile.tile && size_of(was) == size_of(now);
            });
            if (same != old.end()) {
                now[1] = (*same)[1];
                old.erase(same);
            } else {
                now[1] = octets_pool_.take(size_of(now), words(octets));
            }
            for (std::size_t i = 0; i < size_of(now); ++i)
                words(octets).set(2 * (now[1] + i), from[tile.first_octet + i]);
            tiles.push_back(now);
        }
        for (const Word& unused : old)
            octets_pool_.give_back(unused[1], size_of(unused));
        return tiles;
    }

    /// Forgets records that the view does not have.
    void remove_others() {
        std::erase_if(places_, [this](const auto& entry) {
            const Place& place = entry.second;
            if (place.round == round_)
                return false;
            for (std::uint32_t i = 0; i < place.tiles; ++i) {
                const Word tile = at(records, place.at + record_head + i);
                octets_pool_.give_back(tile[1], size_of(tile));
            }
            if (place.at != 0)
                records_pool_.give_back(2 * place.at, pairs_of(place.tiles));
            return true;
        });
    }

    // ---- slots: keys and where their records stand

    /// Shaders read two at once, and stop where one is free.
    static constexpr std::size_t spare_slots = 2;

    void set_slots(const detail::CacheReader& reader) {
        const std::size_t keys = reader.records().size() + reader.aliases().size();
        if (2 * keys + 2 > std::size_t{1} << 31)
            throw std::length_error("lightmesh: the cache is too large for a shader");
        slot_count_ = (std::max)(slot_count_, std::bit_ceil(2 * keys + 2));
        // The slots of keys follow each other in the order of their hashes, which keeps the way to the
        // farthest one short.
        std::vector<Word> all(slot_count_ + spare_slots);
        const auto first_of = [&](const Word& slot) {
            return hash_of(slot) & (slot_count_ - 1);
        };
        const auto add = [&](const detail::RecordKey& key, std::uint32_t at) {
            Word slot{key.words[0], key.words[1], key.words[2], at};
            std::size_t place = first_of(slot);
            for (; all[place][3] != 0; ++place)
                if (first_of(all[place]) > first_of(slot))
                    std::swap(all[place], slot);
            all[place] = slot;
            if (place + spare_slots >= all.size())
                all.resize(place + spare_slots + 1);
        };
        for (const detail::StoredRecord& stored : reader.records())
            add(stored.key, places_.at(stored.key).at);
        for (const detail::StoredAlias& alias : reader.aliases())
            add(alias.key, places_.at(reader.records()[alias.record].key).at);
        words(slots).grow(4 * all.size());
        for (std::size_t i = 0; i < all.size(); ++i)
            set(slots, i, all[i]);
    }

    std::array<detail::UploadWords, buffer_count> words_;
    detail::UploadPool records_pool_;  ///< of pairs in `records`
    detail::UploadPool octets_pool_;   ///< of pairs in `octets`
    std::uint64_t round_ = 0;          ///< number of updates
    std::size_t slot_count_ = 0;
    std::unordered_map<detail::RecordKey, Place, KeyHash> places_;
};

}  // namespace lightmesh
