// SPDX-License-Identifier: MIT
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"
#include "snapshot_bytes.hpp"

#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace cache_snapshot_test {

namespace {

using lightmesh::CacheSettings;
using lightmesh::SnapshotView;
using lightmesh::VisibilityCache;
using test::HitTracer;
using Cache = VisibilityCache<HitTracer>;
using test::Bytes;
using test::error_of;

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<lightmesh::SurfacePoint> points;
    CacheSettings settings{.spacing = 0.4f, .detail = 2, .lamp_rays = 16};

    explicit Work(int light_count, int point_count = 40) {
        test::Random random(17);
        scene = test::boxes_on_floor(random, 4);
        for (int i = 0; i < light_count; ++i)
            lights.push_back(lightmesh::PointLight{
                .position = glm::vec3(random.in_box({-4.0, -4.0, 2.0}, {4.0, 4.0, 4.5})), .radius = 0.4f});
        for (const test::SurfacePoint& point : test::surface_points(random, scene, point_count))
            points.push_back({.position = point.position, .normal = point.normal});
    }

    Cache cache() const { return Cache{HitTracer{&scene}, lights, settings}; }
    std::span<const lightmesh::SurfacePoint> part(std::size_t first, std::size_t last) const {
        return std::span(points).subspan(first, last - first);
    }
};

std::vector<float> ask(const auto& cache, const lightmesh::SurfacePoint& point) {
    std::vector<float> all(cache.light_count());
    cache.visibility(point, all);
    return all;
}

std::uint64_t rays_of(const auto& cache) {
    const lightmesh::CacheStatistics held = cache.statistics();
    return held.kept_rays();
}

