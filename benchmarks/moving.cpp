// SPDX-License-Identifier: MIT

// The rows of "Scenes that move": what a frame of a film of the park costs in visibility, after something has
// moved, over the next one, in which nothing has, beside the first one, which fills the cache or the mesh;
// and a flight through it, over hard shadows. One thread; all times are processor time.
//
//     lightmesh-moving-benchmark [WORD...]    only rows whose names begin with one of these

#include "embree_rays.hpp"
#include "lamp_share.hpp"
#include "mesh_frame.hpp"
#include "render/embree_scene.hpp"
#include "render/follow_scene.hpp"
#include "render/text_table.hpp"
#include "render/view.hpp"
#include "scene/film.hpp"
#include "scene/moving_parts.hpp"
#include "scene/random.hpp"
#include "surface_end.hpp"

#include <lightmesh/lightmesh.hpp>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <iostream>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace {

using bench::processor_seconds;
using lightmesh::SurfacePoint;

using Cache = lightmesh::VisibilityCache<demo::EmbreeIntersector>;

constexpr float park_lamp_radius = 1.0f;
constexpr double frame_length = 1.0 / 24.0;

/// What a renderer asks for in a frame: tile by tile of 16x16 pixels, or every so many of these.
class Picture {
public:
    Picture(const demo::EmbreeScene& scene, int width, int height, std::size_t every) {
        const demo::Camera& camera = scene.scene().camera;
        const bench::ShadingPoints points(scene, width, height);
        const float pixel_angle = demo::View(camera, width, height).pixel_angle();
        for (std::size_t t = 0; t < points.tile_count(); t += every) {
            const bench::Points tile = points.tile(t);
            tiles_.emplace_back();
            for (std::size_t i = 0; i < tile.size(); ++i)
                tiles_.back().push_back(
                    {.position = tile.positions[i],
                     .normal = tile.normals[i],
                     .footprint = pixel_angle * glm::distance(tile.positions[i], camera.eye)});
            size_ += tile.size();
        }
    }

    std::span<const std::vector<SurfacePoint>> tiles() const { return tiles_; }
    double size() const { return static_cast<double>(size_); }

private:
    std::vector<std::vector<SurfacePoint>> tiles_;
    std::size_t size_ = 0;
};

/// The part of another animation that lies in a box at 0 s: all other vertices stay.
class PartInBox : public demo::Animation {
public:
    PartInBox(const demo::AnimatedScene& whole, const lightmesh::Bounds& box)
        : whole_(whole.animation), positions_(whole.scene.positions), normals_(whole.scene.normals),
          moves_(positions_.size()) {
        for (const std::uint32_t vertex : demo::vertices_within(whole.scene, box.low, box.high))
            moves_[vertex] = true;
    }

    double length() const override { return whole_->length(); }
    void pose(demo::Scene& scene, double seconds, const demo::Moving& moving) const override {
        whole_->pose(scene, seconds, moving);
        for (std::size_t i = 0; i < positions_.size(); ++i)
            if (!moves_[i]) {
                scene.positions[i] = positions_[i];
                scene.normals[i] = normals_[i];
            }
    }

private:
    std::shared_ptr<const demo::Animation> whole_;
    std::vector<glm::vec3> positions_, normals_;
    std::vector<bool> moves_;
};

/// The park's film in which of all objects only the swing moves.
demo::AnimatedScene swing_alone() {
    demo::AnimatedScene park = demo::load_animated("park");
    park.animation =
        std::make_shared<PartInBox>(park, lightmesh::Bounds{{-2.0f, -41.0f, -10.0f}, {8.0f, -31.0f, 30.0f}});
    return park;
}

/// A film's scene, all lights of which are spheres.
class Stage {
public:
    Stage(demo::AnimatedScene animated, float lamp_radius, const demo::Moving& moving)
        : lamp_radius_(lamp_radius), film_(std::move(animated), moving),
          scene_(film_.scene(), demo::EmbreeScene::For::films) {}

