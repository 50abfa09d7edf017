// SPDX-License-Identifier: MIT
#include "cache_walks.hpp"

#include "embree_rays.hpp"
#include "lamp_share.hpp"
#include "mesh_frame.hpp"
#include "render/embree_scene.hpp"
#include "render/text_table.hpp"
#include "render/view.hpp"
#include "scene/mesh_builder.hpp"
#include "scene/random.hpp"
#include "scene/scene.hpp"
#include "shading_points.hpp"
#include "surface_end.hpp"

#include <lightmesh/visibility_cache.hpp>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace bench {

namespace {

using Cache = lightmesh::VisibilityCache<demo::EmbreeIntersector>;
using Build = std::function<void(demo::MeshBuilder&)>;

constexpr float spacing = 0.25f;

/// A small scene, one sphere lamp over it, and a cache with default settings but the spacing, with or without
/// shaft rows.
class Stage {
public:
    Stage(const lightmesh::PointLight& lamp, const Build& build, bool shaft_rows = true) : lamp_(lamp) {
        model_.materials.emplace_back();
        demo::MeshBuilder builder(model_);
        build(builder);
        scene_ = std::make_unique<demo::EmbreeScene>(model_);
        cache_ =
            std::make_unique<Cache>(scene_->intersector(), std::vector<lightmesh::Light>{lamp},
                                    lightmesh::CacheSettings{.spacing = spacing, .shaft_rows = shaft_rows});
    }

    bool is_faced(const glm::vec3& point, const glm::vec3& normal) const {
        return glm::dot(normal, lamp_.position - point) >= 0.0f;
    }
    float cached(const glm::vec3& point, const glm::vec3& normal, float footprint = 0.0f) const {
        return cache_->visibility({.position = point, .normal = normal, .footprint = footprint}, 0);
    }
    /// By rays, the same pattern from everywhere.
    float reference(const glm::vec3& point, const glm::vec3& normal, int rays) const {
        Occlusion tracer(scene_->handle(), true);
        demo::Random random(5);
        return open_share(tracer, surface_end(point, normal), lamp_.position, lamp_.radius, rays, random);
    }

private:
    lightmesh::PointLight lamp_;
    demo::Scene model_;
    std::unique_ptr<demo::EmbreeScene> scene_;
    std::unique_ptr<Cache> cache_;
};

void add_floor(demo::MeshBuilder& builder) {
    builder.quad({-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0});
}

/// Of points of the floor around the origin whose reference is below .2, the share that the cache has below
/// .4.
double kept_contacts(const Build& build, bool shaft_rows) {
    const Stage stage(
        {.position = {1.6f, -2.4f, 2.5f}, .radius = 0.15f},
        [&](demo::MeshBuilder& builder) {
            add_floor(builder);
            build(builder);
        },
        shaft_rows);
    constexpr int side = 240;
    int dark = 0;
    int kept = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const glm::vec3 point(2.0f * (static_cast<float>(x) + 0.37f) / side - 1.0f,
                                  2.0f * (static_cast<float>(y) + 0.37f) / side - 1.0f, 0.0f);
            const glm::vec3 up(0, 0, 1);
            if (stage.reference(point, up, 64) > 0.25f || stage.reference(point, up, 1024) > 0.2f)
                continue;
            ++dark;
            kept += stage.cached(point, up) < 0.4f ? 1 : 0;
        }
    return static_cast<double>(kept) / dark;
}

void add_fence(demo::MeshBuilder& builder) {
    for (int post = -8; post <= 8; ++post) {
        const float x = 0.12f * static_cast<float>(post);
        builder.box({x - 0.02f, -0.02f, 0.0f}, {x + 0.02f, 0.02f, 0.7f});
    }
}

void add_legs(demo::MeshBuilder& builder) {
    for (const float x : {-0.6f, 0.6f})
        for (const float y : {-0.4f, 0.4f})
            builder.box({x - 0.03f, y - 0.03f, 0.0f}, {x + 0.03f, y + 0.03f, 0.7f});
}

void add_grass(demo::MeshBuilder& builder) {
    demo::Random random(3);
    for (int blade = 0; blade < 400; ++blade) {
        const glm::vec3 foot(2.0f * random.uniform() - 1.0f, 2.0f * random.uniform() - 1.0f, 0.0f);
        const glm::vec2 turn = demo::circle_point(random.uniform());
        const glm::vec3 half(0.012f * turn, 0.0f);
        builder.triangle(foot - half, foot + half, foot + glm::vec3(0.05f * turn, 0.2f));
    }
}

/// Points and normals along a way of 1e5 steps of g / 1000.
using Way = std::function<std::pair<glm::vec3, glm::vec3>(float)>;
/// Of the points of a way.
using Footprint = float (*)(float);

