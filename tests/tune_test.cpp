// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/tune.hpp>

#include <doctest/doctest.h>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tune_test {

using lightmesh::ShortTest;
namespace tune = lightmesh::tune;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A floor with boxes, points on it and lights, as a user would hand them to the tuner.
struct World {
    std::vector<test::Triangle> triangles;
    std::vector<lightmesh::Light> lights;
    std::vector<glm::vec3> points;
    std::vector<glm::vec3> normals;

    explicit World(int point_count = 300) {
        test::Random random(5);
        triangles = test::boxes_on_floor(random, 4);
        lights = {lightmesh::PointLight{{1.0f, 2.0f, 3.5f}}, lightmesh::PointLight{{-3.0f, 0.0f, 2.5f}},
                  lightmesh::DirectionalLight{{0.4f, 0.2f, -1.0f}}};
        for (const test::SurfacePoint& p : test::surface_points(random, triangles, point_count)) {
            points.push_back(p.position);
            normals.push_back(p.normal);
        }
    }
    test::PlainTracer tracer() const { return {&triangles}; }
    tune::Samples samples() const { return {points, normals, 100 * points.size()}; }
    tune::Subject<test::PlainTracer> subject() const { return {tracer(), lights, samples()}; }
};

/// Quick: few points, one pass.
tune::Options quick_options() {
    tune::Options options;
    options.reference_points = 12;
    options.least_seconds = 0.0;
    return options;
}

/// Distances by brute force: every triangle against every ray.
struct PlainRenderer {
    const std::vector<test::Triangle>* triangles;

    void render_depth(const lightmesh::DepthView& view, std::span<float> distance) {
        for (int row = 0; row < view.resolution; ++row)
            for (int column = 0; column < view.resolution; ++column)
                distance[static_cast<std::size_t>(row * view.resolution + column)] =
                    cast(view.ray(column, row));
    }
    lightmesh::Bounds bounds() const { return {glm::vec3(-6.0f), glm::vec3(6.0f)}; }

private:
    float cast(const lightmesh::DepthRay& ray) const {
        double reach = 64.0;
        const test::Vec origin(ray.origin);
        const test::Vec direction(ray.direction);
        if (!test::blocked(origin, origin + reach * direction, *triangles))
            return std::numeric_limits<float>::infinity();
        double open = 0.0;
        while (reach - open > 1e-3) {
            const double middle = 0.5 * (open + reach);
            (test::blocked(origin, origin + middle * direction, *triangles) ? reach : open) = middle;
        }
        return static_cast<float>(reach);
    }
};

struct PlainOccluders {
    const std::vector<test::Triangle>* triangles;

    std::size_t triangle_count() const { return triangles->size(); }
    std::array<glm::vec3, 3> triangle(std::size_t i) const {
        const test::Triangle& t = (*triangles)[i];
        return {glm::vec3(t.a), glm::vec3(t.b), glm::vec3(t.c)};
    }
};

tune::Measurement made_up(float quality, double ns, double error, double bytes, float radius = 1.0f) {
    tune::Measurement m;
    m.candidate.radius = radius;
    m.candidate.quality = quality;
    m.points = 100;
    m.points_per_frame = 1000;
    m.frame.cold_seconds = 2e-9 * ns * 1000.0;
    m.frame.warm_seconds = 1e-9 * ns * 1000.0;
    m.frame.bytes = bytes;
    m.mean_absolute_error = error;
    return m;
}

/// An eighth of the points of a frame, and all of them to count at.
tune::Samples part_of_frame(const World& world) {
    const std::size_t few = world.points.size() / 8 / 64 * 64 + 64;
    tune::Samples samples{std::span(world.points).first(few), std::span(world.normals).first(few)};
    samples.frame_points = world.points;
    samples.frame_normals = world.normals;
    return samples;
}

}  // namespace

TEST_CASE("tune: a grid of candidates has every combination, and maps only their sizes") {
    tune::Choices choices{.radii = {1.0f, 2.0f}};
    choices.qualities = {2.0f, 4.0f, 6.0f};
    choices.short_tests = {ShortTest::none, ShortTest::linked};
    choices.long_tests = {tune::LongTest::rays, tune::LongTest::shadow_maps};
    choices.shadow_map_sizes = {256, 512};
    const auto candidates = tune::make_candidates(choices);
    CHECK(candidates.size() == 2 * 3 * 2 * 3);
    for (const tune::Candidate& c : candidates) {
        CHECK((c.shadow_map_size != 0) == (c.long_test == tune::LongTest::shadow_maps));
        CHECK(std::count(candidates.begin(), candidates.end(), c) == 1);
    }
}