    const demo::EmbreeScene& scene() const { return scene_; }
    std::vector<lightmesh::Light> lamps() const { return bench::sphere_lamps(film_.scene(), lamp_radius_); }

    /// Goes to a frame, with the BVH.
    demo::SceneChange go_to(int frame) {
        demo::SceneChange change = film_.go_to(frame * frame_length);
        if (change.changes_triangles())
            scene_.update(change);
        return change;
    }

    lightmesh::LightMesh<demo::EmbreeIntersector> linked() const {
        return {scene_.intersector(), lamps(), lightmesh::Settings{.radius = film_.scene().radius}};
    }
    Cache cache(int lamp_rays = lightmesh::CacheSettings{}.lamp_rays) const {
        return {scene_.intersector(), lamps(),
                lightmesh::CacheSettings{.spacing = 0.25f * film_.scene().radius, .lamp_rays = lamp_rays}};
    }

private:
    float lamp_radius_;
    demo::Film film_;
    demo::EmbreeScene scene_;
};

template <class Subject>
void ask(const Subject& subject, const Picture& picture) {
    std::vector<float> values;
    for (const std::vector<SurfacePoint>& tile : picture.tiles()) {
        values.resize(tile.size() * subject.light_count());
        subject.visibility(tile, values);
    }
}

/// In how many of some points anything differs from what another one says.
template <class Subject>
std::size_t differing_points(const Subject& subject, const Subject& other, const Picture& picture) {
    std::size_t differing = 0;
    std::vector<float> values(subject.light_count());
    std::vector<float> expected(values.size());
    for (std::size_t t = 0; t < picture.tiles().size(); t += 16)
        for (std::size_t i = 0; i < picture.tiles()[t].size(); i += 32) {
            subject.visibility(picture.tiles()[t][i], values);
            other.visibility(picture.tiles()[t][i], expected);
            differing += values != expected ? 1u : 0u;
        }
    return differing;
}

/// For the name of a row.
std::string of_tiles(std::size_t every) {
    return every > 1 ? ", one tile in " + std::to_string(every) : "";
}

/// The least times of some frames in which something moves, over those of the next ones, in which nothing
/// does.
template <class Make>
void time_moves(const std::string& what, demo::AnimatedScene animated, const demo::Moving& moving,
                const Make& make, std::size_t every, double to_reach) {
    Stage park(std::move(animated), park_lamp_radius, moving);
    auto subject = make(park);
    const Picture still(park.scene(), 960, 720, every);
    const double cold = processor_seconds([&] { ask(subject, still); });
    double frame = 1e9;
    double update = 0.0;
    double warm = 1e9;
    constexpr int frames = 6;
    for (int number = 1; number <= frames; ++number) {
        const demo::SceneChange change = park.go_to(number);
        const Picture picture(park.scene(), 960, 720, every);
        const std::vector<lightmesh::Light> lamps = park.lamps();
        const double telling = processor_seconds([&] { demo::follow_scene(subject, lamps, change); });
        const double all = telling + processor_seconds([&] { ask(subject, picture); });
        if (all < frame) {
            frame = all;
            update = telling;
        }
        warm = (std::min)(warm, processor_seconds([&] { ask(subject, picture); }));
    }
    const auto fresh = make(park);
    const std::size_t differing = differing_points(subject, fresh, Picture(park.scene(), 960, 720, every));
    bench::print_row(what + of_tiles(every) + ": frame over the warm frame", frame / warm, to_reach, false,
                     "first frame " + demo::fixed(cold, 2) + " s, this one " + demo::fixed(frame, 3) +
                         " s, warm " + demo::fixed(warm, 3) + " s, " + std::to_string(subject.light_count()) +
                         " lamps; the update itself " + demo::fixed(update / warm, 4) + " of a warm frame; " +
                         std::to_string(differing) + " sampled points differ from a new one's");
}

