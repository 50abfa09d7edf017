// SPDX-License-Identifier: MIT
#include "analytic.hpp"
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"
#include "snapshot_bytes.hpp"
#include "still_world.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace moving_scenes_test {

namespace {

using lightmesh::Bounds;
using lightmesh::CacheSettings;
using lightmesh::VisibilityCache;
using test::ask;
using test::error_of;
using test::HitTracer;
using test::Random;
using test::StillWorld;
using test::Vec;

/// A floor and boxes that move about over it, and lights that come, move and go.
class MovingWorld {
public:
    MovingWorld(std::uint64_t seed, int light_count) : random_(seed) {
        for (int i = 0; i < 4; ++i)
            boxes_.push_back(new_box());
        build();
        for (int i = 0; i < light_count; ++i)
            lights_.push_back(new_light());
    }

    const std::vector<test::Triangle>& scene() const { return scene_; }
    test::BoxScene boxes() const {
        test::BoxScene scene;
        scene.boxes.push_back({{-5.0f, -5.0f, -3.0f}, {5.0f, 5.0f, -3.0f}});
        for (const Bounds& box : boxes_)
            scene.boxes.push_back(box);
        return scene;
    }
    std::span<const lightmesh::Light> lights() const { return lights_; }
    Random& random() { return random_; }

    /// Changes one thing, or several, and tells `subject`.
    template <class Subject>
    void move(Subject& subject) {
        switch (random_.below(8)) {
        case 0:
        case 1: {
            const std::size_t i = random_.below(lights_.size());
            lights_[i] = new_light();
            subject.set_light(i, lights_[i]);
            is_free_[i] = false;
            break;
        }
        case 2: {
            const auto free = std::ranges::find(is_free_, true);
            const std::size_t expected =
                free == is_free_.end() ? lights_.size() : static_cast<std::size_t>(free - is_free_.begin());
            if (expected == is_free_.size())
                break;
            const lightmesh::Light light = new_light();
            CHECK(subject.add_light(light) == expected);
            if (expected == lights_.size())
                lights_.emplace_back();
            lights_[expected] = light;
            is_free_[expected] = false;
            break;
        }
        case 3: {
            const std::size_t i = random_.below(lights_.size());
            if (is_free_[i])
                break;
            lights_[i] = lightmesh::PointLight{.range = 0.0f};
            is_free_[i] = true;
            subject.remove_light(i);
            break;
        }
        default: {
            std::vector<Bounds> changed;
            const std::size_t count = 1 + random_.below(2);
            for (std::size_t k = 0; k < count; ++k) {
                Bounds& box = boxes_[random_.below(boxes_.size())];
                changed.push_back(box);
                if (random_.below(2) == 0) {
                    box = new_box();
                } else {
                    const auto by = glm::vec3(random_.in_box({-0.4, -0.4, 0.0}, {0.4, 0.4, 0.2}));
                    box = {box.low + by, box.high + by};
                }
                changed.push_back(box);
            }
            build();
            subject.scene_changed(changed);
            changed_.insert(changed_.end(), changed.begin(), changed.end());
        }
        }
    }

    /// All boxes that have changed so far.
    std::vector<Bounds>& changed() { return changed_; }

    lightmesh::SurfacePoint point() {
        const auto [position, normal] = test::surface_points(random_, scene_, 1)[0];
        // By which level 0 of a mesh, or others up to 3, and all or few of a cache's serve it.
        const float footprint = random_.below(2) == 0 ? 0.0f : static_cast<float>(random_.uniform(0.02, 2.0));
        return {.position = position, .normal = normal, .footprint = footprint};
    }

private:
    Bounds new_box() {
        const glm::vec3 low(random_.in_box({-4.0, -4.0, -3.0}, {3.0, 3.0, -2.0}));
        return {low, low + glm::vec3(random_.in_box({0.3, 0.3, 0.5}, {1.5, 1.5, 4.0}))};
    }
    lightmesh::Light new_light() {
        std::vector<lightmesh::Light> lights = test::random_lights(random_, 3);
        lightmesh::Light& light = lights[random_.below(3)];
        if (auto* lamp = std::get_if<lightmesh::PointLight>(&light))
            lamp->radius = static_cast<float>(random_.below(2)) * 0.4f;
        if (auto* sun = std::get_if<lightmesh::DirectionalLight>(&light))
            sun->angular_radius = static_cast<float>(random_.below(2)) * 0.1f;
        if (random_.below(4) == 0)
            return lightmesh::RectLight{.position = glm::vec3(random_.in_box(Vec(-4.0), Vec(4.0)))};
        return light;
    }
    void build() {
        scene_.clear();
        test::add_quad(scene_, {-5.0, -5.0, -3.0}, {10.0, 0.0, 0.0}, {0.0, 10.0, 0.0});
        for (const Bounds& box : boxes_)
            test::add_box(scene_, Vec(box.low), Vec(box.high));
    }

