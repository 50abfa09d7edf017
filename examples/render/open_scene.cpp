// SPDX-License-Identifier: MIT
#include "render/open_scene.hpp"

#include "render/embree_scene.hpp"
#include "render/renderer.hpp"
#include "render/view.hpp"
#include "render/visibility.hpp"
#include "scene/boxes.hpp"
#include "scene/light_rig.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

namespace demo {
namespace {

constexpr float pi = 3.14159265f;
/// Pixels of the small picture by which radius and exposure are chosen.
constexpr int probe_width = 96;
constexpr int probe_height = 72;
/// A radius is chosen by at least so many points, spread over the picture.
constexpr std::size_t enough_points = 4096;

/// The i-th of `count` directions spread evenly over the sphere.
glm::vec3 direction_of(int i, int count) {
    const float z = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / static_cast<float>(count);
    const float angle = 2.39996323f * static_cast<float>(i);  // the golden angle
    const float radius = std::sqrt((std::max)(0.0f, 1.0f - z * z));
    return {radius * std::cos(angle), radius * std::sin(angle), z};
}

std::string number_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

std::string in_brackets(const glm::dvec3& v) {
    return number_text(v.x) + "," + number_text(v.y) + "," + number_text(v.z);
}

void set_view(const SceneOptions& options, Scene& scene) {
    Camera& camera = scene.camera;
    if (options.up)
        camera.up = glm::normalize(*options.up);
    if (options.field_of_view) {
        camera.vertical_field_of_view = *options.field_of_view * pi / 180.0f;
        camera.orthographic_height = 0.0f;
    }
    const auto here = [&](const glm::vec3& file_point) {
        return glm::vec3(glm::dvec3(file_point) - scene.origin);
    };
    if (options.eye)
        camera.eye = here(*options.eye);
    if (options.target)
        camera.target = here(*options.target);
    else if (options.eye)
        camera.target = centre_of(bounds_of(scene));
    for (const glm::vec3& place : {camera.eye, camera.target})
        if (!(glm::length(glm::dvec3(place)) < 1e18))
            throw std::invalid_argument("--eye or --target is too far away to see anything: " +
                                        in_brackets(glm::dvec3(place)));
    if (!(glm::length(camera.target - camera.eye) > 0.0f))
        throw std::invalid_argument("--eye and --target are one place: the camera looks nowhere");
    const glm::vec3 ahead = glm::normalize(camera.target - camera.eye);
    if (!(glm::length(glm::cross(ahead, camera.up)) > 1e-4f)) {
        if (options.up)
            throw std::invalid_argument("--up is along the view");
        camera.up = std::abs(ahead.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
    }
    if (options.eye || options.target)
        std::erase_if(scene.remarks,
                      [](const std::string& remark) { return remark.starts_with("the file has no camera"); });
}

/// A place inside of a building, and how it lies there.
struct Inside {
    glm::vec3 place;
    float openness;  ///< mean distance to what is around
};

float distance_along(const EmbreeScene& scene, const glm::vec3& from, const glm::vec3& direction,
                     float most) {
    const auto hit = scene.trace(from, direction);
    return hit ? (std::min)(most, glm::length(hit->position - from)) : most;
}

/// True if a place has walls around it and a ceiling, seen from their front.
std::optional<Inside> inside_at(const EmbreeScene& scene, const glm::vec3& place, const glm::vec3& up) {
    constexpr int count = 96;
    int hits = 0;
    int fronts = 0;
    int above = 0;
    int covered = 0;
    float sum = 0.0f;
    for (int i = 0; i < count; ++i) {
        const glm::vec3 direction = direction_of(i, count);
        const bool is_above = glm::dot(direction, up) > 0.6f;
        above += is_above ? 1 : 0;
        const auto hit = scene.trace(place, direction);
        if (!hit)
            continue;
        ++hits;
        covered += is_above ? 1 : 0;
        fronts += hit->from_inside ? 0 : 1;
        sum += glm::length(hit->position - place);
    }
    const bool is_inside = hits >= count * 3 / 4 && covered >= above * 4 / 5 && fronts >= hits * 3 / 5;
    return is_inside ? std::optional(Inside{place, sum / static_cast<float>((std::max)(hits, 1))})
                     : std::nullopt;
}

/// The most open of the places that are inside, if there are enough of them for a building.
std::optional<Inside> find_inside(const EmbreeScene& scene, const glm::vec3& up) {
    constexpr std::array<float, 5> shares{0.2f, 0.35f, 0.5f, 0.65f, 0.8f};
    const Bounds bounds = bounds_of(scene.scene());
    std::optional<Inside> best;
    std::size_t found = 0;
    for (const float x : shares)
        for (const float y : shares)
            for (const float z : shares) {
                const glm::vec3 place = bounds.low + glm::vec3(x, y, z) * (bounds.high - bounds.low);
                const auto inside = inside_at(scene, place, up);
                found += inside ? 1 : 0;
                if (inside && (!best || inside->openness > best->openness))
                    best = inside;
            }
    return found >= shares.size() * shares.size() * shares.size() / 8 ? best : std::nullopt;
}

/// Looks along the longest way from a place, from as far back as there is room.
Camera view_from(const EmbreeScene& scene, const Inside& inside, const glm::vec3& up) {
    constexpr int count = 24;
    const float most = 0.5f * scene.diagonal();
    const glm::vec3 other = std::abs(up.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1);
    const glm::vec3 right = glm::normalize(glm::cross(up, other));
    const glm::vec3 front = glm::cross(right, up);
    glm::vec3 best_direction = front;
    float best = -1.0f;
    for (int i = 0; i < count; ++i) {
        const float turn = 2.0f * pi * (static_cast<float>(i) + 0.5f) / count;
        const glm::vec3 direction = std::cos(turn) * right + std::sin(turn) * front;
        if (!scene.trace(inside.place, direction))
            continue;  // out of a window
        const float length = distance_along(scene, inside.place, direction, most) +
                             0.9f * distance_along(scene, inside.place, -direction, 0.35f * scene.diagonal());
        if (length > best) {
            best = length;
            best_direction = direction;
        }
    }
    Camera camera;
    camera.up = up;
    const float behind = distance_along(scene, inside.place, -best_direction, 0.35f * scene.diagonal());
    camera.eye = inside.place - 0.9f * behind * best_direction;
    camera.target =
        inside.place + 0.5f * distance_along(scene, inside.place, best_direction, most) * best_direction;
    camera.vertical_field_of_view = 1.0f;
    return camera;
}

/// Four lamps below the ceiling, along the way that the camera looks.
void light_inside(const EmbreeScene& embree, Scene& scene) {
    const glm::vec3 way = scene.camera.target - scene.camera.eye;
    const glm::vec3& up = scene.camera.up;
    scene.lights.clear();
    for (const float share : {0.1f, 0.45f, 0.8f, 1.2f}) {
        const glm::vec3 below = scene.camera.eye + share * way;
        const float height = distance_along(embree, below, up, 0.5f * glm::length(way));
        const float reach = (std::max)(height, 0.25f * glm::length(way));
        scene.lights.push_back({lightmesh::PointLight{below + 0.7f * height * up},
                                0.4f * reach * reach * glm::vec3(1.0f, 0.95f, 0.88f)});
    }
}

void drop_remark(Scene& scene, const std::string& start) {
    std::erase_if(scene.remarks, [&](const std::string& remark) { return remark.starts_with(start); });
}

void complete_view_and_lights(const SceneOptions& options, const EmbreeScene& embree, Scene& scene) {
    bool is_inside = false;
    if (!scene.has_own_camera && !options.eye && !options.target) {
        if (const auto inside = find_inside(embree, scene.camera.up)) {
            scene.camera = view_from(embree, *inside, scene.camera.up);
            is_inside = true;
            drop_remark(scene, "the file has no camera");
            scene.remarks.push_back("the file has no camera, but rooms: seen from inside, --eye " +
                                    in_brackets(glm::dvec3(scene.camera.eye) + scene.origin) + " --target " +
                                    in_brackets(glm::dvec3(scene.camera.target) + scene.origin));
        }
    } else {
        is_inside = inside_at(embree, scene.camera.eye, scene.camera.up).has_value();
    }
    if (!scene.has_own_lights && is_inside && options.lights == 0) {
        light_inside(embree, scene);
        drop_remark(scene, "the file has no lights");
        scene.remarks.push_back("the file has no lights: " + std::to_string(scene.lights.size()) +
                                " point lights added where the camera looks");
    }
}

/// The surfaces that the camera sees first in each pixel of the small picture, or of one some times as fine.
std::vector<std::optional<Hit>> probe(const EmbreeScene& embree, int times = 1) {
    const int width = times * probe_width;
    const int height = times * probe_height;
    const View view(embree.scene().camera, width, height);
    std::vector<std::optional<Hit>> hits;
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const float x = static_cast<float>(column) + 0.5f;
            const float y = static_cast<float>(row) + 0.5f;
            hits.push_back(embree.trace(view.origin(x, y), view.direction(x, y)));
        }
    return hits;
}

/// How far away things are that the camera sees.
std::vector<float> depths_of(const std::vector<std::optional<Hit>>& hits, const Camera& camera) {
    const glm::vec3 ahead = glm::normalize(camera.target - camera.eye);
    std::vector<float> depths;
    for (const auto& hit : hits)
        if (hit)
            depths.push_back(glm::dot(hit->position - camera.eye, ahead));
    return depths;
}

/// A radius by the size that near things have in the picture: a fraction of its height where they are. No
/// more than the scene's own. `hits` are those of `probe`; where they are few, since most of the picture is
/// sky, a finer grid is looked at.
void choose_radius(const EmbreeScene& embree, const std::vector<std::optional<Hit>>& hits, Scene& scene) {
    constexpr float share_of_height = 0.045f;
    constexpr int finest = 8;
    const Camera& camera = scene.camera;
    std::vector<float> depths = depths_of(hits, camera);
    if (depths.empty())
        return;
    for (int times = 2; depths.size() < enough_points && times <= finest; times *= 2) {
        std::vector<float> more = depths_of(probe(embree, times), camera);
        if (more.size() > depths.size())
            depths = std::move(more);
    }
    const auto nearer = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 4);
    std::ranges::nth_element(depths, nearer);
    const float height = camera.orthographic_height > 0.0f
                             ? camera.orthographic_height
                             : 2.0f * *nearer * std::tan(0.5f * camera.vertical_field_of_view);
    if (height > 0.0f && std::isfinite(height))
        scene.radius = (std::min)(scene.radius, share_of_height * height);
}

/// Names lamps that are shut in: nothing lies open around them, and nothing that is seen has light from them.
void note_closed_lamps(const EmbreeScene& embree, const std::vector<std::optional<Hit>>& hits, Scene& scene) {
    constexpr std::size_t most_lamps = 256;
    constexpr int directions = 64;
    const EmbreeIntersector tracer = embree.intersector();
    const float reach = 0.1f * embree.diagonal();
    for (std::size_t l = 0; l < (std::min)(scene.lights.size(), most_lamps); ++l) {
        const SceneLight& light = scene.lights[l];
        const auto* lamp = std::get_if<lightmesh::PointLight>(&light.shape);
        const auto* spot = std::get_if<lightmesh::SpotLight>(&light.shape);
        if ((lamp == nullptr && spot == nullptr) || light.facing != glm::vec3(0.0f) || light.name.empty())
            continue;
        const glm::vec3 place = lamp != nullptr ? lamp->position : spot->position;
        bool is_closed = true;
        for (int i = 0; i < directions && is_closed; ++i)
            is_closed = tracer.occluded({place, place + reach * direction_of(i, directions)});
        for (std::size_t i = 0; i < hits.size() && is_closed; i += 7)
            if (hits[i])
                is_closed =
                    tracer.occluded({hits[i]->position + embree.offset() * hits[i]->geometric_normal, place});
        if (is_closed)
            scene.remarks.push_back("lamp '" + light.name +
                                    "' is inside a closed surface: it lights nothing");
    }
}

/// The light in a picture of surfaces that do not shine themselves.
struct Brightness {
    double high = 0.0;  ///< 98 of 100 are darker
    double mean = 0.0;
};

Brightness brightness_of(const EmbreeScene& embree, const std::vector<std::optional<Hit>>& hits,
                         Scene& scene) {
    const glm::vec3 ambient = std::exchange(scene.ambient, glm::vec3(0.0f));
    const glm::vec3 background = std::exchange(scene.background, glm::vec3(0.0f));
    const auto shadows = make_hard_shadows(embree);
    RenderOptions options;
    options.width = probe_width;
    options.height = probe_height;
    RenderStatistics statistics;
    const Image picture = render(embree, *shadows, options, statistics);
    scene.ambient = ambient;
    scene.background = background;
    std::vector<double> values;
    Brightness found;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (!hits[i] || scene.materials[hits[i]->material].emission != glm::vec3(0.0f))
            continue;
        const glm::dvec3 value(picture.pixels[i]);
        if (!std::isfinite(value.r + value.g + value.b))
            continue;
        values.push_back((std::max)({value.r, value.g, value.b}));
        found.mean += 0.2126 * value.r + 0.7152 * value.g + 0.0722 * value.b;
    }
    if (values.empty())
        return {};
    found.mean /= static_cast<double>(values.size());
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 98 / 100);
    std::ranges::nth_element(values, place);
    found.high = *place;
    return found;
}

