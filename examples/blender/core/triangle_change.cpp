// SPDX-License-Identifier: MIT
#include "blender/core/triangle_change.hpp"

#include "blender/core/light_mesh_core.h"
#include "scene/boxes.hpp"
#include "scene/same_bits.hpp"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

namespace demo {

namespace {

/// What a thing is, and its number in a list.
struct Keyed {
    std::uint64_t key;
    std::uint32_t number;
};

/// Leaves what the other list has not as many times, in the order of numbers.
void drop_common(std::vector<Keyed>& a, std::vector<Keyed>& b) {
    const auto by_key = [](const Keyed& x, const Keyed& y) {
        return std::pair(x.key, x.number) < std::pair(y.key, y.number);
    };
    tbb::parallel_sort(a.begin(), a.end(), by_key);
    tbb::parallel_sort(b.begin(), b.end(), by_key);
    std::vector<Keyed> only_a;
    std::vector<Keyed> only_b;
    std::ranges::set_difference(a, b, std::back_inserter(only_a), {}, &Keyed::key, &Keyed::key);
    std::ranges::set_difference(b, a, std::back_inserter(only_b), {}, &Keyed::key, &Keyed::key);
    std::ranges::sort(only_a, {}, &Keyed::number);
    std::ranges::sort(only_b, {}, &Keyed::number);
    a = std::move(only_a);
    b = std::move(only_b);
}

/// A state with what passes its materials.
class Side {
public:
    Side(const SceneState& state, const std::vector<std::size_t>& passing,
         const std::vector<bool>& has_texture)
        : scene_(state.scene), pieces_(state.pieces), passing_(passing), has_texture_(has_texture) {}

    std::vector<Keyed> pieces() const {
        std::vector<Keyed> all;
        for (const Piece& piece : pieces_)
            all.push_back({piece.key, static_cast<std::uint32_t>(all.size())});
        return all;
    }

    /// Of the pieces that lie where they are drawn, each by itself.
    std::vector<Keyed> triangles_of(const std::vector<Keyed>& pieces) const {
        std::vector<Keyed> all;
        for (const Keyed& piece : pieces) {
            const Piece& own = pieces_[piece.number];
            for (std::uint32_t t = 0; t < (own.instance ? 0 : own.triangle_count); ++t)
                all.push_back({0, own.first_triangle + t});
        }
        tbb::parallel_for(std::size_t{0}, all.size(),
                          [&](std::size_t i) { all[i].key = key_of(all[i].number); });
        return all;
    }

    /// Of the other pieces.
    std::vector<Keyed> instances_of(const std::vector<Keyed>& pieces) const {
        std::vector<std::uint64_t> keys_of_parts(scene_.parts.size(), 0);
        std::vector<Keyed> all;
        for (const Keyed& piece : pieces)
            if (const auto number = pieces_[piece.number].instance) {
                const Instance& instance = scene_.instances[*number];
                std::uint64_t& part = keys_of_parts[instance.part];
                if (part == 0)
                    part = key_of(scene_.parts[instance.part]);
                const std::uint64_t placed = lm_hash(part, &instance.transform, sizeof instance.transform);
                all.push_back({lm_hash(placed, &instance.surface, sizeof instance.surface), *number});
            }
        return all;
    }

    /// Some for each piece that triangles are of: those that lie beside each other in it have one together.
    void add_boxes(const std::vector<Keyed>& triangles, std::vector<Bounds>& boxes) const {
        constexpr std::size_t most = 4096;
        const std::size_t together = triangles.size() / most + 1;
        std::vector<std::uint32_t> ends;  // of pieces, ascending
        for (const Piece& piece : pieces_)
            if (!piece.instance)
                ends.push_back(piece.first_triangle + piece.triangle_count);
        std::size_t in_box = together;
        std::uint32_t end = 0;
        for (const Keyed& triangle : triangles) {
            const Bounds box = around(corners_of(scene_, scene_.triangles[triangle.number]));
            if (in_box == together || triangle.number >= end) {
                end = *std::ranges::upper_bound(ends, triangle.number);
                boxes.push_back(box);
                in_box = 0;
            }
            boxes.back() = common(boxes.back(), box);
            ++in_box;
        }
    }

    void add_instance_boxes(const std::vector<Keyed>& instances, std::vector<Bounds>& boxes) const {
        const std::vector<Bounds> of_parts = boxes_of_parts(scene_);
        for (const Keyed& instance : instances)
            boxes.push_back(
                placed(scene_.instances[instance.number], of_parts[scene_.instances[instance.number].part]));
    }

