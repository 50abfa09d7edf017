// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/point_rays.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/row_list_fill.hpp>
#include <lightmesh/cache/row_table.hpp>
#include <lightmesh/cache/share_work.hpp>
#include <lightmesh/fill/share_finder.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// Finds rows of many records at once by a caller's own shaders, and keeps them: the same values as
/// `CacheStore::row`.
template <class Store, ShareFinder Find>
class ShareListFill {
public:
    ShareListFill(const Store& store, Find& find)
        : store_(store), find_(find), work_(store.lamps(), greatest_reach(store.lattice())) {}

    /// Throws what the shaders and the store's `Intersector` throw, and std::bad_alloc.
    void run(std::span<const RowTable::Entry> rows) {
        for (const RowTable::Entry& row : rows) {
            const ListedRow listed = listed_row(store_, row);
            if (listed.wanted == 0)
                continue;
            work_.add(store_.look_of(listed.column), listed.tile, listed.wanted);
            rows_.push_back(listed);
            if (work_.share_count() > most_listed_shares - lamps_per_tile || work_.size() >= most_bytes)
                find();
        }
        find();
    }

private:
    /// Of rows.
    static constexpr std::size_t most_bytes = std::size_t{1} << 24;

    void find() {
        if (rows_.empty())
            return;
        found_.assign(work_.share_count(), 0);
        find_(work_.finish(), std::span<std::uint32_t>(found_));
        std::size_t next = 0;
        std::uint64_t rays = 0;
        for (const ListedRow& row : rows_) {
            TileValues values{};
            for (std::uint64_t rest = row.wanted; rest != 0; rest &= rest - 1) {
                const std::uint32_t found = found_[next++];
                values[static_cast<std::size_t>(std::countr_zero(rest))] =
                    static_cast<std::uint8_t>(found & 255u);
                rays += found >> 8;
            }
            store_.keep_row(*row.record, row.tile, row.wanted, values);
        }
        store_.count_listed_rays(rays);
        rows_.clear();
        work_.clear();
    }

    const Store& store_;
    Find& find_;
    ShareWork work_;
    std::vector<ListedRow> rows_;
    std::vector<std::uint32_t> found_;
};

}  // namespace lightmesh::detail