/// Strengths are the renderer's: the same lights are set again.
template <class Make>
void time_strengths(const std::string& what, const Make& make, std::size_t every) {
    Stage park(demo::load_animated("park"), park_lamp_radius,
               {.objects = false, .lights = false, .camera = false});
    auto subject = make(park);
    const Picture picture(park.scene(), 960, 720, every);
    const std::vector<lightmesh::Light> lamps = park.lamps();
    const double cold = processor_seconds([&] { ask(subject, picture); });
    const auto rays = [&subject] {
        return subject.statistics().kept_rays();
    };
    double frame = 1e9;
    double warm = 1e9;
    ask(subject, picture);
    const std::uint64_t rays_before = rays();
    ask(subject, picture);
    const std::uint64_t rays_of_frame = rays() - rays_before;
    std::uint64_t rays_again = 0;
    for (int i = 0; i < 6; ++i) {
        warm = (std::min)(warm, processor_seconds([&] { ask(subject, picture); }));
        const std::uint64_t before = rays();
        frame = (std::min)(frame, processor_seconds([&] {
                               for (std::size_t l = 0; l < lamps.size(); ++l)
                                   subject.set_light(l, lamps[l]);
                               ask(subject, picture);
                           }));
        rays_again += rays() - before - rays_of_frame;
    }
    const auto fresh = make(park);
    bench::print_row(what + of_tiles(every) + ": frame over the warm frame", frame / warm, 1.0, false,
                     "1 but for the noise of the clock; first frame " + demo::fixed(cold, 2) + " s; " +
                         std::to_string(rays_again) + " rays more than in a warm frame; " +
                         std::to_string(differing_points(subject, fresh, picture)) +
                         " sampled points differ from a new one's");
}

/// ns a point of one shadow ray to each facing light, and of 16 in a packet to each facing lamp.
struct RayTimes {
    double hard;
    double lamps;
};
RayTimes time_rays(const Stage& park, const Picture& picture) {
    bench::Occlusion tracer(park.scene().handle(), true);
    bench::Occlusion single(park.scene().handle(), false);
    demo::Random random(1);
    std::vector<glm::vec3> at;
    for (const lightmesh::Light& lamp : park.lamps())
        at.push_back(std::get<lightmesh::PointLight>(lamp).position);
    double points = 0.0;
    const auto for_facing = [&](std::size_t every, const auto& trace) {
        points = 0.0;
        for (std::size_t t = 0; t < picture.tiles().size(); t += every)
            for (const SurfacePoint& point : picture.tiles()[t]) {
                const glm::vec3 from = bench::surface_end(point.position, point.normal);
                for (const glm::vec3& lamp : at)
                    if (glm::dot(point.normal, lamp - point.position) >= 0.0f)
                        trace(from, lamp);
                points += 1.0;
            }
    };
    const double hard = processor_seconds([&] {
        for_facing(8, [&](const glm::vec3& from, const glm::vec3& lamp) {
            RTCRay ray = bench::make_ray(from, lamp);
            single.trace(ray);
        });
    });
    const double hard_ns = 1e9 * hard / points;
    const double area = processor_seconds([&] {
        for_facing(64, [&](const glm::vec3& from, const glm::vec3& lamp) {
            bench::open_share(tracer, from, lamp, park_lamp_radius, 16, random);
        });
    });
    return {hard_ns, 1e9 * area / points};
}

