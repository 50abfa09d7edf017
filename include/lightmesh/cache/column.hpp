// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/cache/record.hpp>

#include <glm/vec3.hpp>

#include <atomic>
#include <cstdint>

namespace lightmesh::detail {

/// A record where it stands.
struct Column {
    const Record* record;
    std::atomic<std::uint16_t>* links;  ///< null: not kept
    RecordKey key;                      ///< of the record's own lattice point
    glm::vec3 position;
    glm::vec3 normal;  ///< zero: there is no surface
};

/// True if a record looks at what lies around it, too: see `shaft_byte`.
inline bool has_shaft_row(const Lattice& lattice, const RecordKey& key, const Record& record) {
    return key.what() < static_cast<std::uint32_t>(RecordKind::air) && record.is_on_surface() &&
           lattice.has_shaft_rows(key.level());
}

/// The place that the middle of what a probe stands for falls from: of the cell of which `index` has the
/// least indices along u and v.
inline glm::vec3 probe_start(const Lattice& lattice, const glm::ivec3& index, const Facing& facing,
                             int level) {
    glm::vec3 start = lattice.position(index, level);
    const auto half = static_cast<float>(0.5 * lattice.step(level));
    start[facing.u()] += half;
    start[facing.v()] += half;
    return start;
}

/// A record, put where its key and its fall say.
inline Column column_of(const Lattice& lattice, const RecordKey& key, const Record& record,
                        const Facing& facing, bool is_kept) {
    const int level = key.level();
    Column column;
    column.record = &record;
    column.links = is_kept ? &const_cast<Record&>(record).links : nullptr;
    column.key = key;
    column.position = key.is_probe() ? probe_start(lattice, key.index(), facing, level)
                                     : lattice.position(key.index(), level);
    column.normal = glm::vec3(0.0f);
    if (record.is_on_surface()) {
        column.position[facing.axis] -= record.fall * facing.sign;
        column.normal = record.unit_normal();
    }
    return column;
}

}  // namespace lightmesh::detail
