// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/cache_change.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_table.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache/snapshot_reader.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/support/check.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace lightmesh::detail {

/// Adds what a snapshot knows and a cache lacks. What lights that differ see, and what a changed box may have
/// to do with, is left out.
template <class Store>
class CacheMerge {
public:
    CacheMerge(const Store& store, const CacheReader& from, HitKind hits, const RowSource& row_source,
               std::span<const Bounds> changed)
        : store_(store), from_(from), row_source_(row_source),
          change_(store.lattice(), store.lamps(), row_source, changed) {
        check_changed(changed);
        check_same_cache(hits);
        const auto mine = store.user_lights();
        const auto theirs = from.user_lights();
        same_.resize(store.lamps().tile_count());
        for (std::size_t i = 0; i < (std::min)(mine.size(), theirs.size()); ++i)
            if (record_of(mine[i]) == record_of(theirs[i]))
                same_[i / lamps_per_tile] |= std::uint64_t{1} << i % lamps_per_tile;
    }

    /// Throws std::invalid_argument, before anything has changed, if more than one in 1,000 of the values
    /// that both know differ; std::bad_alloc.
    void run() {
        check_same_scene();
        for (const StoredRecord& stored : from_.records())
            if (!store_.is_full())
                add(stored);
        for (const StoredAlias& alias : from_.aliases())
            if (!store_.is_full())
                add(alias);
    }

private:
    void check_same_cache(HitKind hits) const {
        const CacheSettings& mine = store_.settings();
        const CacheSettings& theirs = from_.settings();
        const auto refuse = [](const std::string& what) {
            throw std::invalid_argument("lightmesh: the snapshot is of another cache: " + what);
        };
        const bool same_origin =
            std::isnan(mine.origin.x) ? std::isnan(theirs.origin.x) : mine.origin == theirs.origin;
        if (mine.spacing != theirs.spacing || mine.lamp_rays != theirs.lamp_rays || !same_origin)
            refuse("its spacing is " + to_text(theirs.spacing) + ", its origin " + to_text(theirs.origin) +
                   ", its lamp_rays " + std::to_string(theirs.lamp_rays) + ", where this cache has " +
                   to_text(mine.spacing) + ", " + to_text(mine.origin) + " and " +
                   std::to_string(mine.lamp_rays));
        if (mine.shaft_rows != theirs.shaft_rows)
            refuse("one of the two has shaft_rows, the other has none");
        if (hits != from_.hits())
            refuse("one of the two has found surfaces by closest_hit, the other by bisection");
        if (row_source_ != from_.row_source())
            refuse("its values come from lamps or a mesh with other settings");
    }

    void check_same_scene() const {
        if (store_.table().record_count() == 0)
            return;
        std::uint64_t compared = 0;
        std::uint64_t differing = 0;
        for (const StoredRecord& stored : from_.records()) {
            const Record* own = store_.table().find(stored.key).record;
            if (own == nullptr)
                continue;
            Record made;
            CacheReader::copy(stored, made);
            if (change_.moves(stored.key, made))
                continue;
            ++compared;
            if (!is_same(*own, stored)) {
                ++differing;
                continue;
            }
            const auto sight = change_.sight_of(stored.key, made);
            const RowList list(store_.table().pool(), const_cast<Record*>(own)->rows);
            for (const StoredTile& tile : from_.tiles_of(stored)) {
                if (tile.tile >= same_.size())
                    continue;
                const RowBytes theirs = from_.row(stored, tile.tile);
                const RowBytes mine = list.gather(tile.tile);
                std::uint64_t both = theirs.known & mine.known & same_[tile.tile];
                both &= change_.unchanged(sight, tile.tile, both);
                compared += static_cast<std::uint64_t>(std::popcount(both));
                for (; both != 0; both &= both - 1) {
                    const auto l = static_cast<std::size_t>(std::countr_zero(both));
                    differing += theirs.byte(l) != mine.byte(l) ? 1u : 0u;
                }
            }
        }
        if (1000 * differing > compared)
            throw std::invalid_argument("lightmesh: the snapshot is not of the same scene: of " +
                                        std::to_string(compared) + " values that both know " +
                                        std::to_string(differing) + " differ");
    }

    void add(const StoredRecord& stored) {
        Record made;
        CacheReader::copy(stored, made);
        if (change_.moves(stored.key, made))
            return;
        made.links.store(0, std::memory_order_relaxed);
        const RecordEntry entry = store_.table().add(stored.key, made);
        store_.mark_used(*entry.brick);
        Record& own = *entry.record;
        if (!is_same(own, stored))
            return;
        if (!change_.relinks(stored.key))
            own.links.fetch_or(missing_links(own, stored), std::memory_order_relaxed);
        const auto sight = change_.sight_of(stored.key, made);
        const RowList list(store_.table().pool(), own.rows);
        for (const StoredTile& tile : from_.tiles_of(stored)) {
            if (tile.tile >= same_.size())
                continue;
            const RowBytes theirs = from_.row(stored, tile.tile);
            std::uint64_t lights = theirs.known & same_[tile.tile] & ~list.gather(tile.tile).known;
            lights &= change_.unchanged(sight, tile.tile, lights);
            if (lights == 0)
                continue;
            store_.keep_row(own, tile.tile, lights, values_of(theirs));
        }
    }

    void add(const StoredAlias& alias) {
        const StoredRecord& target = from_.records()[alias.record];
        Record made;
        CacheReader::copy(target, made);
        if (change_.moves(alias.key, target.key, made))
            return;
        if (const RecordEntry own = store_.table().find(target.key))
            store_.table().add_alias(alias.key, own.key);
    }

    static bool is_same(const Record& own, const StoredRecord& stored) {
        return own.fall == stored.fall && std::equal(stored.normal.begin(), stored.normal.end(), own.normal);
    }

    /// The stored links that the record does not know yet.
    static std::uint16_t missing_links(const Record& own, const StoredRecord& stored) {
        const unsigned known = own.links.load(std::memory_order_relaxed) & 63u;
        const unsigned added = stored.links & 63u & ~known;
        return static_cast<std::uint16_t>(added | (stored.links & added << 6));
    }

    const Store& store_;
    const CacheReader& from_;
    RowSource row_source_;
    CacheChange change_;
    std::vector<std::uint64_t> same_;  ///< for each tile, its lights that the snapshot has as well
};

}  // namespace lightmesh::detail