/// Mean absolute errors of S to lamps of 1,024 rays, at some points of a picture and all lamps that they
/// face.
template <class Subject>
std::string errors_of(const Subject& subject, const Stage& park, const Picture& picture) {
    bench::Occlusion tracer(park.scene().handle(), true);
    demo::Random random(2);
    const std::vector<lightmesh::Light> lamps = park.lamps();
    std::vector<float> values(lamps.size());
    double own = 0.0;
    double hard = 0.0;
    double few = 0.0;
    double pairs = 0.0;
    const std::size_t step = picture.tiles().size() / 80 + 1;
    for (std::size_t t = 0; t < picture.tiles().size(); t += step) {
        const SurfacePoint& point = picture.tiles()[t][t * 37 % picture.tiles()[t].size()];
        const glm::vec3 from = bench::surface_end(point.position, point.normal);
        subject.visibility(point, values);
        for (std::size_t l = 0; l < lamps.size(); ++l) {
            const glm::vec3 lamp = std::get<lightmesh::PointLight>(lamps[l]).position;
            if (glm::dot(point.normal, lamp - point.position) < 0.0f)
                continue;
            const auto error = [reference = bench::open_share(tracer, from, lamp, park_lamp_radius, 1024,
                                                              random)](float share) {
                return static_cast<double>(std::abs(share - reference));
            };
            own += error(values[l]);
            hard += error(bench::open_share(tracer, from, lamp, 0.0f, 16, random));
            few += error(bench::open_share(tracer, from, lamp, park_lamp_radius, 16, random));
            pairs += 1.0;
        }
    }
    return "mean errors of S " + demo::fixed(own / pairs, 4) + ", hard " + demo::fixed(hard / pairs, 4) +
           ", 16 rays " + demo::fixed(few / pairs, 4);
}

/// A flight through a park in which nothing else moves.
template <class Make>
void time_flight(const std::string& name, const Make& make, int frames, int width, int height,
                 std::size_t every, double lamps_to_reach) {
    Stage park(demo::load_animated("park"), park_lamp_radius,
               {.objects = false, .lights = false, .camera = true});
    const auto subject = make(park);
    double first = 0.0;
    double later = 0.0;
    double hard = 0.0;
    double lamps = 0.0;
    std::string errors;
    for (int number = 0; number < frames; ++number) {
        park.go_to(number);
        const Picture picture(park.scene(), width, height, every);
        const double time = processor_seconds([&] { ask(subject, picture); });
        (number == 0 ? first : later) += time;
        if (number == frames - 1)
            errors = errors_of(subject, park, picture);
        if (number % 12 != 1)
            continue;
        const RayTimes rays = time_rays(park, picture);
        hard = 1e-9 * rays.hard * picture.size();
        lamps = 1e-9 * rays.lamps * picture.size();
    }
    const double frame = later / (frames - 1);
    const std::string beside = "first frame " + demo::fixed(first, 1) + " s, later ones " +
                               demo::fixed(frame, 2) + " s, hard shadows " + demo::fixed(hard, 2) +
                               " s, 16-ray lamps " + demo::fixed(lamps, 1) + " s; " + errors;
    const std::string what = name + ", " + std::to_string(frames) + " frames of " + std::to_string(width) +
                             "x" + std::to_string(height) + of_tiles(every);
    bench::print_row(what + ": a frame after the first over one of hard shadows", frame / hard, 0.25, false,
                     beside);
    bench::print_row(what + ": by 16-ray lamps over all of it", lamps * frames / (first + later),
                     lamps_to_reach, true, beside);
}

/// The share of a sphere lamp that is open, by rays to places that lie on a spiral (Vogel 1979): always the
/// same ones, so that from frame to frame it changes as what is in the lamp's way does.
double open_share(bench::Occlusion& tracer, const SurfacePoint& point, const glm::vec3& lamp, float radius,
                  int rays) {
    constexpr float golden_turn = 0.38196601f;
    return bench::open_share(tracer, bench::surface_end(point.position, point.normal), lamp, radius, rays,
                             [radius, rays](int i) {
                                 const auto number = static_cast<float>(i);
                                 return demo::circle_point(golden_turn * number) *
                                        (radius * std::sqrt((number + 0.5f) / static_cast<float>(rays)));
                             });
}

