// SPDX-License-Identifier: MIT
#include "followed_upload.hpp"
#include "gpu/cache_queries.hpp"
#include "gpu/compute.hpp"
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "render/embree_scene.hpp"
#include "render/scene_cache.hpp"
#include "render/view.hpp"
#include "render/visibility.hpp"
#include "scene/scene.hpp"
#include "seen_points.hpp"
#include "watched_device.hpp"

#include <lightmesh/cache/lattice.hpp>
#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace gpu_cache_test {

/// These tests need a Vulkan driver (Mesa's lavapipe will do) and the validation layers, and fail without
/// them.

namespace {

/// A floor and a wall, boxes of any direction, a roof and facets of a cylinder; points on all of them.
class World {
public:
    World(std::uint32_t seed, const glm::vec3& middle) : random_(seed), middle_(middle) {
        add_quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0});
        add_quad({-4, 3.5f, 0}, {8, 0, 0}, {0, 0, 3});
        for (int i = 0; i < 3; ++i)
            add_box(vector(2.5f), i == 0 ? 0.0f : between(0.0f, 3.0f));
        // A roof at 45 degrees, and a fan of facets.
        add_quad({-3, -3, 1}, {0, 1.5f, 0}, {1.2f, 0, 1.2f});
        for (int i = 0; i < 8; ++i) {
            const auto corner = [&](int k) {
                return glm::vec3(1.5f * std::cos(0.35f * static_cast<float>(k)), -1.0f,
                                 1.5f * std::sin(0.35f * static_cast<float>(k)));
            };
            add_quad(corner(i), corner(i + 1) - corner(i), {0, 2, 0});
        }
    }

    test::HitTracer tracer() const { return {&triangles_}; }
    float between(float low, float high) {
        return low + (high - low) * static_cast<float>(random_()) * 0x1p-32f;
    }
    glm::vec3 vector(float size) {
        const float x = between(-size, size);
        const float y = between(-size, size);
        return {x, y, between(-size, size)};
    }
    glm::vec3 place(const glm::vec3& from_middle) const { return middle_ + from_middle; }
    std::uint32_t number(std::uint32_t below) { return static_cast<std::uint32_t>(random_()) % below; }

    /// Points on surfaces, some of them near to each other; `is_odd`: with all that may come with points.
    std::vector<lightmesh::SurfacePoint> points(std::size_t count, bool is_odd) {
        std::vector<lightmesh::SurfacePoint> points;
        while (points.size() < count) {
            const test::Triangle& triangle =
                triangles_[number(static_cast<std::uint32_t>(triangles_.size()))];
            const glm::vec3 a(triangle.a);
            const glm::vec3 u(triangle.b - triangle.a);
            const glm::vec3 v(triangle.c - triangle.a);
            float s = between(0, 1);
            float t = between(0, 1);
            if (s + t > 1.0f) {
                s = 1.0f - s;
                t = 1.0f - t;
            }
            lightmesh::SurfacePoint point;
            point.position = a + s * u + t * v;
            point.normal = glm::normalize(glm::cross(u, v));
            if (number(2) == 0)
                point.normal = -point.normal;
            if (is_odd)
                disturb(point);
            points.push_back(point);
        }
        return points;
    }

    std::vector<lightmesh::Light> lights(std::size_t count) {
        std::vector<lightmesh::Light> lights;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::vec3 at = place(glm::vec3(0, 0, 2) + vector(3));
            const float range = number(3) == 0 ? between(1, 6) : std::numeric_limits<float>::infinity();
            switch (number(8)) {
            case 0:
                lights.push_back(lightmesh::DirectionalLight{vector(1), number(2) == 0 ? 0.0f : 0.1f});
                break;
            case 1:
            case 2:
                lights.push_back(
                    lightmesh::SpotLight{at, vector(1), between(0.1f, 3.1f), range, between(0, 0.2f)});
                break;
            case 3:
                lights.push_back(lightmesh::RectLight{at, vector(1), vector(1), range});
                break;
            case 4:
                lights.push_back(lightmesh::PointLight{at, number(2) == 0 ? 0.0f : range, 0.0f});
                break;
            default:
                lights.push_back(lightmesh::PointLight{at, range, between(0, 0.5f)});
            }
        }
        return lights;
    }

