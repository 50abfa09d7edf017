// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/segment.hpp>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <bit>
#include <cstdint>

namespace test {

inline std::uint32_t mixed(std::uint32_t hash, std::uint32_t value) {
    hash = (hash ^ value) * 0x9e3779b1u;
    return hash ^ hash >> 15;
}
inline std::uint32_t mixed(std::uint32_t hash, const glm::vec3& place) {
    for (int axis = 0; axis < 3; ++axis)
        hash = mixed(hash, place[axis] == 0.0f ? 0u : std::bit_cast<std::uint32_t>(place[axis]));
    return hash;
}

/// Goes by the bits of a segment's ends, as shaders/hashed_tracer.glsl does.
inline bool is_open_by_hash(const lightmesh::Segment& segment) {
    const std::uint32_t hash = mixed(mixed(1u, segment.origin), segment.target) >> 8;
    const std::uint32_t kind = mixed(2u, glm::floor(2.0f * segment.origin)) >> 8 & 7u;
    return kind < 2u || (kind >= 4u && (kind < 6u ? (hash & 1u) != 0u : (hash & 31u) != 0u));
}

}  // namespace test
