// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/cell.hpp>
#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/lazy_array.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_brick.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/row_table.hpp>
#include <lightmesh/cache/taps.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// The cells that a thread's queries have visited last, and their records: what neighbouring points share.
/// Lives on the stack.
template <class Store>
class NearCells {
public:
    explicit NearCells(const Store& store) : store_(store) {}

    /// The place where a cell is, or may be put in the place of another one.
    CacheCell& place_of(const CellCorners& corners, const Facing& facing, int level) {
        // Neighbours on a surface, level or sloped, do not take each other's place, and those on two surfaces
        // seldom.
        const auto u = static_cast<std::size_t>(corners.u);
        const auto v = static_cast<std::size_t>(corners.v);
        const std::size_t surface = 6 * static_cast<std::size_t>(corners.along[0]) + 5 * facing.number();
        const std::size_t place = ((u & 3u) + 4 * (v & 3u) + surface) & 15u;
        return cells_[16 * (static_cast<std::size_t>(level) & 3u) + place];
    }

    /// The number of such a place, below 64.
    std::size_t number_of(const CacheCell& cell) { return static_cast<std::size_t>(&cell - &cells_[0]); }

    /// Finds the columns of a cell that was put in its place, and the links between them.
    void make(CacheCell& cell) {
        const Facing& facing = cell.facing;
        const int level = cell.level;
        bool is_kept = true;
        for (std::size_t k = 0; k < 4; ++k) {
            set_column(cell, k, RecordKind::fallen, [&](const glm::ivec3& index, Record& spare) {
                return store_.column(index, facing, level, spare, near_brick(cell, k));
            });
            is_kept &= cell.columns[k].links != nullptr;
        }
        const auto link = [&](std::size_t from, std::size_t to, int direction) -> std::uint32_t {
            return store_.is_linked(cell.columns[from], cell.columns[to], direction, facing, level) ? 1u : 0u;
        };
        cell.links.along_u = link(0, 1, 0) | link(2, 3, 0) << 2;
        cell.links.along_v = link(0, 2, 1) | link(1, 3, 1) << 1;
        cell.finish(store_.lattice().step(level));
        cell.is_made = is_kept;
    }
    /// Adds the record in the air at a cell's k-th lattice point. Returns which one of the cell's that is.
    std::size_t add_air(CacheCell& cell, std::size_t k) {
        const std::size_t air = CellValues::first_in_air + k;
        if (!cell.has_column[air])
            set_column(cell, air, RecordKind::air, [&](const glm::ivec3& index, Record& spare) {
                return store_.air(index, cell.facing, cell.level, spare, near_brick(cell, k));
            });
        return air;
    }
    /// Adds what tells what four records miss between them: see `probe` of the store.
    void add_probe(CacheCell& cell) {
        if (cell.has_column[CellValues::centre])
            return;
        const auto [lowest, highest] = std::ranges::minmax(cell.corners.along);
        glm::ivec3 index = cell.corners.index(0, cell.facing);
        index[cell.facing.axis] = cell.facing.sign > 0.0f ? highest : lowest;
        cell.columns[CellValues::centre] =
            store_.probe(index, cell.facing, cell.level, spare(cell, CellValues::centre), near_brick(cell));
        cell.has_column[CellValues::centre] = true;
    }

    /// Makes some lights known in the values of one of a cell's records; or, where `listed` is one, lists
    /// those that are not.
    void read(CacheCell& cell, std::size_t record, std::size_t tile, std::uint64_t lights, RowTable* listed) {
        if ((lights & ~cell.values.known(record)) == 0)
            return;
        const Column& column = cell.columns[record];
        const bool is_shaft = has_shaft_row(store_.lattice(), column.key, *column.record);
        if (NearColumn* const place = listed == nullptr ? near_column_of(cell, record) : nullptr) {
            if (place->tile != tile || (lights & ~place->row.known) != 0) {
                place->row = store_.row(column, tile, lights);
                place->misses = is_shaft ? read_shaft_bytes(place->row) : 0;
                place->tile = tile;
            }
            cell.values.set(record, place->row, place->misses);
            return;
        }
        RowBytes row =
            listed == nullptr ? store_.row(column, tile, lights) : store_.known_row(*column.record, tile);
        const std::uint64_t misses = is_shaft ? read_shaft_bytes(row) : 0;
        cell.values.set(record, row, misses);
        // A record that is not kept has no links.
        if (const std::uint64_t missing = lights & ~row.known;
            listed != nullptr && missing != 0 && column.links != nullptr)
            listed->add({column.key, tile}, missing);
    }

private:
    /// On all levels together.
    static constexpr std::size_t cell_count = 64;