float no_footprint(float) {
    return 0.0f;
}
/// Twice up from half the finest level's step by some octaves, and back.
float up_and_down(float s, float octaves) {
    const float turn = s / (50.0f * spacing);
    const float up = 2.0f * (std::min)(turn - std::floor(turn), 1.0f - turn + std::floor(turn));
    return spacing * std::exp2(-4.0f + octaves * up);
}
float through_levels_of_penumbrae(float s) {
    return up_and_down(s, 4.75f);
}
float through_all_levels(float s) {
    return up_and_down(s, 14.0f);
}

/// The largest step of S, and how far one goes at most beyond the step that the reference has there.
struct Step {
    double raw = 0.0;
    double beyond = 0.0;
};

Step largest_step(const Stage& stage, const Way& way, const Footprint& footprint) {
    constexpr int steps = 100'000;
    const auto length = [](int i) {
        return spacing / 1000.0f * static_cast<float>(i);
    };
    const auto reference_at = [&](int i) {
        const auto [point, normal] = way(length(i));
        return stage.reference(point, normal, 1024);
    };
    Step largest;
    float before = -1.0f;
    for (int i = 0; i <= steps; ++i) {
        const auto [point, normal] = way(length(i));
        // Where the lamp's middle sets, S ends by definition.
        const float now =
            stage.is_faced(point, normal) ? stage.cached(point, normal, footprint(length(i))) : -1.0f;
        if (now >= 0.0f && before >= 0.0f) {
            const auto step = static_cast<double>(std::abs(now - before));
            largest.raw = (std::max)(largest.raw, step);
            // Rays are only needed where the step alone would be the largest.
            if (step > largest.beyond)
                largest.beyond =
                    (std::max)(largest.beyond,
                               step - static_cast<double>(std::abs(reference_at(i) - reference_at(i - 1))));
        }
        before = now;
    }
    return largest;
}

/// Blocks over a floor, or over what stands for one.
void add_blocks(demo::MeshBuilder& builder) {
    demo::Random random(4);
    for (int i = 0; i < 24; ++i) {
        const glm::vec3 low(24.0f * random.uniform() - 12.0f, 4.0f * random.uniform() - 2.0f,
                            0.8f + 0.4f * random.uniform());
        builder.box(low, low + glm::vec3(0.6f, 0.6f, 0.3f));
    }
}

Step walk_on_floor(Footprint footprint) {
    const Stage stage({.position = {0, 0, 5}, .radius = 0.6f}, [](demo::MeshBuilder& builder) {
        add_floor(builder);
        add_blocks(builder);
    });
    const auto way = [](float s) {
        return std::pair(glm::vec3(s - 12.5f, 0.04f * s - 0.5f, 0.0f), glm::vec3(0, 0, 1));
    };
    return largest_step(stage, way, footprint);
}

/// On a floor along the penumbra of a beam, from side to side of it.
Step walk_along_beam(Footprint footprint) {
    const Stage stage({.position = {0, 0, 5}, .radius = 0.6f}, [](demo::MeshBuilder& builder) {
        add_floor(builder);
        builder.box({-20, 1.0f, 1.2f}, {20, 2.0f, 1.4f});
    });
    const auto way = [](float s) {
        return std::pair(glm::vec3(s - 12.5f, 1.316f + 0.15f * std::sin(s), 0.0f), glm::vec3(0, 0, 1));
    };
    return largest_step(stage, way, footprint);
}

/// On a plane with blocks before it.
Step walk_on_plane(const glm::vec3& normal, Footprint footprint) {
    const glm::vec3 across(1, 0, 0);
    const glm::vec3 right = glm::normalize(across - glm::dot(across, normal) * normal);
    const glm::vec3 along = glm::cross(normal, right);
    const Stage stage({.position = 6.0f * normal - 1.0f * along, .radius = 0.6f},
                      [&](demo::MeshBuilder& builder) {
                          const glm::vec3 side = 20.0f * right;
                          builder.quad(-side - 8.0f * along, side - 8.0f * along, side + 8.0f * along,
                                       -side + 8.0f * along);
                          demo::Random random(6);
                          for (int i = 0; i < 24; ++i) {
                              const glm::vec3 at = (24.0f * random.uniform() - 12.0f) * right +
                                                   (3.0f * random.uniform() - 1.5f) * along +
                                                   (0.8f + 0.4f * random.uniform()) * normal;
                              builder.box(at - 0.3f, at + 0.3f);
                          }
                      });
    const auto way = [&](float s) {
        return std::pair((s - 12.5f) * right + (0.06f * s - 0.75f) * along, normal);
    };
    return largest_step(stage, way, footprint);
}

