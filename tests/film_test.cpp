// SPDX-License-Identifier: MIT

// Scenes that move, and what follows them: the BVH and all ways to find visibility.

#include "gltf_writer.hpp"
#include "random_scene.hpp"
#include "render/embree_scene.hpp"
#include "render/open_scene.hpp"
#include "render/renderer.hpp"
#include "render/view.hpp"
#include "render/visibility.hpp"
#include "scene/film.hpp"
#include "scene/moving_parts.hpp"
#include "scene/random.hpp"
#include "temporary_folder.hpp"

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace film_test {

namespace {

using demo::SceneChange;

bool holds(const lightmesh::Bounds& box, const glm::vec3& p) {
    return glm::all(glm::lessThanEqual(box.low, p)) && glm::all(glm::lessThanEqual(p, box.high));
}

bool any_holds(const std::vector<lightmesh::Bounds>& boxes, const glm::vec3& p) {
    return std::ranges::any_of(boxes, [&](const lightmesh::Bounds& box) { return holds(box, p); });
}

float volume(const std::vector<lightmesh::Bounds>& boxes) {
    float sum = 0.0f;
    for (const lightmesh::Bounds& box : boxes) {
        const glm::vec3 size = box.high - box.low;
        sum += size.x * size.y * size.z;
    }
    return sum;
}

std::vector<std::uint32_t> ball(const demo::Scene& scene, const glm::vec3& centre, float radius) {
    return demo::vertices_within(scene, centre - 1.001f * radius, centre + 1.001f * radius);
}

void shift(demo::Scene& scene, const std::vector<std::uint32_t>& vertices, const glm::vec3& way) {
    for (const std::uint32_t vertex : vertices)
        scene.positions[vertex] += way;
}

/// Spheres of which the blue one rises and goes aside, with a light that moves, too.
demo::AnimatedScene moving_spheres() {
    demo::Scene scene = demo::make_spheres();
    demo::MovingPart part;
    part.vertices = ball(scene, {-17, -13, 7}, 7.0f);
    part.lights = {2};
    part.motion = [](double seconds) {
        demo::Motion motion = demo::turned_about({-17, -13, 7}, {0, 0, 1}, 0.1 * seconds);
        motion.to += seconds * glm::dvec3(4, -3, 2);
        return motion;
    };
    return demo::animate(std::move(scene), {part}, {}, 4.0);
}

/// A floor below a pane with a mask of holes by its vertices' alpha, which moves.
demo::AnimatedScene moving_mask() {
    demo::Scene scene;
    scene.name = "mask";
    scene.positions = {{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}, {-2, -2, 2}, {2, -2, 2}, {0, 3, 2}};
    scene.normals.assign(7, {0, 0, 1});
    scene.colours = {glm::vec4(1), glm::vec4(1),          glm::vec4(1),         glm::vec4(1),
                     glm::vec4(1), glm::vec4(1, 1, 1, 0), glm::vec4(1, 1, 1, 0)};
    demo::Material mask;
    mask.alpha_mode = demo::AlphaMode::mask;
    mask.shadow = demo::ShadowBy::opacity;
    scene.materials = {demo::Material{}, mask};
    scene.triangles = {{{0, 1, 2}, 0}, {{0, 2, 3}, 0}, {{4, 5, 6}, 1}};
    scene.lights.push_back({lightmesh::PointLight{{0.3f, 0.1f, 6.0f}}});
    demo::MovingPart part;
    part.vertices = {4, 5, 6};
    part.motion = [](double seconds) {
        return demo::Motion{glm::dvec3(0), seconds * glm::dvec3(1, 0.5, 0.25), glm::dmat3(1)};
    };
    return demo::animate(std::move(scene), {part}, {}, 4.0);
}

std::vector<lightmesh::Segment> segments_in(const lightmesh::Bounds& box, std::size_t count) {
    demo::Random random(5);
    const auto place = [&] {
        glm::vec3 share;
        for (int axis = 0; axis < 3; ++axis)
            share[axis] = random.uniform();
        return box.low + share * (box.high - box.low);
    };
    std::vector<lightmesh::Segment> segments(count);
    for (lightmesh::Segment& segment : segments) {
        segment.origin = place();
        segment.target = place();
    }
    return segments;
}

std::vector<std::uint8_t> blocked(RTCScene scene, const std::vector<lightmesh::Segment>& segments) {
    std::vector<std::uint8_t> hit(segments.size());
    demo::EmbreeIntersector(scene, demo::EmbreeIntersector::Batches::packets).occluded(segments, hit);
    return hit;
}

demo::Image picture(const demo::EmbreeScene& scene, const demo::Visibility& visibility) {
    demo::RenderOptions options;
    options.width = 40;
    options.height = 30;
    options.threads = 1;
    demo::RenderStatistics statistics;
    return demo::render(scene, visibility, options, statistics);
}

/// What every 12th pixel of a picture shows.
std::vector<lightmesh::SurfacePoint> seen_points(const demo::EmbreeScene& scene) {
    const demo::View view(scene.scene().camera, 640, 480);
    std::vector<lightmesh::SurfacePoint> points;
    for (int row = 6; row < 480; row += 12)
        for (int column = 6; column < 640; column += 12) {
            const glm::vec3 eye = view.origin(static_cast<float>(column), static_cast<float>(row));
            const glm::vec3 way = view.direction(static_cast<float>(column), static_cast<float>(row));
            if (const auto hit = scene.trace(eye, way))
                points.push_back({.position = hit->position,
                                  .normal = hit->geometric_normal,
                                  .footprint = view.pixel_angle() * glm::distance(eye, hit->position)});
        }
    return points;
}

}  // namespace

TEST_CASE("difference: nothing, a camera, lights by their shapes, other scenes") {
    const demo::Scene before = demo::make_spheres();
    demo::Scene after = before;
    const SceneChange none = demo::difference(before, after);
    CHECK_FALSE(none.changes_shadows());
    CHECK_FALSE(none.camera);

    after.camera.eye.x += 1.0f;
    after.lights[3].intensity *= 2.0f;
    const SceneChange seen = demo::difference(before, after);
    CHECK(seen.camera);
    CHECK_FALSE(seen.changes_shadows());

    std::get<lightmesh::PointLight>(after.lights[5].shape).position.z += 1.0f;
    std::get<lightmesh::PointLight>(after.lights[1].shape).range = 90.0f;
    const SceneChange lit = demo::difference(before, after);
    CHECK(lit.lights == std::vector<std::size_t>{1, 5});
    CHECK(lit.boxes.empty());
    CHECK_FALSE(lit.changes_triangles());

    demo::Scene fewer = before;
    fewer.triangles.pop_back();
    CHECK(demo::difference(before, fewer).is_another_scene);
    demo::Scene darker = before;
    darker.lights.pop_back();
    CHECK(demo::difference(before, darker).is_another_scene);
    demo::Scene clearer = before;
    clearer.materials[2].opacity = 0.5f;
    CHECK(demo::difference(before, clearer).is_another_scene);
}

TEST_CASE("difference: a box for each object that moved, where it was and where it is") {
    const demo::Scene before = demo::make_spheres();
    demo::Scene after = before;
    const auto blue = ball(before, {-17, -13, 7}, 7.0f);
    const auto yellow = ball(before, {36, 23, 26.5f}, 8.5f);
    REQUIRE(blue.size() > 50);
    REQUIRE(yellow.size() > 50);
    shift(after, blue, {0.5f, 0.0f, 0.0f});
    shift(after, yellow, {0.0f, 0.0f, 60.0f});
    const SceneChange change = demo::difference(before, after);
    CHECK(change.boxes.size() == 3);  // the yellow one has gone far: two boxes
    CHECK(change.lights.empty());
    for (const auto& vertices : {blue, yellow})
        for (const std::uint32_t vertex : vertices) {
            CHECK(any_holds(change.boxes, before.positions[vertex]));
            CHECK(any_holds(change.boxes, after.positions[vertex]));
        }
    CHECK(volume(change.boxes) < 1.01f * (15.0f * 14.0f * 14.0f + 2.0f * 17.0f * 17.0f * 17.0f));
    // A corner alone takes its triangles along.
    demo::Scene corner = before;
    corner.positions[yellow[0]].x += 0.1f;
    const SceneChange little = demo::difference(before, corner);
    CHECK(any_holds(little.boxes, corner.positions[yellow[0]]));
    CHECK(volume(little.boxes) < 17.0f * 17.0f * 17.0f);
}

TEST_CASE("difference: many objects that move have a bounded number of boxes around them all") {
    demo::Scene before = demo::make_park();
    demo::Scene after = before;
    for (std::size_t i = 0; i < after.positions.size(); i += 7)
        after.positions[i].z += 0.01f;
    const SceneChange change = demo::difference(before, after);
    CHECK(change.boxes.size() <= SceneChange::most_boxes);
    for (std::size_t i = 0; i < after.positions.size(); i += 7)
        if (!any_holds(change.boxes, after.positions[i]))
            FAIL_CHECK("vertex " << i << " is outside");
}

TEST_CASE("difference: what moves within the roundings of its place, and many large triangles, are cut into "
          "few pieces") {
    demo::Scene before;
    before.materials.resize(1);
    before.positions = {{10.0f, 5.0f, 3.0f}, {10.000001f, 5.0f, 3.0f}, {10.0f, 5.0000005f, 3.0f}};
    before.triangles = {{{0, 1, 2}, 0}};
    demo::Scene after = before;
    after.positions[1] = {10.0f, 5.0f, 3.0000002f};
    const SceneChange tiny = demo::difference(before, after);
    REQUIRE(tiny.boxes.size() >= 1);
    for (const glm::vec3& position : after.positions)
        CHECK(any_holds(tiny.boxes, position));
    test::Random random(3);
    for (std::uint32_t i = 0; i < 6000; ++i)
        before.positions.push_back(glm::vec3(random.in_box(test::Vec(-50.0), test::Vec(50.0))));
    for (std::uint32_t i = 0; i < 2000; ++i)
        before.triangles.push_back({{3 * i + 3, 3 * i + 4, 3 * i + 5}, 0});
    after = before;
    for (glm::vec3& position : after.positions)
        position.x += 0.5f;
    const SceneChange large = demo::difference(before, after);
    CHECK(large.boxes.size() <= SceneChange::most_boxes);
    for (const glm::vec3& position : after.positions)
        if (!any_holds(large.boxes, position))
            FAIL_CHECK("a corner is outside");
}

TEST_CASE("built-in films: the still scene with what moves, each pose the same from wherever it is reached") {
    for (const std::string name : {"park", "rooms", "spheres"}) {
        CAPTURE(name);
        const demo::Scene still = demo::load_scene(name);
        demo::Film film(demo::load_animated(name));
        demo::Film other(demo::load_animated(name));
        const demo::Scene first = film.scene();
        REQUIRE(first.triangles.size() >= still.triangles.size());
        // Only a lamp that swings has moved at 0 s, by nothing.
        for (std::size_t i = 0; i < still.positions.size(); ++i)
            if (glm::distance(first.positions[i], still.positions[i]) > 1e-5f)
                FAIL_CHECK("vertex " << i << " is not where the still scene has it");
        for (const double time : {0.4, 2.9, 1.3})
            film.go_to(time);
        const SceneChange change = other.go_to(1.3);
        CHECK(film.scene().positions == other.scene().positions);
        CHECK(film.scene().normals == other.scene().normals);
        CHECK(film.scene().camera.eye == other.scene().camera.eye);
        CHECK_FALSE(change.is_another_scene);
        CHECK(change.boxes.size() >= 1);
        CHECK(change.boxes.size() <= SceneChange::most_boxes);
        // What has not moved has not moved at all, and the rest is in the boxes.
        std::size_t moved = 0;
        for (std::size_t i = 0; i < first.positions.size(); ++i)
            if (first.positions[i] != other.scene().positions[i]) {
                ++moved;
                if (!any_holds(change.boxes, first.positions[i]) ||
                    !any_holds(change.boxes, other.scene().positions[i]))
                    FAIL_CHECK("vertex " << i << " is outside of the boxes");
            }
        CHECK(moved > 0);
        CHECK(moved < 2000);
        CHECK(change.lights.size() == (name == "spheres" ? 0 : 1));
        CHECK(change.camera == (name == "park"));
        CHECK_FALSE(film.go_to(1.3).changes_shadows());
    }
}

TEST_CASE("films: only what shall move does") {
    demo::Moving moving;
    moving.objects = false;
    moving.camera = false;
    demo::Film film(demo::load_animated("park"), moving);
    const SceneChange change = film.go_to(2.0);
    CHECK(change.boxes.empty());
    CHECK_FALSE(change.camera);
    CHECK(change.lights.size() == 1);
    demo::SceneOptions options;
    options.scene = "park";
    options.eye = glm::vec3(0, -50, 20);
    options.lights = 3;
    demo::Film asked = demo::open_film(options);
    const SceneChange objects = asked.go_to(2.0);
    CHECK(asked.scene().lights.size() == 3);
    CHECK(objects.lights.empty());
    CHECK_FALSE(objects.camera);
    CHECK_FALSE(objects.boxes.empty());
    options.import.time = 1.0;
    CHECK_THROWS_AS(demo::open_film(options), std::invalid_argument);
    CHECK_THROWS_AS(demo::load_animated("street"), std::runtime_error);
}

TEST_CASE("an Embree scene that is fitted blocks the segments that a new one blocks") {
    for (const std::string name : {"spheres", "rooms", "mask"}) {
        CAPTURE(name);
        demo::Film film(name == "mask" ? moving_mask() : demo::load_animated(name));
        demo::EmbreeScene fitted(film.scene(), demo::EmbreeScene::For::films);
        demo::EmbreeScene rebuilt(film.scene());
        CHECK((fitted.blockers() != fitted.handle()) == (name == "mask"));
        for (const double time : {0.7, 3.0, 1.6}) {
            CAPTURE(time);
            const SceneChange change = film.go_to(time);
            fitted.update(change);
            rebuilt.update(change);
            const demo::EmbreeScene made(film.scene());
            REQUIRE_FALSE(change.boxes.empty());
            auto segments = segments_in(change.boxes[0], 3000);
            for (const lightmesh::Segment& segment : segments_in(
                     {film.scene().positions.front(), film.scene().camera.eye + glm::vec3(0, 0, 5)}, 1000))
                segments.push_back(segment);
            CHECK(blocked(fitted.handle(), segments) == blocked(made.handle(), segments));
            CHECK(blocked(rebuilt.handle(), segments) == blocked(made.handle(), segments));
            CHECK(blocked(fitted.blockers(), segments) == blocked(made.blockers(), segments));
            CHECK(fitted.offset() == made.offset());
            CHECK(fitted.far_away() == made.far_away());
        }
        SceneChange other;
        other.is_another_scene = true;
        CHECK_THROWS_AS(fitted.update(other), std::invalid_argument);
    }
}

TEST_CASE("all algorithms follow a scene that moves: pictures are those of new ones") {
    for (const demo::Algorithm& algorithm : demo::algorithms()) {
        CAPTURE(algorithm.name);
        demo::Film film(moving_spheres());
        demo::EmbreeScene embree(film.scene(), demo::EmbreeScene::For::films);
        demo::VisibilityOptions options;
        options.settings.radius = film.scene().radius;
        options.settings.quality = 3.0f;
        options.settings.shadow_map_size = 64;
        options.cache.detail = 1;
        options.area_samples = 4;
        options.depth = demo::DepthSource::embree;
        const auto followed = demo::make_visibility(algorithm.name, embree, options);
        picture(embree, *followed);
        for (const double time : {0.5, 2.0}) {
            const SceneChange change = film.go_to(time);
            REQUIRE(change.changes_triangles());
            REQUIRE(change.lights.size() == 1);
            embree.update(change);
            followed->update(embree, change);
            const auto made = demo::make_visibility(algorithm.name, embree, options);
            CHECK(picture(embree, *followed).pixels == picture(embree, *made).pixels);
        }
    }
}

TEST_CASE("budgets change no picture, and at the next frame what went unused is forgotten") {
    for (const std::string algorithm : {"cache", "blur-cache", "linked", "lmm+map", "express+volume"}) {
        CAPTURE(algorithm);
        demo::Film film(moving_spheres());
        demo::EmbreeScene embree(film.scene(), demo::EmbreeScene::For::films);
        demo::VisibilityOptions options;
        options.settings.radius = film.scene().radius;
        options.settings.quality = 3.0f;
        options.settings.shadow_map_size = 64;
        options.cache.detail = 1;
        options.depth = demo::DepthSource::embree;
        const auto unbounded = demo::make_visibility(algorithm, embree, options);
        const demo::Image first = picture(embree, *unbounded);
        if (const auto cache = unbounded->cache())
            options.cache.memory_budget = cache->bytes - cache->bytes / 8;
        options.settings.memory_budget = 1;
        const auto bounded = demo::make_visibility(algorithm, embree, options);
        const auto kept = [&] {
            const auto cache = bounded->cache();
            return cache ? cache->records : bounded->mesh()->light_points;
        };
        const auto bytes = [&] {
            const auto cache = bounded->cache();
            return cache ? cache->bytes : bounded->mesh()->bytes;
        };
        CHECK(picture(embree, *bounded).pixels == first.pixels);
        bounded->begin_frame();
        CHECK(kept() > 0);
        CHECK(picture(embree, *bounded).pixels == first.pixels);
        const std::size_t most = bytes();
        for (const double time : {0.5, 2.0}) {
            const SceneChange change = film.go_to(time);
            embree.update(change);
            unbounded->update(embree, change);
            bounded->update(embree, change);
            bounded->begin_frame();
            CHECK(picture(embree, *bounded).pixels == picture(embree, *unbounded).pixels);
        }
        // Of a frame that asks for nothing all goes.
        bounded->begin_frame();
        bounded->begin_frame();
        CHECK(kept() == 0);
        CHECK(bytes() < most);
        CHECK(picture(embree, *bounded).pixels == picture(embree, *unbounded).pixels);
    }
}

TEST_CASE("a budget of 1 MB is enough for a flight through the park, if barely, and values stay right") {
    demo::Film film(demo::load_animated("park"), {.objects = false, .lights = false, .camera = true});
    demo::EmbreeScene scene(film.scene(), demo::EmbreeScene::For::films);
    std::vector<lightmesh::Light> lamps;
    for (const demo::SceneLight& light : film.scene().lights)
        lamps.push_back(light.shape);
    lamps.resize(16);
    constexpr std::size_t budget = 1'000'000;
    const auto fly = [&](auto& bounded, const auto& unbounded) {
        std::vector<float> values(lamps.size());
        std::vector<float> expected(lamps.size());
        std::size_t differing = 0;
        for (int frame = 0; frame < 4; ++frame) {
            film.go_to(frame);
            bounded.begin_frame();
            for (const lightmesh::SurfacePoint& point : seen_points(scene)) {
                bounded.visibility(point, values);
                unbounded.visibility(point, expected);
                differing += values != expected ? 1u : 0u;
            }
        }
        CHECK(differing == 0);
        CHECK(unbounded.statistics().bytes > 2 * budget);
    };
    lightmesh::Settings settings{.radius = film.scene().radius};
    const lightmesh::LightMesh mesh(scene.intersector(), lamps, settings);
    settings.memory_budget = budget;
    lightmesh::LightMesh bounded_mesh(scene.intersector(), lamps, settings);
    fly(bounded_mesh, mesh);
    // Within a frame the mesh takes what it needs.
    film.go_to(10.0);
    bounded_mesh.begin_frame();
    bounded_mesh.begin_frame();
    CHECK(bounded_mesh.statistics().bytes < budget + 1'000'000);

    lightmesh::CacheSettings cache_settings{.spacing = 0.25f * film.scene().radius, .lamp_rays = 4};
    const lightmesh::VisibilityCache cache(scene.intersector(), lamps, cache_settings);
    cache_settings.memory_budget = budget;
    lightmesh::VisibilityCache bounded_cache(scene.intersector(), lamps, cache_settings);
    fly(bounded_cache, cache);
    CHECK(bounded_cache.statistics().bytes < budget + 1'000'000);
}

TEST_CASE("algorithms follow lights alone, masks of holes, and maps by Vulkan") {
    for (const std::string algorithm : {"lmm+volume", "shadow-volume", "lmm+map", "shadow-map", "cache"}) {
        CAPTURE(algorithm);
        demo::Film film(moving_mask());
        demo::EmbreeScene embree(film.scene(), demo::EmbreeScene::For::films);
        demo::VisibilityOptions options;
        options.settings.shadow_map_size = 64;
        options.cache.detail = 1;
        const auto followed = demo::make_visibility(algorithm, embree, options);
        picture(embree, *followed);
        const SceneChange change = film.go_to(1.0);
        embree.update(change);
        followed->update(embree, change);
        const auto made = demo::make_visibility(algorithm, embree, options);
        CHECK(picture(embree, *followed).pixels == picture(embree, *made).pixels);
    }
    demo::Moving lights;
    lights.objects = false;
    for (const std::string algorithm : {"shadow-map", "area", "express"}) {
        CAPTURE(algorithm);
        demo::Film film(moving_spheres(), lights);
        demo::EmbreeScene embree(film.scene());
        demo::VisibilityOptions options;
        options.settings.radius = film.scene().radius;
        options.settings.shadow_map_size = 64;
        options.depth = demo::DepthSource::embree;
        const auto followed = demo::make_visibility(algorithm, embree, options);
        picture(embree, *followed);
        const SceneChange change = film.go_to(1.0);
        REQUIRE_FALSE(change.changes_triangles());
        embree.update(change);
        followed->update(embree, change);
        const auto made = demo::make_visibility(algorithm, embree, options);
        CHECK(picture(embree, *followed).pixels == picture(embree, *made).pixels);
    }
}

namespace {

/// A file of a triangle, a lamp, a camera and a triangle that shines, each of which an animation of 2 s moves
/// by (4, 0, 0); the first one is there once more, at rest.
std::filesystem::path animated_file(const test::TemporaryFolder& folder) {
    test::GltfFile file;
    const int keys = file.add("SCALAR", {0, 2});
    const int ways = file.add("VEC3", {0, 0, 0, 4, 0, 0});
    const int lamp_ways = file.add("VEC3", {0, 2, 3, 4, 2, 3});
    const int camera_ways = file.add("VEC3", {0, 0, 9, 4, 0, 9});
    const int shrinks = file.add("VEC3", {0, 0, 0, 1, 1, 1});
    std::string channels;
    std::string samplers;
    const auto add = [&](int node, int values, const std::string& path) {
        const std::string comma = channels.empty() ? "" : ",";
        channels += comma + R"({"sampler":)" + std::to_string(node) + R"(,"target":{"node":)" +
                    std::to_string(node + 1) + R"(,"path":")" + path + R"("}})";
        samplers +=
            comma + R"({"input":)" + std::to_string(keys) + R"(,"output":)" + std::to_string(values) + "}";
    };
    add(0, ways, "translation");
    add(1, lamp_ways, "translation");
    add(2, camera_ways, "translation");
    add(3, ways, "translation");
    add(4, shrinks, "scale");
    return file.write(folder,
                      R"("nodes":[{"children":[1,2,3,4,5],"mesh":0},{"mesh":0},
            {"extensions":{"KHR_lights_punctual":{"light":0}}},{"camera":0},{"mesh":1},{"mesh":0}],
           "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]},
                     {"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
           "materials":[{"emissiveFactor":[1,1,1],"extensions":{"KHR_materials_emissive_strength":
                        {"emissiveStrength":5}}}],
           "cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":0.1}}],
           "extensionsUsed":["KHR_lights_punctual","KHR_materials_emissive_strength"],
           "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":50}]}},
           "animations":[{"name":"all","channels":[)" +
                          channels + R"(],"samplers":[)" + samplers + "]}]");
}

}  // namespace

