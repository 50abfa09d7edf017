// SPDX-License-Identifier: MIT
#include "scene_change.hpp"

#include "boxes.hpp"
#include "instances.hpp"
#include "same_bits.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
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

/// How triangles are cut into pieces.
struct Cuts {
    float longest;  ///< edges that are not cut
    int most;       ///< cuts of a triangle and its halves after each other
};

/// Boxes around the pieces of a triangle, cut across its longest edge: a box around a long thin triangle is
/// mostly empty.
void add_pieces(std::vector<Bounds>& boxes, const std::array<glm::vec3, 3>& corners, const Cuts& cuts) {
    std::size_t from = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (glm::distance(corners[i], corners[(i + 1) % 3]) >
            glm::distance(corners[from], corners[(from + 1) % 3]))
            from = i;
    const std::size_t to = (from + 1) % 3;
    if (cuts.most == 0 || !(glm::distance(corners[from], corners[to]) > cuts.longest)) {
        boxes.push_back(around(corners));
        return;
    }
    const glm::vec3 middle = 0.5f * (corners[from] + corners[to]);
    for (const std::size_t moved : {from, to}) {
        std::array<glm::vec3, 3> half = corners;
        half[moved] = middle;
        add_pieces(boxes, half, {cuts.longest, cuts.most - 1});
    }
}

/// Such that there are few pieces.
Cuts cuts_of(std::span<const std::array<glm::vec3, 3>> triangles) {
    constexpr std::size_t most_pieces = 4096;
    constexpr float share = 1.0f / 16.0f;  // of all that moves
    if (triangles.empty() || triangles.size() > most_pieces)
        return {0.0f, 0};
    Bounds all = around(triangles[0]);
    for (const std::array<glm::vec3, 3>& corners : triangles)
        all = common(all, around(corners));
    return {share * glm::distance(all.low, all.high),
            static_cast<int>(std::bit_width(most_pieces / triangles.size())) - 1};
}

/// Boxes around the instances that moved, or whose part has other places, before and after.
void add_moved_instances(std::vector<Bounds>& moved, const Scene& before, const Scene& after) {
    std::vector<bool> has_moved;
    for (const MeshPart& part : after.parts)
        has_moved.push_back(std::memcmp(&before.positions[part.first_vertex],
                                        &after.positions[part.first_vertex],
                                        part.vertex_count * sizeof(glm::vec3)) != 0);
    const std::vector<Bounds> boxes_before = boxes_of_parts(before);
    const std::vector<Bounds> boxes_after = boxes_of_parts(after);
    for (std::size_t i = 0; i < after.instances.size(); ++i) {
        const Instance& was = before.instances[i];
        const Instance& is = after.instances[i];
        if (has_moved[is.part] || !same_bits(was.transform, is.transform)) {
            moved.push_back(placed(was, boxes_before[was.part]));
            moved.push_back(placed(is, boxes_after[is.part]));
        }
    }
}

/// What boxes hide along each of the three axes.
glm::dvec3 areas_of(const glm::dvec3& size) {
    return {size.y * size.z, size.z * size.x, size.x * size.y};
}
glm::dvec3 areas_of(const Bounds& box) {
    return areas_of(glm::dvec3(box.high) - glm::dvec3(box.low));
}
/// What both of two boxes hide.
glm::dvec3 common_areas(const Bounds& a, const Bounds& b) {
    const glm::dvec3 size = glm::dvec3(glm::min(a.high, b.high)) - glm::dvec3(glm::max(a.low, b.low));
    return areas_of(glm::max(size, glm::dvec3(0.0)));
}
double sum(const glm::dvec3& areas) {
    return areas.x + areas.y + areas.z;
}

glm::vec3 doubled_centre(const Bounds& box) {
    return box.low + box.high;
}

/// Boxes with a box around them all.
struct Group {
    std::span<Bounds> boxes;
    Bounds around;

    explicit Group(std::span<Bounds> all) : boxes(all), around(all[0]) {
        for (const Bounds& box : boxes)
            around = common(around, box);
    }

    bool operator<(const Group& other) const { return sum(areas_of(around)) < sum(areas_of(other.around)); }