    Random random_;
    std::vector<Bounds> boxes_;
    std::vector<test::Triangle> scene_;
    std::vector<lightmesh::Light> lights_;
    std::vector<Bounds> changed_;
    std::vector<bool> is_free_ = std::vector<bool>(16, false);
};

constexpr std::size_t no_budget = (std::numeric_limits<std::size_t>::max)();

/// Moves, queries, merges, and compares with something new: make(world, budget) must know nothing yet. The
/// subject of two of four seeds has hardly more memory than a new one.
template <class Make>
void compare_with_new(std::uint64_t seed, int rounds, const Make& make_with_budget) {
    MovingWorld world(seed, 9);
    const auto make = [&](const MovingWorld& of) {
        return make_with_budget(of, no_budget);
    };
    const bool is_bounded = seed / 2 % 2 == 1;
    auto subject = make_with_budget(world, is_bounded ? make(world).statistics().bytes + std::size_t{50'000}
                                                      : no_budget);
    std::size_t differing = 0;
    std::vector<lightmesh::SurfacePoint> points;
    for (int i = 0; i < 6; ++i)
        points.push_back(world.point());
    // A snapshot, and how many boxes had changed when it was taken.
    test::Bytes snapshot = subject.snapshot();
    std::size_t changed_before = 0;
    for (int round = 0; round < rounds; ++round) {
        world.move(subject);
        points[world.random().below(points.size())] = world.point();
        const auto fresh = make(world);
        switch (world.random().below(8)) {
        case 0:
            snapshot = subject.snapshot();
            changed_before = world.changed().size();
            break;
        case 1:
            subject.merge(snapshot, std::span(world.changed()).subspan(changed_before));
            break;
        case 2: {
            const auto other = make(world);
            other.fill(points);
            subject.merge(other.snapshot());
            break;
        }
        case 3:
        case 4:
            subject.begin_frame();
            break;
        case 5:
            subject.compact();
            break;
        default:
            break;
        }
        for (std::size_t i = 0; i < points.size(); ++i)
            if (world.random().below(2) == 0)
                differing += ask(subject, points[i]) != ask(fresh, points[i]) ? 1u : 0u;
    }
    CHECK(differing == 0);
    if constexpr (requires { subject.statistics().evicted_bricks; })
        CHECK((subject.statistics().evicted_bricks > 0) == is_bounded);
    else
        CHECK((subject.statistics().evicted_records > 0) == is_bounded);
}

}  // namespace

TEST_CASE("moving scenes: after any moves a cache of lamps says what a new one says") {
    for (const std::uint64_t seed : {1u, 2u, 3u})
        compare_with_new(seed, 60, [](const MovingWorld& world, std::size_t budget) {
            return VisibilityCache{
                HitTracer{&world.scene()}, world.lights(),
                CacheSettings{.spacing = 0.4f, .detail = 2, .lamp_rays = 16, .memory_budget = budget}};
        });
    compare_with_new(4, 20, [](const MovingWorld& world, std::size_t budget) {
        return VisibilityCache{
            test::PlainTracer{&world.scene()}, world.lights(),
            CacheSettings{.spacing = 0.5f, .detail = 1, .lamp_rays = 16, .memory_budget = budget}};
    });
}

namespace {

/// Reads the world's triangles, or takes pictures of its boxes, as they are when it is asked.
struct WorldTriangles {
    const MovingWorld* world;
    std::size_t triangle_count() const { return world->scene().size(); }
    std::array<glm::vec3, 3> triangle(std::size_t i) const {
        const test::Triangle& t = world->scene()[i];
        return {glm::vec3(t.a), glm::vec3(t.b), glm::vec3(t.c)};
    }
};
struct WorldPictures {
    const MovingWorld* world;
    void render_depth(const lightmesh::DepthView& view, std::span<float> distances) const {
        const test::BoxScene boxes = world->boxes();
        test::BoxRenderer{&boxes}.render_depth(view, distances);
    }
    Bounds bounds() const {
        Bounds all{{-5.0f, -5.0f, -3.0f}, {5.0f, 5.0f, -2.0f}};
        for (const lightmesh::Bounds& box : world->boxes().boxes)
            all = {glm::min(all.low, box.low), glm::max(all.high, box.high)};
        return all;
    }
};

lightmesh::Settings mesh_settings(std::uint64_t seed, std::size_t budget) {
    constexpr std::array short_tests{lightmesh::ShortTest::linked, lightmesh::ShortTest::none,
                                     lightmesh::ShortTest::exact};
    lightmesh::Settings settings;
    settings.radius = 0.9f;
    settings.quality = 3.0f;
    settings.short_test = short_tests[seed % 3];
    settings.adaptive_long_tests = seed % 2 == 0;
    settings.shadow_map_size = 32;
    settings.memory_budget = budget;
    return settings;
}

}  // namespace

TEST_CASE("moving scenes: after any moves a mesh with rays says what a new one says") {
    for (std::uint64_t seed = 0; seed < 6; ++seed)
        compare_with_new(seed, 40, [seed](const MovingWorld& world, std::size_t budget) {
            return lightmesh::LightMesh{test::PlainTracer{&world.scene()}, world.lights(),
                                        mesh_settings(seed, budget)};
        });
}

TEST_CASE("moving scenes: after any moves a mesh with shadow volumes says what a new one says") {
    for (std::uint64_t seed = 10; seed < 13; ++seed)
        compare_with_new(seed, 30, [seed](const MovingWorld& world, std::size_t budget) {
            return lightmesh::LightMesh{test::PlainTracer{&world.scene()}, WorldTriangles{&world},
                                        world.lights(), mesh_settings(seed, budget)};
        });
}

TEST_CASE("moving scenes: after any moves a mesh with shadow maps says what a new one says") {
    for (std::uint64_t seed = 20; seed < 24; ++seed)
        compare_with_new(seed, 30, [seed](const MovingWorld& world, std::size_t budget) {
            lightmesh::Settings settings = mesh_settings(seed, budget);
            settings.refine_shadow_maps = seed % 4 == 3;
            return lightmesh::LightMesh{test::PlainTracer{&world.scene()}, WorldPictures{&world},
                                        world.lights(), settings};
        });
}

TEST_CASE("moving scenes: after any moves a cache of a mesh's blur says what a new one says") {
    for (std::uint64_t seed = 30; seed < 32; ++seed)
        compare_with_new(seed, 30, [seed](const MovingWorld& world, std::size_t budget) {
            return VisibilityCache{
                lightmesh::LightMesh{HitTracer{&world.scene()}, world.lights(), mesh_settings(seed, budget)},
                CacheSettings{.spacing = 0.5f, .detail = 1, .memory_budget = budget}};
        });
}

TEST_CASE("moving scenes: maps and volumes that do not show what has moved are kept, and all are counted") {
    struct Still {
        test::BoxScene boxes;
        std::vector<std::array<glm::vec3, 3>> corners;
        std::vector<test::Triangle> triangles;

        void build() {
            triangles.clear();
            for (const Bounds& box : boxes.boxes)
                test::add_box(triangles, Vec(box.low), Vec(box.high));
            corners.clear();
            for (const test::Triangle& t : triangles)
                corners.push_back({glm::vec3(t.a), glm::vec3(t.b), glm::vec3(t.c)});
        }
    };
    struct StillTriangles {
        const Still* of;
        std::size_t triangle_count() const { return of->corners.size(); }
        std::array<glm::vec3, 3> triangle(std::size_t i) const { return of->corners[i]; }
    };
    // Around a lamp a box in each direction, and one more light to which all of them lie on one side.
    Still still;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-2.0f, 2.0f}) {
            glm::vec3 centre(0.0f);
            centre[axis] = side;
            still.boxes.boxes.push_back({centre - 0.4f, centre + 0.4f});
        }
    still.build();
    std::vector<lightmesh::Light> lights{lightmesh::PointLight{.position{0.05f, 0.03f, 0.01f}},
                                         lightmesh::PointLight{.position{20.0f, 0.5f, 0.3f}}};
    lightmesh::Settings settings{.radius = 0.9f, .quality = 3.0f, .short_test = lightmesh::ShortTest::none};
    settings.shadow_map_size = 64;
    const auto make_maps = [&] {
        return lightmesh::LightMesh{test::PlainTracer{&still.triangles}, test::BoxRenderer{&still.boxes},
                                    lights, settings};
    };
    const auto make_volumes = [&] {
        return lightmesh::LightMesh{test::PlainTracer{&still.triangles}, StillTriangles{&still}, lights,
                                    settings};
    };
    std::vector<lightmesh::SurfacePoint> points;
    test::Random random(2);
    for (int i = 0; i < 60; ++i)
        points.push_back({.position = glm::vec3(random.in_box(Vec(-3.5), Vec(3.5))), .normal{0, 0, 1}});
    auto maps = make_maps();
    auto volumes = make_volumes();
    const auto check_same = [&] {
        const auto new_maps = make_maps();
        const auto new_volumes = make_volumes();
        std::size_t differing = 0;
        for (const lightmesh::SurfacePoint& point : points) {
            differing += ask(maps, point) != ask(new_maps, point) ? 1u : 0u;
            differing += ask(volumes, point) != ask(new_volumes, point) ? 1u : 0u;
        }
        CHECK(differing == 0);
    };
    check_same();
    CHECK(maps.statistics().depth_pictures == 7);
    CHECK(volumes.statistics().volume_grids == 7);
    CHECK(volumes.statistics().forgotten_grids == 0);

    // A box moves in one direction of the first lamp: both have a view of it.
    const auto move = [&](glm::vec3 by) {
        Bounds& box = still.boxes.boxes[1];
        const Bounds before = box;
        box = {box.low + by, box.high + by};
        still.build();
        const std::array changed{before, box};
        maps.scene_changed(changed);
        volumes.scene_changed(changed);
    };
    move({0.3f, 0.1f, 0.2f});
    CHECK(maps.statistics().forgotten_pictures == 2);
    CHECK(volumes.statistics().forgotten_grids == 2);
    check_same();
    CHECK(maps.statistics().depth_pictures == 9);
    CHECK(volumes.statistics().volume_grids == 9);
    // Beyond the middle of two directions.
    move({0.2f, 1.9f, 0.0f});
    CHECK(maps.statistics().forgotten_pictures == 5);
    CHECK(volumes.statistics().forgotten_grids == 5);
    check_same();
    // A lamp that moves takes its views along.
    lights[0] = lightmesh::PointLight{.position{0.0f, 0.1f, 0.0f}};
    maps.set_light(0, lights[0]);
    volumes.set_light(0, lights[0]);
    CHECK(maps.statistics().forgotten_pictures == 11);
    CHECK(volumes.statistics().forgotten_grids == 11);
    check_same();
    // A box more: the numbers of triangles mean nothing any more.
    still.boxes.boxes.push_back({{-3.0f, -3.0f, -3.0f}, {-2.9f, -2.9f, -2.9f}});
    still.build();
    maps.scene_changed(still.boxes.boxes.back());
    volumes.scene_changed(still.boxes.boxes.back());
    CHECK(maps.statistics().forgotten_pictures < 18);
    CHECK(volumes.statistics().forgotten_grids == 18);
    check_same();
}

