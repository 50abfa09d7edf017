// SPDX-License-Identifier: MIT
#include "render/commands.hpp"
#include "render/options.hpp"
#include "scene/boxes.hpp"

#include <nlohmann/json.hpp>

#include <iostream>
#include <memory>
#include <string>
#include <variant>

namespace demo {

namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions : SceneOptions {
    bool json = false;
};

Json list_of(const glm::vec3& v) {
    return Json::array({v.x, v.y, v.z});
}

Json light_info(const SceneLight& light) {
    Json info{{"name", light.name}};
    if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&light.shape)) {
        info["kind"] = "directional";
        info["direction"] = list_of(sun->direction);
    } else if (const auto* spot = std::get_if<lightmesh::SpotLight>(&light.shape)) {
        info["kind"] = "spot";
        info["position"] = list_of(spot->position);
        info["cone"] = spot->cone;
    } else if (const auto* pane = std::get_if<lightmesh::RectLight>(&light.shape)) {
        info["kind"] = "rectangle";
        info["position"] = list_of(pane->position);
        info["half sides"] = Json::array({list_of(pane->half_u), list_of(pane->half_v)});
    } else {
        info["kind"] = light.facing == glm::vec3(0.0f) ? "point" : "patch of a surface";
        info["position"] = list_of(std::get<lightmesh::PointLight>(light.shape).position);
    }
    info["intensity"] = list_of(light.intensity);
    return info;
}

std::string alpha_name(AlphaMode mode) {
    if (mode == AlphaMode::opaque)
        return "opaque";
    return mode == AlphaMode::mask ? "mask" : "blend";
}

Json material_info(const Material& material) {
    return {{"name", material.name},
            {"diffuse", list_of(material.diffuse)},
            {"emission", list_of(material.emission)},
            {"texture", material.base_map.texture >= 0},
            {"emission texture", material.emission_map.texture >= 0},
            {"alpha", alpha_name(material.alpha_mode)},
            {"lets through", material.k_t}};
}

Json info_of(const Scene& scene) {
    const Bounds bounds = bounds_of(scene);
    Json info{{"name", scene.name},
              {"meshes", scene.mesh_count},
              {"triangles", scene.triangles.size()},
              {"vertices", scene.positions.size()},
              {"textures", scene.textures.size()},
              {"low corner", list_of(bounds.low)},
              {"high corner", list_of(bounds.high)},
              {"radius", scene.radius},
              {"quality", scene.quality},
              {"cameras", scene.cameras}};
    for (const char* list : {"lights", "materials"})
        info[list] = Json::array();
    for (const SceneLight& light : scene.lights)
        info["lights"].push_back(light_info(light));
    for (const Material& material : scene.materials)
        info["materials"].push_back(material_info(material));
    info["notes"] = scene.remarks;
    return info;
}

/// A line for each value, and for each element of a list.
void print(const Json& info) {
    for (const auto& [key, value] : info.items()) {
        const bool is_list = value.is_array() && (value.empty() || !value.front().is_number());
        if (!is_list) {
            std::cout << key << ": " << (value.is_string() ? value.get<std::string>() : value.dump()) << '\n';
            continue;
        }
        std::cout << key << ": " << value.size() << '\n';
        for (const Json& element : value) {
            std::string line;
            if (element.is_object())
                for (const auto& [part, inner] : element.items())
                    line += (line.empty() ? "" : ", ") + part + " " +
                            inner.dump(-1, ' ', false, Json::error_handler_t::replace);
            else
                line = element.get<std::string>();
            std::cout << "    " << line << '\n';
        }
    }
}

int show_info(const InfoOptions& options) {
    const Json info = info_of(open_scene(options));
    if (options.json)
        std::cout << info.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    else
        print(info);
    return 0;
}

}  // namespace

void add_info_command(CLI::App& program, int& status) {
    const auto options = std::make_shared<InfoOptions>();
    CLI::App* command = program.add_subcommand("info", "what was found in a file");
    add_file_options(*command, *options);
    command->add_flag("--json", options->json, "as JSON");
    command->callback([options, &status] { status = show_info(*options); });
}

}  // namespace demo