/// A factor that leaves less than 2 of 100 pixels white and brings the mean to where one sees well; 1 where
/// that is so already.
double factor_for(const Brightness& seen) {
    constexpr double dark = 0.1;
    constexpr double bright = 0.5;
    constexpr double good = 0.3;
    if (!(seen.mean > 0.0) || (seen.high <= 1.0 && seen.mean >= dark && seen.mean <= bright))
        return 1.0;
    return (std::min)(0.98 / (std::max)(seen.high, 1e-300), good / seen.mean);
}

bool is_patch(const SceneLight& light) {
    return light.facing != glm::vec3(0.0f) || std::holds_alternative<lightmesh::RectLight>(light.shape);
}

/// Signs and dials shine, but light no room: lights are added to them.
double factor_with_lights(const EmbreeScene& embree, const std::vector<std::optional<Hit>>& hits,
                          Scene& scene) {
    constexpr double too_dark = 32.0;
    const double factor = factor_for(brightness_of(embree, hits, scene));
    if (factor < too_dark || !std::ranges::all_of(scene.lights, is_patch))
        return factor;
    add_light_rig(scene);
    scene.remarks.emplace_back(
        "the surfaces that shine give too little light to see by: 6 point lights added around and above");
    return factor_for(brightness_of(embree, hits, scene));
}