private:
    void disturb(lightmesh::SurfacePoint& point) {
        switch (number(8)) {
        case 0:
            point.footprint = between(0, 2);
            break;
        case 1:
            point.shading_normal = between(0.1f, 4.0f) * (point.normal + vector(0.3f));
            break;
        case 2:
            point.normal *= between(0.01f, 100.0f);
            break;
        case 3:
            point.normal = glm::normalize(point.normal + vector(0.4f));
            break;
        case 4:
            point.position += vector(0.3f);
            break;
        case 5:
            point.normal = vector(1);
            point.footprint = 0.25f * between(1.0f, 1.16f);
            break;
        default:
            break;
        }
        switch (number(200)) {
        case 0:
            point.normal = glm::vec3(0.0f);
            break;
        case 1:
            point.position.y = std::numeric_limits<float>::quiet_NaN();
            break;
        case 2:
            point.normal.x = std::numeric_limits<float>::infinity();
            break;
        case 3:
            point.shading_normal.z = std::numeric_limits<float>::quiet_NaN();
            break;
        case 4:
            point.footprint = std::numeric_limits<float>::quiet_NaN();
            break;
        case 5:
            point.footprint = std::numeric_limits<float>::infinity();
            break;
        default:
            break;
        }
    }

    void add_quad(const glm::vec3& at, const glm::vec3& u, const glm::vec3& v) {
        const std::array corners{test::Vec(place(at)), test::Vec(place(at + u)), test::Vec(place(at + u + v)),
                                 test::Vec(place(at + v))};
        triangles_.push_back({corners[0], corners[1], corners[2]});
        triangles_.push_back({corners[0], corners[2], corners[3]});
    }
    void add_box(const glm::vec3& at, float angle) {
        const float size = between(0.3f, 0.8f);
        const glm::vec3 u = size * glm::vec3(std::cos(angle), std::sin(angle), 0.2f * angle);
        const glm::vec3 v = size * glm::vec3(-std::sin(angle), std::cos(angle), 0);
        const glm::vec3 w(0, 0, size);
        for (const auto& [a, b, c] : {std::array{u, v, w}, std::array{v, w, u}, std::array{w, u, v}}) {
            add_quad(at, a, b);
            add_quad(at + c, a, b);
        }
    }

    std::mt19937 random_;
    glm::vec3 middle_;
    std::vector<test::Triangle> triangles_;
};

bool same_bits(float a, float b) {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

/// What a snapshot knows without rays from points to lamps.
template <class Tracer>
class KnownStore : public lightmesh::detail::FrozenCacheStore<Tracer> {
public:
    using lightmesh::detail::FrozenCacheStore<Tracer>::FrozenCacheStore;

    template <class... Arguments>
    void exact(const Arguments&...) const {
        throw lightmesh::detail::NotInCacheSnapshot();
    }
    template <class... Arguments>
    void stand_in(const Arguments&...) const {
        throw lightmesh::detail::NotInCacheSnapshot();
    }
};

struct Differences {
    std::size_t values = 0;  ///< known on both sides, and not the same
    std::size_t known = 0;   ///< known on one side only
    std::size_t compared = 0;
    std::size_t penumbrae = 0;  ///< of those, neither 0 nor 1
    std::size_t unknown = 0;

    Differences& operator+=(const Differences& other) {
        values += other.values;
        known += other.known;
        compared += other.compared;
        penumbrae += other.penumbrae;
        unknown += other.unknown;
        return *this;
    }
};

/// The answers of shaders against those of the CPU.
template <class Tracer>
Differences compare(std::span<const std::byte> bytes, const Tracer& tracer,
                    std::span<const lightmesh::SurfacePoint> points, std::span<const float> values) {
    Differences found;
    const lightmesh::detail::CacheReader reader(bytes);
    const KnownStore<Tracer> store(tracer, reader);
    lightmesh::detail::CacheQuery query(store);
    const std::size_t count = reader.lamps().size();
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t l = 0; l < count; ++l) {
            float expected = std::numeric_limits<float>::quiet_NaN();
            try {
                expected = query.one(points[i], l);
            } catch (const lightmesh::detail::NotInCacheSnapshot&) {
            }
            const float value = values[i * count + l];
            found.unknown += std::isnan(value) ? 1u : 0u;
            if (std::isnan(expected) || std::isnan(value)) {
                found.known += std::isnan(expected) != std::isnan(value) ? 1u : 0u;
                continue;
            }
            ++found.compared;
            found.values += same_bits(value, expected) ? 0u : 1u;
            found.penumbrae += value > 0.0f && value < 1.0f ? 1u : 0u;
        }
    return found;
}

