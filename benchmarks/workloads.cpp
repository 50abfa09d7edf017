// SPDX-License-Identifier: MIT
#include "workloads.hpp"

#include <map>
#include <stdexcept>
#include <utility>
#include <variant>

namespace bench {

namespace {

demo::Scene make_scene(const std::string& name) {
    if (name == "park")
        return demo::make_park();
    if (name == "spheres")
        return demo::make_spheres();
    if (name == "rooms")
        return demo::make_rooms();
    if (name == "street")
        return demo::make_street();
    throw std::invalid_argument("there is no built-in scene '" + name + "'");
}

/// A scene and what is seen of it, which stay where they are.
struct Stage {
    explicit Stage(const std::string& name)
        : scene(make_scene(name)), bvh(scene), points(bvh, picture_width, picture_height) {}
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

    demo::Scene scene;
    demo::EmbreeScene bvh;
    ShadingPoints points;
    std::map<std::size_t, ShadingPoints> parts;
    std::map<std::size_t, Workload> workloads;
};

Stage& stage(const std::string& name) {
    static std::map<std::string, Stage> stages;
    return stages.try_emplace(name, name).first->second;
}

std::vector<glm::vec3> lights_over(demo::Scene scene, std::size_t count) {
    demo::spread_lights(scene, count);
    std::vector<glm::vec3> positions;
    for (const demo::SceneLight& light : scene.lights)
        positions.push_back(std::get<lightmesh::PointLight>(light.shape).position);
    return positions;
}

}  // namespace

const Workload& workload(const std::string& scene, std::size_t lights) {
    Stage& s = stage(scene);
    auto found = s.workloads.find(lights);
    if (found == s.workloads.end()) {
        Workload made{s.bvh, s.points, lights_over(s.scene, lights), s.scene.radius};
        found = s.workloads.emplace(lights, std::move(made)).first;
    }
    return found->second;
}

const ShadingPoints& points_of(const std::string& scene, std::size_t most) {
    Stage& s = stage(scene);
    if (most == 0 || most >= s.points.size())
        return s.points;
    auto found = s.parts.find(most);
    if (found == s.parts.end())
        found = s.parts.emplace(most, s.points.part(most)).first;
    return found->second;
}

}  // namespace bench
