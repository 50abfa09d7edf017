// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_table.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/row_table.hpp>
#include <lightmesh/fill/segment_tracer.hpp>
#include <lightmesh/segment.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// A row that a list names, as far as it is still to be found.
struct ListedRow {
    Record* record;
    std::size_t tile;
    std::uint64_t wanted;  ///< lights; 0: there is nothing to find
    Column column;
};

template <class Store>
ListedRow listed_row(const Store& store, const RowTable::Entry& row) {
    // Updates since it was listed may have forgotten the record, or taken out lights.
    const RecordEntry entry = store.table().find(row.key.record);
    if (!entry || row.key.tile >= store.lamps().tile_count() || store.is_full())
        return {};
    const std::uint64_t wanted = row.mask & ~store.known_row(*entry.record, row.key.tile).known;
    return {entry.record, row.key.tile, wanted,
            column_of(store.lattice(), entry.key, *entry.record, entry.key.facing(), true)};
}

/// Finds rows of many records at once by a caller's own tracer, round by round, and keeps them: the same
/// values as `CacheStore::row`.
template <class Store, SegmentTracer Trace>
class RowListFill {
public:
    RowListFill(const Store& store, Trace& trace) : store_(store), trace_(trace) {}

    /// Throws what the tracer and the store's `Intersector` throw, and std::bad_alloc.
    void run(std::span<const RowTable::Entry> rows) {
        for (const RowTable::Entry& row : rows) {
            add(row);
            if (values_begun_ >= most_values || works_.size() == most_works)
                find();
        }
        find();
    }

private:
    struct Work {
        Record* record;
        std::size_t tile;
        std::uint64_t wanted;
        LampTally tally;
        TileValues values{};
    };

    /// So many that a first round, of up to sixteen rays each, fills most of a call.
    static constexpr std::size_t most_values = most_listed_segments / 20;
    /// What is known of them meanwhile takes two KiB each.
    static constexpr std::size_t most_works = std::size_t{1} << 14;
    /// Of a round: of 64 lights, `CacheSettings::lamp_rays` each.
    static constexpr std::size_t most_rays_of_work = 64 * 256;

    void add(const RowTable::Entry& row) {
        const ListedRow listed = listed_row(store_, row);
        if (listed.wanted == 0)
            return;
        works_.push_back(
            {listed.record, listed.tile, listed.wanted,
             LampTally(store_.lamps(), listed.tile, store_.look_of(listed.column), listed.wanted)});
        values_begun_ += static_cast<std::size_t>(std::popcount(listed.wanted));
    }

    void find() {
        while (!works_.empty()) {
            std::size_t left = 0;
            for (std::size_t w = 0; w < works_.size();) {
                const std::size_t end = list_rays(w);
                trace_listed();
                for (std::size_t next = 0; w < end; ++w) {
                    Work& work = works_[w];
                    for (; next < rays_.size() && rays_[next].work == w; ++next)
                        work.tally.take(rays_[next].ray, hit_[next] == 0);
                    if (!work.tally.end_round(work.values))
                        store_.keep_row(*work.record, work.tile, work.wanted, work.values);
                    else if (left++ != w)
                        works_[left - 1] = work;
                }
            }
            works_.erase(works_.begin() + static_cast<std::ptrdiff_t>(left), works_.end());
        }
        values_begun_ = 0;
    }

    /// Lists the rays of a round for some works, as many as are sure to go into a call. Returns the first of
    /// the others.
    std::size_t list_rays(std::size_t first) {
        segments_.clear();
        rays_.clear();
        std::size_t w = first;
        for (; w < works_.size() && segments_.size() <= most_listed_segments - most_rays_of_work; ++w)
            works_[w].tally.list_round([&](std::uint8_t ray, const auto& make) {
                segments_.push_back(make());
                rays_.push_back({static_cast<std::uint32_t>(w), ray});
            });
        return w;
    }

    void trace_listed() {
        hit_.assign(segments_.size(), 0);
        if (!segments_.empty())
            trace_(std::span<const Segment>(segments_), std::span(hit_));
        store_.count_listed_rays(segments_.size());
    }

    /// A ray of the round: whose it is, and the name that `LampTally` gave it.
    struct Ray {
        std::uint32_t work;
        std::uint8_t ray;
    };

    const Store& store_;
    Trace& trace_;
    std::size_t values_begun_ = 0;
    std::vector<Work> works_;
    std::vector<Segment> segments_;
    std::vector<Ray> rays_;
    std::vector<std::uint8_t> hit_;
};

}  // namespace lightmesh::detail