/// A device that is watched, and queries of it.
struct Gpu : test::WatchedDevice {
    demo::CacheQueries queries{device};
};

/// Kept, as drivers take their time to compile shaders.
Gpu& the_gpu() {
    static Gpu gpu;
    return gpu;
}

std::vector<lightmesh::SurfacePoint> points_of(std::span<const lightmesh::CacheRequest> requests) {
    std::vector<lightmesh::SurfacePoint> points;
    for (const lightmesh::CacheRequest& request : requests)
        points.push_back(request.point);
    return points;
}

/// Asks for points of which a part was filled; has the rest filled as shaders ask for it.
template <class Tracer, class Cache>
Differences ask_and_fill(Gpu& gpu, const Tracer& tracer, const Cache& cache,
                         std::span<const lightmesh::SurfacePoint> points) {
    const auto trace = demo::trace_by(tracer);
    cache.fill(points.first(points.size() / 2));
    auto bytes = cache.snapshot();
    gpu.queries.upload(bytes);
    auto answer = gpu.queries.ask(points, trace);
    Differences found = compare(bytes, tracer, points, answer.values);
    CHECK(answer.points_without_rays == 0);
    CHECK(answer.asked == answer.requests.size());

    // Each point that is not wholly known has asked, but those that cannot be.
    std::vector<char> has_asked(points.size());
    for (const lightmesh::CacheRequest& request : answer.requests) {
        has_asked[request.id] = 1;
        const lightmesh::SurfacePoint& point = points[request.id];
        CHECK(request.point.position == point.position);
        CHECK(request.point.normal == point.normal);
        CHECK((request.lacks_values || request.lacks_rays));
    }
    std::size_t silent = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto row = std::span(answer.values).subspan(i * cache.light_count(), cache.light_count());
        const bool is_known = std::ranges::none_of(row, [](float value) { return std::isnan(value); });
        const bool is_finite = lightmesh::detail::is_finite(points[i].position) &&
                               lightmesh::detail::is_finite(points[i].normal);
        silent += is_known == (has_asked[i] != 0) && (is_finite || has_asked[i] != 0) ? 1u : 0u;
    }
    CHECK(silent == 0);

    cache.fill(points_of(answer.requests));
    bytes = cache.snapshot();
    gpu.queries.upload(bytes);
    answer = gpu.queries.ask(points, trace);
    found += compare(bytes, tracer, points, answer.values);
    for (const lightmesh::CacheRequest& request : answer.requests)
        CHECK(!request.lacks_values);
    // What is left takes rays from the point itself: those the cache traces. The rest is what it says.
    std::vector<float> all(cache.light_count());
    for (std::size_t i = 0; i < points.size(); ++i) {
        cache.visibility(points[i], all);
        for (std::size_t l = 0; l < all.size(); ++l) {
            const float value = answer.values[i * all.size() + l];
            found.values += std::isnan(value) || same_bits(value, all[l]) ? 0u : 1u;
        }
    }
    return found;
}

}  // namespace

