// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/cache/column.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/point_rays.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_brick.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache/snapshot_reader.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/segment.hpp>

#include <glm/vec3.hpp>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>

namespace lightmesh::detail {

/// Thrown, and caught within the library, where a snapshot does not hold what a query needs.
struct NotInCacheSnapshot : std::exception {
    const char* what() const noexcept override { return "lightmesh: the snapshot lacks what a query needs"; }
};

/// Stands for a tracer where there is none.
struct NoTracer {
    [[noreturn]] bool occluded(const Segment&) const { throw NotInCacheSnapshot(); }
};

/// The store that a `CacheQuery` asks, answered from a snapshot alone; rays are for links and for what no
/// record says.
template <Intersector Tracer>
class FrozenCacheStore {
public:
    FrozenCacheStore(const Tracer& tracer, const CacheReader& reader) : tracer_(tracer), reader_(reader) {}

    const Tracer& tracer() const { return tracer_; }
    const CacheSettings& settings() const { return reader_.settings(); }
    const Lattice& lattice() const { return reader_.lattice(); }
    const LampTable& lamps() const { return reader_.lamps(); }

    Column column(const glm::ivec3& index, const Facing& facing, int level, Record& spare,
                  RecordBrick*&) const {
        return find(RecordKey(index, RecordKind::fallen, facing, level), facing, spare);
    }
    Column air(const glm::ivec3& index, const Facing& facing, int level, Record& spare, RecordBrick*&) const {
        return find(RecordKey(index, RecordKind::air, facing, level), facing, spare);
    }
    Column probe(const glm::ivec3& index, const Facing& facing, int level, Record& spare,
                 RecordBrick*&) const {
        return find(RecordKey(index, RecordKind::probe, facing, level), facing, spare);
    }

    bool is_linked(const Column& from, const Column& to, int direction, const Facing& facing,
                   int level) const {
        const glm::ivec3 start = from.key.index();
        const glm::ivec3 end = to.key.index();
        const int rise = end[facing.axis] - start[facing.axis];
        if (rise < -1 || rise > 1)
            return false;
        const int bit = link_bit(direction, rise);
        const std::uint16_t links = from.links->load(std::memory_order_relaxed);
        if ((links >> bit & 1) != 0)
            return (links >> (bit + 6) & 1) != 0;
        return !tracer_.occluded({lattice().position(start, level), lattice().position(end, level)});
    }

    RowBytes row(const Column& column, std::size_t tile, std::uint64_t wanted) const {
        const RowBytes row = known_row(*column.record, tile);
        if ((wanted & ~row.known) != 0)
            throw NotInCacheSnapshot();
        return row;
    }
    RowBytes known_row(const Record& record, std::size_t tile) const {
        return reader_.row(reader_.records()[record.rows.load(std::memory_order_relaxed)], tile);
    }

    /// Nobody asks.
    void count_point_rays(std::uint64_t) const {}

    void exact(const glm::vec3& point, const glm::vec3& unit_normal, std::size_t tile, std::uint64_t wanted,
               TileValues& values) const {
        PointRays<Tracer>(tracer_, lattice(), lamps(), settings())
            .find(point, unit_normal, tile, wanted, values);
    }
    void stand_in(const glm::vec3& point, const glm::vec3& unit_normal, std::size_t tile,
                  std::uint64_t wanted, TileValues& values) const {
        PointRays<Tracer>(tracer_, lattice(), lamps(), settings())
            .stand_in(point, unit_normal, tile, wanted, values);
    }
    void exact(const glm::vec3& point, const glm::vec3& unit_normal, const glm::vec3& smooth_normal,
               std::size_t tile, std::uint64_t wanted, TileValues& values) const {
        PointRays<Tracer>(tracer_, lattice(), lamps(), settings())
            .find(point, unit_normal, smooth_normal, tile, wanted, values);
    }

private:
    /// A copy of a record, whose `rows` is its number in the snapshot.
    Column find(const RecordKey& key, const Facing& facing, Record& spare) const {
        const StoredRecord* stored = reader_.find(key);
        if (stored == nullptr)
            throw NotInCacheSnapshot();
        CacheReader::copy(*stored, spare);
        spare.rows.store(static_cast<std::uint32_t>(stored - reader_.records().data()),
                         std::memory_order_relaxed);
        return column_of(lattice(), stored->key, spare, facing, true);
    }

    const Tracer& tracer_;
    const CacheReader& reader_;
};

}  // namespace lightmesh::detail
