// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/snapshot_block.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/prefetch.hpp>

#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// The parts of a cache's snapshot, read where they stand. Everything is checked first: whatever the bytes
/// are, what follows neither reads beyond them nor goes on without end. Must not move.
class CacheReader {
public:
    /// Throws std::invalid_argument that says in one sentence what is wrong with the bytes.
    explicit CacheReader(std::span<const std::byte> bytes) : block_(bytes) {
        read_settings();
        read_lights();
        slots_ = section<std::uint32_t>(cache_slots_section);
        records_ = section<StoredRecord>(cache_records_section);
        aliases_ = section<StoredAlias>(cache_aliases_section);
        tiles_ = section<StoredTile>(cache_tiles_section);
        octets_ = section<std::uint64_t>(cache_octets_section);
        check_slots();
        check_records();
    }
    CacheReader(const CacheReader&) = delete;
    CacheReader& operator=(const CacheReader&) = delete;

    const CacheSettings& settings() const { return settings_; }
    const Lattice& lattice() const { return *lattice_; }
    const LampTable& lamps() const { return *lamps_; }
    std::span<const Light> user_lights() const { return user_lights_; }
    HitKind hits() const { return static_cast<HitKind>(header_.hits); }
    const RowSource& row_source() const { return header_.row_source; }
    std::span<const StoredRecord> records() const { return records_; }
    std::span<const StoredAlias> aliases() const { return aliases_; }
    /// The values of all tiles.
    std::span<const std::uint64_t> octets() const { return octets_; }
    std::span<const StoredTile> tiles_of(const StoredRecord& record) const {
        return tiles_.subspan(record.first_tile, record.tile_count);
    }

    /// The record to which a key leads, or nullptr.
    const StoredRecord* find(const RecordKey& key) const {
        const std::uint32_t slot = find_slot(key);
        if (slot == 0)
            return nullptr;
        const std::uint32_t at = (slot & ~stored_alias_bit) - 1;
        return &records_[(slot & stored_alias_bit) != 0 ? aliases_[at].record : at];
    }

    /// The values of a tile of lights at a record, as far as they are known.
    RowBytes row(const StoredRecord& record, std::size_t tile) const {
        RowBytes row{};
        for (const StoredTile& stored : tiles_of(record)) {
            if (stored.tile != tile)
                continue;
            row.known = stored.known;
            const std::uint64_t* octet = &octets_[stored.first_octet];
            for (std::uint32_t octets = octets_of(stored.known); octets != 0; octets &= octets - 1)
                row.octets[static_cast<std::size_t>(std::countr_zero(octets))] = *octet++;
        }
        return row;
    }

    /// A record as a live cache has it, without its rows.
    static void copy(const StoredRecord& stored, Record& record) {
        record.fall = stored.fall;
        for (std::size_t k = 0; k < 3; ++k)
            record.normal[k] = stored.normal[k];
        record.links.store(stored.links, std::memory_order_relaxed);
    }

private:
    void read_settings() {
        settings_.spacing = header_.spacing;
        settings_.detail = header_.detail;
        settings_.lamp_rays = header_.lamp_rays;
        const RowSource& rows = header_.row_source;
        require_right(header_.exact_edges <= 1 && header_.has_origin <= 1 && rows.is_mesh <= 1 &&
                          rows.has_origin <= 1 && rows.adaptive <= 1 && header_.shaft_rows <= 1 &&
                          header_.shaft_rows + rows.is_mesh <= 1,
                      "what is either so or not is neither");
        settings_.exact_edges = header_.exact_edges != 0;
        settings_.shaft_rows = header_.shaft_rows != 0;
        if (header_.has_origin != 0)
            settings_.origin = {header_.origin[0], header_.origin[1], header_.origin[2]};
        require_right(header_.hits <= static_cast<std::uint32_t>(HitKind::bisected),
                      "there is no such way to find surfaces");
        require_right(rows.short_test <= static_cast<std::uint32_t>(ShortTest::exact) &&
                          rows.long_tests <= static_cast<std::uint32_t>(LongTest::refined_shadow_maps),
                      "there is no such short or long test");
        lattice_ = std::make_unique<const Lattice>(settings_);
    }