TEST_CASE("tune: caches follow the meshes, every combination of their own settings") {
    tune::Choices choices{.radii = {1.0f}, .qualities = {2.0f}};
    choices.short_tests = {ShortTest::linked};
    choices.spacings = {0.5f, 0.25f};
    choices.details = {0, 3};
    choices.lamp_rays = {16, 64};
    choices.shaft_rows = {false, true};
    const auto candidates = tune::make_candidates(choices);
    REQUIRE(candidates.size() == 1 + 2 * 2 * 2 * 2);
    CHECK_FALSE(tune::is_cache(candidates.front()));
    CHECK(tune::radius_of(candidates.front()) == 1.0f);
    for (std::size_t i = 1; i < candidates.size(); ++i) {
        CHECK(tune::is_cache(candidates[i]));
        CHECK(tune::radius_of(candidates[i]) == 0.0f);
        CHECK(std::count(candidates.begin(), candidates.end(), candidates[i]) == 1);
    }
    const tune::Candidate& last = candidates.back();
    CHECK(tune::describe(last) == "cache, g 0.25, detail 3, 64 lamp rays");
    CHECK(tune::to_source(last) ==
          "lightmesh::CacheSettings{.spacing = 0.25f, .detail = 3, .lamp_rays = 64}");
    const lightmesh::CacheSettings settings = tune::cache_settings_of(last);
    CHECK(settings.spacing == 0.25f);
    CHECK(settings.detail == 3);
    CHECK(settings.lamp_rays == 64);
    CHECK(settings.shaft_rows);
    const tune::Candidate& without = candidates[candidates.size() - 2];
    CHECK(tune::describe(without) == "cache, g 0.25, detail 3, 64 lamp rays, no shaft rows");
    CHECK(tune::to_source(without) == "lightmesh::CacheSettings{.spacing = 0.25f, .detail = 3, "
                                      ".lamp_rays = 64, .shaft_rows = false}");
    CHECK_FALSE(tune::cache_settings_of(without).shaft_rows);
    choices.shaft_rows = {true};
    CHECK(tune::make_candidates(choices).size() == 1 + 2 * 2 * 2);
    CHECK(tune::make_candidates({}).empty());
}

TEST_CASE("tune: candidates as text") {
    tune::Candidate c{3.0f, 4.0f, ShortTest::linked, tune::LongTest::rays, 0};
    CHECK(tune::describe(c) == "r 3, q 4, linked, rays");
    CHECK(tune::to_source(c) == "lightmesh::Settings{.radius = 3.0f, .quality = 4.0f, "
                                ".short_test = lightmesh::ShortTest::linked}");
    c.radius = 0.25f;
    c.long_test = tune::LongTest::refined_shadow_maps;
    c.shadow_map_size = 512;
    CHECK(tune::describe(c) == "r 0.25, q 4, linked, refined shadow maps 512");
    CHECK(tune::to_source(c) == "lightmesh::Settings{.radius = 0.25f, .quality = 4.0f, "
                                ".short_test = lightmesh::ShortTest::linked, .shadow_map_size = 512, "
                                ".refine_shadow_maps = true}");
    c.radius = 0.3f;
    CHECK(tune::describe(c).starts_with("r 0.3, "));
    c.radius = 1e20f;
    CHECK(tune::to_source(c).find(".radius = 1e+20f,") != std::string::npos);
}

TEST_CASE("tune: light points are predicted within a factor of 3, and bytes") {
    const World world(400);
    const auto subject = world.subject();
    tune::Choices choices{.radii = {0.5f, 1.5f}};
    const auto candidates = tune::make_candidates(choices);
    const tune::Forecast forecast = tune::predict(subject, candidates, quick_options());
    const tune::Outcome outcome = tune::run(subject, candidates, quick_options());
    REQUIRE(outcome.finished);
    REQUIRE(outcome.measurements.size() == candidates.size());
    REQUIRE(forecast.candidates.size() == candidates.size());
    CHECK(forecast.seconds > 0.0);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        const tune::Prediction& predicted = forecast.candidates[i];
        const tune::Measurement& m = outcome.measurements[i];
        CAPTURE(tune::describe(candidates[i]));
        CHECK(predicted.candidate == candidates[i]);
        CHECK(m.candidate == candidates[i]);
        CHECK(predicted.light_points < 3.0 * static_cast<double>(m.light_points));
        CHECK(predicted.light_points > static_cast<double>(m.light_points) / 3.0);
        CHECK(predicted.bytes < 3.0 * static_cast<double>(m.bytes));
        CHECK(predicted.bytes > static_cast<double>(m.bytes) / 3.0);
        CHECK(predicted.seconds > 0.0);
    }
}

TEST_CASE("tune: what is measured fits together") {
    const World world;
    const auto subject = world.subject();
    const auto candidates = tune::make_candidates({.radii = {1.0f}, .qualities = {2.0f, 4.0f}});
    const tune::Outcome outcome = tune::run(subject, candidates, quick_options());
    for (const tune::Measurement& m : outcome.measurements) {
        CAPTURE(tune::describe(m.candidate));
        CHECK(m.points == world.points.size());
        CHECK(m.cold_ns_per_point > 0.0);
        CHECK(m.warm_ns_per_point > 0.0);
        CHECK(m.light_points > 0);
        CHECK(m.bytes > 0);
        CHECK(m.long_rays > 0);
        CHECK(m.mean_absolute_error >= 0.0);
        CHECK(m.mean_absolute_error < (m.candidate.short_test == ShortTest::none ? 0.5 : 0.1));
        CHECK(m.rms_error >= m.mean_absolute_error);
        CHECK(m.reference.quality > 4.0f);
        CHECK(m.reference.converged == (m.reference.change < 0.001));
        CHECK((m.reference.converged || m.reference.quality == 16.0f));
        const bool links = m.candidate.short_test == ShortTest::linked;
        CHECK((m.link_rays > 0) == links);
        // A hundred times as many points on the same surfaces: more light points, but not as many times more.
        CHECK(m.frame.light_points >= static_cast<double>(m.light_points));
        CHECK(m.frame.light_points <= 101.0 * static_cast<double>(m.light_points));
        CHECK(m.frame.cold_seconds >= m.frame.warm_seconds);
    }
    const auto rays = [&](ShortTest short_test) {
        double sum = 0.0;
        for (const tune::Measurement& m : outcome.measurements)
            if (m.candidate.short_test == short_test)
                sum += m.short_rays_per_point;
        return sum;
    };
    CHECK(rays(ShortTest::none) < rays(ShortTest::linked));
    CHECK(rays(ShortTest::linked) < rays(ShortTest::exact));
}

