// SPDX-License-Identifier: MIT

// The visibility cache against lamps of 1,024 rays (of 64 where those agree), against hard shadows and
// against lamps of 16 rays in packets: errors, times and bytes of a frame of 1920x1440 points, on one thread.
// Then contact shadows of thin things, walks over surfaces, and a film.

#include "cache_walks.hpp"
#include "embree_rays.hpp"
#include "lamp_share.hpp"
#include "mesh_frame.hpp"
#include "render/embree_scene.hpp"
#include "render/text_table.hpp"
#include "render/view.hpp"
#include "scene/random.hpp"
#include "scene/scene.hpp"
#include "shading_points.hpp"
#include "surface_end.hpp"
#include "workloads.hpp"

#include <lightmesh/visibility_cache.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace bench {

namespace {

using Cache = lightmesh::VisibilityCache<demo::EmbreeIntersector>;

/// Figures to reach; those that are lacking are only reported.
struct Bars {
    std::optional<double> mean_error{}, misses{}, warm_ns{}, warm_over_hard{}, warm_over_lamps{},
        cold_over_hard{}, cold_over_lamps{}, megabytes{};
    std::optional<double> pair_ns{};  ///< warm, a point and light
    bool is_below_hard = false;       ///< whether errors are to be below those of hard shadows
};

struct Case {
    std::string scene;
    float lamp_radius;
    std::size_t lights = 0;  ///< 0: the scene's own, up to 64
    Bars to_reach{};
    bool shaft_rows = true;
};

/// All that is compared, for one scene.
class Contest {
public:
    Contest(const Case& which, const lightmesh::CacheSettings& settings)
        : which_(which), model_(demo::load_scene(which.scene)), settings_(settings) {
        if (which.lights > 0)
            demo::spread_lights(model_, which.lights);
        else if (model_.lights.size() > 64)
            model_.lights.resize(64);
        scene_ = std::make_unique<demo::EmbreeScene>(model_);
        points_ = std::make_unique<ShadingPoints>(*scene_, picture_width, picture_height);
        lights_ = sphere_lamps(model_, which.lamp_radius);
        for (const lightmesh::Light& lamp : lights_)
            at_.push_back(std::get<lightmesh::PointLight>(lamp).position);
        if (settings_.spacing == 0.0f)
            settings_.spacing = model_.radius / 4.0f;
        pixel_angle_ = demo::View(model_.camera, picture_width, picture_height).pixel_angle();
    }