void sign(Bytes& bytes) {
    test::sign<lightmesh::detail::CacheHeader>(bytes);
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("cache snapshot: with a tracer it equals the live cache, also where nobody asked before") {
    for (const int light_count : {1, 9, 70}) {
        const Work work(light_count);
        const Cache cache = work.cache();
        cache.fill(work.part(0, 30));
        const Bytes bytes = cache.snapshot();
        const SnapshotView view{std::span<const std::byte>(bytes)};
        CHECK(view.is_cache());
        CHECK(view.light_count() == work.lights.size());
        CHECK(view.cache_settings().spacing == work.settings.spacing);
        CHECK(view.cache_settings().detail == work.settings.detail);
        CHECK(std::isnan(view.cache_settings().origin.x));
        std::vector<float> all(work.lights.size());
        for (const lightmesh::SurfacePoint& point : work.points) {
            view.visibility(HitTracer{&work.scene}, point, all);
            CHECK(all == ask(cache, point));
        }
        CHECK(
            contains(error_of([&] { view.visibility(test::PlainTracer{&work.scene}, work.points[0], all); }),
                     "closest_hit"));
    }
}

TEST_CASE("cache snapshot: without a tracer it answers what needs none, and says what is missing") {
    const Work work(9, 60);
    const Cache cache = work.cache();
    cache.fill(work.part(0, 40));
    const Bytes bytes = cache.snapshot();
    const SnapshotView view{std::span<const std::byte>(bytes)};
    std::vector<float> all(work.lights.size());
    std::size_t answered = 0;
    std::size_t missing = 0;
    for (std::size_t i = 0; i < work.points.size(); ++i) {
        const std::vector<float> expected = ask(cache, work.points[i]);
        const std::size_t counted = view.visibility(work.points[i], all);
        std::size_t nan = 0;
        for (std::size_t l = 0; l < all.size(); ++l) {
            nan += std::isnan(all[l]) ? 1u : 0u;
            if (!std::isnan(all[l]))
                CHECK(all[l] == expected[l]);
        }
        CHECK(nan == counted);
        (i < 40 ? answered : missing) += i < 40 ? all.size() - nan : nan;
    }
    CHECK(answered > 40 * work.lights.size() / 2);
    CHECK(missing > 0);
    CHECK(view.visibility(glm::vec3(NAN, 0, 0), glm::vec3(0, 0, 1), all) == all.size());
}

TEST_CASE("cache snapshot: without a tracer, records that are missing in the air are missed, not read") {
    const Work work(9);
    const Cache cache = work.cache();
    cache.fill(work.points);
    const Bytes bytes = cache.snapshot();
    const SnapshotView view{std::span<const std::byte>(bytes)};
    std::vector<float> all(work.lights.size());
    std::size_t answered = 0;
    std::size_t missing = 0;
    for (const lightmesh::SurfacePoint& point : work.points)
        for (const float tilt : {0.3f, 0.5f, 0.7f}) {
            // The same records on surfaces, which fit the point less well.
            const glm::vec3& n = point.normal;
            const lightmesh::SurfacePoint tilted{
                .position = point.position, .normal = glm::normalize(n + tilt * glm::vec3(n.y, n.z, n.x))};
            missing += view.visibility(tilted, all);
            const std::vector<float> expected = ask(cache, tilted);
            for (std::size_t l = 0; l < all.size(); ++l)
                if (!std::isnan(all[l])) {
                    CHECK(all[l] == expected[l]);
                    ++answered;
                }
        }
    CHECK(answered > 0);
    CHECK(missing > 0);
}

TEST_CASE("cache snapshot: merged into an empty cache it restores all without a ray") {
    for (const int light_count : {9, 130}) {
        const Work work(light_count, 25);
        const Cache full = work.cache();
        full.fill(work.points);
        const Bytes bytes = full.snapshot();
        Cache restored = work.cache();
        restored.merge(bytes);
        CHECK(rays_of(restored) == 0);
        CHECK(restored.snapshot() == bytes);
        CHECK(restored.statistics().records == full.statistics().records);
        restored.fill(work.points);
        CHECK(rays_of(restored) == 0);
        for (const lightmesh::SurfacePoint& point : work.points)
            CHECK(ask(restored, point) == ask(full, point));
        Cache small{HitTracer{&work.scene}, work.lights, [&] {
                        CacheSettings settings = work.settings;
                        settings.memory_budget = 0;
                        return settings;
                    }()};
        small.merge(bytes);
        CHECK(small.statistics().records == 0);
    }
}

TEST_CASE("cache snapshot: the same bytes, whichever thread asked in what order") {
    const Work work(70);
    const Cache forwards = work.cache();
    forwards.fill(work.points);
    const Cache backwards = work.cache();
    {
        std::vector<std::jthread> threads;
        for (std::size_t t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                for (std::size_t i = work.points.size(); i-- > 0;)
                    (void)ask(backwards, work.points[(i + 10 * t) % work.points.size()]);
            });
    }
    CHECK(forwards.snapshot() == backwards.snapshot());
    // Two halves, merged.
    const Cache first = work.cache();
    first.fill(work.part(0, 20));
    Cache second = work.cache();
    second.fill(work.part(20, work.points.size()));
    second.merge(first.snapshot());
    CHECK(second.snapshot() == forwards.snapshot());
}

TEST_CASE("cache snapshot: may be taken while other threads query") {
    const Work work(9);
    const Cache cache = work.cache();
    std::vector<Bytes> taken;
    {
        const std::jthread other([&] { cache.fill(work.points); });
        for (int i = 0; i < 5; ++i)
            taken.push_back(cache.snapshot());
    }
    for (const Bytes& bytes : taken) {
        Cache merged = work.cache();
        merged.merge(bytes);
        for (const std::size_t i : {3u, 30u})
            CHECK(ask(merged, work.points[i]) == ask(cache, work.points[i]));
    }
}

TEST_CASE("cache snapshot: lights that differ, and what meets a changed box, contribute nothing") {
    Work work(12);
    const Cache full = work.cache();
    full.fill(work.points);
    const Bytes bytes = full.snapshot();
    Work other = work;
    std::get<lightmesh::PointLight>(other.lights[3]).position.x += 0.5f;
    std::get<lightmesh::PointLight>(other.lights[7]).radius = 0.1f;
    other.lights.resize(11);
    // A box that was not there.
    const lightmesh::Bounds changed{{-1.0f, -1.0f, 0.2f}, {-0.2f, 0.4f, 1.3f}};
    test::add_box(other.scene, test::Vec(changed.low), test::Vec(changed.high));
    Cache merged = other.cache();
    merged.merge(bytes, std::span(&changed, 1));
    const std::uint64_t none = rays_of(merged);
    CHECK(none == 0);
    const Cache fresh = other.cache();
    for (const lightmesh::SurfacePoint& point : other.points)
        CHECK(ask(merged, point) == ask(fresh, point));
    CHECK(rays_of(merged) < rays_of(fresh));
    CHECK(rays_of(merged) > 0);
    // Nobody says that the scene has changed: too much differs.
    Cache wrong = other.cache();
    wrong.fill(other.points);
    const Bytes before = wrong.snapshot();
    CHECK(contains(error_of([&] { wrong.merge(bytes); }), "not of the same scene"));
    CHECK(wrong.snapshot() == before);
}