    /// A record that neighbouring cells share, and what is known of its row.
    struct NearColumn {
        bool is_made = false;
        RecordKey key;  ///< that was asked for
        Column column;
        std::size_t tile;      ///< of the row
        RowBytes row;          ///< plain values
        std::uint64_t misses;  ///< of the row, as `CellValues` has them
    };
    /// A brick in which neighbouring cells have records.
    struct NearBrick {
        RecordBrick* brick = nullptr;
    };

    /// The brick that was found last where records of a cell's level beside its k-th lattice point are.
    RecordBrick*& near_brick(const CacheCell& cell, std::size_t k = 0) {
        const std::size_t u = static_cast<std::size_t>(cell.corners.u) + (k & 1u);
        const std::size_t v = static_cast<std::size_t>(cell.corners.v) + (k >> 1);
        const std::size_t place = (u >> 2 & 1u) + 2 * (v >> 2 & 1u);
        return near_bricks_[4 * static_cast<std::size_t>(cell.level) + place].brick;
    }
    /// The place among those that were asked for last of one of a cell's records at its four lattice points,
    /// on a surface or in the air.
    NearColumn& near_place(const CacheCell& cell, std::size_t record) {
        static_assert(CellValues::first_in_air == 4 && CellValues::centre == 8);
        const std::size_t k = record & 3u;
        const auto u = static_cast<std::size_t>(cell.corners.u) + (k & 1u);
        const auto v = static_cast<std::size_t>(cell.corners.v) + (k >> 1);
        const auto along = static_cast<std::size_t>(cell.corners.along[k]);
        return near_columns_[(static_cast<std::size_t>(cell.level) & 3u) + (record & 4u)]
                            [(u & 3u) + 4 * (v & 3u) + 16 * (along & 3u)];
    }
    /// Sets one of these records, by find(index, where one stands that is not kept) if it must.
    template <class Find>
    void set_column(CacheCell& cell, std::size_t record, RecordKind kind, const Find& find) {
        const glm::ivec3 index = cell.corners.index(record & 3u, cell.facing);
        const RecordKey key(index, kind, cell.facing, cell.level);
        NearColumn& place = near_place(cell, record);
        Column& column = cell.columns[record];
        if (place.is_made && place.key == key) {
            column = place.column;
            cell.has_column[record] = true;
            return;
        }
        Record& own = spare(cell, record);
        column = find(index, own);
        cell.has_column[record] = true;
        // What stands in the cell's own place goes with the cell.
        if (column.record == &own)
            return;
        place.is_made = true;
        place.key = key;
        place.column = column;
        place.tile = CellValues::no_tile;
    }
    /// One of these records among those that were asked for last, or null.
    NearColumn* near_column_of(const CacheCell& cell, std::size_t record) {
        if (record >= CellValues::centre)
            return nullptr;
        NearColumn& place = near_place(cell, record);
        return place.is_made && place.column.record == cell.columns[record].record ? &place : nullptr;
    }

    /// The place of a record of a cell that is not kept.
    Record& spare(const CacheCell& cell, std::size_t record) { return spares_[number_of(cell)][record]; }

    const Store& store_;
    LazyArray<CacheCell, cell_count> cells_;                ///< by level modulo 4
    LazyArray<LazyArray<NearColumn, 64>, 8> near_columns_;  ///< by level modulo 4, and in the air
    LazyArray<NearBrick, 4 * Lattice::level_count> near_bricks_;
    LazyArray<std::array<Record, CellValues::record_count>, cell_count> spares_;
};

}  // namespace lightmesh::detail