/// On a ball of radius 2 past bars that shade it.
Step walk_on_ball(const std::function<glm::vec3(float)>& normal_at, Footprint footprint) {
    const Stage stage({.position = {6, 2, 5}, .radius = 0.8f}, [](demo::MeshBuilder& builder) {
        builder.ball({0, 0, 0}, 2.0f, 160);
        builder.box({2.6f, -4.0f, 0.9f}, {2.9f, 4.0f, 1.2f});
        builder.box({-4.0f, 2.6f, 0.9f}, {4.0f, 2.9f, 1.2f});
        builder.box({2.0f, -4.0f, 1.6f}, {2.3f, 4.0f, 1.9f});
    });
    const auto way = [&](float s) {
        const glm::vec3 normal = normal_at(s);
        return std::pair(2.0f * normal, normal);
    };
    return largest_step(stage, way, footprint);
}

/// All around, through all axes.
glm::vec3 around(float s) {
    const float turn = 0.5f * s;
    const float height = 0.9f * std::sin(0.31f * turn);
    const float flat = std::sqrt(1.0f - height * height);
    return {flat * std::cos(turn), flat * std::sin(turn), height};
}

/// To and fro through the direction that leans to all three axes alike, from all sides.
glm::vec3 through_tie_of_three(float s) {
    const glm::vec3 middle = glm::normalize(glm::vec3(1.0f));
    const glm::vec3 right = glm::normalize(glm::vec3(1, -1, 0));
    const float side = 0.25f * std::sin(2.0f * s);
    const glm::vec3 way = std::cos(0.37f * s) * right + std::sin(0.37f * s) * glm::cross(middle, right);
    return std::cos(side) * middle + std::sin(side) * way;
}

struct Edge {
    double variation, reference_variation;  ///< total
    double step, reference_step;            ///< 99th percentile, of steps of g / 500
};

/// Across the soft edge of a wide block's shadow.
Edge soft_edge() {
    const Stage stage({.position = {0.3f, 0.2f, 5}, .radius = 0.5f}, [](demo::MeshBuilder& builder) {
        add_floor(builder);
        builder.box({0, -8, 1.5f}, {8, 8, 1.7f});
    });
    std::vector<double> steps, reference_steps;
    float before = -1.0f;
    float reference_before = -1.0f;
    Edge edge{};
    for (int i = 0; i <= 3000; ++i) {
        const float s = spacing / 500.0f * static_cast<float>(i) - 0.75f;
        const glm::vec3 point(0.9f * s, 0.44f * s, 0.0f);
        const float now = stage.cached(point, {0, 0, 1});
        const float reference = stage.reference(point, {0, 0, 1}, 4096);
        if (i > 0) {
            steps.push_back(static_cast<double>(std::abs(now - before)));
            reference_steps.push_back(static_cast<double>(std::abs(reference - reference_before)));
            edge.variation += steps.back();
            edge.reference_variation += reference_steps.back();
        }
        before = now;
        reference_before = reference;
    }
    const auto percentile = [](std::vector<double>& values) {
        std::ranges::sort(values);
        return values[values.size() * 99 / 100];
    };
    edge.step = percentile(steps);
    edge.reference_step = percentile(reference_steps);
    return edge;
}

/// Mean changes of S from one frame to the next.
struct FilmChange {
    /// Of what a frame sees, with the footprints of the next: rays change nothing there.
    double of_points = 0.0;
    double of_pixels = 0.0;
    double reference = 0.0;  ///< of pixels, by rays
};

