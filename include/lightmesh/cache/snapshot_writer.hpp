// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_table.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/snapshot_block.hpp>
#include <lightmesh/support/prefetch.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

inline auto order_of(const RecordKey& key) {
    return std::pair(std::uint64_t{key.words[0]} << 32 | key.words[1], key.words[2]);
}

/// Copies what a cache knows. Other threads may add to it meanwhile: what is published by then is copied, and
/// never half of something.
class CacheSnapshotWriter {
public:
    explicit CacheSnapshotWriter(RecordTable& table) : table_(table) {}

    /// Throws std::bad_alloc.
    std::vector<std::byte> write(const CacheSettings& settings, std::span<const Light> lights, HitKind hits,
                                 const RowSource& row_source) {
        copy_records();
        copy_aliases();
        fill_slots();
        CacheHeader header{};
        header.spacing = settings.spacing;
        header.detail = settings.detail;
        header.lamp_rays = settings.lamp_rays;
        header.exact_edges = settings.exact_edges ? 1 : 0;
        header.shaft_rows = settings.shaft_rows ? 1 : 0;
        if (!std::isnan(settings.origin.x)) {
            header.has_origin = 1;
            header.origin = {settings.origin.x, settings.origin.y, settings.origin.z};
        }
        header.hits = static_cast<std::uint32_t>(hits);
        header.row_source = row_source;
        return write_block(header, records_of(lights), slots_, records_, aliases_, tiles_, octets_);
    }

private:
    void copy_records() {
        std::vector<RecordEntry> all;
        all.reserve(table_.record_count());
        table_.for_each_record([&](const RecordEntry& entry) { all.push_back(entry); });
        std::ranges::sort(all, {}, [](const RecordEntry& entry) { return order_of(entry.key); });
        records_.reserve(all.size());
        for (std::size_t i = 0; i < all.size(); ++i) {
            fetch_ahead(all, i);
            Record& record = *all[i].record;
            StoredRecord stored{all[i].key,
                                record.fall,
                                {record.normal[0], record.normal[1], record.normal[2]},
                                record.links.load(std::memory_order_relaxed),
                                static_cast<std::uint32_t>(tiles_.size()),
                                0};
            copy_rows(record);
            stored.tile_count = static_cast<std::uint32_t>(tiles_.size()) - stored.first_tile;
            records_.push_back(stored);
        }
    }

    /// In the order of their keys records, and their rows, lie anywhere in memory.
    void fetch_ahead(std::span<const RecordEntry> all, std::size_t i) const {
        constexpr std::size_t records_ahead = 16;
        constexpr std::size_t rows_ahead = 8;
        if (i + records_ahead >= all.size())
            return;
        prefetch(all[i + records_ahead].record);
        table_.pool().fetch_ahead(all[i + rows_ahead].record->rows.load(std::memory_order_acquire));
    }

    void copy_rows(Record& record) {
        const RowList list(table_.pool(), record.rows);
        known_.clear();
        list.for_each([&](std::size_t tile, std::uint64_t lights) {
            if (lights != 0)
                known_.emplace_back(tile, lights);
        });
        std::ranges::sort(known_);
        for (std::size_t i = 0; i < known_.size();) {
            const std::size_t tile = known_[i].first;
            std::uint64_t known = 0;
            for (; i < known_.size() && known_[i].first == tile; ++i)
                known |= known_[i].second;
            const RowBytes row = list.gather(tile);
            tiles_.push_back(
                {static_cast<std::uint32_t>(tile), static_cast<std::uint32_t>(octets_.size()), known});
            for (std::uint32_t octets = octets_of(known); octets != 0; octets &= octets - 1) {
                const int o = std::countr_zero(octets);
                // A byte for each known light: others may just be on their way.
                octets_.push_back(row.octets[static_cast<std::size_t>(o)] & bytes_of(known >> 8 * o & 255u));
            }
        }
    }

    void copy_aliases() {
        table_.for_each_alias([&](const RecordKey& key, const RecordEntry& entry) {
            // A record that was added after the others were copied is left out, and so are its aliases.
            const auto at = std::ranges::lower_bound(records_, order_of(entry.key), {},
                                                     [](const StoredRecord& r) { return order_of(r.key); });
            if (at != records_.end() && at->key == entry.key)
                aliases_.push_back({key, static_cast<std::uint32_t>(at - records_.begin())});
        });
        std::ranges::sort(aliases_, {}, [](const StoredAlias& alias) { return order_of(alias.key); });
    }

    void fill_slots() {
        slots_.resize(std::bit_ceil(2 * (records_.size() + aliases_.size()) + 2));
        const auto put = [&](const RecordKey& key, std::uint32_t value) {
            std::uint64_t i = hash_of(key);
            while (slots_[i & (slots_.size() - 1)] != 0)
                ++i;
            slots_[i & (slots_.size() - 1)] = value;
        };
        for (std::size_t i = 0; i < records_.size(); ++i)
            put(records_[i].key, static_cast<std::uint32_t>(i + 1));
        for (std::size_t i = 0; i < aliases_.size(); ++i)
            put(aliases_[i].key, static_cast<std::uint32_t>(i + 1) | stored_alias_bit);
    }

    RecordTable& table_;
    std::vector<std::pair<std::size_t, std::uint64_t>> known_;  ///< of a record, by its tiles
    std::vector<std::uint32_t> slots_;
    std::vector<StoredRecord> records_;
    std::vector<StoredAlias> aliases_;
    std::vector<StoredTile> tiles_;
    std::vector<std::uint64_t> octets_;
};

}  // namespace lightmesh::detail
