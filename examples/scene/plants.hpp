// SPDX-License-Identifier: MIT
#pragma once

#include "mesh_builder.hpp"
#include "random.hpp"

#include <array>
#include <cmath>
#include <vector>

namespace demo {

/// The parts that a tree is made of: materials for bark and for leaves.
struct Foliage {
    std::uint32_t bark;
    std::array<std::uint32_t, 3> leaves;
};

/// 2 triangles: a leaf with a fold along its middle, at `stem`, pointing along `along` and facing `facing`.
inline void add_leaf(MeshBuilder& mesh, glm::vec3 stem, glm::vec3 along, glm::vec3 facing, float length) {
    const glm::vec3 side = glm::normalize(glm::cross(along, facing));
    const glm::vec3 tip = stem + length * along;
    const glm::vec3 middle = stem + 0.45f * length * along + 0.10f * length * facing;
    mesh.triangle(stem, middle + 0.33f * length * side, tip);
    mesh.triangle(stem, tip, middle - 0.33f * length * side);
}

/// 1 triangle: a blade of grass or a leaf on the ground.
inline void add_blade(MeshBuilder& mesh, glm::vec3 root, glm::vec3 side, glm::vec3 tip) {
    mesh.triangle(root - side, root + side, tip);
}

/// `count` leaves (2 triangles each) loosely inside an ellipsoid, denser towards its surface.
inline void add_leaf_cluster(MeshBuilder& mesh, Random& random, const Foliage& foliage, glm::vec3 centre,
                             glm::vec3 radii, int count, float leaf_length) {
    for (int i = 0; i < count; ++i) {
        const glm::vec3 outwards = random_direction(random);
        const float depth = std::sqrt(random.uniform(0.25f, 1.0f));
        const glm::vec3 stem = centre + radii * (depth * outwards);
        const glm::vec3 droop =
            glm::normalize(outwards + 0.9f * random_direction(random) - glm::vec3{0, 0, 0.35f});
        // Facing must not be parallel to `droop`: the leaf would have no side.
        const glm::vec3 facing =
            glm::normalize(glm::cross(droop, random_direction(random)) + 0.2f * outwards);
        mesh.use(foliage.leaves[random.index(3)]);
        add_leaf(mesh, stem, droop, facing, leaf_length * random.uniform(0.75f, 1.2f));
    }
}

/// A broad-leaved tree of the given height that stands at `root`. Triangles: 14 * 3 for the trunk, 10 for
/// each of the 8 branches, and 2 for each of `leaves`.
inline void add_broadleaf(MeshBuilder& mesh, Random& random, const Foliage& foliage, glm::vec3 root,
                          float height, int leaves) {
    mesh.place(root, random.uniform(), height / 16.0f);
    mesh.use(foliage.bark);
    const glm::vec3 lean{random.uniform(-0.5f, 0.5f), random.uniform(-0.5f, 0.5f), 0.0f};
    const std::array<glm::vec3, 4> trunk{glm::vec3{0, 0, -0.6f}, glm::vec3{0, 0, 1.0f},
                                         glm::vec3{0, 0, 5.5f} + lean, glm::vec3{0, 0, 10.0f} + 1.6f * lean};
    const std::array<float, 4> thickness{0.95f, 0.58f, 0.46f, 0.22f};
    for (std::size_t i = 0; i + 1 < trunk.size(); ++i) {
        mesh.tube(trunk[i], trunk[i + 1], thickness[i], thickness[i + 1], 7);
    }
    constexpr int branches = 8;
    const float start = random.uniform();
    for (int i = 0; i < branches; ++i) {
        // The golden angle spreads the branches evenly around the trunk; the last cluster is the top of the
        // crown.
        const float share = static_cast<float>(i) / (branches - 1);
        const glm::vec2 around = circle_point(start + 0.381966f * static_cast<float>(i));
        const float reach = (1.0f - share * share * 0.9f) * random.uniform(2.9f, 3.9f);
        const glm::vec3 from = glm::mix(trunk[2], trunk[3], share * 0.95f);
        const glm::vec3 to =
            from + glm::vec3{reach * around.x, reach * around.y, random.uniform(1.0f, 1.8f) + 1.6f * share};
        mesh.use(foliage.bark);
        mesh.tube(from, to, 0.20f, 0.07f, 5);
        const int share_of_leaves = leaves * (i + 1) / branches - leaves * i / branches;
        const float size = random.uniform(2.1f, 2.7f);
        add_leaf_cluster(mesh, random, foliage, to, {size, size, 0.8f * size}, share_of_leaves, 1.15f);
    }
}

/// A conifer of the given height. Triangles: 7 for the trunk and 2 for each of `twigs`, long leaves that hang
/// in tiers.
inline void add_conifer(MeshBuilder& mesh, Random& random, const Foliage& foliage, glm::vec3 root,
                        float height, int twigs) {
    mesh.place(root, random.uniform(), height / 18.0f);
    mesh.use(foliage.bark);
    mesh.tube({0, 0, -0.6f}, {0, 0, 17.5f}, 0.55f, 0.0f, 7);
    constexpr int tiers = 13;
    for (int i = 0; i < twigs; ++i) {
        const auto tier = static_cast<float>(random.index(tiers));
        const float share = (tier + random.uniform(0.0f, 0.7f)) / tiers;
        const float reach = 4.3f * (1.0f - share) + 0.35f;
        const glm::vec2 around = circle_point(random.uniform());
        const float from = reach * random.uniform(0.05f, 0.72f);
        const glm::vec3 outwards{around.x, around.y, 0.0f};
        const glm::vec3 along =
            glm::normalize(outwards + 0.25f * random_direction(random) - glm::vec3{0, 0, 0.38f});
        const glm::vec3 facing = glm::normalize(glm::vec3{0, 0, 1.0f} + 0.3f * random_direction(random));
        const glm::vec3 stem =
            glm::vec3{0, 0, 2.6f + 14.9f * share} + from * outwards - glm::vec3{0, 0, 0.38f * from};
        mesh.use(foliage.leaves[random.index(3)]);
        add_leaf(mesh, stem, along, facing, random.uniform(1.1f, 1.6f));
    }
}

}  // namespace demo