TEST_CASE("tune: with all points of a frame its light points are counted") {
    const World world;
    tune::Samples samples = part_of_frame(world);
    const tune::Subject of_frame{world.tracer(), world.lights, samples};
    const tune::Subject of_all{world.tracer(), world.lights, tune::Samples{world.points, world.normals}};
    CHECK(of_frame.samples().points_per_frame == world.points.size());
    const std::array candidates{tune::Candidate{1.0f, 2.0f, ShortTest::none, tune::LongTest::rays, 0}};
    const auto estimated = tune::run(of_frame, candidates, quick_options()).measurements.front();
    const auto counted = tune::run(of_all, candidates, quick_options()).measurements.front();
    CHECK(estimated.light_points < counted.light_points);
    // Where samples agree whole bricks are known: a greater share of what few points touch than of a frame.
    CHECK(estimated.frame.light_points ==
          doctest::Approx(static_cast<double>(counted.light_points)).epsilon(0.1));

    samples.points_per_frame = 7;
    CHECK_THROWS_WITH_AS((tune::Subject{world.tracer(), world.lights, samples}),
                         doctest::Contains("points_per_frame is 7"), std::invalid_argument);
    samples.points_per_frame = 0;
    samples.frame_normals = {};
    CHECK_THROWS_WITH_AS((tune::Subject{world.tracer(), world.lights, samples}),
                         doctest::Contains("the span of frame normals has 0 places"), std::invalid_argument);
}

TEST_CASE("tune: the reference has no error to itself, and errors shrink with q") {
    const World world;
    const auto subject = world.subject();
    tune::Options options = quick_options();
    const auto exact = [](float quality) {
        return tune::Candidate{1.0f, quality, ShortTest::exact, tune::LongTest::rays, 0};
    };
    const std::array candidates{exact(2.0f), exact(6.0f), exact(16.0f)};
    options.reference_change = 1e-9;
    options.reference_points = 100;
    const auto results = tune::run(subject, candidates, options).measurements;
    REQUIRE(results.size() == 3);
    CHECK(results[2].reference.quality == 16.0f);
    CHECK_FALSE(results[2].reference.converged);
    CHECK(results[2].reference.change > 0.0);
    CHECK(results[2].mean_absolute_error == 0.0);
    CHECK(results[2].rms_error == 0.0);
    CHECK(results[1].mean_absolute_error > 0.0);
    CHECK(results[0].mean_absolute_error > results[1].mean_absolute_error);
}

TEST_CASE("tune: everything but times is the same in every run, on any number of threads") {
    const World world(150);
    const auto subject = world.subject();
    const auto candidates = tune::make_candidates({.radii = {1.0f}, .qualities = {3.0f}});
    tune::Options backwards = quick_options();
    backwards.executor.threads = 3;
    backwards.executor.for_each = [](std::size_t count, const std::function<void(std::size_t)>& work) {
        for (std::size_t i = count; i > 0; --i)
            work(i - 1);
    };
    const auto a = tune::run(subject, candidates, quick_options()).measurements;
    const auto b = tune::run(subject, candidates, backwards).measurements;
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CHECK(a[i].light_points == b[i].light_points);
        CHECK(a[i].bytes == b[i].bytes);
        CHECK(a[i].long_rays == b[i].long_rays);
        CHECK(a[i].short_rays_per_point == b[i].short_rays_per_point);
        CHECK(a[i].mean_absolute_error == b[i].mean_absolute_error);
        CHECK(a[i].rms_error == b[i].rms_error);
        CHECK(a[i].frame.light_points == b[i].frame.light_points);
    }
}

TEST_CASE("tune: the reference of caches is the open share of a lamp") {
    // A half plane above the floor: its edge passes below the lamp's middle, so half of the lamp is open. A
    // point to one side sees all of it, one to the other none.
    std::vector<test::Triangle> triangles;
    test::add_quad(triangles, {0, -20, 2}, {20, 0, 0}, {0, 40, 0});
    const test::PlainTracer tracer{&triangles};
    const std::vector<glm::vec3> points{{0, 0, 0}, {-2, 0, 0}, {2, 0, 0}};
    const std::vector<glm::vec3> normals(points.size(), glm::vec3(0, 0, 1));
    const std::vector<lightmesh::Light> lamps{
        lightmesh::PointLight{.position = {0, 0, 4}, .radius = 0.5f},
        lightmesh::DirectionalLight{.direction = {0, 0, -1}, .angular_radius = 0.1f},
        lightmesh::RectLight{.position = {0, 0, 4}, .half_u = {0.5f, 0, 0}, .half_v = {0, -0.5f, 0}},
        lightmesh::PointLight{.position = {0.5f, 0, 4}}};
    const tune::Subject subject{tracer, lamps, tune::Samples{points, normals}};
    tune::detail::Reporter reporter({});
    const tune::detail::ErrorPoints at(subject, points.size());
    const tune::detail::LampReference reference(at, subject, tune::Options{}, reporter);
    const std::span<const float> open = reference.values();
    REQUIRE(open.size() == points.size() * lamps.size());
    for (std::size_t light = 0; light < 3; ++light) {
        CAPTURE(light);
        CHECK(open[light] == doctest::Approx(0.5).epsilon(0.04));
        CHECK(open[4 + light] == 1.0f);
        CHECK(open[8 + light] == 0.0f);
    }
    CHECK(open[3] == 0.0f);
    CHECK(open[7] == 1.0f);
    CHECK(open[11] == 0.0f);
    CHECK(reference.convergence().change < 0.02);
}

