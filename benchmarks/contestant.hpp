// SPDX-License-Identifier: MIT
#pragma once

#include "shading_points.hpp"

#include <lightmesh/settings.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bench {

/// A scene, its view's points, and some lights.
struct Workload {
    const demo::EmbreeScene& scene;
    const ShadingPoints& points;
    std::vector<glm::vec3> lights;
    float radius;  ///< r of light meshes here

    /// Whether (n, L - P) >= 0: only then anyone spends a ray.
    bool faces(std::size_t light, const glm::vec3& point, const glm::vec3& normal) const {
        return glm::dot(normal, lights[light] - point) >= 0.0f;
    }
};

/// One way to find how lit points are. Const members may be used by any number of threads.
class Contestant {
public:
    virtual ~Contestant() = default;

    /// The points of a tile; `lit` is row-major, a row of lights for each point: 0 in shadow to 1 lit.
    virtual void find(const Points& points, std::span<float> lit) const = 0;

    /// Rays that `find` spends on these points, if nothing new has to be cached.
    virtual std::uint64_t rays(const Points& points) const = 0;

    /// Rays spent so far on what is cached.
    virtual std::uint64_t cached_rays() const { return 0; }
    virtual std::size_t light_points() const { return 0; }
    virtual std::size_t bytes() const { return 0; }
};

/// How many points a call of the light mesh gets.
enum class Query { point, tile };

/// Forms of one shadow ray per point and facing light: `rtcOccluded1` first, then packets over the points of
/// a tile that face the same light, and streams of all of them; the suffix says Embree's context flag, if it
/// is not its default INCOHERENT.
const std::vector<std::string>& hard_forms();
std::unique_ptr<Contestant> make_hard_shadows(const Workload& workload, const std::string& form);

/// 16 rays to each facing light, stratified over a disc of a tenth of the mesh's radius that faces the point:
/// by `rtcOccluded1`, or all 16 in one packet.
const std::vector<std::string>& area_forms();
std::unique_ptr<Contestant> make_area_shadows(const Workload& workload, const std::string& form);

/// Percentage-closer filtered shadow maps.
inline constexpr int shadow_map_side = 512;
inline constexpr float shadow_map_filter = 1.5f;  // texels to each side
std::unique_ptr<Contestant> make_shadow_maps(const Workload& workload);

/// An empty light mesh.
std::unique_ptr<Contestant> make_light_mesh(const Workload& workload, float quality,
                                            lightmesh::ShortTest short_test, Query query);
/// One that shares `mesh`, made by `make_light_mesh`, and asks it in the other way.
std::unique_ptr<Contestant> share_light_mesh(const Contestant& mesh, Query query);

}  // namespace bench