namespace {

constexpr lightmesh::PointLight elsewhere{.position{1.5f, -2.5f, 3.0f}, .radius = 0.2f};

}  // namespace

TEST_CASE("moving scenes: a light that moves costs its own rays, and no others") {
    for (const bool adaptive : {false, true}) {
        StillWorld world(20);
        auto mesh = world.mesh(adaptive);
        mesh.fill(world.points);
        const auto before = mesh.statistics();
        mesh.set_light(11, elsewhere);
        CHECK(mesh.statistics().forgotten_visibilities > 0);
        CHECK(mesh.statistics().forgotten_links == 0);
        mesh.fill(world.points);
        const auto after = mesh.statistics();
        world.lights = {elsewhere};
        const auto alone = world.mesh(adaptive);
        alone.fill(world.points);
        CHECK(after.link_rays == before.link_rays);
        // Of 20 lights; some need more of space than others.
        CHECK(after.long_rays - before.long_rays >= alone.statistics().long_rays);
        CHECK(after.long_rays - before.long_rays < before.long_rays / 20 * 3 / 2);
    }
    StillWorld world(20);
    auto cache = world.cache();
    cache.fill(world.points);
    const auto before = cache.statistics();
    cache.set_light(11, elsewhere);
    CHECK(cache.statistics().forgotten_values > 0);
    CHECK(cache.statistics().forgotten_records == 0);
    cache.fill(world.points);
    const auto after = cache.statistics();
    world.lights = {elsewhere};
    const auto alone = world.cache();
    alone.fill(world.points);
    CHECK(after.lamp_rays - before.lamp_rays == alone.statistics().lamp_rays);
}