TEST_CASE("shaders answer from a cache's snapshot what the CPU does, bit by bit, and ask for the rest") {
    Gpu& gpu = the_gpu();
    Differences sum;
    const auto run = [&](std::uint32_t seed, std::size_t lights, std::size_t points, const glm::vec3& middle,
                         const lightmesh::CacheSettings& settings) {
        CAPTURE(seed);
        World world(seed, middle);
        const lightmesh::VisibilityCache cache{world.tracer(), world.lights(lights), settings};
        const Differences found = ask_and_fill(gpu, world.tracer(), cache, world.points(points, true));
        CHECK(found.values == 0);
        CHECK(found.known == 0);
        sum += found;
    };
    const lightmesh::CacheSettings coarse{.spacing = 0.25f, .detail = 2, .lamp_rays = 4, .shaft_rows = false};
    for (const std::uint32_t lights : {0u, 1u, 63u, 64u, 65u})
        run(lights, lights, 120, glm::vec3(0.0f), coarse);
    run(256, 256, 40, glm::vec3(0.0f), coarse);
    run(1024, 1024, 12, glm::vec3(0.0f), coarse);
    run(10, 8, 120, {100'000.0f, -300'000.0f, 20'000.0f}, coarse);
    run(11, 8, 120, {1.0f, 2.0f, 3.0f},
        {.spacing = 0.5f, .detail = 3, .lamp_rays = 2, .origin = glm::vec3(0.0f), .exact_edges = true});
    run(12, 8, 120, glm::vec3(0.0f), {.spacing = 0.3f, .detail = 0, .lamp_rays = 16});
    lightmesh::CacheSettings with_shafts = coarse;
    with_shafts.shaft_rows = true;
    run(13, 65, 120, glm::vec3(0.0f), with_shafts);
    run(14, 8, 120, {100'000.0f, -300'000.0f, 20'000.0f}, with_shafts);
    with_shafts.detail = 1;
    with_shafts.exact_edges = true;
    run(15, 8, 120, {1.0f, 2.0f, 3.0f}, with_shafts);
    MESSAGE("" << sum.compared << " values, " << sum.penumbrae << " in penumbrae; " << sum.unknown
               << " not known");
    CHECK(sum.compared > 40'000);
    CHECK(sum.penumbrae > 1'000);
    CHECK(gpu.messages.empty());
}

TEST_CASE("shaders end their rays at lattice points where the CPU has those") {
    Gpu& gpu = the_gpu();
    for (const float spacing : {0.3f, 0.7f}) {
        CAPTURE(spacing);
        World world(9, glm::vec3(0.0f));
        const lightmesh::CacheSettings settings{
            .spacing = spacing, .detail = 2, .lamp_rays = 2, .shaft_rows = false};
        const lightmesh::VisibilityCache cache{world.tracer(), world.lights(8), settings};
        const auto points = world.points(300, true);
        cache.fill(points);
        gpu.queries.upload(cache.snapshot());
        std::vector<glm::vec3> ends;
        const auto trace = demo::trace_by(world.tracer());
        gpu.queries.ask(points, [&](auto segments, auto hit) {
            for (const lightmesh::Segment& segment : segments)
                ends.push_back(segment.target);
            trace(segments, hit);
        });
        const lightmesh::detail::Lattice lattice(settings);
        std::size_t elsewhere = 0;
        for (const glm::vec3& end : ends) {
            bool is_found = false;
            for (int level = 0; level < lightmesh::detail::Lattice::level_count; ++level)
                is_found |=
                    lattice.position(glm::ivec3(glm::round(lattice.locate(end, level))), level) == end;
            elsewhere += is_found ? 0u : 1u;
        }
        CHECK(ends.size() > 100);
        CHECK(elsewhere == 0);
    }
}

TEST_CASE("shaders answer from blur rows as well") {
    Gpu& gpu = the_gpu();
    World world(7, glm::vec3(0.0f));
    lightmesh::LightMesh mesh{world.tracer(), world.lights(20), {.radius = 1.0f, .quality = 2.0f}};
    const lightmesh::VisibilityCache cache{std::move(mesh),
                                           lightmesh::CacheSettings{.spacing = 0.5f, .detail = 1}};
    const Differences found = ask_and_fill(gpu, world.tracer(), cache, world.points(60, true));
    CHECK(found.values == 0);
    CHECK(found.known == 0);
    CHECK(found.penumbrae > 100);
    CHECK(gpu.messages.empty());
}

TEST_CASE("shaders answer at all points of small pictures, with shaft rows and without") {
    Gpu& gpu = the_gpu();
    for (const demo::Scene& scene : {demo::make_spheres(), demo::make_rooms()}) {
        const demo::EmbreeScene embree(scene);
        const auto points = test::seen_points(embree, 24);
        demo::VisibilityOptions options = demo::options_of(scene);
        for (const bool shaft_rows : {false, true}) {
            CAPTURE(scene.name);
            CAPTURE(shaft_rows);
            options.cache.shaft_rows = shaft_rows;
            const demo::SceneCache cache = demo::cache_of(embree, options);
            const Differences found = ask_and_fill(gpu, embree.intersector(), cache, points);
            CHECK(found.values == 0);
            CHECK(found.known == 0);
            CHECK(found.penumbrae > 100);
        }
    }
    CHECK(gpu.messages.empty());
}

TEST_CASE("shaders answer at all points of a small picture of the park, with the footprints of its pixels") {
    Gpu& gpu = the_gpu();
    const demo::Scene scene = demo::make_park();
    const demo::EmbreeScene embree(scene);
    constexpr int side = 12;
    auto points = test::seen_points(embree, side);
    const float pixel_angle = demo::View(scene.camera, side, side).pixel_angle();
    // Every other one, and those with a tenth of that: finer levels.
    for (std::size_t i = 0; i < points.size(); i += 2)
        points[i].footprint =
            (i % 4 == 0 ? 1.0f : 0.1f) * pixel_angle * glm::distance(points[i].position, scene.camera.eye);
    demo::VisibilityOptions options = demo::options_of(scene);
    options.cache.shaft_rows = false;
    const demo::SceneCache cache = demo::cache_of(embree, options);
    const Differences found = ask_and_fill(gpu, embree.intersector(), cache, points);
    CHECK(found.values == 0);
    CHECK(found.known == 0);
    CHECK(found.penumbrae > 100);
    CHECK(gpu.messages.empty());
}

TEST_CASE("an upload that follows fills and updates of a cache answers as a whole one, and writes little") {
    Gpu& gpu = the_gpu();
    World world(17, glm::vec3(0.0f));
    const auto tracer = world.tracer();
    lightmesh::VisibilityCache cache{
        tracer, world.lights(40),
        lightmesh::CacheSettings{.spacing = 0.25f, .detail = 2, .lamp_rays = 4, .shaft_rows = false}};
    const std::vector<lightmesh::SurfacePoint> points = world.points(160, true);
    const auto some = std::span<const lightmesh::SurfacePoint>(points);
    cache.fill(some.first(101));
    const std::vector<std::byte> first_bytes = cache.snapshot();
    lightmesh::CacheUpload upload{lightmesh::SnapshotView(first_bytes)};
    test::FollowedUpload host(upload);
    demo::CacheQueries followed(gpu.device);
    followed.upload(first_bytes);
    const auto check = [&] {
        const std::vector<std::byte> bytes = cache.snapshot();
        const std::size_t written = host.write(upload, upload.update(lightmesh::SnapshotView(bytes)));
        CHECK(host.equals(upload));
        CHECK(followed.upload(bytes) == written);
        const auto answer = followed.ask(points, demo::trace_by(tracer));
        const Differences found = compare(bytes, tracer, points, answer.values);
        CHECK(found.values == 0);
        CHECK(found.known == 0);
        CHECK(found.compared > 1000);
        return written;
    };
    CHECK(check() == 0);
    cache.fill(some.subspan(101, 1));
    CHECK(check() < host.size() / 4);
    cache.fill(some.subspan(102, 40));
    check();
    cache.set_light(3, lightmesh::PointLight{.position = {1.0f, 0.5f, 2.0f}, .range = 5.0f, .radius = 0.1f});
    check();
    cache.fill(some);
    check();
    cache.scene_changed(lightmesh::Bounds{glm::vec3(-1.0f), glm::vec3(1.0f)});
    cache.remove_light(5);
    check();
    cache.fill(some);
    check();
    const std::size_t before = host.size();
    for (int i = 0; i < 50; ++i)
        cache.add_light(
            lightmesh::PointLight{.position = {0.1f * static_cast<float>(i), 1.0f, 2.0f}, .radius = 0.1f});
    check();
    cache.fill(some);
    check();
    CHECK(host.size() > before);
    // Hither and thither: what was freed is used again.
    const std::vector<std::byte> all = cache.snapshot();
    std::size_t size = 0;
    for (int i = 0; i < 4; ++i) {
        for (const auto& bytes : {first_bytes, all})
            host.write(upload, upload.update(lightmesh::SnapshotView(bytes)));
        CHECK((i == 0 || host.size() == size));
        size = host.size();
    }
    CHECK(host.equals(upload));

    demo::CacheQueries whole(gpu.device);
    whole.upload(all);
    const auto expected = whole.ask(points, demo::trace_by(tracer)).values;
    const auto found = followed.ask(points, demo::trace_by(tracer)).values;
    REQUIRE(found.size() == expected.size());
    CHECK(std::ranges::equal(found, expected, [](float a, float b) { return same_bits(a, b); }));
    CHECK(gpu.messages.empty());
}

TEST_CASE("request buffers that are too small say so, and snapshots that are broken reach no shader") {
    World world(3, glm::vec3(0.0f));
    const auto lights = world.lights(5);
    const lightmesh::VisibilityCache cache{world.tracer(), lights, lightmesh::CacheSettings{.spacing = 0.5f}};
    Gpu& gpu = the_gpu();
    const auto empty = cache.snapshot();
    gpu.queries.upload(empty);
    const auto points = world.points(64, false);
    const test::HitTracer tracer = world.tracer();
    const auto answer = gpu.queries.ask(points, demo::trace_by(tracer), false, 3);
    CHECK(answer.asked > 3);
    CHECK(answer.requests.size() == 3);

    cache.fill(points);
    auto bytes = cache.snapshot();
    for (const std::size_t at : {std::size_t{9}, std::size_t{300}, bytes.size() / 2, bytes.size() - 1}) {
        bytes[at] ^= std::byte{4};
        CHECK_THROWS_AS(gpu.queries.upload(bytes), std::invalid_argument);
        bytes[at] ^= std::byte{4};
    }
    const lightmesh::LightMesh mesh{world.tracer(), lights, {.radius = 1.0f}};
    const auto of_mesh = mesh.snapshot();
    CHECK_THROWS_AS(gpu.queries.upload(of_mesh), std::invalid_argument);
    // What was there before still is.
    CHECK(gpu.queries.ask(points, demo::trace_by(tracer), false, 3).asked == answer.asked);

    CHECK_THROWS_AS(lightmesh::CacheUpload::empty_requests(0), std::invalid_argument);
    CHECK_THROWS_AS(lightmesh::CacheUpload::empty_requests((std::size_t{1} << 26) + 1),
                    std::invalid_argument);
    const auto room = lightmesh::CacheUpload::empty_requests(2);
    CHECK(lightmesh::CacheUpload::requests(room).empty());
    CHECK_THROWS_AS(lightmesh::CacheUpload::requests(std::span(room).first(room.size() - 1)),
                    std::invalid_argument);
    CHECK_THROWS_AS(lightmesh::CacheUpload::request_count(std::span(room).first(8)), std::invalid_argument);
    CHECK(gpu.messages.empty());
}

}  // namespace gpu_cache_test