/// Of 48 frames by a camera that comes nearer to what it looks at by a hundredth each time, with the
/// footprints of 960 pixels, one in forty of which are looked at.
FilmChange change_in_film(const std::string& name, float radius) {
    demo::Scene model = demo::load_scene(name);
    const demo::EmbreeScene scene(model);
    const std::vector<lightmesh::Light> lights = sphere_lamps(model, radius);
    const Cache cache(scene.intersector(), lights, {.spacing = model.radius / 4.0f});
    Occlusion tracer(scene.handle(), true);
    const float pixel_angle = demo::View(model.camera, 960, 720).pixel_angle();
    constexpr int width = 24;
    constexpr int height = 18;
    const auto eye_at = [&](int frame) {
        return model.camera.target +
               std::pow(0.99f, static_cast<float>(frame)) * (model.camera.eye - model.camera.target);
    };
    struct Pixel {
        std::vector<float> cached, reference;  ///< below 0: it does not face the lamp, or sees nothing
    };
    const Pixel nothing{std::vector<float>(lights.size(), -1.0f), std::vector<float>(lights.size(), -1.0f)};
    std::vector<Pixel> before(width * height, nothing);
    std::vector<float> next(lights.size());
    FilmChange change;
    double of_points = 0.0;
    double of_pixels = 0.0;
    for (int frame = 0; frame < 48; ++frame) {
        demo::Camera moved = model.camera;
        moved.eye = eye_at(frame);
        const demo::View view(moved, width, height);
        for (int i = 0; i < width * height; ++i) {
            const float column = static_cast<float>(i % width) + 0.5f;
            const float row = static_cast<float>(i / width) + 0.5f;
            const auto hit = scene.trace(view.origin(column, row), view.direction(column, row), 1e30f);
            Pixel now = nothing;
            if (hit) {
                const auto ask = [&](int at_frame, std::vector<float>& lit) {
                    cache.visibility(
                        {.position = hit->position,
                         .normal = hit->geometric_normal,
                         .footprint = pixel_angle * glm::distance(hit->position, eye_at(at_frame))},
                        lit);
                };
                ask(frame, now.cached);
                ask(frame + 1, next);
                for (std::size_t l = 0; l < lights.size(); ++l) {
                    const auto& lamp = std::get<lightmesh::PointLight>(lights[l]);
                    if (glm::dot(hit->geometric_normal, lamp.position - hit->position) < 0.0f)
                        continue;
                    change.of_points += static_cast<double>(std::abs(next[l] - now.cached[l]));
                    of_points += 1.0;
                    const auto share = [&](int rays) {
                        demo::Random random(5);
                        return open_share(tracer, surface_end(hit->position, hit->geometric_normal),
                                          lamp.position, radius, rays, random);
                    };
                    float& reference = now.reference[l] = share(64);
                    if (reference > 0.0f && reference < 1.0f)
                        reference = share(1024);
                    const Pixel& last = before[static_cast<std::size_t>(i)];
                    if (last.reference[l] < 0.0f)
                        continue;
                    change.of_pixels += static_cast<double>(std::abs(now.cached[l] - last.cached[l]));
                    change.reference += static_cast<double>(std::abs(reference - last.reference[l]));
                    of_pixels += 1.0;
                }
            }
            before[static_cast<std::size_t>(i)] = std::move(now);
        }
    }
    change.of_points /= of_points;
    change.of_pixels /= of_pixels;
    change.reference /= of_pixels;
    return change;
}

}  // namespace

void print_cache_walks() {
    const std::pair<const char*, Build> things[] = {
        {"fence", add_fence}, {"table legs", add_legs}, {"grass", add_grass}};
    for (const bool shaft_rows : {true, false})
        for (const auto& [name, build] : things)
            print_row(std::string(name) + (shaft_rows ? "" : ", no shaft rows") +
                          ": of points whose reference is below .2, below .4, %",
                      100.0 * kept_contacts(build, shaft_rows), 95.0, true, "");
    const glm::vec3 slope = glm::normalize(glm::vec3(0.0f, -1.0f, 2.3f));
    const glm::vec3 between_two = glm::normalize(glm::vec3(0.0f, -1.0f, 1.03f));
    const glm::vec3 between_three = glm::normalize(glm::vec3(0.97f, -1.0f, 1.02f));
    const std::pair<const char*, Footprint> footprints[] = {
        {"", no_footprint},
        {", twice through levels g / 8 to 2 g and back", through_levels_of_penumbrae},
        {", twice through levels g / 8 to 512 g and back", through_all_levels}};
    for (const auto& [levels, footprint] : footprints) {
        const auto add = [levels = levels](const std::string& where, const Step& step) {
            print_row(where + levels + ": largest step of S beyond the reference's, of 1e5 of g / 1000",
                      step.beyond, 0.01, false, "the whole step " + demo::fixed(step.raw, 4));
        };
        add("floor", walk_on_floor(footprint));
        add("floor, along the penumbra of a beam", walk_along_beam(footprint));
        add("slope of 1 in 2.3", walk_on_plane(slope, footprint));
        add("slope of 1 in 1.03, between two axes", walk_on_plane(between_two, footprint));
        add("slope between three axes", walk_on_plane(between_three, footprint));
        add("ball, through all axes", walk_on_ball(around, footprint));
        add("ball, to and fro where three axes meet", walk_on_ball(through_tie_of_three, footprint));
    }
    const Edge edge = soft_edge();
    print_row("soft edge: total variation over the reference's", edge.variation / edge.reference_variation,
              1.01, false, "");
    print_row("soft edge: 99th percentile of steps of g / 500", edge.step, 0.0015, false,
              "the reference's " + demo::fixed(edge.reference_step, 4));
    for (const auto& [scene, radius] : {std::pair("rooms", 0.3f), {"spheres", 6.0f}, {"park", 1.0f}}) {
        const FilmChange change = change_in_film(scene, radius);
        const std::string name = std::string(scene) + " R " + demo::fixed(static_cast<double>(radius), 2) +
                                 ", film of 48 frames: change of S from frame to frame of a ";
        print_row(name + "point, beyond the reference's", change.of_points, 0.001, false,
                  "the reference's 0");
        print_row(name + "pixel, beyond the reference's", change.of_pixels - change.reference, 0.001, false,
                  "the reference's " + demo::fixed(change.reference, 4));
    }
}

}  // namespace bench