TEST_CASE("moving scenes: a light that is set as it is costs nothing, as one whose colour changes") {
    const StillWorld world(20);
    auto mesh = world.mesh();
    auto cache = world.cache();
    const auto blur_of = [&] {
        return VisibilityCache{
            lightmesh::LightMesh{HitTracer{&world.scene}, world.lights, lightmesh::Settings{.radius = 2.0f}},
            CacheSettings{.spacing = 0.4f, .detail = 1}};
    };
    auto blur = blur_of();
    const auto check = [&](auto& subject, const auto& rays) {
        subject.fill(world.points);
        const test::Bytes known = subject.snapshot();
        const std::uint64_t before = rays();
        for (std::size_t i = 0; i < world.lights.size(); ++i)
            subject.set_light(i, world.lights[i]);
        CHECK(subject.snapshot() == known);
        subject.fill(world.points);
        CHECK(rays() == before);
    };
    check(mesh, [&] { return mesh.statistics().long_rays + mesh.statistics().link_rays; });
    CHECK(mesh.statistics().forgotten_visibilities == 0);
    // What rays from points take, nothing keeps.
    const auto of_cache = [](const lightmesh::CacheStatistics& found) {
        return found.kept_rays();
    };
    check(cache, [&] { return of_cache(cache.statistics()); });
    CHECK(cache.statistics().forgotten_values == 0);
    check(blur, [&] {
        return of_cache(blur.statistics()) + blur.mesh().statistics().long_rays +
               blur.mesh().statistics().link_rays;
    });
    CHECK(blur.statistics().forgotten_values == 0);
    CHECK(blur.mesh().statistics().forgotten_visibilities == 0);
}

