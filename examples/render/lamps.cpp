// SPDX-License-Identifier: MIT
#include "render/lamps.hpp"

#include "render/text_table.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

namespace demo {

namespace {

/// Half the angle that the sun fills, radians.
constexpr float sun_angle = 0.00465f;

/// "0.333", or the least and the greatest.
std::string range_text(const std::vector<float>& sizes) {
    const auto [low, high] = std::ranges::minmax(sizes);
    return low == high ? number(low) : number(low) + " to " + number(high);
}

}  // namespace

float default_lamp_radius(const VisibilityOptions& options) {
    return options.settings.radius / 3.0f;
}

std::vector<lightmesh::Light> lamps_of(const EmbreeScene& scene, const VisibilityOptions& options) {
    const float wanted = options.light_size;
    std::vector<lightmesh::Light> lamps = shapes_of_lights(scene.scene(), options.lights);
    for (lightmesh::Light& lamp : lamps)
        std::visit(
            [&](auto& kind) {
                using Kind = std::remove_cvref_t<decltype(kind)>;
                if constexpr (std::is_same_v<Kind, lightmesh::DirectionalLight>) {
                    if (wanted > 0.0f)
                        kind.angular_radius = std::atan(wanted / (0.5f * scene.diagonal()));
                    else if (kind.angular_radius == 0.0f)
                        kind.angular_radius = sun_angle;
                } else if constexpr (!std::is_same_v<Kind, lightmesh::RectLight>) {
                    if (wanted > 0.0f)
                        kind.radius = wanted;
                    else if (kind.radius == 0.0f)
                        kind.radius = default_lamp_radius(options);
                }
            },
            lamp);
    return lamps;
}

VisibilityOptions lamp_options(const VisibilityOptions& options) {
    VisibilityOptions looked_at;
    looked_at.settings = options.settings;
    looked_at.light_size = options.light_size;
    looked_at.lights = options.lights;
    return looked_at;
}

std::vector<float> sizes_at_ends(std::span<const lightmesh::Light> lamps, float far_away) {
    std::vector<float> sizes;
    for (const lightmesh::Light& lamp : lamps) {
        if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&lamp))
            sizes.push_back(far_away * std::tan(sun->angular_radius));
        else if (const auto* spot = std::get_if<lightmesh::SpotLight>(&lamp))
            sizes.push_back(spot->radius);
        else if (const auto* point = std::get_if<lightmesh::PointLight>(&lamp))
            sizes.push_back(point->radius);
        else
            sizes.push_back(0.0f);
    }
    return sizes;
}

std::string lamp_size_text(std::span<const lightmesh::Light> lamps) {
    std::vector<float> radii;
    std::vector<float> angles;
    for (const lightmesh::Light& lamp : lamps)
        std::visit(
            [&](const auto& kind) {
                using Kind = std::remove_cvref_t<decltype(kind)>;
                if constexpr (std::is_same_v<Kind, lightmesh::DirectionalLight>)
                    angles.push_back(kind.angular_radius);
                else if constexpr (!std::is_same_v<Kind, lightmesh::RectLight>)
                    radii.push_back(kind.radius);
            },
            lamp);
    std::string text = radii.empty() ? "" : range_text(radii);
    if (!angles.empty())
        text += (text.empty() ? "" : ", ") + range_text(angles) + " rad";
    return text.empty() ? "-" : text;
}

}  // namespace demo