void set_exposure(double factor, Scene& scene) {
    const double kept = std::clamp(factor, 1e-30, 1e30);
    scene.exposure = static_cast<float>(kept);
    // These belong to the picture, not to the scene.
    scene.ambient /= scene.exposure;
    scene.background /= scene.exposure;
}

/// Gives a scene, as it was loaded, what the options ask for and what it does not have.
Scene completed(const SceneOptions& options, Scene scene) {
    set_view(options, scene);
    if (!scene.is_file) {
        if (options.lights > 0)
            spread_lights(scene, options.lights);
        // Its own radius suits its own view.
        if (options.eye || options.target || options.field_of_view) {
            const EmbreeScene embree(scene);
            choose_radius(embree, probe(embree), scene);
        }
        if (options.exposure)
            scene.exposure = std::exp2(*options.exposure);
        return scene;
    }
    const EmbreeScene embree(scene);
    complete_view_and_lights(options, embree, scene);
    if (options.lights > 0)
        spread_lights(scene, options.lights);
    const std::vector<std::optional<Hit>> hits = probe(embree);
    if (std::ranges::none_of(hits, [](const std::optional<Hit>& hit) { return hit.has_value(); }))
        scene.remarks.emplace_back("the camera sees nothing of the scene");
    choose_radius(embree, hits, scene);
    note_closed_lamps(embree, hits, scene);
    if (options.exposure) {
        set_exposure(std::exp2(static_cast<double>(*options.exposure)), scene);
    } else {
        const double factor = factor_with_lights(embree, hits, scene);
        set_exposure(factor, scene);
        if (factor != 1.0)
            scene.remarks.push_back("the exposure is set by what the camera sees: --exposure " +
                                    number_text(std::log2(factor)) +
                                    "; --exposure 0 takes the file's own values");
    }
    return scene;
}

}  // namespace

Scene open_scene(const SceneOptions& options) {
    return completed(options, load_scene(options.scene, options.import));
}

Film open_film(const SceneOptions& options, Moving moving) {
    if (options.import.time)
        throw std::invalid_argument("--time is of still pictures; films go --from one time --to another");
    AnimatedScene loaded = load_animated(options.scene, options.import);
    loaded.scene = completed(options, std::move(loaded.scene));
    const bool has_view = options.eye || options.target || options.up || options.field_of_view;
    moving.camera = moving.camera && !has_view;
    moving.lights = moving.lights && options.lights == 0;
    return Film(std::move(loaded), moving);
}

}  // namespace demo