TEST_CASE("moving scenes: a light that is added costs its own rays") {
    constexpr lightmesh::PointLight added{.position{-2.0f, 1.5f, 3.5f}, .radius = 0.2f};
    for (const int count : {9, 60, 64})
        for (const bool adaptive : {false, true})
            for (const bool moves_before : {false, true}) {
                CAPTURE(count);
                CAPTURE(adaptive);
                CAPTURE(moves_before);
                StillWorld world(count, 60);
                auto mesh = world.mesh(adaptive);
                auto cache = world.cache();
                mesh.fill(world.points);
                cache.fill(world.points);
                const auto mesh_before = mesh.statistics();
                const auto cache_before = cache.statistics();
                const auto tell = [&](auto& subject) {
                    if (moves_before)
                        subject.set_light(3, elsewhere);
                    CHECK(subject.add_light(added) == static_cast<std::size_t>(count));
                };
                tell(mesh);
                tell(cache);
                mesh.fill(world.points);
                cache.fill(world.points);
                const std::uint64_t rays = mesh.statistics().long_rays - mesh_before.long_rays;
                const std::uint64_t lamp_rays = cache.statistics().lamp_rays - cache_before.lamp_rays;
                CHECK(mesh.statistics().link_rays == mesh_before.link_rays);
                if (moves_before)
                    world.lights[3] = elsewhere;
                world.lights.emplace_back(added);
                const auto new_mesh = world.mesh(adaptive);
                const auto new_cache = world.cache();
                std::size_t differing = 0;
                for (const lightmesh::SurfacePoint& point : world.points) {
                    differing += ask(mesh, point) != ask(new_mesh, point) ? 1u : 0u;
                    differing += ask(cache, point) != ask(new_cache, point) ? 1u : 0u;
                }
                CHECK(differing == 0);
                world.lights = {added};
                if (moves_before)
                    world.lights.emplace_back(elsewhere);
                const auto mesh_alone = world.mesh(adaptive);
                const auto cache_alone = world.cache();
                mesh_alone.fill(world.points);
                cache_alone.fill(world.points);
                CHECK(lamp_rays == cache_alone.statistics().lamp_rays);
                // Groups of lights are found together, in the cells that any of them needs.
                CHECK(rays > mesh_alone.statistics().long_rays * 4 / 5);
                CHECK(rays < mesh_alone.statistics().long_rays * 5 / 4);
            }
}