TEST_CASE("cache snapshot: other caches are refused, with a reason") {
    const Work work(2, 10);
    const Cache cache = work.cache();
    cache.fill(work.points);
    const Bytes bytes = cache.snapshot();
    const auto refused = [&](auto other) {
        return error_of([&] { other.merge(bytes); });
    };
    Work wider = work;
    wider.settings.spacing = 0.5f;
    CHECK(contains(refused(wider.cache()), "spacing"));
    Work fewer = work;
    fewer.settings.lamp_rays = 8;
    CHECK(contains(refused(fewer.cache()), "lamp_rays"));
    Work moved = work;
    moved.settings.origin = glm::vec3(0.0f);
    CHECK(contains(refused(moved.cache()), "origin"));
    Work finer = work;
    finer.settings.detail = 3;
    CHECK(refused(finer.cache()).empty());
    Work without = work;
    without.settings.shaft_rows = false;
    CHECK(contains(refused(without.cache()), "shaft_rows"));
    CHECK(contains(refused(VisibilityCache{test::PlainTracer{&work.scene}, work.lights, work.settings}),
                   "bisection"));
    CHECK(contains(
        refused(VisibilityCache{
            lightmesh::LightMesh{HitTracer{&work.scene}, work.lights, lightmesh::Settings{}}, work.settings}),
        "mesh"));
}

TEST_CASE("cache snapshot: caches without shaft rows are saved, restored and read as well") {
    Work work(9);
    work.settings.shaft_rows = false;
    const Cache full = work.cache();
    full.fill(work.part(0, 30));
    const Bytes bytes = full.snapshot();
    Cache restored = work.cache();
    restored.merge(bytes);
    CHECK(restored.snapshot() == bytes);
    restored.fill(work.part(0, 30));
    CHECK(rays_of(restored) == 0);
    const SnapshotView view{std::span<const std::byte>(bytes)};
    CHECK(!view.cache_settings().shaft_rows);
    std::vector<float> all(work.lights.size());
    for (const lightmesh::SurfacePoint& point : work.points) {
        view.visibility(HitTracer{&work.scene}, point, all);
        CHECK(all == ask(full, point));
    }
    work.settings.shaft_rows = true;
    CHECK(contains(error_of([&] { work.cache().merge(bytes); }), "shaft_rows"));
    const VisibilityCache blur{
        lightmesh::LightMesh{HitTracer{&work.scene}, work.lights, lightmesh::Settings{}}, work.settings};
    CHECK(!blur.settings().shaft_rows);
}

TEST_CASE("cache snapshot: blur rows are saved, restored and read as well") {
    const Work work(3, 20);
    const lightmesh::Settings mesh_settings{.radius = 0.8f, .quality = 2.0f};
    const auto make = [&] {
        return VisibilityCache{lightmesh::LightMesh{HitTracer{&work.scene}, work.lights, mesh_settings},
                               work.settings};
    };
    const auto full = make();
    full.fill(work.part(0, 15));
    const Bytes bytes = full.snapshot();
    auto restored = make();
    restored.merge(bytes);
    CHECK(restored.snapshot() == bytes);
    restored.fill(work.part(0, 15));
    CHECK(restored.mesh().statistics().light_points == 0);
    const SnapshotView view{std::span<const std::byte>(bytes)};
    CHECK(view.settings().radius == mesh_settings.radius);
    std::vector<float> all(3);
    for (const lightmesh::SurfacePoint& point : work.points) {
        view.visibility(HitTracer{&work.scene}, point, all);
        CHECK(all == ask(full, point));
    }
}