TEST_CASE("tune: caches are measured beside meshes, and are nearer to lamps") {
    World world;
    for (lightmesh::Light& light : world.lights)
        if (auto* lamp = std::get_if<lightmesh::PointLight>(&light))
            lamp->radius = 0.3f;
        else
            std::get<lightmesh::DirectionalLight>(light).angular_radius = 0.05f;
    const auto subject = world.subject();
    tune::Choices choices{.radii = {1.0f}, .qualities = {4.0f}};
    choices.short_tests = {ShortTest::linked};
    choices.spacings = {1.0f};
    choices.details = {0, 2};
    choices.lamp_rays = {64};
    choices.shaft_rows = {false, true};
    tune::Options options = quick_options();
    options.reference_points = 100;
    const auto candidates = tune::make_candidates(choices);
    const tune::Forecast forecast = tune::predict(subject, candidates, options);
    const auto results = tune::run(subject, candidates, options).measurements;
    REQUIRE(results.size() == 5);
    REQUIRE(forecast.candidates.size() == 5);
    const tune::Measurement& mesh = results[0];
    for (const std::size_t i : {1u, 2u, 3u, 4u}) {
        const tune::Measurement& cache = results[i];
        CAPTURE(tune::describe(cache.candidate));
        CHECK(cache.candidate == candidates[i]);
        CHECK(cache.warm_ns_per_point > 0.0);
        CHECK(cache.light_points > 0);
        CHECK(cache.bytes > 0);
        CHECK(cache.long_rays > 0);
        CHECK(cache.link_rays > 0);
        CHECK(cache.mean_absolute_error == cache.lamp_error);
        CHECK(cache.rms_error >= cache.mean_absolute_error);
        CHECK(cache.reference.quality == 0.0f);
        CHECK(cache.reference.change < 0.02);
        CHECK(cache.lamp_error < mesh.lamp_error);
        CHECK(cache.frame.light_points >= static_cast<double>(cache.light_points));
        CHECK(cache.frame.light_points <= 101.0 * static_cast<double>(cache.light_points));
        CHECK(cache.frame.cold_seconds >= cache.frame.warm_seconds);
        CHECK(forecast.candidates[i].light_points > static_cast<double>(cache.light_points) / 3.0);
        CHECK(forecast.candidates[i].light_points < 3.0 * static_cast<double>(cache.light_points));
        CHECK(forecast.candidates[i].seconds > 0.0);
    }
    for (const std::size_t i : {1u, 2u}) {
        CHECK(results[i + 2].lamp_error < results[i].lamp_error);
        CHECK(results[i + 2].long_rays > results[i].long_rays);
    }
    // Shaft rows look further around.
    CHECK(results[2].long_rays != results[1].long_rays);
    // To its own reference, which is as blurred, the mesh is far better than to lamps.
    CHECK(mesh.mean_absolute_error < 0.5 * mesh.lamp_error);
    const tune::Recommendation advice = tune::recommend(results, {.mean_absolute_error = 0.2});
    REQUIRE(advice.choice);
    CHECK(advice.reason.find(" rather than a ") != std::string::npos);
}

TEST_CASE("tune: with all points of a frame the records of a cache are counted") {
    const World world;
    tune::Samples samples = part_of_frame(world);
    const std::vector<float> footprints(world.points.size(), 0.1f);
    samples.footprints = std::span(footprints).first(samples.points.size());
    samples.frame_footprints = footprints;
    const tune::Subject of_frame{world.tracer(), world.lights, samples};
    const tune::Subject of_all{
        world.tracer(), world.lights,
        tune::Samples{.points = world.points, .normals = world.normals, .footprints = footprints}};
    const auto candidates = tune::make_candidates({.spacings = {0.5f}, .details = {2}, .lamp_rays = {16}});
    const auto estimated = tune::run(of_frame, candidates, quick_options()).measurements.front();
    const auto counted = tune::run(of_all, candidates, quick_options()).measurements.front();
    CHECK(estimated.light_points < counted.light_points);
    CHECK(estimated.frame.light_points ==
          doctest::Approx(static_cast<double>(counted.light_points)).epsilon(0.1));

    samples.footprints = std::span(footprints).first(3);
    CHECK_THROWS_WITH_AS((tune::Subject{world.tracer(), world.lights, samples}),
                         doctest::Contains("the size of Samples::footprints is 3"), std::invalid_argument);
}