TEST_CASE("glTF films: nodes, lamps, cameras and surfaces that shine move, and the rest stands still") {
    const test::TemporaryFolder folder;
    demo::SceneOptions options;
    options.scene = animated_file(folder).string();
    demo::Film film = demo::open_film(options);
    const demo::Scene first = film.scene();
    CHECK(film.length() == doctest::Approx(2.0));
    REQUIRE(first.triangles.size() == 4);  // also the one that has no area at 0 s
    REQUIRE(first.lights.size() >= 2);
    const SceneChange change = film.go_to(1.0);
    const demo::Scene& now = film.scene();
    CHECK_FALSE(change.is_another_scene);
    CHECK(change.camera);
    CHECK(now.camera.eye == first.camera.eye + glm::vec3(2, 0, 0));
    CHECK(change.lights.size() == first.lights.size());
    for (std::size_t i = 0; i < first.lights.size(); ++i) {
        const auto place = [i](const demo::Scene& scene) {
            return std::visit(
                [](const auto& light) -> glm::vec3 {
                    if constexpr (requires { light.position; })
                        return light.position;
                    else
                        return glm::vec3(0);
                },
                scene.lights[i].shape);
        };
        CHECK(glm::distance(place(now), place(first) + glm::vec3(2, 0, 0)) < 1e-5f);
    }
    // The nodes come in their order, parents first: one at rest, two that move, one that grows.
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(now.positions[i] == first.positions[i]);
        CHECK(now.positions[3 + i] == first.positions[3 + i] + glm::vec3(2, 0, 0));
        CHECK(now.positions[6 + i] == first.positions[6 + i] + glm::vec3(2, 0, 0));
        CHECK(first.positions[9 + i] == glm::vec3(0));
    }
    CHECK(now.positions[10] == glm::vec3(0.5f, 0, 0));
    CHECK(now.normals[10] == glm::vec3(0, 0, 1));
    for (const lightmesh::Bounds& box : change.boxes)
        CHECK(box.high.x <= 3.0f);
    // To and fro: the same to the last bit.
    film.go_to(1.7);
    film.go_to(0.0);
    CHECK(film.scene().positions == first.positions);
    CHECK_FALSE(demo::difference(first, film.scene()).changes_shadows());
    CHECK(film.scene().camera.target == first.camera.target);
}

TEST_CASE("glTF films: a file without an animation, or that has gone, is named") {
    const test::TemporaryFolder folder;
    demo::SceneOptions options;
    options.scene = test::GltfFile()
                        .write(folder, R"("nodes":[{"mesh":0}],
                               "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}])")
                        .string();
    CHECK_THROWS_WITH_AS(
        demo::open_film(options),
        (options.scene + ": has no animation; films are of glTF files that have one").c_str(),
        std::runtime_error);
    options.scene = animated_file(folder).string();
    demo::Film film = demo::open_film(options);
    const std::vector<glm::vec3> positions = film.scene().positions;
    std::filesystem::remove(options.scene);
    CHECK_THROWS_AS(film.go_to(1.0), std::runtime_error);
    CHECK(film.scene().positions == positions);
}

}  // namespace film_test
