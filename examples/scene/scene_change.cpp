// SPDX-License-Identifier: MIT
#include "scene_change.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <queue>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

namespace demo {
namespace {

/// Of values without padding.
template <class Value>
bool same_bits(const Value& a, const Value& b) {
    static_assert(std::is_trivially_copyable_v<Value>);
    return std::memcmp(&a, &b, sizeof(Value)) == 0;
}

template <class Value>
bool same_bits(const std::vector<Value>& a, const std::vector<Value>& b) {
    static_assert(std::is_trivially_copyable_v<Value>);
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Value)) == 0);
}

bool same_shape(const lightmesh::Light& a, const lightmesh::Light& b) {
    return a.index() == b.index() &&
           std::visit(
               [&](const auto& kind) {
                   return same_bits(kind, std::get<std::remove_cvref_t<decltype(kind)>>(b));
               },
               a);
}

bool same_camera(const Camera& a, const Camera& b) {
    return same_bits(a, b);
}

/// All that a ray may ask of a material.
auto parts_of(const TextureMap& m) {
    return std::tie(m.texture, m.coordinates, m.wrap_u, m.wrap_v, m.transform);
}
bool same(const TextureMap& a, const TextureMap& b) {
    return parts_of(a) == parts_of(b);
}
auto parts_of(const Material& m) {
    return std::tie(m.diffuse, m.specular, m.shininess, m.k_s, m.k_t, m.refraction_index, m.tint, m.emission,
                    m.metallic, m.opacity, m.alpha_mode, m.alpha_cutoff, m.is_unlit, m.shadow, m.highlight,
                    m.roughness);
}
bool same(const Material& a, const Material& b) {
    return parts_of(a) == parts_of(b) && same(a.base_map, b.base_map) && same(a.opacity_map, b.opacity_map) &&
           same(a.emission_map, b.emission_map);
}

bool same_but_for_places(const Scene& a, const Scene& b) {
    return a.positions.size() == b.positions.size() && a.normals.size() == b.normals.size() &&
           a.lights.size() == b.lights.size() && same_bits(a.triangles, b.triangles) &&
           same_bits(a.parts, b.parts) &&
           std::ranges::equal(a.instances, b.instances, {}, &Instance::part, &Instance::part) &&
           same_bits(a.colours, b.colours) && same_bits(a.texture_coordinates[0], b.texture_coordinates[0]) &&
           same_bits(a.texture_coordinates[1], b.texture_coordinates[1]) &&
           std::ranges::equal(a.materials, b.materials,
                              [](const Material& x, const Material& y) { return same(x, y); });
}

lightmesh::Bounds common(const lightmesh::Bounds& a, const lightmesh::Bounds& b) {
    return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
}

lightmesh::Bounds around(const Scene& scene, const Triangle& triangle) {
    const glm::vec3& first = scene.positions[triangle.vertex[0]];
    lightmesh::Bounds box{first, first};
    for (const std::uint32_t vertex : triangle.vertex)
        box = common(box, {scene.positions[vertex], scene.positions[vertex]});
    return box;
}

/// Boxes around the instances that moved, or whose part has other places, before and after.
void add_moved_instances(std::vector<lightmesh::Bounds>& moved, const Scene& before, const Scene& after) {
    std::vector<bool> has_moved;
    for (const MeshPart& part : after.parts)
        has_moved.push_back(std::memcmp(&before.positions[part.first_vertex],
                                        &after.positions[part.first_vertex],
                                        part.vertex_count * sizeof(glm::vec3)) != 0);
    const std::vector<lightmesh::Bounds> boxes_before = boxes_of_parts(before);
    const std::vector<lightmesh::Bounds> boxes_after = boxes_of_parts(after);
    for (std::size_t i = 0; i < after.instances.size(); ++i) {
        const Instance& was = before.instances[i];
        const Instance& is = after.instances[i];
        if (has_moved[is.part] || !same_bits(was.transform, is.transform)) {
            moved.push_back(placed(was, boxes_before[was.part]));
            moved.push_back(placed(is, boxes_after[is.part]));
        }
    }
}