TEST_CASE("tune: shadow maps, shadow volumes and their sources") {
    const World world(100);
    const tune::Subject subject{world.tracer(), world.lights, world.samples(),
                                PlainRenderer{&world.triangles}, PlainOccluders{&world.triangles}};
    tune::Choices choices{.radii = {1.0f}, .qualities = {3.0f}};
    choices.short_tests = {ShortTest::linked};
    choices.long_tests = {tune::LongTest::rays, tune::LongTest::shadow_maps,
                          tune::LongTest::refined_shadow_maps, tune::LongTest::shadow_volumes};
    choices.shadow_map_sizes = {64};
    const auto results = tune::run(subject, tune::make_candidates(choices), quick_options()).measurements;
    REQUIRE(results.size() == 4);
    CHECK(results[1].long_rays == 0);
    CHECK(results[1].bytes > results[0].bytes);
    CHECK(results[1].setup_seconds > results[0].setup_seconds);
    CHECK(results[2].long_rays > 0);
    CHECK(results[2].long_rays < results[0].long_rays);
    CHECK(results[2].mean_absolute_error <= results[1].mean_absolute_error);
    CHECK(results[3].long_rays == 0);
    CHECK(results[3].mean_absolute_error == doctest::Approx(results[0].mean_absolute_error).epsilon(0.05));
}

TEST_CASE("tune: a candidate without its source, or out of range, is refused before anything runs") {
    const World world(20);
    const auto subject = world.subject();
    bool called = false;
    const auto run = [&](const tune::Candidate& bad) {
        const std::array candidates{tune::Candidate{}, bad};
        tune::run(subject, candidates, quick_options(), {}, [&](const tune::Progress&) {
            called = true;
            return true;
        });
    };
    CHECK_THROWS_WITH_AS(run({1.0f, 4.0f, ShortTest::linked, tune::LongTest::shadow_maps, 512}),
                         "lightmesh: candidate (r 1, q 4, linked, shadow maps 512): it needs a DepthRenderer",
                         std::invalid_argument);
    CHECK_THROWS_AS(run({1.0f, 4.0f, ShortTest::linked, tune::LongTest::shadow_volumes, 0}),
                    std::invalid_argument);
    CHECK_THROWS_AS(run({0.0f, 4.0f, ShortTest::linked, tune::LongTest::rays, 0}), std::invalid_argument);
    CHECK_THROWS_AS(run({1.0f, 17.0f, ShortTest::linked, tune::LongTest::rays, 0}), std::invalid_argument);
    CHECK_THROWS_AS(run({1.0f, std::nanf(""), ShortTest::linked, tune::LongTest::rays, 0}),
                    std::invalid_argument);
    CHECK_THROWS_AS(run({1.0f, 4.0f, ShortTest::linked, tune::LongTest::rays, 64}), std::invalid_argument);
    CHECK_THROWS_AS(run({1e-7f, 4.0f, ShortTest::linked, tune::LongTest::rays, 0}), std::out_of_range);
    CHECK_THROWS_AS(run({.spacing = -1.0f, .detail = 3, .lamp_rays = 64}), std::invalid_argument);
    CHECK_THROWS_AS(run({.spacing = 1.0f, .detail = 7, .lamp_rays = 64}), std::invalid_argument);
    CHECK_THROWS_AS(run({.spacing = 1.0f, .detail = 3, .lamp_rays = 0}), std::invalid_argument);
    CHECK_THROWS_AS(run({.spacing = 1e-7f, .detail = 3, .lamp_rays = 64}), std::out_of_range);
    CHECK_FALSE(called);
}

TEST_CASE("tune: bad samples, lights and options are refused by name") {
    World world(20);
    CHECK_THROWS_WITH_AS(tune::Subject(world.tracer(), world.lights, tune::Samples{}),
                         "lightmesh: there are no sample points; tuning needs at least one",
                         std::invalid_argument);
    CHECK_THROWS_AS(
        tune::Subject(world.tracer(), world.lights,
                      tune::Samples{world.points, std::span<const glm::vec3>(world.normals).first(3)}),
        std::invalid_argument);
    CHECK_THROWS_AS(tune::Subject(world.tracer(), std::vector<lightmesh::Light>{}, world.samples()),
                    std::invalid_argument);
    CHECK_THROWS_AS(tune::Subject(world.tracer(),
                                  std::vector<lightmesh::Light>{lightmesh::DirectionalLight{glm::vec3(0.0f)}},
                                  world.samples()),
                    std::invalid_argument);
    tune::Options options;
    options.reference_points = 0;
    CHECK_THROWS_AS(tune::run(world.subject(), std::array{tune::Candidate{}}, options),
                    std::invalid_argument);
    options = {};
    options.reference_change = std::nan("");
    CHECK_THROWS_AS(tune::predict(world.subject(), std::array{tune::Candidate{}}, options),
                    std::invalid_argument);
    world.points[7].y = std::nanf("");
    CHECK_THROWS_AS(world.subject(), std::invalid_argument);
    world.points[7].y = std::numeric_limits<float>::infinity();
    CHECK_THROWS_AS(world.subject(), std::invalid_argument);
}

