// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/long_fill.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/kernels/kernels.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/reaching.hpp>
#include <lightmesh/query/tally.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <span>

/// Queries of a mesh that cannot be added to.

namespace lightmesh::detail {

/// Thrown within a query, and caught by who made it.
struct NotInSnapshot : std::exception {
    const char* what() const noexcept override { return "lightmesh: the snapshot lacks what a query needs"; }
};

/// In place of a `MeshFiller`: a tracer, and what a snapshot holds.
template <class Tracer>
class FrozenFiller {
public:
    struct Data {
        const MeshView& mesh;
        const MeshView& view() const { return mesh; }
    };

    FrozenFiller(const Tracer& tracer, const MeshView& mesh) : tracer_(tracer), mesh_(mesh) {}

    const Tracer& tracer() const { return tracer_; }
    Data data() const { return {mesh_}; }
    const Brick* use_brick(const MeshView& mesh, const glm::ivec3& coord) const {
        const Brick* brick = mesh.find_brick(coord);
        return brick != nullptr ? brick : throw NotInSnapshot();
    }
    [[noreturn]] void fill(const MissingList&) const { throw NotInSnapshot(); }
    std::uint32_t flood_of(const MeshView& mesh, const Brick& brick, const glm::ivec3& seed) const {
        const std::uint32_t flood = find_flood(mesh, brick, bit_in_brick(seed));
        return flood != 0 ? flood : throw NotInSnapshot();
    }

private:
    const Tracer& tracer_;
    const MeshView& mesh_;
};

/// As `SnapshotView::visibility` without a tracer, of one level. Of what is in `all` the values found replace
/// `share`.
inline void query_view(const MeshView& mesh, const glm::vec3& position, const glm::vec3& normal, float share,
                       std::span<float> all) {
    constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
    if (!is_finite(position) || !is_finite(normal)) {
        std::ranges::fill(all, unknown);
        return;
    }
    const glm::vec3 unit_normal = unit_or_zero(normal);
    const Hemisphere hemisphere(*mesh.grid, mesh.grid->locate(position), position, unit_normal);
    BrickMask masks[Hemisphere::most_bricks];
    BrickPoints entries[Hemisphere::most_bricks];
    const std::size_t size = kernels().find_masks(hemisphere, masks);
    bool is_known = size != 0 && mesh.settings->short_test == ShortTest::none;
    for (std::size_t i = 0; i < size; ++i) {
        const Brick* brick =
            mesh.find_brick(hemisphere.first_brick + glm::ivec3(masks[i].x, masks[i].y, masks[i].z));
        entries[i] = {brick, masks[i].points, 0, 0};
        is_known &= brick != nullptr;
    }
    const int count = Neighbours(entries, size).point_count();

    for (std::size_t t = 0; t < mesh.lights->tile_count(); ++t) {
        const std::uint64_t reaching = find_reaching(*mesh.lights, kernels(), t, position, unit_normal);
        std::uint64_t known_groups = is_known ? cell_bits(reaching) * every_byte : 0;
        alignas(64) std::array<float, lights_per_tile> values{};
        if (known_groups != 0) {
            Tally tally(mesh, kernels(), t);
            tally.start_anew();
            for (const BrickPoints& entry : std::span(entries).first(size)) {
                const std::uint64_t units = cells_in(entry.points) & every_byte;
                for (std::uint64_t rest = mesh.missing(*entry.brick, t, units * 0xff); rest != 0;
                     rest &= rest - 1)
                    known_groups &= ~(every_byte << (std::countr_zero(rest) % 8));
                tally.add(*entry.brick, entry.points, 0);
            }
            tally.finish();
            kernels().divide(tally.counts(), count, reaching, values.data());
        }
        for (std::size_t l = 0; l < static_cast<std::size_t>(mesh.lights->tile_size(t)); ++l) {
            const bool is_missing =
                (reaching >> l & 1) != 0 && (known_groups >> (l / lights_per_group) & 1) == 0;
            const float found = is_missing ? unknown : values[l];
            float& value = all[mesh.lights->order().light_at(t * lights_per_tile + l)];
            value = share == 1.0f ? found : blended(value, found, share);
        }
    }
}

/// The same where a snapshot has nothing of the level: all that lights can reach is unknown.
inline void query_nothing(const Grid& grid, const LightTable& lights, const glm::vec3& position,
                          const glm::vec3& normal, std::span<float> all) {
    const bool is_point = is_finite(position) && is_finite(normal);
    if (is_point)
        static_cast<void>(grid.locate(position));
    const glm::vec3 unit_normal = is_point ? unit_or_zero(normal) : glm::vec3(0.0f);
    for (std::size_t light = 0; light < lights.size(); ++light)
        all[light] = is_point && !lights.can_light(light, position, unit_normal)
                         ? 0.0f
                         : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace lightmesh::detail