/// How penumbrae flicker that move, with their lamps or with what throws them, beyond what rays from each
/// point do; and whether lamps flicker that stay. The camera stays. The first of seven frames is the one of a
/// time.
void measure_flicker(const std::string& name, const std::string& scene, float lamp_radius, bool of_objects,
                     double start) {
    constexpr int reference_rays = 1024;
    Stage stage(demo::load_animated(scene), lamp_radius,
                {.objects = of_objects, .lights = !of_objects, .camera = false});
    const int first = static_cast<int>(std::lround(start / frame_length));
    stage.go_to(first);
    Cache cache = stage.cache(256);
    bench::Occlusion tracer(stage.scene().handle(), true);
    const Picture picture(stage.scene(), 960, 720, 1);
    const std::size_t lights = cache.light_count();
    // Of what is behind objects all lamps are asked.
    const std::size_t every = of_objects ? lights / 12 + 1 : 3;
    std::vector<SurfacePoint> points;
    for (std::size_t t = 0; t < picture.tiles().size(); t += every)
        points.push_back(picture.tiles()[t][t * 37 % picture.tiles()[t].size()]);
    std::vector<lightmesh::Light> lamps = stage.lamps();
    std::vector<float> values(points.size() * lights);
    cache.visibility(points, values);
    const auto at = [](const lightmesh::Light& lamp) {
        return std::get<lightmesh::PointLight>(lamp).position;
    };
    // What an object has covered, or has left in the air, is in no picture any more.
    const glm::vec3 eye = stage.scene().scene().camera.eye;
    const auto is_seen = [&](const SurfacePoint& point) {
        const glm::vec3 way = point.position - eye;
        const float distance = glm::length(way);
        const auto hit = stage.scene().trace(eye, way / distance, 2.0f * distance);
        return hit && glm::distance(hit->position, point.position) < 1e-5f * distance;
    };
    struct Shares {
        std::vector<double> reference, few;  ///< few: by as many rays as the cache takes
    };
    const auto shares_of = [&](std::size_t l) {
        Shares shares;
        for (const SurfacePoint& point : points) {
            const bool faces = glm::dot(point.normal, at(lamps[l]) - point.position) >= 0.0f;
            const auto share = [&](int rays) {
                return faces ? open_share(tracer, point, at(lamps[l]), lamp_radius, rays) : 0.0;
            };
            shares.reference.push_back(share(reference_rays));
            shares.few.push_back(share(256));
        }
        return shares;
    };
    std::vector<Shares> all(lights);
    for (std::size_t l = 0; l < lights && of_objects; ++l)
        all[l] = shares_of(l);
    double beyond = 0.0;
    double beyond_of_few = 0.0;
    double reference_change = 0.0;
    double pairs = 0.0;
    std::size_t flickering = 0;
    std::vector<char> stays(points.size());
    for (int frame = first + 1; frame <= first + 6; ++frame) {
        std::ranges::transform(points, stays.begin(), is_seen);
        const demo::SceneChange change = stage.go_to(frame);
        for (std::size_t i = 0; i < points.size(); ++i)
            stays[i] = stays[i] != 0 && is_seen(points[i]) ? 1 : 0;
        const std::vector<lightmesh::Light> next = stage.lamps();
        std::vector<float> now(values.size());
        demo::follow_scene(cache, next, change);
        cache.visibility(points, now);
        for (std::size_t l = 0; l < lights; ++l) {
            if (!of_objects && at(next[l]) == at(lamps[l])) {
                for (std::size_t i = l; i < now.size(); i += lights)
                    flickering += now[i] != values[i] ? 1u : 0u;
                continue;
            }
            if (all[l].reference.empty())
                all[l] = shares_of(l);
            lamps[l] = next[l];
            const Shares before = std::exchange(all[l], shares_of(l));
            for (std::size_t i = 0; i < points.size(); ++i) {
                const double was = before.reference[i];
                const double step = all[l].reference[i] - was;
                if (stays[i] == 0 || was < 0.02 || was > 0.98 || (of_objects && step == 0.0))
                    continue;
                const double cached =
                    static_cast<double>(now[i * lights + l]) - static_cast<double>(values[i * lights + l]);
                beyond += std::abs(cached - step);
                beyond_of_few += std::abs(all[l].few[i] - before.few[i] - step);
                reference_change += std::abs(step);
                pairs += 1.0;
            }
        }
        values = std::move(now);
    }
    bench::print_row(
        name + ", 256 rays: change from frame to frame along moving penumbrae, beyond the reference's",
        beyond / pairs, 0.004, false,
        "by 256 rays from each point " + demo::fixed(beyond_of_few / pairs, 4) + "; the reference's own " +
            demo::fixed(reference_change / pairs, 4) + ", of " + demo::fixed(pairs, 0) + " points and lamps");
    if (!of_objects)
        bench::print_row(name + ": values of lamps that stay, which change", static_cast<double>(flickering),
                         0.0, false, "of " + std::to_string(6 * points.size() * lights));
}