TEST_CASE("tune: a run can be cancelled, and what is there is kept and not measured again") {
    const World world(100);
    const auto subject = world.subject();
    auto candidates = tune::make_candidates({.radii = {1.0f, 2.0f}, .qualities = {2.0f, 3.0f}});
    const std::size_t unique = candidates.size();
    candidates.push_back(candidates.front());
    std::vector<tune::Candidate> shown;
    const auto stop_after = [&](std::size_t count) {
        shown.clear();
        return [&shown, count](const tune::Progress& progress) {
            if (progress.latest != nullptr)
                shown.push_back(progress.latest->candidate);
            return shown.size() < count;
        };
    };
    const tune::Outcome part = tune::run(subject, candidates, quick_options(), {}, stop_after(5));
    CHECK_FALSE(part.finished);
    CHECK(part.measurements.size() == 5);
    CHECK(shown.size() == 5);
    const std::vector<tune::Candidate> first = shown;

    const tune::Outcome all =
        tune::run(subject, candidates, quick_options(), part.measurements, stop_after(unique + 1));
    CHECK(all.finished);
    CHECK(all.measurements.size() == unique);
    CHECK(shown.size() == unique - 5);
    for (const tune::Candidate& candidate : shown)
        CHECK(std::find(first.begin(), first.end(), candidate) == first.end());
    for (std::size_t i = 0; i < 5; ++i)
        CHECK(all.measurements[i].warm_ns_per_point == part.measurements[i].warm_ns_per_point);

    const tune::Outcome again = tune::run(subject, candidates, quick_options(), all.measurements,
                                          [](const tune::Progress&) { return false; });
    CHECK(again.finished);

    const auto never = [](const tune::Progress&) {
        return false;
    };
    CHECK(tune::run(subject, candidates, quick_options(), {}, never).measurements.empty());
    CHECK_THROWS_AS(tune::predict(subject, candidates, quick_options(), never), std::runtime_error);
}

TEST_CASE("tune: the frontier holds what nothing beats, radius by radius") {
    const double nan = std::nan("");
    const std::vector<tune::Measurement> results{
        made_up(2, 10, 0.05, 100),       made_up(3, 20, 0.06, 100),        made_up(4, 30, 0.01, 100),
        made_up(5, 30, 0.01, 100),       made_up(6, nan, 0.001, 100),      made_up(7, 5, nan, 100),
        made_up(2, 100, 0.5, 100, 2.0f), made_up(3, 5, infinity, 1, 2.0f),
    };
    CHECK(tune::pareto_frontier(results) == std::vector<std::size_t>{0, 2, 6});
    CHECK(tune::pareto_frontier({}).empty());
}

TEST_CASE("tune: a recommendation keeps to the wishes") {
    const std::vector<tune::Measurement> results{
        made_up(2, 10, 0.05, 1e6),
        made_up(3, 20, 0.02, 2e6),
        made_up(4, 40, 0.008, 4e6),
        made_up(6, 90, 0.004, 9e6),
    };
    const auto quality = [&](const tune::Wishes& wishes) {
        const tune::Recommendation r = tune::recommend(results, wishes);
        CHECK_FALSE(r.reason.empty());
        return r.choice ? r.choice->candidate.quality : 0.0f;
    };
    SUBCASE("none: the best balance; nobody sees an error of less than 1/255") {
        CHECK(quality({}) == 4.0f);
        const std::vector<tune::Measurement> exact{made_up(4, 40, 0.003, 4e6), made_up(6, 45, 0.0001, 9e6)};
        CHECK(tune::recommend(exact, {}).choice->candidate.quality == 4.0f);
    }
    SUBCASE("time: the most exact; a first frame costs twice as much here") {
        CHECK(quality({.ns_per_point = 80.0}) == 4.0f);
        CHECK(quality({.ns_per_point = 80.0, .frame = tune::Frame::later}) == 4.0f);
        CHECK(quality({.ns_per_point = 79.0}) == 3.0f);
        CHECK(quality({.ns_per_point = 90.0, .frame = tune::Frame::later}) == 6.0f);
        CHECK(quality({.ns_per_point = 19.0}) == 0.0f);
    }
    SUBCASE("seconds a frame, shared by threads") {
        CHECK(quality({.seconds_per_frame = 80e-6}) == 4.0f);
        CHECK(quality({.seconds_per_frame = 80e-6, .threads = 4.0}) == 6.0f);
    }
    SUBCASE("error: the fastest") {
        CHECK(quality({.mean_absolute_error = 0.02}) == 3.0f);
        CHECK(quality({.mean_absolute_error = 0.001}) == 0.0f);
        CHECK(quality({.ns_per_point = 100.0, .mean_absolute_error = 0.02}) == 3.0f);
        CHECK(quality({.ns_per_point = 30.0, .mean_absolute_error = 0.02}) == 0.0f);
    }
    SUBCASE("memory") {
        CHECK(quality({.mean_absolute_error = 0.05, .bytes = 1e6}) == 2.0f);
        CHECK(quality({.ns_per_point = 1000.0, .bytes = 4e6}) == 4.0f);
        CHECK(quality({.bytes = 2e6}) == 3.0f);
        CHECK(quality({.bytes = 1e5}) == 0.0f);
    }
    SUBCASE("radius") {
        CHECK(quality({.radius = 1.0f}) == 4.0f);
        CHECK(quality({.radius = 2.0f}) == 0.0f);
    }
    SUBCASE("reasons") {
        CHECK(tune::recommend(results, {.bytes = 1e5}).reason ==
              "No candidate fits 0.1 MB; the nearest is r 1, q 2, linked, rays with 1 MB.");
        CHECK(tune::recommend({}, {}).reason == "There is no measured candidate to choose from.");
    }
    SUBCASE("what makes no sense") {
        CHECK_THROWS_AS(quality({.ns_per_point = std::nan("")}), std::invalid_argument);
        CHECK_THROWS_AS(quality({.seconds_per_frame = 0.0}), std::invalid_argument);
        CHECK_THROWS_AS(quality({.mean_absolute_error = -0.1}), std::invalid_argument);
        CHECK_THROWS_AS(quality({.bytes = -1.0}), std::invalid_argument);
        CHECK_THROWS_AS(quality({.threads = 0.0}), std::invalid_argument);
    }
}

