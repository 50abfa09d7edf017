// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lamp.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache/snapshot_reader.hpp>
#include <lightmesh/mesh/merge.hpp>
#include <lightmesh/support/check.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
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
    CacheMerge(const Store& store, const CacheReader& from, PlaceKind places, const RowSource& row_source,
               std::span<const Bounds> changed)
        : store_(store), from_(from), changed_(changed), row_source_(row_source) {
        check_same_cache(places);
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
    void check_same_cache(PlaceKind places) const {
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
        if (places != from_.places())
            refuse("one of the two has found places by closest_hit, the other by bisection");
        if (row_source_ != from_.row_source())
            refuse("its values come from lamps or a mesh with other settings");
    }

    void check_same_scene() const {
        std::uint64_t compared = 0;
        std::uint64_t differing = 0;
        for (const StoredRecord& stored : from_.records()) {
            Record* own = store_.table().find(stored.key);
            if (own == nullptr || is_near_change(stored))
                continue;
            ++compared;
            if (!is_same(*own, stored)) {
                ++differing;
                continue;
            }
            const RowList list(store_.table().pool(), own->rows);
            for (const StoredTile& tile : from_.tiles_of(stored)) {
                if (tile.tile >= same_.size())
                    continue;
                const TileRow theirs = from_.row(stored, tile.tile);
                const TileRow mine = list.gather(tile.tile);
                std::uint64_t both =
                    theirs.known & mine.known & same_[tile.tile] & unchanged(stored, tile.tile, theirs.known);
                compared += static_cast<std::uint64_t>(std::popcount(both));
                for (; both != 0; both &= both - 1) {
                    const int l = std::countr_zero(both);
                    differing += byte_of(theirs, l) != byte_of(mine, l) ? 1u : 0u;
                }
            }
        }
        if (1000 * differing > compared)
            throw std::invalid_argument("lightmesh: the snapshot is not of the same scene: of " +
                                        std::to_string(compared) + " values that both know " +
                                        std::to_string(differing) + " differ");
    }

    void add(const StoredRecord& stored) {
        if (is_near_change(stored))
            return;
        Record made;
        CacheReader::copy(stored, made);
        Record& own = *store_.table().add(made);
        if (!is_same(own, stored))
            return;
        if (!is_near_change(reach_of_links(stored)))
            own.links.fetch_or(missing_links(own, stored), std::memory_order_relaxed);
        const RowList list(store_.table().pool(), own.rows);
        for (const StoredTile& tile : from_.tiles_of(stored)) {
            if (tile.tile >= same_.size())
                continue;
            const TileRow theirs = from_.row(stored, tile.tile);
            std::uint64_t lights = theirs.known & same_[tile.tile] & ~list.gather(tile.tile).known;
            lights &= unchanged(stored, tile.tile, lights);
            if (lights == 0)
                continue;
            TileValues values{};
            for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1)
                values[static_cast<std::size_t>(std::countr_zero(rest))] =
                    byte_of(theirs, std::countr_zero(rest));
            store_.keep_row(own, tile.tile, lights, values);
        }
    }

    void add(const StoredAlias& alias) {
        const StoredRecord& target = from_.records()[alias.record];
        Bounds fall = fall_of(target);
        const glm::vec3 start = store_.lattice().position(alias.key.index(), alias.key.level());
        fall.low = (glm::min)(fall.low, start - slack(alias.key));
        fall.high = (glm::max)(fall.high, start + slack(alias.key));
        if (is_near_change(fall))
            return;
        if (const Record* record = store_.table().find(target.key))
            store_.table().add_alias(alias.key, *record);
    }

    static bool is_same(const Record& own, const StoredRecord& stored) {
        return own.fall == stored.fall && std::equal(stored.normal.begin(), stored.normal.end(), own.normal);
    }

    static std::uint8_t byte_of(const TileRow& row, int light) {
        return static_cast<std::uint8_t>(row.octet(light / 8) >> 8 * (light % 8));
    }

    /// The stored links that the record does not know yet.
    static std::uint16_t missing_links(const Record& own, const StoredRecord& stored) {
        const unsigned known = own.links.load(std::memory_order_relaxed) & 63u;
        const unsigned added = stored.links & 63u & ~known;
        return static_cast<std::uint16_t>(added | (stored.links & added << 6));
    }

    float slack(const RecordKey& key) const {
        return 0.13f * static_cast<float>(store_.lattice().step(key.level()));
    }

    Bounds around(const glm::vec3& a, const glm::vec3& b, float margin) const {
        return {(glm::min)(a, b) - margin, (glm::max)(a, b) + margin};
    }

    Column column_of(const StoredRecord& stored, Record& record) const {
        CacheReader::copy(stored, record);
        return detail::column_of(store_.lattice(), record, stored.key.way(), false);
    }

    /// What a record's place depends on: the way that it fell, or found nothing on.
    Bounds fall_of(const StoredRecord& stored) const {
        const Lattice& lattice = store_.lattice();
        const RecordKey& key = stored.key;
        const Way way = key.way();
        const bool in_air = !key.is_probe() && key.what() >= static_cast<std::uint32_t>(RecordKind::air);
        const glm::vec3 start = key.is_probe() ? probe_start(lattice, key.index(), way, key.level())
                                               : lattice.position(key.index(), key.level());
        const float length = in_air                ? 0.0f
                             : stored.fall >= 0.0f ? stored.fall
                                                   : (key.is_probe() ? 4.0f : 2.5f) *
                                                         static_cast<float>(lattice.step(key.level()));
        // A probe's rays start a quarter of a step to its sides.
        const float aside = key.is_probe() ? 0.3f * static_cast<float>(lattice.step(key.level())) : 0.0f;
        return around(start, start - length * way.up(), aside + slack(key));
    }

    Bounds reach_of_links(const StoredRecord& stored) const {
        const glm::vec3 start = store_.lattice().position(stored.key.index(), stored.key.level());
        return around(start, start, 1.1f * static_cast<float>(store_.lattice().step(stored.key.level())));
    }

    bool is_near_change(const Bounds& box) const {
        return std::ranges::any_of(changed_, [&](const Bounds& changed) {
            return changed.low.x <= box.high.x && changed.low.y <= box.high.y &&
                   changed.low.z <= box.high.z && changed.high.x >= box.low.x &&
                   changed.high.y >= box.low.y && changed.high.z >= box.low.z;
        });
    }
    bool is_near_change(const StoredRecord& stored) const {
        return !changed_.empty() && is_near_change(fall_of(stored));
    }

    /// Those of some lights of a tile whose rays from a record meet no changed box.
    std::uint64_t unchanged(const StoredRecord& stored, std::size_t tile, std::uint64_t lights) const {
        if (changed_.empty())
            return lights;
        Record record;
        const glm::vec3 place = column_of(stored, record).place;
        // A mesh's values depend on light points within its radius, and on links between them.
        const float margin = row_source_.is_mesh != 0
                                 ? row_source_.radius * (1.0f + 3.0f / row_source_.quality)
                                 : slack(stored.key);
        const bool is_spread = stored.key.is_probe() && row_source_.is_mesh == 0;
        const Bounds from = is_spread ? fall_of(stored) : around(place, place, margin);
        if (row_source_.is_mesh != 0 && is_near_change(from))
            return 0;
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            const Lamp& lamp = store_.lamps().lamp(tile * lamps_per_tile + l);
            for (const Bounds& changed : changed_) {
                // Rays to all of a lamp pass within its size of those to its centre.
                double size = lamp.extent();
                if (lamp.shape().is_directional) {
                    const glm::vec3 farthest = (glm::max)(
                        (glm::max)(glm::abs(changed.low - from.low), glm::abs(changed.high - from.low)),
                        (glm::max)(glm::abs(changed.low - from.high), glm::abs(changed.high - from.high)));
                    size *= static_cast<double>(glm::length(farthest));
                }
                const auto wide = static_cast<float>(1.001 * size);
                if (crosses(from, lamp.shape(), {changed.low - wide, changed.high + wide})) {
                    lights &= ~(rest & (~rest + 1u));
                    break;
                }
            }
        }
        return lights;
    }

    const Store& store_;
    const CacheReader& from_;
    std::span<const Bounds> changed_;
    RowSource row_source_;
    std::vector<std::uint64_t> same_;  ///< for each tile, its lights that the snapshot has as well
};

}  // namespace lightmesh::detail