    void read_lights() {
        user_lights_ = lights_of(section<LightRecord>(cache_lights_section));
        lamps_ = std::make_unique<const LampTable>(user_lights_);
    }

    template <class T>
    std::span<const T> section(std::size_t name) const {
        return block_.section<T>(name);
    }

    const RecordKey& key_of(std::uint32_t slot) const {
        const std::uint32_t at = (slot & ~stored_alias_bit) - 1;
        return (slot & stored_alias_bit) != 0 ? aliases_[at].key : records_[at].key;
    }

    std::uint32_t find_slot(const RecordKey& key) const {
        for (std::uint64_t i = hash_of(key);; ++i) {
            const std::uint32_t slot = slots_[i & (slots_.size() - 1)];
            if (slot == 0 || key_of(slot) == key)
                return slot;
        }
    }

    void check_slots() const {
        require_right(std::has_single_bit(slots_.size()), "the size of its table is no power of two");
        std::uint64_t taken = 0;
        for (const std::uint32_t slot : slots_) {
            if (slot == 0)
                continue;
            ++taken;
            const std::uint32_t at = (slot & ~stored_alias_bit) - 1;
            require_right(at < ((slot & stored_alias_bit) != 0 ? aliases_.size() : records_.size()),
                          "a record is named that is not there");
        }
        require_right(2 * taken <= slots_.size() && taken == records_.size() + aliases_.size(),
                      "its table is too full, or leaves records out");
        check_places(records_, 0);
        check_places(aliases_, stored_alias_bit);
    }

    /// True if the table leads to each of some records or aliases.
    template <class Stored>
    void check_places(std::span<const Stored> all, std::uint32_t bit) const {
        constexpr std::size_t slots_ahead = 16;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (i + slots_ahead < all.size())
                prefetch(&slots_[hash_of(all[i + slots_ahead].key) & (slots_.size() - 1)]);
            require_right(find_slot(all[i].key) == ((i + 1) | bit), "a record is not where its table says");
        }
    }

    static void check_key(const RecordKey& key) {
        require_right(key.what() < RecordKey::kind_count && key.level() < Lattice::level_count &&
                          key.words[2] >> 27 == 0,
                      "there is no such kind of record");
    }

    void check_records() const {
        for (const StoredRecord& record : records_) {
            check_key(record.key);
            require_right(std::isfinite(record.fall) && record.links >> 12 == 0, "a record makes no sense");
            require_right(record.first_tile <= tiles_.size() &&
                              record.tile_count <= tiles_.size() - record.first_tile,
                          "a record's tiles reach beyond its end");
            for (const StoredTile& tile : tiles_of(record))
                check_tile(tile);
        }
        for (const StoredAlias& alias : aliases_) {
            check_key(alias.key);
            require_right(alias.record < records_.size(), "a record is named that is not there");
            const RecordKey& target = records_[alias.record].key;
            const int steps = alias.key.steps_to(target);
            require_right(steps > 0 && steps < 1 << 20 && alias.key.below(steps) == target,
                          "a record lies in another column than its key says");
        }
    }

    void check_tile(const StoredTile& tile) const {
        require_right(tile.tile < lamps_->tile_count(), "a tile is named that is not there");
        const std::size_t size = lamps_->tile_size(tile.tile);
        require_right(tile.known != 0 && (size == 64 || tile.known >> size == 0),
                      "a light is named that is not there");
        const auto count = static_cast<std::size_t>(std::popcount(octets_of(tile.known)));
        require_right(tile.first_octet <= octets_.size() && count <= octets_.size() - tile.first_octet,
                      "a tile's values reach beyond its end");
    }

    SnapshotBlock<CacheHeader> block_;
    const CacheHeader& header_ = block_.header();
    CacheSettings settings_;
    std::unique_ptr<const Lattice> lattice_;
    std::vector<Light> user_lights_;
    std::unique_ptr<const LampTable> lamps_;
    std::span<const std::uint32_t> slots_;
    std::span<const StoredRecord> records_;
    std::span<const StoredAlias> aliases_;
    std::span<const StoredTile> tiles_;
    std::span<const std::uint64_t> octets_;
};

}  // namespace lightmesh::detail