    const Scene& scene() const { return scene_; }
    std::size_t passing_at(std::uint32_t triangle) const {
        return passing_[scene_.triangles[triangle].material];
    }
    bool has_texture(std::size_t passing) const { return has_texture_[passing]; }
    glm::vec2 coordinates_at(std::uint32_t vertex) const {
        const std::vector<glm::vec2>& all = scene_.texture_coordinates[0];
        return all.empty() ? glm::vec2(0.0f) : all[vertex];
    }

private:
    std::uint64_t key_of(std::uint32_t number) const {
        const Triangle& triangle = scene_.triangles[number];
        const std::array<glm::vec3, 3> corners = corners_of(scene_, triangle);
        const std::size_t passing = passing_at(number);
        std::uint64_t key = lm_hash(passing, corners.data(), sizeof corners);
        if (passing > 0 && !scene_.surfaces.empty())
            key = lm_hash(key, &scene_.surfaces[number], sizeof scene_.surfaces[number]);
        if (has_texture(passing)) {
            std::array<glm::vec2, 3> coordinates;
            for (std::size_t k = 0; k < 3; ++k)
                coordinates[k] = coordinates_at(triangle.vertex[k]);
            key = lm_hash(key, coordinates.data(), sizeof coordinates);
        }
        return key;
    }

    /// Never 0.
    std::uint64_t key_of(const MeshPart& part) const {
        std::vector<std::uint64_t> keys(part.triangle_count);
        tbb::parallel_for(std::uint32_t{0}, part.triangle_count,
                          [&](std::uint32_t t) { keys[t] = key_of(part.first_triangle + t); });
        return lm_hash(1, keys.data(), keys.size() * sizeof(std::uint64_t)) | 1u;
    }

    const Scene& scene_;
    const std::vector<Piece>& pieces_;
    const std::vector<std::size_t>& passing_;
    const std::vector<bool>& has_texture_;
};

/// Whether a BVH of the one scene needs no more than other places to be one of the other.
bool same_but_for_places(const Side& before, const Side& after) {
    const Scene& a = before.scene();
    const Scene& b = after.scene();
    if (a.positions.size() != b.positions.size() || a.triangles.size() != b.triangles.size() ||
        !same_bits(a.parts, b.parts) ||
        !std::ranges::equal(a.instances, b.instances, {}, &Instance::part, &Instance::part))
        return false;
    for (std::uint32_t t = 0; t < a.triangles.size(); ++t) {
        const std::size_t passing = before.passing_at(t);
        if (passing != after.passing_at(t) ||
            !std::ranges::equal(a.triangles[t].vertex, b.triangles[t].vertex))
            return false;
        for (std::size_t k = 0; k < (before.has_texture(passing) ? 3 : 0); ++k)
            if (before.coordinates_at(a.triangles[t].vertex[k]) !=
                after.coordinates_at(b.triangles[t].vertex[k]))
                return false;
    }
    return true;
}

/// Whether each vertex and each instance lies where the one of its number lay.
bool same_places(const Scene& a, const Scene& b) {
    return same_bits(a.positions, b.positions) &&
           std::ranges::equal(a.instances, b.instances, {}, &Instance::transform, &Instance::transform);
}

}  // namespace

SceneChange triangle_change(const SceneState& before, const SceneState& after, const Passing& passing) {
    const Side was(before, passing.before, passing.has_texture);
    const Side is(after, passing.after, passing.has_texture);
    std::vector<Keyed> gone = was.pieces();
    std::vector<Keyed> come = is.pieces();
    drop_common(gone, come);
    std::vector<Keyed> triangles_gone = was.triangles_of(gone);
    std::vector<Keyed> triangles_come = is.triangles_of(come);
    drop_common(triangles_gone, triangles_come);
    std::vector<Keyed> instances_gone = was.instances_of(gone);
    std::vector<Keyed> instances_come = is.instances_of(come);
    drop_common(instances_gone, instances_come);
    std::vector<Bounds> boxes;
    was.add_boxes(triangles_gone, boxes);
    is.add_boxes(triangles_come, boxes);
    was.add_instance_boxes(instances_gone, boxes);
    is.add_instance_boxes(instances_come, boxes);
    SceneChange change;
    change.boxes = few_boxes(boxes);
    change.has_other_triangles =
        !same_but_for_places(was, is) || (boxes.empty() && !same_places(before.scene, after.scene));
    return change;
}

}  // namespace demo