TEST_CASE("moving scenes: what a box has nothing to do with is kept") {
    const StillWorld world(20);
    auto mesh = world.mesh();
    auto cache = world.cache();
    mesh.fill(world.points);
    cache.fill(world.points);
    const auto mesh_before = mesh.statistics();
    const auto cache_before = cache.statistics();
    // Under the floor, and so small that few lights shine through it from anywhere.
    const Bounds nowhere{{-4.9f, -4.9f, -9.0f}, {-4.8f, -4.8f, -8.9f}};
    mesh.scene_changed(nowhere);
    cache.scene_changed(nowhere);
    CHECK(mesh.statistics().forgotten_visibilities == 0);
    CHECK(cache.statistics().forgotten_values == 0);
    CHECK(cache.statistics().forgotten_records == 0);
    const Bounds small{{0.0f, 0.0f, -1.0f}, {0.1f, 0.1f, -0.9f}};
    mesh.scene_changed(small);
    cache.scene_changed(small);
    mesh.fill(world.points);
    cache.fill(world.points);
    CHECK(mesh.statistics().long_rays < mesh_before.long_rays * 3 / 2);
    CHECK(cache.statistics().lamp_rays < cache_before.lamp_rays * 3 / 2);
    CHECK(mesh.statistics().forgotten_visibilities > 0);
    CHECK(mesh.statistics().forgotten_floods > 0);
    CHECK(cache.statistics().forgotten_values > 0);
}

TEST_CASE("moving scenes: memory is used again, and compact gives back the rest") {
    const StillWorld world(20);
    auto mesh = world.mesh();
    auto cache = world.cache();
    const auto there_and_back = [&](auto& subject) {
        for (const bool is_back : {false, true}) {
            subject.set_light(11, is_back ? world.lights[11] : lightmesh::Light(elsewhere));
            subject.scene_changed(Bounds{{-1.0f, -1.0f, -3.0f}, {1.0f, 1.0f, -1.0f}});
            subject.fill(world.points);
        }
    };
    mesh.fill(world.points);
    cache.fill(world.points);
    for (int i = 0; i < 3; ++i) {
        there_and_back(mesh);
        there_and_back(cache);
    }
    const std::size_t mesh_bytes = mesh.statistics().bytes;
    const std::size_t cache_bytes = cache.statistics().bytes;
    for (int i = 0; i < 20; ++i) {
        there_and_back(mesh);
        there_and_back(cache);
    }
    CHECK(mesh.statistics().bytes <= mesh_bytes + mesh_bytes / 50);
    CHECK(cache.statistics().bytes == cache_bytes);

    mesh.compact();
    cache.compact();
    CHECK(mesh.statistics().bytes < mesh_bytes);
    CHECK(cache.statistics().bytes <= cache_bytes);
    const auto rays = mesh.statistics().long_rays;
    const auto lamp_rays = cache.statistics().lamp_rays;
    mesh.fill(world.points);
    cache.fill(world.points);
    CHECK(mesh.statistics().long_rays == rays);
    CHECK(cache.statistics().lamp_rays == lamp_rays);
}