TEST_CASE("cache snapshot: no byte can be wrong unseen, and none can do harm") {
    Work work(2, 0);
    work.settings.detail = 1;
    work.points = {{.position = {0.3f, 0.2f, 0.0f}, .normal = {0.0f, 0.0f, 1.0f}},
                   {.position = {-3.0f, 3.1f, 0.0f}, .normal = {0.0f, 0.0f, 1.0f}}};
    const Cache cache = work.cache();
    cache.fill(work.points);
    const Bytes bytes = cache.snapshot();
    REQUIRE(bytes.size() > 1000);
    REQUIRE(bytes.size() < 20000);
    const auto is_refused = [](std::span<const std::byte> data) {
        return !error_of([&] { const SnapshotView view(data); }).empty();
    };
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        Bytes wrong = bytes;
        wrong[i] ^= std::byte{0x10};
        CHECK(is_refused(wrong));
    }
    for (std::size_t size = 0; size < bytes.size(); size += 7)
        CHECK(is_refused(std::span(bytes).first(size)));
    std::vector<std::byte> shifted(bytes.size() + 1);
    std::ranges::copy(bytes, shifted.begin() + 1);
    CHECK(is_refused(std::span(shifted).subspan(1)));
    // With a right checksum: refused, or readable.
    std::vector<float> all(2);
    int readable = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        for (const std::byte flip : {std::byte{1}, std::byte{0x80}}) {
            Bytes wrong = bytes;
            wrong[i] ^= flip;
            sign(wrong);
            try {
                const SnapshotView view{std::span<const std::byte>(wrong)};
                if (view.light_count() != 2)
                    continue;
                view.visibility(work.points[0], all);
                view.visibility(HitTracer{&work.scene}, work.points[1], all);
                ++readable;
            } catch (const std::exception&) {
            }
        }
    }
    CHECK(readable > 0);
    CHECK(contains(error_of([&] { const SnapshotView view{std::span<const std::byte>(bytes).first(100)}; }),
                   "header"));
}

TEST_CASE("cache: filling reports progress and can be ended") {
    const Work work(2, 600);
    const Cache cache = work.cache();
    std::vector<std::pair<std::size_t, std::size_t>> calls;
    CHECK(cache.fill(work.part(0, 600), [&](std::size_t done, std::size_t total) {
        calls.emplace_back(done, total);
        return true;
    }));
    CHECK(calls.size() == 3);
    CHECK(calls.back() == std::pair<std::size_t, std::size_t>(600, 600));
    const std::uint64_t rays = rays_of(cache);
    std::vector<float> all(600 * 2);
    cache.visibility(work.points, all);
    CHECK(rays_of(cache) == rays);
    const Cache ended = work.cache();
    CHECK_FALSE(ended.fill(work.part(0, 600), [](std::size_t, std::size_t) { return false; }));
    CHECK(rays_of(ended) < rays);
}

TEST_CASE("cache statistics: every ray is counted, also those from points that nothing keeps") {
    struct CountingTracer : HitTracer {
        std::uint64_t* rays;

        bool occluded(const lightmesh::Segment& segment) const {
            ++*rays;
            return HitTracer::occluded(segment);
        }
        std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& segment) const {
            ++*rays;
            return HitTracer::closest_hit(segment);
        }
    };
    const Work work(9, 100);
    for (const bool is_exact : {false, true}) {
        CAPTURE(is_exact);
        lightmesh::CacheSettings settings = work.settings;
        settings.exact_edges = is_exact;
        std::uint64_t rays = 0;
        const lightmesh::VisibilityCache cache{CountingTracer{{&work.scene}, &rays}, work.lights, settings};
        std::vector<float> all(100 * 9);
        cache.visibility(work.part(0, 100), all);
        CHECK(rays_of(cache) + cache.statistics().point_rays == rays);
        const std::uint64_t cold = rays;
        const std::uint64_t from_points = cache.statistics().point_rays;
        cache.visibility(work.part(0, 100), all);
        (void)cache.visibility(work.points[0], 3);
        CHECK(rays > cold);
        CHECK(cache.statistics().point_rays - from_points == rays - cold);
        // A smooth surface asks where rays leave it as well.
        lightmesh::SurfacePoint smooth = work.points[0];
        smooth.shading_normal = smooth.normal + glm::vec3(0.5f, 0.3f, 0.2f);
        cache.visibility(smooth, std::span(all).first(9));
        CHECK(rays_of(cache) + cache.statistics().point_rays == rays);
    }
}

}  // namespace cache_snapshot_test
