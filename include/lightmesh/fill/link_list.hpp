// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/unit_table.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

/// Links for tracers that take very many at once, such as one on a GPU: what a mesh lacks is listed, traced
/// by the caller and stored.

namespace lightmesh {

template <class Tracer, class Source>
class LightMesh;

/// Links of one brick of 4x4x4 light points, which a caller's own tracer is asked for. Light points are
/// numbered as in `LongTestWord`; cell c has those from 8 c to 8 c + 7.
///
/// 16 bytes, which shaders may read as they are: the last word has the level in its lower half.
struct LinkWord {
    std::array<std::int32_t, 3> brick;  ///< coordinates of the brick: those of its first light point over 4
    std::uint16_t level;                ///< of the mesh
    std::uint16_t cells;                ///< bit c: whether links of the light points of cell c are asked for
};
static_assert(sizeof(LinkWord) == 16, "LinkWord must be packed: shaders read it");

/// Open links of a brick: bit p of [a], whether nothing lies between light point p and the next one up along
/// axis a.
using OpenLinks = std::array<std::uint64_t, 3>;

/// The caller's own tracer of links:
///
///     void trace(std::span<const LinkWord> words, std::span<OpenLinks> open);
///
/// Sets bit p of open[i][a] to 1 if nothing lies on `LightMesh::link_segment(words[i], p, a)`, else to 0, for
/// all light points p of the cells that words[i] asks for, and the axes a of 0 to 2; other bits mean nothing.
/// Both spans have the same size, from 1 to `most_link_words`; all words of a call are of one level. The
/// answers should be those of the mesh's `Intersector`. What it throws leaves `LightMesh::fill_links`, and
/// nothing is stored of the words of the call.
template <class Trace>
concept LinkTracer = std::invocable<Trace&, std::span<const LinkWord>, std::span<OpenLinks>>;

/// The most words of a call of a `LinkTracer`: up to 12 million rays.
inline constexpr std::size_t most_link_words = std::size_t{1} << 16;

/// Links between light points that a mesh lacks at some points, each named once: made by
/// `LightMesh::list_links`, served by `LightMesh::fill_links` of the same mesh.
class LinkList {
public:
    /// True if nothing is lacking.
    bool is_empty() const { return units_.is_empty(); }

    /// Adds what another one lists, say another thread's. Throws std::bad_alloc.
    void add(const LinkList& other) { units_.add(other.units_); }

private:
    template <class Tracer, class Source>
    friend class LightMesh;

    detail::UnitsByLevel units_;  ///< all of tile 0, with one bit a cell
};

}  // namespace lightmesh