TEST_CASE("moving scenes: what has moved and come back knows the same as what never did") {
    StillWorld world(20);
    // With ranges lights have an order of their own, in which each of them has its place.
    for (std::size_t i = 0; i < world.lights.size(); i += 2)
        std::get<lightmesh::PointLight>(world.lights[i]).range = 7.0f;
    // Of adaptive long tests, what a fill asks for depends on what is uniform already.
    auto mesh = world.mesh(false);
    auto cache = world.cache();
    mesh.fill(world.points);
    cache.fill(world.points);
    const auto mesh_bytes = mesh.snapshot();
    const auto cache_bytes = cache.snapshot();
    mesh.set_light(4, elsewhere);
    mesh.set_light(4, world.lights[4]);
    mesh.fill(world.points);
    CHECK(mesh.snapshot() == mesh_bytes);
    mesh.set_light(4, elsewhere);
    cache.set_light(4, elsewhere);
    mesh.fill(world.points);
    cache.fill(world.points);
    const auto moved = mesh.snapshot();
    mesh.set_light(4, world.lights[4]);
    cache.set_light(4, world.lights[4]);
    mesh.fill(world.points);
    cache.fill(world.points);
    // Records stay that were made for the light where it was elsewhere, without values: besides them there is
    // what the other snapshot has, value by value.
    auto never_moved = world.cache();
    never_moved.merge(cache_bytes);
    CHECK(never_moved.snapshot() == cache_bytes);
    never_moved.merge(cache.snapshot());
    CHECK(never_moved.snapshot() == cache.snapshot());
    CHECK(never_moved.statistics().lamp_rays == 0);
    auto back = world.mesh(false);
    back.merge(mesh.snapshot());
    back.fill(world.points);
    CHECK(back.statistics().long_rays == 0);

    // A reader knows the lights as they are now.
    world.lights[4] = elsewhere;
    auto restored = world.mesh(false);
    restored.merge(moved);
    restored.fill(world.points);
    const auto fresh = world.mesh(false);
    fresh.fill(world.points);
    // Groups of eight lights are others now: what was known of some only is found again.
    CHECK(restored.statistics().long_rays < fresh.statistics().long_rays / 3);
    for (const lightmesh::SurfacePoint& point : world.points)
        CHECK(ask(restored, point) == ask(fresh, point));
}

TEST_CASE("moving scenes: what is wrong is named, and nothing has changed then") {
    const StillWorld world(3, 10);
    auto mesh = world.mesh();
    auto cache = world.cache();
    const auto check = [&](auto& subject) {
        std::vector<std::vector<float>> before;
        for (const lightmesh::SurfacePoint& point : world.points)
            before.push_back(ask(subject, point));
        constexpr float nan = std::numeric_limits<float>::quiet_NaN();
        const auto contains = [](const std::string& text, const std::string& part) {
            return text.find(part) != std::string::npos;
        };
        CHECK(contains(error_of([&] {
                           subject.set_light(1, lightmesh::PointLight{.position = {0, nan, 0}});
                       }),
                       "light 1: PointLight::position is (0, nan, 0)"));
        CHECK(contains(error_of([&] { subject.add_light(lightmesh::PointLight{.range = -1.0f}); }),
                       "light 3: PointLight::range is -1"));
        CHECK_THROWS_AS(subject.set_light(3, elsewhere), std::out_of_range);
        CHECK_THROWS_AS(subject.remove_light(3), std::out_of_range);
        CHECK(contains(error_of([&] {
                           subject.scene_changed(Bounds{{0, 0, 0}, {1, nan, 1}});
                       }),
                       "changed box 0: Bounds::high is (1, nan, 1)"));
        CHECK(contains(error_of([&] {
                           subject.scene_changed(Bounds{{2, 0, 0}, {1, 1, 1}});
                       }),
                       "changed box 0: Bounds::low is (2, 0, 0)"));
        CHECK(contains(error_of([&] {
                           subject.merge({}, std::array{Bounds{{2, 0, 0}, {1, 1, 1}}});
                       }),
                       "lightmesh"));
        for (std::size_t i = 0; i < before.size(); ++i)
            CHECK(ask(subject, world.points[i]) == before[i]);
        subject.remove_light(1);
        CHECK_THROWS_AS(subject.remove_light(1), std::out_of_range);
        for (const lightmesh::SurfacePoint& point : world.points)
            CHECK(ask(subject, point)[1] == 0.0f);
        CHECK(subject.add_light(world.lights[1]) == 1);
        for (std::size_t i = 0; i < before.size(); ++i)
            CHECK(ask(subject, world.points[i]) == before[i]);
    };
    check(mesh);
    check(cache);
}

