// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"

#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// Rays by kind, as far as an algorithm traces them itself.
struct VisibilityCost {
    std::uint64_t shadow_rays = 0;
    std::uint64_t short_rays = 0;
    double seconds = 0.0;  ///< in visibility queries, summed over threads

    VisibilityCost& operator+=(const VisibilityCost& other) {
        shadow_rays += other.shadow_rays;
        short_rays += other.short_rays;
        seconds += other.seconds;
        return *this;
    }
};

/// How lit surface points are: what the algorithms of `lightmesh-render` differ in. Const members may be used by any number
/// of threads.
class Visibility {
public:
    virtual ~Visibility() = default;

    /// Row-major, a row of lights for each point: 0 in shadow to 1 lit. `seeds` are random numbers, one a point, that depend
    /// on nothing but the point's place in the picture.
    virtual void find(std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                      std::span<const std::uint32_t> seeds, std::span<float> lit, VisibilityCost& cost) const = 0;

    /// Of the light mesh, if there is one.
    virtual std::optional<lightmesh::MeshStatistics> mesh() const { return std::nullopt; }
};

/// What the command line can ask of an algorithm.
struct VisibilityOptions {
    lightmesh::Settings settings;
    int area_samples = 16;
    float light_radius = 0.0f;  ///< of a sphere light; 0: as wide as the penumbra of the light mesh at mid-distance
};

/// A way to find visibility, by the name that the command line knows it by.
struct Algorithm {
    std::string name;
    std::string description;
    std::function<std::unique_ptr<Visibility>(const EmbreeScene&, const VisibilityOptions&)> make;
};

/// All of them: whitted, area, lmm, linked, express.
const std::vector<Algorithm>& algorithms();

/// Throws std::runtime_error that names the algorithm and lists those there are.
const Algorithm& find_algorithm(const std::string& name);

}  // namespace demo