    void run() {
        const std::size_t count = points_->size();
        Cache cache(scene_->intersector(), lights_, settings_);
        const double cold = processor_seconds([&] { query_all(cache, 1); });
        const lightmesh::CacheStatistics held = cache.statistics();
        const std::size_t part = 16;
        std::size_t queried = 0;
        double warm = 1e9;
        for (int i = 0; i < 3; ++i)
            warm = (std::min)(warm, processor_seconds([&] { queried = query_all(cache, part); }));
        const double warm_ns = 1e9 * warm / static_cast<double>(queried);
        std::size_t hard_points = 0;
        const double hard = processor_seconds([&] { hard_points = hard_rays(64); });
        const double hard_ns = 1e9 * hard / static_cast<double>(hard_points);
        std::size_t lamp_points = 0;
        const double lamp = processor_seconds([&] { lamp_points = lamp_packets(256); });
        const double lamp_ns = 1e9 * lamp / static_cast<double>(lamp_points);
        const Errors errors = compare(cache);
        const double cold_ns = 1e9 * cold / static_cast<double>(count);

        const std::string name = which_.scene + " R " +
                                 demo::fixed(static_cast<double>(which_.lamp_radius), 2) +
                                 (which_.shaft_rows ? "" : ", no shaft rows") + ", " +
                                 std::to_string(lights_.size()) + " lights: ";
        const auto add = [&](const std::string& what, double got, std::optional<double> to_reach,
                             bool at_least, const std::string& beside) {
            print_row(name + what, got, to_reach, at_least, beside);
        };
        const Bars& reach = which_.to_reach;
        const std::string against = reach.is_below_hard ? ", against hard shadows' own" : "";
        add("mean absolute error of S" + against, errors.mean,
            reach.is_below_hard ? errors.hard_mean : reach.mean_error, false,
            "the reference to another of its kind " + demo::fixed(errors.noise, 5) + ", hard shadows " +
                demo::fixed(errors.hard_mean, 5) + ", 16-ray lamps " + demo::fixed(errors.lamp_mean, 5));
        add("misses, % of facing pairs" + against, 100.0 * errors.misses,
            reach.is_below_hard ? 100.0 * errors.hard_misses : reach.misses, false,
            "hard shadows " + demo::fixed(100.0 * errors.hard_misses, 3));
        const std::string rays_ns = "hard single rays " + demo::fixed(hard_ns, 0) +
                                    " ns a point, 16-ray lamps in packets " + demo::fixed(lamp_ns, 0);
        add("warm, ns a point", warm_ns, reach.warm_ns, false, rays_ns);
        if (reach.pair_ns)
            add("warm, ns a point and light", warm_ns / static_cast<double>(lights_.size()), reach.pair_ns,
                false, "");
        add("warm, times faster than hard single rays", hard_ns / warm_ns, reach.warm_over_hard, true, "");
        add("warm, times faster than 16-ray lamps in packets", lamp_ns / warm_ns, reach.warm_over_lamps, true,
            "");
        add("error over that of 16-ray lamps", errors.mean / errors.lamp_mean,
            reach.warm_over_lamps ? std::optional(1.0) : std::nullopt, false, "");
        const std::string cold_s = "the frame " + demo::fixed(cold, 2) + " s";
        add("cold frame, times faster than hard single rays", hard_ns / cold_ns, reach.cold_over_hard, true,
            cold_s);
        add("cold frame, times faster than 16-ray lamps in packets", lamp_ns / cold_ns, reach.cold_over_lamps,
            true, cold_s);
        std::string levels;
        for (const std::size_t records : held.records_of_level)
            if (records > 0)
                levels += (levels.empty() ? "" : " ") + std::to_string(records / 1000);
        const auto millions = [](std::uint64_t rays) {
            return demo::fixed(1e-6 * static_cast<double>(rays), 2);
        };
        add("MB of a frame", 1e-6 * static_cast<double>(held.bytes), reach.megabytes, false,
            std::to_string(held.records / 1000) + " thousand records, of levels " + levels + "; " +
                millions(held.lamp_rays) + " million rays to lamps, " +
                millions(held.drop_rays + held.link_rays) + " million for surfaces and links");
    }

private:
    struct Errors {
        double mean = 0.0, noise = 0.0, hard_mean = 0.0, lamp_mean = 0.0, misses = 0.0, hard_misses = 0.0;
    };

