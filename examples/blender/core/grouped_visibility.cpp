// SPDX-License-Identifier: MIT
#include "blender/core/grouped_visibility.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace demo {

namespace {

/// Gives lights that `before` has too the place that they have there, and others those that are free, or new
/// ones.
void keep_places(LightGroup& group, const LightGroup& before) {
    std::vector<std::size_t>& numbers = *group.options.lights;
    std::vector<std::uint64_t>& ids = group.light_ids;
    std::vector<std::size_t> placed(before.light_ids.size(), no_light);
    std::vector<std::uint64_t> placed_ids = before.light_ids;
    std::vector<std::size_t> come;  // places here of lights that are not there
    for (std::size_t k = 0; k < ids.size(); ++k) {
        std::size_t place = 0;
        while (place < placed.size() && (placed[place] != no_light || before.light_ids[place] != ids[k]))
            ++place;
        if (place < placed.size())
            placed[place] = numbers[k];
        else
            come.push_back(k);
    }
    for (const std::size_t k : come) {
        const auto free = static_cast<std::size_t>(std::ranges::find(placed, no_light) - placed.begin());
        if (free == placed.size()) {
            placed.push_back(no_light);
            placed_ids.push_back(0);
        }
        placed[free] = numbers[k];
        placed_ids[free] = ids[k];
    }
    numbers = std::move(placed);
    ids = std::move(placed_ids);
}

}  // namespace

GroupedVisibility::GroupedVisibility(const EmbreeScene& scene, std::size_t light_count,
                                     std::vector<LightGroup> groups, GroupedVisibility* before,
                                     const SceneChange& change)
    : light_count_(light_count) {
    for (LightGroup& group : groups) {
        Made made{std::move(group), nullptr};
        for (Made& old : before != nullptr ? std::span(before->groups_) : std::span<Made>{}) {
            if (!old.visibility || old.group.settings != made.group.settings)
                continue;
            LightGroup placed = made.group;
            keep_places(placed, old.group);
            if (placed.options.lights == old.group.options.lights ||
                old.visibility->set_lights(*placed.options.lights)) {
                made = {std::move(placed), std::move(old.visibility)};
                made.visibility->update(scene, change);
                ++kept_;
            }
        }
        if (!made.visibility)
            made.visibility = make_visibility(made.group.algorithm, scene, made.group.options);
        groups_.push_back(std::move(made));
    }
}

bool GroupedVisibility::has_all(const Made& made) const {
    const std::vector<std::size_t>& numbers = *made.group.options.lights;
    for (std::size_t k = 0; k < numbers.size(); ++k)
        if (numbers[k] != k)
            return false;
    return numbers.size() == light_count_;
}

void GroupedVisibility::find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const {
    std::vector<lightmesh::SurfacePoint> of_samples(points.points.begin(), points.points.end());
    for (lightmesh::SurfacePoint& point : of_samples)
        point.footprint *= footprint_share_;
    // In most scenes.
    if (groups_.size() == 1 && has_all(groups_.front()))
        return groups_.front().visibility->find({of_samples, points.seeds}, lit, cost);
    std::ranges::fill(lit, 1.0f);
    std::vector<float> part;
    for (const Made& made : groups_) {
        const std::vector<std::size_t>& numbers = *made.group.options.lights;
        part.resize(points.points.size() * numbers.size());
        made.visibility->find({of_samples, points.seeds}, part, cost);
        for (std::size_t i = 0; i < points.points.size(); ++i)
            for (std::size_t k = 0; k < numbers.size(); ++k)
                if (numbers[k] != no_light)
                    lit[i * light_count_ + numbers[k]] = part[i * numbers.size() + k];
    }
}

void GroupedVisibility::set_samples(int samples) {
    footprint_share_ = 1.0f / std::sqrt(static_cast<float>((std::max)(samples, 1)));
}

void GroupedVisibility::update(const EmbreeScene& scene, const SceneChange& change) {
    for (const Made& made : groups_)
        made.visibility->update(scene, change);
}

void GroupedVisibility::begin_frame() {
    for (const Made& made : groups_)
        made.visibility->begin_frame();
}

template <class Statistics>
std::optional<Statistics> GroupedVisibility::sum(std::optional<Statistics> (Visibility::*of)() const,
                                                 std::size_t Statistics::*count) const {
    std::optional<Statistics> all;
    for (const Made& made : groups_)
        if (const auto one = (*made.visibility.*of)()) {
            if (!all)
                all.emplace();
            (*all).*count += (*one).*count;
            all->bytes += one->bytes;
        }
    return all;
}

std::optional<lightmesh::MeshStatistics> GroupedVisibility::mesh() const {
    return sum(&Visibility::mesh, &lightmesh::MeshStatistics::light_points);
}

std::optional<lightmesh::CacheStatistics> GroupedVisibility::cache() const {
    return sum(&Visibility::cache, &lightmesh::CacheStatistics::records);
}

std::uint64_t GroupedVisibility::kept_rays() const {
    std::uint64_t rays = 0;
    for (const Made& made : groups_)
        rays += demo::kept_rays(*made.visibility);
    return rays;
}

}  // namespace demo
