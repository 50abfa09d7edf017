// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/unit_table.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

/// Long tests for tracers that take very many at once, such as one on a GPU: what a mesh lacks is listed,
/// traced by the caller and stored.

namespace lightmesh {

template <class Tracer, class Source>
class LightMesh;

/// Long tests of one light from light points of one brick of 4x4x4, which a caller's own tracer is asked for.
/// Light point p, 0 to 63, has the index 4 * brick + (x, y, z) in the grid of its level, where bits 0, 1 and
/// 2 of p are the lowest bits of x, y and z, and bits 3, 4 and 5 their second bits.
///
/// 32 bytes, which shaders may read as they are: `light_slot` is what lightmesh.glsl calls 64 * tile + l.
struct LongTestWord {
    std::array<std::int32_t, 3> brick;  ///< coordinates of the brick: those of its first light point over 4
    std::uint32_t light;                ///< the light's number
    std::uint32_t light_slot;           ///< its slot in the order in which the mesh keeps lights
    std::uint32_t level;                ///< of the mesh
    std::uint64_t points;               ///< bit p: whether V(L, x) is asked for from light point p
};
static_assert(sizeof(LongTestWord) == 32, "LongTestWord must be packed: shaders read it");

/// The caller's own tracer of long tests:
///
///     void trace(std::span<const LongTestWord> words, std::span<std::uint64_t> seen);
///
/// Sets bit p of seen[i] to 1 if nothing lies on `LightMesh::long_segment(words[i], p)`, else to 0, for all
/// p that words[i].points has; other bits mean nothing. Both spans have the same size, from 1 to
/// `most_long_test_words`. All words of a call are of one level; neighbours are of one light, brick by brick.
/// The answers should be those of the mesh's `Intersector`: what that has found and what this has found are
/// averaged together. What it throws leaves `LightMesh::fill`, and nothing is stored of the words of the
/// call.
template <class Trace>
concept LongTestTracer = std::invocable<Trace&, std::span<const LongTestWord>, std::span<std::uint64_t>>;

/// The most words of a call of a `LongTestTracer`: 8 MiB of them.
inline constexpr std::size_t most_long_test_words = std::size_t{1} << 18;

/// Long tests that a mesh lacks at some points, each named once: made by `LightMesh::list_long_tests`, served
/// by `LightMesh::fill` of the same mesh.
class LongTestList {
public:
    /// True if nothing is lacking.
    bool is_empty() const { return units_.is_empty(); }

    /// Adds what another one lists, say another thread's. Throws std::bad_alloc.
    void add(const LongTestList& other) { units_.add(other.units_); }

private:
    template <class Tracer, class Source>
    friend class LightMesh;

    detail::UnitsByLevel units_;
};

}  // namespace lightmesh