/// Half of the surface.
double area_of(const lightmesh::Bounds& box) {
    const glm::dvec3 size = glm::dvec3(box.high) - glm::dvec3(box.low);
    return size.x * size.y + size.y * size.z + size.z * size.x;
}

glm::vec3 doubled_centre(const lightmesh::Bounds& box) {
    return box.low + box.high;
}

/// Boxes with a box around them all, and what two boxes instead of it would save.
struct Group {
    std::span<lightmesh::Bounds> boxes;
    lightmesh::Bounds around;
    double saved = 0.0;
    std::size_t left = 0;  ///< how many boxes go into the first of the two, in order of `axis`
    int axis = 0;

    explicit Group(std::span<lightmesh::Bounds> all) : boxes(all), around(all[0]) {
        for (const lightmesh::Bounds& box : boxes)
            around = common(around, box);
        for (int along = 0; along < 3; ++along)
            find_split(along);
    }

    bool operator<(const Group& other) const { return saved < other.saved; }

    void sort(int along) const {
        std::ranges::stable_sort(
            boxes, {}, [along](const lightmesh::Bounds& box) { return doubled_centre(box)[along]; });
    }

private:
    /// By the surface area heuristic, sweeping over all boxes.
    void find_split(int along) {
        sort(along);
        std::vector<double> behind(boxes.size());
        lightmesh::Bounds box = boxes.back();
        for (std::size_t i = boxes.size(); i-- > 0;) {
            box = common(box, boxes[i]);
            behind[i] = area_of(box);
        }
        box = boxes[0];
        for (std::size_t i = 1; i < boxes.size(); ++i) {
            box = common(box, boxes[i - 1]);
            const double gain = area_of(around) - area_of(box) - behind[i];
            if (gain > saved) {
                saved = gain;
                left = i;
                axis = along;
            }
        }
    }
};

}  // namespace

SceneChange difference(const Scene& before, const Scene& after) {
    SceneChange change;
    change.camera = !same_camera(before.camera, after.camera);
    change.is_another_scene = !same_but_for_places(before, after);
    if (change.is_another_scene)
        return change;
    for (std::size_t i = 0; i < after.lights.size(); ++i)
        if (!same_shape(before.lights[i].shape, after.lights[i].shape))
            change.lights.push_back(i);
    std::vector<lightmesh::Bounds> moved;
    for (const Triangle& triangle : std::span(after.triangles).first(own_triangles(after)))
        if (std::ranges::any_of(triangle.vertex, [&](std::uint32_t vertex) {
                return !same_bits(before.positions[vertex], after.positions[vertex]);
            })) {
            moved.push_back(around(before, triangle));
            moved.push_back(around(after, triangle));
        }
    add_moved_instances(moved, before, after);
    change.boxes = few_boxes(moved);
    return change;
}

std::vector<lightmesh::Bounds> few_boxes(std::vector<lightmesh::Bounds>& boxes) {
    // Splits where that saves most, as long as it saves a fair share of a box.
    constexpr double worth_a_box = 0.25;
    std::vector<lightmesh::Bounds> result;
    if (boxes.empty())
        return result;
    std::priority_queue<Group> groups;
    groups.push(Group(boxes));
    while (!groups.empty()) {
        const Group group = groups.top();
        groups.pop();
        const bool is_last = groups.size() + result.size() + 2 > SceneChange::most_boxes;
        if (is_last || !(group.saved > worth_a_box * area_of(group.around))) {
            result.push_back(group.around);
            continue;
        }
        group.sort(group.axis);
        groups.push(Group(group.boxes.first(group.left)));
        groups.push(Group(group.boxes.subspan(group.left)));
    }
    return result;
}

}  // namespace demo
