// SPDX-License-Identifier: MIT
#pragma once

#include "render/visibility.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// Lights that share a cache or a light mesh.
struct LightGroup {
    std::string settings;  ///< all that tells this group's algorithm from others
    std::string algorithm;
    VisibilityOptions options;  ///< with the numbers of its lights
    /// Of these, in the same order: what tells a light from others, in all frames. Those that are alike are
    /// told apart by their order.
    std::vector<std::uint64_t> light_ids;
};

/// Several algorithms beside each other, each for some of a scene's lights. Lights that are in no group throw
/// no shadows.
class GroupedVisibility final : public Visibility {
public:
    /// `light_count` is that of the scene. Groups that `before` has with the same settings are taken from it,
    /// and told of the change, and of lights that came or went. Throws what the algorithms throw.
    GroupedVisibility(const EmbreeScene& scene, std::size_t light_count, std::vector<LightGroup> groups,
                      GroupedVisibility* before, const SceneChange& change);

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override;
    void update(const EmbreeScene& scene, const SceneChange& change) override;
    void begin_frame() override;
    /// Of all light meshes together.
    std::optional<lightmesh::MeshStatistics> mesh() const override;
    /// Of all caches together.
    std::optional<lightmesh::CacheStatistics> cache() const override;

    /// Pixels are drawn by so many samples: the footprint of each is its part of the pixel, since their mean
    /// smooths once more. Not while another thread uses this.
    void set_samples(int samples);

    /// That the caches and meshes have traced for what they keep.
    std::uint64_t kept_rays() const;
    std::size_t group_count() const { return groups_.size(); }
    std::size_t groups_kept() const { return kept_; }

private:
    struct Made {
        LightGroup group;
        std::unique_ptr<Visibility> visibility;
    };

    /// True if a group has the scene's lights in their order.
    bool has_all(const Made& made) const;
    /// Of the groups that have such statistics: their `count`, and their bytes.
    template <class Statistics>
    std::optional<Statistics> sum(std::optional<Statistics> (Visibility::*of)() const,
                                  std::size_t Statistics::*count) const;

    std::size_t light_count_;
    std::size_t kept_ = 0;
    float footprint_share_ = 1.0f;
    std::vector<Made> groups_;
};

}  // namespace demo