TEST_CASE("moving scenes: over its budget, a frame forgets what has gone unused for the longest time") {
    // Memory comes in chunks: only of many of them half can be given back.
    const StillWorld world(20, 1000);
    const auto part = [&](std::size_t frame) {
        return std::span(world.points).subspan(frame % 10 * 100, 100);
    };
    lightmesh::Settings settings{.radius = 0.4f, .quality = 3.0f};
    CacheSettings cache_settings{.spacing = 0.08f, .detail = 4, .lamp_rays = 16};
    const lightmesh::LightMesh expected_mesh{test::PlainTracer{&world.scene}, world.lights, settings};
    const VisibilityCache expected_cache{HitTracer{&world.scene}, world.lights, cache_settings};
    const auto watch = [&](auto& subject, const auto& expected, std::size_t budget, double slack) {
        std::size_t most = 0;
        for (std::size_t frame = 0; frame < 20; ++frame) {
            subject.begin_frame();
            most = std::max(most, frame < 2 ? 0 : subject.statistics().bytes);
            for (const lightmesh::SurfacePoint& point : part(frame))
                CHECK(ask(subject, point) == ask(expected, point));
        }
        CHECK(static_cast<double>(most) < slack * static_cast<double>(budget));
        // What the last frame used is there still.
        subject.begin_frame();
        const auto before = subject.statistics();
        for (const lightmesh::SurfacePoint& point : part(19))
            (void)ask(subject, point);
        return std::pair(before, subject.statistics());
    };
    expected_mesh.fill(world.points);
    expected_cache.fill(world.points);
    const std::size_t mesh_budget = expected_mesh.statistics().bytes / 2;
    settings.memory_budget = mesh_budget;
    lightmesh::LightMesh mesh{test::PlainTracer{&world.scene}, world.lights, settings};
    const auto [mesh_before, mesh_after] = watch(mesh, expected_mesh, mesh_budget, 1.5);
    CHECK(mesh_after.long_rays == mesh_before.long_rays);
    CHECK(mesh_before.long_rays > expected_mesh.statistics().long_rays);
    CHECK(mesh_before.evicted_bricks > 0);
    CHECK(expected_mesh.statistics().evicted_bricks == 0);

    const std::size_t cache_budget = expected_cache.statistics().bytes * 4 / 5;
    cache_settings.memory_budget = cache_budget;
    VisibilityCache cache{HitTracer{&world.scene}, world.lights, cache_settings};
    const auto [cache_before, cache_after] = watch(cache, expected_cache, cache_budget, 1.3);
    const VisibilityCache fresh{HitTracer{&world.scene}, world.lights, cache_settings};
    fresh.fill(part(19));
    CHECK(cache_after.lamp_rays - cache_before.lamp_rays < fresh.statistics().lamp_rays / 4);
    CHECK(cache_before.lamp_rays > expected_cache.statistics().lamp_rays);
    CHECK(cache_before.evicted_records > 0);
    CHECK(expected_cache.statistics().evicted_records == 0);
}

TEST_CASE("moving scenes: a light may be added that is there already") {
    const StillWorld world(3, 10);
    auto mesh = world.mesh();
    auto cache = world.cache();
    for (int i = 0; i < 70; ++i) {
        mesh.add_light(mesh.lights()[1]);
        cache.add_light(cache.lights()[1]);
    }
    for (const lightmesh::SurfacePoint& point : world.points) {
        CHECK(ask(mesh, point).back() == ask(mesh, point)[1]);
        CHECK(ask(cache, point).back() == ask(cache, point)[1]);
    }
}

TEST_CASE("moving scenes: a snapshot of more lights, merged with changed boxes") {
    const StillWorld more(40, 20);
    const auto blur_of = [&](std::span<const lightmesh::Light> lights) {
        return VisibilityCache{
            lightmesh::LightMesh{HitTracer{&more.scene}, lights, lightmesh::Settings{.radius = 2.0f}},
            CacheSettings{.spacing = 0.4f, .detail = 1}};
    };
    const auto from = blur_of(more.lights);
    from.fill(more.points);
    const std::vector<lightmesh::Light> lights(more.lights.begin(), more.lights.begin() + 3);
    auto fewer = blur_of(lights);
    fewer.fill(more.points);
    fewer.merge(from.snapshot(), std::array{Bounds{glm::vec3(4.0f), glm::vec3(4.1f)}});
    const auto fresh = blur_of(lights);
    for (const lightmesh::SurfacePoint& point : more.points)
        CHECK(ask(fewer, point) == ask(fresh, point));
}

}  // namespace moving_scenes_test