    lightmesh::SurfacePoint point_at(const Points& points, std::size_t i) const {
        return {.position = points.positions[i],
                .normal = points.normals[i],
                .footprint = pixel_angle_ * glm::distance(points.positions[i], model_.camera.eye)};
    }
    bool faces(const glm::vec3& point, const glm::vec3& normal, std::size_t light) const {
        return glm::dot(normal, at_[light] - point) >= 0.0f;
    }
    /// Every `step`-th block of eight tiles.
    template <class Call>
    std::size_t for_tiles(std::size_t step, const Call& call) const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < points_->tile_count(); ++i)
            if (i / 8 % step == 0) {
                call(points_->tile(i));
                count += points_->tile(i).size();
            }
        return count;
    }

    std::size_t query_all(const Cache& cache, std::size_t step) const {
        std::vector<lightmesh::SurfacePoint> tile;
        std::vector<float> lit;
        return for_tiles(step, [&](const Points& points) {
            tile.clear();
            for (std::size_t i = 0; i < points.size(); ++i)
                tile.push_back(point_at(points, i));
            lit.resize(tile.size() * lights_.size());
            cache.visibility(tile, lit);
        });
    }

    std::size_t hard_rays(std::size_t step) const {
        Occlusion tracer(scene_->handle(), false);
        return for_tiles(step, [&](const Points& points) {
            for (std::size_t i = 0; i < points.size(); ++i) {
                const glm::vec3 from = surface_end(points.positions[i], points.normals[i]);
                for (std::size_t l = 0; l < at_.size(); ++l)
                    if (faces(points.positions[i], points.normals[i], l)) {
                        RTCRay ray = make_ray(from, at_[l]);
                        tracer.trace(ray);
                    }
            }
        });
    }

    std::size_t lamp_packets(std::size_t step) const {
        Occlusion tracer(scene_->handle(), true);
        demo::Random random(1);
        return for_tiles(step, [&](const Points& points) {
            for (std::size_t i = 0; i < points.size(); ++i) {
                const glm::vec3 from = surface_end(points.positions[i], points.normals[i]);
                for (std::size_t l = 0; l < at_.size(); ++l)
                    if (faces(points.positions[i], points.normals[i], l))
                        open_share(tracer, from, at_[l], which_.lamp_radius, 16, random);
            }
        });
    }

    Errors compare(const Cache& cache) const {
        constexpr std::size_t sampled = 2000;
        Occlusion tracer(scene_->handle(), true);
        Errors sum;
        double pairs = 0.0;
        std::vector<float> lit(lights_.size());
        std::size_t next = 0;
        std::size_t seen = 0;
        for (std::size_t t = 0; t < points_->tile_count(); ++t) {
            const Points points = points_->tile(t);
            for (; next < seen + points.size(); next += points_->size() / sampled) {
                const lightmesh::SurfacePoint point = point_at(points, next - seen);
                cache.visibility(point, lit);
                const glm::vec3 from = surface_end(point.position, point.normal);
                for (std::size_t l = 0; l < at_.size(); ++l) {
                    if (!faces(point.position, point.normal, l))
                        continue;
                    demo::Random random(next * 1024 + l);
                    const auto share = [&](int count) {
                        return static_cast<double>(
                            open_share(tracer, from, at_[l], which_.lamp_radius, count, random));
                    };
                    double reference = share(64);
                    double other = reference;
                    if (reference > 0.0 && reference < 1.0) {
                        reference = share(1024);
                        other = share(1024);
                    }
                    RTCRay ray =
                        make_ray(from, from + (std::max)(0.3f, 1.0f - 1.15f * which_.lamp_radius /
                                                                          glm::distance(from, at_[l])) *
                                                  (at_[l] - from));
                    tracer.trace(ray);
                    const double hard = ray.tfar < 0.0f ? 0.0 : 1.0;
                    const double error = std::abs(static_cast<double>(lit[l]) - reference);
                    pairs += 1.0;
                    sum.mean += error;
                    sum.misses += error > 0.3 ? 1.0 : 0.0;
                    sum.noise += std::abs(other - reference);
                    sum.hard_mean += std::abs(hard - reference);
                    sum.hard_misses += std::abs(hard - reference) > 0.3 ? 1.0 : 0.0;
                    sum.lamp_mean += std::abs(share(16) - reference);
                }
            }
            seen += points.size();
        }
        for (double* value :
             {&sum.mean, &sum.noise, &sum.hard_mean, &sum.lamp_mean, &sum.misses, &sum.hard_misses})
            *value /= pairs;
        return sum;
    }

    Case which_;
    demo::Scene model_;
    lightmesh::CacheSettings settings_;
    std::unique_ptr<demo::EmbreeScene> scene_;
    std::unique_ptr<ShadingPoints> points_;
    std::vector<lightmesh::Light> lights_;
    std::vector<glm::vec3> at_;
    float pixel_angle_ = 0.0f;
};

int run(std::span<char*> arguments) {
    const std::vector<Case> cases{
        {"rooms", 0.3f, 0, {0.0012, 0.04, 200, 10, 28, 5, 15, 10}},
        {"spheres", 6.0f, 0, {0.0018, 0.02, 150, 3, 14, 1.5, 8, 8}},
        {"rooms", 0.1f, 0, {.is_below_hard = true}},
        {"spheres", 0.45f, 0, {.is_below_hard = true}},
        {"park", 1.0f, 0, {0.045, 3, 600, 18, 90, 0.5, 4, 100}},
        {"park", 1.0f, 256, {.pair_ns = 7}},
        {.scene = "rooms", .lamp_radius = 0.3f, .shaft_rows = false},
        {.scene = "spheres", .lamp_radius = 6.0f, .shaft_rows = false},
    };
    for (const std::string argument : arguments) {
        const bool is_case = argument.size() == 1 && argument[0] >= '0' &&
                             static_cast<std::size_t>(argument[0] - '0') < cases.size();
        if (!is_case && argument != "walks") {
            std::cerr << "there is no case '" << argument << "'; there are 0 to " << cases.size() - 1
                      << ", and walks\n";
            return 1;
        }
    }
    print_head();
    for (std::size_t i = 0; i < cases.size(); ++i) {
        // Named by their numbers, or all.
        const auto is_named = [&](const char* argument) {
            return argument == std::to_string(i);
        };
        if (!arguments.empty() && std::ranges::none_of(arguments, is_named))
            continue;
        Contest(cases[i], lightmesh::CacheSettings{.spacing = 0.0f, .shaft_rows = cases[i].shaft_rows}).run();
    }
    if (arguments.empty() || std::ranges::any_of(arguments, [](const char* argument) {
            return std::string_view(argument) == "walks";
        }))
        print_cache_walks();
    return 0;
}

}  // namespace

}  // namespace bench

int main(int count, char** arguments) {
    return bench::run(std::span(arguments, static_cast<std::size_t>(count)).subspan(1));
}