    /// How many of at least two boxes go into the first of two groups, in order along the axis that is best.
    std::size_t split() const {
        std::size_t left = 0;
        int axis = 0;
        double least = std::numeric_limits<double>::infinity();
        for (int along = 0; along < 3; ++along) {
            sort(along);
            std::vector<Bounds> behind(boxes.begin(), boxes.end());
            for (std::size_t i = boxes.size() - 1; i-- > 0;)
                behind[i] = common(behind[i], behind[i + 1]);
            Bounds box = boxes[0];
            for (std::size_t i = 1; i < boxes.size(); ++i) {
                box = common(box, boxes[i - 1]);
                const double area = sum(areas_of(box) + areas_of(behind[i]) - common_areas(box, behind[i]));
                if (left == 0 || area < least) {
                    least = area;
                    left = i;
                    axis = along;
                }
            }
        }
        sort(axis);
        return left;
    }

private:
    void sort(int along) const {
        std::ranges::stable_sort(boxes, {},
                                 [along](const Bounds& box) { return doubled_centre(box)[along]; });
    }
};

/// Groups, each of which but the last ones is two others together.
struct Node {
    Group group;
    std::size_t first = 0;  ///< of the two, or 0
    std::size_t second = 0;
};

/// Adds boxes around a group: those of its two parts, if they hide clearly less than one. Returns what they
/// hide.
glm::dvec3 add_boxes(std::span<const Node> nodes, std::size_t number, std::vector<Bounds>& boxes) {
    constexpr double worth_more_boxes = 0.75;
    const Node& node = nodes[number];
    const glm::dvec3 whole = areas_of(node.group.around);
    if (node.first != 0) {
        const std::size_t before = boxes.size();
        const glm::dvec3 first = add_boxes(nodes, node.first, boxes);
        const glm::dvec3 second = add_boxes(nodes, node.second, boxes);
        const Bounds& one = nodes[node.first].group.around;
        const Bounds& other = nodes[node.second].group.around;
        // As if what they hide were spread evenly.
        glm::dvec3 both = common_areas(one, other);
        for (int axis = 0; axis < 3; ++axis)
            if (both[axis] > 0.0)
                both[axis] *= first[axis] / areas_of(one)[axis] * second[axis] / areas_of(other)[axis];
        const glm::dvec3 hidden = first + second - both;
        if (sum(hidden) < worth_more_boxes * sum(whole))
            return hidden;
        boxes.resize(before);
    }
    boxes.push_back(node.group.around);
    return whole;
}

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
    std::vector<std::array<glm::vec3, 3>> triangles;
    for (const Triangle& triangle : std::span(after.triangles).first(own_triangles(after)))
        if (std::ranges::any_of(triangle.vertex, [&](std::uint32_t vertex) {
                return !same_bits(before.positions[vertex], after.positions[vertex]);
            })) {
            triangles.push_back(corners_of(before, triangle));
            triangles.push_back(corners_of(after, triangle));
        }
    std::vector<Bounds> moved;
    const Cuts cuts = cuts_of(triangles);
    for (const std::array<glm::vec3, 3>& corners : triangles)
        add_pieces(moved, corners, cuts);
    add_moved_instances(moved, before, after);
    change.boxes = few_boxes(moved);
    return change;
}

std::vector<Bounds> few_boxes(std::vector<Bounds>& boxes) {
    std::vector<Bounds> result;
    if (boxes.empty())
        return result;
    std::vector<Node> nodes{{Group(boxes)}};
    const auto is_less = [&nodes](std::size_t a, std::size_t b) {
        return nodes[a].group < nodes[b].group;
    };
    std::priority_queue<std::size_t, std::vector<std::size_t>, decltype(is_less)> greatest(is_less);
    greatest.push(0);
    while (!greatest.empty() && nodes.size() + 2 < 2 * SceneChange::most_boxes) {
        const std::size_t number = greatest.top();
        greatest.pop();
        const Group group = nodes[number].group;
        if (group.boxes.size() == 1)
            continue;
        const std::size_t left = group.split();
        nodes[number].first = nodes.size();
        nodes[number].second = nodes.size() + 1;
        nodes.push_back({Group(group.boxes.first(left))});
        nodes.push_back({Group(group.boxes.subspan(left))});
        greatest.push(nodes[number].first);
        greatest.push(nodes[number].second);
    }
    add_boxes(nodes, 0, result);
    return result;
}

}  // namespace demo