TEST_CASE("tune: a recommendation chooses between mesh and cache by their errors to lamps") {
    const auto cache = [](float spacing, double ns, double error) {
        tune::Measurement m = made_up(0, ns, error, 1e6, 0.0f);
        m.candidate = {.radius = 0.0f, .quality = 0.0f, .spacing = spacing, .detail = 3, .lamp_rays = 64};
        m.lamp_error = error;
        return m;
    };
    tune::Measurement mesh = made_up(4, 40, 0.008, 1e6);
    mesh.lamp_error = 0.03;
    const std::vector<tune::Measurement> results{mesh, cache(0.5f, 20, 0.02), cache(0.25f, 60, 0.01)};
    const auto choice = [&](const tune::Wishes& wishes) {
        return tune::recommend(results, wishes);
    };
    SUBCASE("none: the less product of time and error to lamps") {
        CHECK(choice({}).choice->candidate.spacing == 0.5f);
        CHECK(choice({}).reason.ends_with(
            " Take a cache rather than a mesh: the best mesh (r 1, q 4, linked, rays) differs from lamps of "
            "their sizes by 3 %, this one by 2 %, in 0.5 times the time."));
        REQUIRE(choice({}).other);
        CHECK(choice({}).other->candidate == mesh.candidate);
        std::vector<tune::Measurement> dear{mesh, cache(0.5f, 400, 0.02)};
        const tune::Recommendation cheap = tune::recommend(dear, {});
        CHECK(cheap.choice->candidate.quality == 4.0f);
        CHECK(cheap.reason.ends_with(" Take a mesh rather than a cache: the best cache (cache, g 0.5, detail "
                                     "3, 64 lamp rays) differs from lamps of their sizes by 2 %, this one by "
                                     "3 %, in 0.1 times the time."));
        REQUIRE(cheap.other);
        CHECK(cheap.other->candidate.spacing == 0.5f);
    }
    SUBCASE("time: the nearer to lamps of those that are fast enough") {
        CHECK(choice({.ns_per_point = 125.0}).choice->candidate.spacing == 0.25f);
        CHECK(choice({.ns_per_point = 100.0}).choice->candidate.spacing == 0.5f);
    }
    SUBCASE("what only one of them can") {
        const tune::Recommendation exact = choice({.mean_absolute_error = 0.009});
        CHECK(exact.choice->candidate.quality == 4.0f);
        CHECK(exact.reason.ends_with(" No cache keeps within the limits."));
        CHECK_FALSE(exact.other);
        const tune::Recommendation fast = choice({.ns_per_point = 50.0});
        CHECK(fast.choice->candidate.spacing == 0.5f);
        CHECK(fast.reason.ends_with(" No mesh keeps within the limits."));
        CHECK_FALSE(choice({.ns_per_point = 1.0}).choice);
    }
    SUBCASE("a radius is for meshes") {
        const tune::Recommendation other = choice({.radius = 7.0f});
        CHECK(tune::is_cache(other.choice->candidate));
        CHECK(other.reason.find("rather than") == std::string::npos);
    }
    SUBCASE("caches have a frontier of their own") {
        CHECK(tune::pareto_frontier(results) == std::vector<std::size_t>{0, 1, 2});
    }
}

TEST_CASE("tune: what is not finite is never recommended") {
    const double nan = std::nan("");
    std::vector<tune::Measurement> results{made_up(2, nan, 0.0, 1.0), made_up(3, 1.0, nan, 1.0),
                                           made_up(4, 1.0, 0.0, nan), made_up(5, 1.0, infinity, 1.0)};
    CHECK_FALSE(tune::recommend(results, {}).choice);
    results.push_back(made_up(6, 100.0, 0.5, 1e9));
    REQUIRE(tune::recommend(results, {}).choice);
    CHECK(tune::recommend(results, {}).choice->candidate.quality == 6.0f);
}

