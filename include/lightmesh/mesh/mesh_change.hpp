// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/mesh/scene_change.hpp>

#include <glm/vec3.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// The numbers of things forgotten, by kinds.
struct ForgottenCounts {
    std::uint64_t visibilities = 0;
    std::uint64_t links = 0;
    std::uint64_t floods = 0;

    ForgottenCounts& operator+=(const ForgottenCounts& other) {
        visibilities += other.visibilities;
        links += other.links;
        floods += other.floods;
        return *this;
    }
};

/// Forgets what a level of a mesh knows that may have to do with boxes in which the scene has changed. Whole
/// regions are left out where no light shines through a box.
class MeshChange {
public:
    /// A sight for each light; of those in `is_new` nothing holds: they look in another way than before.
    /// Throws std::bad_alloc.
    MeshChange(const MeshData& data, std::span<const Bounds> boxes, std::span<const LightSight> sights,
               const std::vector<bool>& is_new)
        : boxes_(boxes), is_new_(is_new), of_region_(data.lights().tile_count()) {
        lights_.reserve(sights.size());
        for (std::size_t i = 0; i < sights.size(); ++i)
            lights_.emplace_back(data.lights().shape(i), sights[i], boxes);
    }

    /// Throws nothing.
    ForgottenCounts forget_in(MeshData& data) {
        ForgottenCounts sum;
        const float step = static_cast<float>(data.grid().step());
        const float reach_of_links = 1.25f * step;
        const float reach_of_floods = (FloodBox::radius(data.grid().quality()) + 1.0f) * step;
        data.for_each_region([&](const Region& region) {
            glm::ivec3 corner(0);
            bool has_bricks = false;
            data.for_each_brick(region, [&](const Brick& brick) {
                corner = brick.position();
                has_bricks = true;
            });
            if (!has_bricks)
                return;
            corner = {corner.x & ~(region_side - 1), corner.y & ~(region_side - 1),
                      corner.z & ~(region_side - 1)};
            const Bounds around = bounds_of(data.grid(), corner, corner + (region_side - 1));
            const bool is_near = meets_any(widened(around, reach_of_floods), boxes_);
            bool is_lit_through = false;
            for (std::size_t t = 0; t < of_region_.size(); ++t) {
                of_region_[t] = changed_lights(data, t, around, ~std::uint64_t{0});
                is_lit_through |= of_region_[t] != 0;
            }
            if (!is_near && !is_lit_through)
                return;
            data.for_each_brick(region, [&](const Brick& brick) {
                const Bounds box = bounds_of(data.grid(), brick.position(), brick.position());
                if (is_near && meets_any(widened(box, reach_of_floods), boxes_)) {
                    sum.floods += data.forget_floods(brick);
                    if (meets_any(widened(box, reach_of_links), boxes_))
                        sum.links += data.forget_links(brick);
                }
                for (std::size_t t = 0; t < of_region_.size(); ++t)
                    if (const std::uint64_t lights = changed_lights(data, t, box, of_region_[t]); lights != 0)
                        sum.visibilities += data.forget(brick, t, lights);
            });
        });
        return sum;
    }

private:
    /// Those of some lights of a tile that may look different now from somewhere in a box.
    std::uint64_t changed_lights(const MeshData& data, std::size_t t, const Bounds& from,
                                 std::uint64_t among) const {
        std::uint64_t changed = 0;
        const auto size = static_cast<std::size_t>(data.lights().tile_size(t));
        if (size < lights_per_tile)
            among &= (std::uint64_t{1} << size) - 1;
        for (; among != 0; among &= among - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(among));
            const std::size_t light = data.lights().order().light_at(t * lights_per_tile + l);
            changed |= std::uint64_t{is_new_[light] || lights_[light].concerns(from)} << l;
        }
        return changed;
    }

    std::span<const Bounds> boxes_;
    std::vector<bool> is_new_;
    std::vector<LightChange> lights_;
    std::vector<std::uint64_t> of_region_;  ///< of each tile the lights that count in a region
};

}  // namespace lightmesh::detail