/// Rows, and what they begin with.
struct Rows {
    std::string name;
    std::function<void(const std::string& name)> print;
};

std::vector<Rows> all_rows() {
    const auto linked = [](const Stage& stage) {
        return stage.linked();
    };
    const auto cache = [](const Stage& stage) {
        return stage.cache();
    };
    constexpr demo::Moving of_lights{.objects = false, .lights = true, .camera = false};
    constexpr demo::Moving of_objects{.objects = true, .lights = false, .camera = false};
    std::vector<Rows> rows;
    const auto add_flicker = [&](const std::string& scene, float lamp_radius, bool objects, double start) {
        rows.push_back(
            {"flicker, " + scene + (objects ? ", objects" : ", lamps"), [=](const std::string& name) {
                 measure_flicker(name, scene, lamp_radius, objects, start);
             }});
    };
    add_flicker("rooms", 0.3f, false, 0.0);
    add_flicker("park", park_lamp_radius, false, 0.0);
    add_flicker("rooms", 0.3f, true, 2.0);
    add_flicker("spheres", 6.0f, true, 0.0);
    add_flicker("park", park_lamp_radius, true, 0.0);
    const auto add_park = [&](const std::string& kind, const auto& make, double light_to_reach,
                              std::size_t every, std::size_t of_flight) {
        const std::string start = kind + ", park, ";
        rows.push_back({start + "one of the lights moves a little each frame", [=](const std::string& name) {
                            time_moves(name, demo::load_animated("park"), of_lights, make, every,
                                       light_to_reach);
                        }});
        rows.push_back({start + "the swing moves", [=](const std::string& name) {
                            time_moves(name, swing_alone(), of_objects, make, every, 1.5);
                        }});
        rows.push_back({start + "the swing and a walker move", [=](const std::string& name) {
                            time_moves(name, demo::load_animated("park"), of_objects, make, every, 1.5);
                        }});
        rows.push_back({start + "all lights' strengths change", [=](const std::string& name) {
                            time_strengths(name, make, every);
                        }});
        rows.push_back({start + "flight", [=](const std::string& name) {
                            time_flight(name, make, 48, 960, 720, of_flight, 40.0);
                        }});
    };
    add_park("Linked", linked, 1.15, 1, 1);
    add_park("cache", cache, 2.0, 16, 32);
    return rows;
}

}  // namespace

int main(int count, char** words) {
    const std::vector<Rows> rows = all_rows();
    const std::vector<std::string_view> wanted(words + 1, words + count);
    for (const std::string_view word : wanted)
        if (std::ranges::none_of(rows, [&](const Rows& each) { return each.name.starts_with(word); })) {
            std::cerr << "no row begins with '" << word << "'; there are:\n";
            for (const Rows& each : rows)
                std::cerr << "    " << each.name << '\n';
            return 1;
        }
    bench::print_head();
    for (const Rows& each : rows)
        if (wanted.empty() ||
            std::ranges::any_of(wanted, [&](std::string_view word) { return each.name.starts_with(word); }))
            each.print(each.name);
}