TEST_CASE("tune: a radius is measured at 4,096 points, spread over the frame") {
    // Half a floor lies under a plate, at a height that tells the parts of the frame apart.
    std::vector<test::Triangle> triangles;
    test::add_quad(triangles, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
    test::add_quad(triangles, {-12, -12, 1}, {24, 0, 0}, {0, 12, 0});
    const test::PlainTracer tracer{&triangles};
    const auto frame = [](int side) {
        std::vector<glm::vec3> points;
        for (int row = 0; row < side; ++row)
            for (int column = 0; column < side; ++column)
                points.emplace_back(
                    20.0f * glm::vec2(static_cast<float>(column) + 0.5f, static_cast<float>(row) + 0.5f) /
                            static_cast<float>(side) -
                        10.0f,
                    0.0f);
        return points;
    };
    const std::vector<lightmesh::Light> lights{
        lightmesh::DirectionalLight{{0, 0, -1}},  // reaches all of them
        lightmesh::DirectionalLight{{0, 0, 1}},   // the other two none
        lightmesh::PointLight{.position = {0, 0, 5}, .range = 0.1f}};
    for (const int side : {200, 70, 10}) {
        CAPTURE(side);
        const std::vector<glm::vec3> points = frame(side);
        const std::vector<glm::vec3> normals(points.size(), glm::vec3(0, 0, 1));
        const tune::RadiusAdvice advice =
            tune::suggest_radii(tune::Subject{tracer, lights, tune::Samples{points, normals}});
        const std::size_t wanted = side == 10 ? 100 : 4096;
        CHECK(advice.points >= wanted);
        CHECK(advice.points <= points.size());
        CHECK(advice.pairs >= wanted);
        CHECK(advice.pairs < 2 * wanted);
        CHECK(static_cast<double>(advice.shadowed) / static_cast<double>(advice.pairs) ==
              doctest::Approx(0.5).epsilon(0.02));
    }

    // Points that no light reaches are looked at, too, and nothing is measured twice for them.
    const std::vector<glm::vec3> points = frame(50);
    std::vector<glm::vec3> normals(points.size(), glm::vec3(0, 0, 1));
    for (std::size_t i = 0; i < points.size(); i += 20)
        normals[i] = glm::vec3(0, 0, -1);
    const std::vector<lightmesh::Light> suns(64, lightmesh::DirectionalLight{{0, 0, -1}});
    const tune::RadiusAdvice advice =
        tune::suggest_radii(tune::Subject{tracer, suns, tune::Samples{points, normals}});
    CHECK(advice.points == points.size());
    CHECK(advice.pairs >= 4096);
    CHECK(advice.pairs < 2 * 4096);
}

TEST_CASE("tune: the suggested radius is that of the penumbra") {
    // A floor of 20 x 20, and above it a plate that shades the middle: d = 1, D = 3.
    std::vector<test::Triangle> triangles;
    test::add_quad(triangles, {-10, -10, 0}, {20, 0, 0}, {0, 20, 0});
    test::add_quad(triangles, {-5, -5, 1}, {10, 0, 0}, {0, 10, 0});
    const test::PlainTracer tracer{&triangles};
    std::vector<glm::vec3> points{{-10, -10, 0}, {10, 10, 0}};  // in the light: the size of the scene
    for (int i = 0; i < 20; ++i)
        points.emplace_back(0.01f * static_cast<float>(i) - 0.1f, 0.0f, 0.0f);
    const std::vector<glm::vec3> normals(points.size(), glm::vec3(0, 0, 1));
    const tune::Samples samples{points, normals};

    const std::vector<lightmesh::Light> lamp{lightmesh::PointLight{{0, 0, 4}}};
    const tune::Subject by_lamp{tracer, lamp, samples};
    const tune::RadiusAdvice soft = tune::suggest_radii(by_lamp, 0.3);
    CHECK(soft.shadowed == 20);
    CHECK(soft.pairs == 22);
    CHECK(soft.points == 22);
    CHECK(soft.penumbra_width == doctest::Approx(2.0 * 0.3 * 4.0 / 3.0).epsilon(0.01));
    CHECK(soft.radius == doctest::Approx(0.5));  // nearest to 0.4 in its series, which has 0.3 and 0.5
    CHECK(soft.radii.size() == 3);

    // With all points of a frame, those are looked at: samples that happen to lie in the light say nothing.
    const tune::Samples lit{.points = std::span(points).first(2),
                            .normals = std::span(normals).first(2),
                            .frame_points = points,
                            .frame_normals = normals};
    CHECK(tune::suggest_radii(tune::Subject{tracer, lamp, lit}, 0.3).shadowed == 20);

    const std::vector<lightmesh::Light> sun{lightmesh::DirectionalLight{{0, 0, -1}}};
    const tune::Subject by_sun{tracer, sun, samples};
    CHECK(tune::suggest_radii(by_sun, 0.3).penumbra_width == doctest::Approx(2.0 * 0.3).epsilon(0.01));

    const std::vector<lightmesh::Light> outside{lightmesh::PointLight{{100, 0, 0.5f}}};
    const tune::Subject unshaded{tracer, outside, samples};
    CHECK(tune::suggest_radii(unshaded).shadowed == 0);
    CHECK(tune::suggest_radii(unshaded).radius == doctest::Approx(0.3));  // 28 / 100, rounded

    CHECK_THROWS_AS(tune::suggest_radii(by_lamp, 0.0), std::invalid_argument);
    CHECK_THROWS_AS(tune::suggest_radii(by_lamp, std::nan("")), std::invalid_argument);
    const tune::Subject one_point{tracer, lamp,
                                  tune::Samples{samples.points.first(1), samples.normals.first(1)}};
    CHECK_THROWS_AS(tune::suggest_radii(one_point), std::invalid_argument);
}

}  // namespace tune_test
