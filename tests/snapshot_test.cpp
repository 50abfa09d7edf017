// SPDX-License-Identifier: MIT
#include "plain.hpp"
#include "random_scene.hpp"
#include "snapshot_bytes.hpp"

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/mesh/snapshot_block.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/snapshot.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#if defined(__unix__)
#include <sys/mman.h>
#endif

namespace snapshot_test {

namespace {

using lightmesh::ShortTest;
using Mesh = lightmesh::LightMesh<test::PlainTracer>;
using test::Bytes;
using test::error_of;

struct Work {
    std::vector<test::Triangle> scene;
    std::vector<lightmesh::Light> lights;
    std::vector<test::SurfacePoint> points;
    lightmesh::Settings settings;

    Work(ShortTest short_test, int light_count, int point_count = 40) {
        test::Random random(91);
        scene = test::thin_walls(random);
        lights = test::random_lights(random, light_count);
        points = test::surface_points(random, scene, point_count);
        settings.radius = 0.8f;
        settings.quality = 2.0f;
        settings.short_test = short_test;
    }

    Mesh mesh() const { return Mesh{test::PlainTracer{&scene}, lights, settings}; }
};

std::vector<float> ask(const Mesh& mesh, const test::SurfacePoint& point) {
    std::vector<float> all(mesh.light_count());
    mesh.visibility(point.position, point.normal, all);
    return all;
}

void ask_all(const Mesh& mesh, const Work& work, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
        ask(mesh, work.points[i]);
}

void sign(Bytes& bytes) {
    test::sign<lightmesh::detail::SnapshotHeader>(bytes);
}

/// Of a block of three sections.
struct Header {
    static constexpr std::array<char, 8> right_magic{'t', 'e', 's', 't'};
    static constexpr std::uint32_t right_version = 1;
    static constexpr std::uint32_t right_byte_order = 0x01020304;
    std::array<char, 8> magic;
    std::uint32_t version;
    std::uint32_t byte_order;
    std::uint64_t size;
    std::uint64_t checksum;
    std::array<lightmesh::detail::SnapshotSection, 3> sections;
};

}  // namespace

TEST_CASE("a snapshot with a tracer equals the live mesh, also where nobody asked before") {
    for (const ShortTest short_test : test::all_short_tests) {
        for (const int light_count : {1, 9, 70}) {
            CAPTURE(light_count);
            const Work work(short_test, light_count);
            const Mesh mesh = work.mesh();
            ask_all(mesh, work, 0, 30);
            const Bytes bytes = mesh.snapshot();
            const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)};
            CHECK(view.light_count() == mesh.light_count());
            std::vector<float> all(mesh.light_count());
            for (const test::SurfacePoint& point : work.points) {
                view.visibility(test::PlainTracer{&work.scene}, point.position, point.normal, all);
                CHECK(all == ask(mesh, point));
            }
        }
    }
}

TEST_CASE("a snapshot without a tracer answers what needs none, and says what is missing") {
    const Work work(ShortTest::none, 70);
    const Mesh mesh = work.mesh();
    ask_all(mesh, work, 0, 20);
    const Bytes bytes = mesh.snapshot();
    const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)};
    std::vector<float> all(mesh.light_count());
    for (std::size_t i = 0; i < 20; ++i) {
        CHECK(view.visibility(work.points[i].position, work.points[i].normal, all) == 0);
        CHECK(all == ask(mesh, work.points[i]));
    }
    std::size_t missing = 0;
    for (std::size_t i = 20; i < work.points.size(); ++i) {
        const std::vector<float> expected = ask(mesh, work.points[i]);
        const std::size_t counted = view.visibility(work.points[i].position, work.points[i].normal, all);
        std::size_t nan = 0;
        for (std::size_t l = 0; l < all.size(); ++l) {
            nan += std::isnan(all[l]) ? 1u : 0u;
            if (!std::isnan(all[l]))
                CHECK(all[l] == expected[l]);
        }
        CHECK(nan == counted);
        missing += nan;
    }
    CHECK(missing > 0);
}

TEST_CASE("a snapshot with short tests by rays tells without a tracer which lights cannot reach a point") {
    for (const ShortTest short_test : {ShortTest::linked, ShortTest::exact}) {
        const Work work(short_test, 9);
        const Mesh mesh = work.mesh();
        ask_all(mesh, work, 0, work.points.size());
        const Bytes bytes = mesh.snapshot();
        const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)};
        const lightmesh::ShadowRays rays(work.lights, work.settings.radius / work.settings.quality);
        std::vector<float> all(9);
        std::size_t known = 0;
        for (const test::SurfacePoint& point : work.points) {
            std::size_t unknown = 0;
            const std::size_t counted = view.visibility(point.position, point.normal, all);
            for (std::size_t l = 0; l < all.size(); ++l) {
                if (rays.can_light(l, point.position, point.normal)) {
                    CHECK(std::isnan(all[l]));
                    ++unknown;
                } else {
                    CHECK(all[l] == 0.0f);
                    ++known;
                }
            }
            CHECK(counted == unknown);
        }
        CHECK(known > 0);
        CHECK(view.visibility({NAN, 0, 0}, {0, 0, 1}, all) == all.size());
    }
}

TEST_CASE("a snapshot merged into an empty mesh restores it without a ray") {
    for (const ShortTest short_test : test::all_short_tests) {
        for (const int light_count : {9, 130}) {
            const Work work(short_test, light_count);
            const Mesh full = work.mesh();
            ask_all(full, work, 0, work.points.size());
            Mesh restored = work.mesh();
            const Bytes bytes = full.snapshot();
            restored.merge(bytes);
            for (const test::SurfacePoint& point : work.points)
                CHECK(ask(restored, point) == ask(full, point));
            CHECK(restored.statistics().long_rays == 0);
            CHECK(restored.statistics().link_rays == 0);
            CHECK(restored.statistics().light_points == full.statistics().light_points);
            CHECK(restored.snapshot() == bytes);
        }
    }
}

TEST_CASE("a mesh that was restored goes on as the one that its snapshot is of") {
    for (const ShortTest short_test : test::all_short_tests) {
        for (const int light_count : {9, 130}) {
            const Work work(short_test, light_count);
            Mesh full = work.mesh();
            ask_all(full, work, 0, 20);
            Mesh restored = work.mesh();
            restored.merge(full.snapshot());
            const lightmesh::Bounds box{{-0.2f, -0.2f, -0.2f}, {0.3f, 0.1f, 0.2f}};
            for (Mesh* mesh : {&full, &restored}) {
                mesh->set_light(2, lightmesh::PointLight{{0.4f, -0.3f, 0.2f}});
                mesh->scene_changed(box);
                ask_all(*mesh, work, 0, work.points.size());
            }
            CHECK(restored.snapshot() == full.snapshot());
            CHECK(restored.statistics().light_points == full.statistics().light_points);
        }
    }
}

TEST_CASE("a snapshot that is merged twice changes nothing the second time") {
    const Work work(ShortTest::linked, 70);
    const Mesh full = work.mesh();
    ask_all(full, work, 0, work.points.size());
    const Bytes bytes = full.snapshot();
    Mesh mesh = work.mesh();
    mesh.merge(bytes);
    const std::size_t held = mesh.statistics().bytes;
    mesh.merge(bytes);
    CHECK(mesh.statistics().bytes == held);
    CHECK(mesh.snapshot() == bytes);
}

TEST_CASE("meshes that know the same have the same bytes, whichever thread asked in what order") {
    Work work(ShortTest::linked, 70);
    work.settings.adaptive_long_tests = false;
    const Mesh forwards = work.mesh();
    ask_all(forwards, work, 0, work.points.size());
    const Mesh backwards = work.mesh();
    {
        std::vector<std::thread> threads;
        for (std::size_t t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                for (std::size_t i = work.points.size(); i-- > 0;)
                    ask(backwards, work.points[(i + 10 * t) % work.points.size()]);
            });
        for (std::thread& thread : threads)
            thread.join();
    }
    CHECK(forwards.snapshot() == backwards.snapshot());
    // Two halves, merged.
    const Mesh first = work.mesh();
    ask_all(first, work, 0, 20);
    Mesh second = work.mesh();
    ask_all(second, work, 20, work.points.size());
    second.merge(first.snapshot());
    CHECK(second.snapshot() == forwards.snapshot());
}

TEST_CASE("what two meshes know together does not depend on which is merged into which") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 70);
        Mesh first = work.mesh();
        ask_all(first, work, 0, 25);
        Mesh second = work.mesh();
        ask_all(second, work, 15, work.points.size());
        const Bytes bytes = first.snapshot();
        first.merge(second.snapshot());
        second.merge(bytes);
        CHECK(first.snapshot() == second.snapshot());
    }
}

TEST_CASE("snapshots may be taken while other threads query") {
    const Work work(ShortTest::linked, 70);
    const Mesh mesh = work.mesh();
    std::thread other([&] { ask_all(mesh, work, 0, work.points.size()); });
    std::vector<Bytes> taken;
    for (int i = 0; i < 5; ++i)
        taken.push_back(mesh.snapshot());
    other.join();
    for (const Bytes& bytes : taken) {
        Mesh merged = work.mesh();
        merged.merge(bytes);
        CHECK(ask(merged, work.points[3]) == ask(mesh, work.points[3]));
    }
}

TEST_CASE("lights that differ contribute nothing") {
    const Work work(ShortTest::none, 20);
    const Mesh full = work.mesh();
    ask_all(full, work, 0, work.points.size());
    Work moved = work;
    moved.lights[3] = lightmesh::PointLight{{0.1f, 0.2f, 0.3f}};
    moved.lights.push_back(lightmesh::PointLight{{-1.0f, 0.5f, 0.0f}});
    Mesh mesh = moved.mesh();
    mesh.merge(full.snapshot());
    const Mesh fresh = moved.mesh();
    for (const test::SurfacePoint& point : work.points)
        CHECK(ask(mesh, point) == ask(fresh, point));
    CHECK(mesh.statistics().long_rays < fresh.statistics().long_rays);
    CHECK(mesh.statistics().long_rays > 0);
}

TEST_CASE("what may have to do with a changed box contributes nothing") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 12);
        const Mesh full = work.mesh();
        ask_all(full, work, 0, work.points.size());
        Work changed = work;
        const test::Vec low(0.4, 0.3, -0.5);
        const test::Vec high(1.1, 0.9, 0.6);
        test::add_box(changed.scene, low, high);
        Mesh mesh = changed.mesh();
        const std::array<lightmesh::Bounds, 1> box{{{glm::vec3(low), glm::vec3(high)}}};
        mesh.merge(full.snapshot(), box);
        const Mesh fresh = changed.mesh();
        for (const test::SurfacePoint& point : work.points)
            CHECK(ask(mesh, point) == ask(fresh, point));
        CHECK(mesh.statistics().long_rays < fresh.statistics().long_rays);
    }
}

TEST_CASE("a snapshot of another mesh or another scene is refused, and changes nothing") {
    const Work work(ShortTest::none, 5);
    const Mesh full = work.mesh();
    ask_all(full, work, 0, work.points.size());
    const Bytes bytes = full.snapshot();
    Work other = work;
    other.settings.radius = 0.7f;
    Mesh of_other_radius = other.mesh();
    CHECK(error_of([&] { of_other_radius.merge(bytes); }).find("radius is 0.8") != std::string::npos);
    Work other_scene = work;
    const test::Vec shift(0.9, 0.0, 0.0);
    for (test::Triangle& triangle : other_scene.scene)
        triangle = test::rounded(triangle.a + shift, triangle.b + shift, triangle.c + shift);
    Mesh of_other_scene = other_scene.mesh();
    ask_all(of_other_scene, work, 0, 5);
    const Bytes before = of_other_scene.snapshot();
    CHECK(error_of([&] { of_other_scene.merge(bytes); }).find("not of the same scene") != std::string::npos);
    CHECK(of_other_scene.snapshot() == before);
}

TEST_CASE("where fewer than 1 in 1000 bits differ from a snapshot a mesh keeps its own") {
    /// One segment in 2,048 is found otherwise, by chance of its ends.
    struct OtherProcessor {
        test::PlainTracer tracer;
        bool occluded(const lightmesh::Segment& segment) const {
            std::uint64_t sum = 0xcbf29ce484222325u;
            for (const glm::vec3* end : {&segment.origin, &segment.target})
                for (int axis = 0; axis < 3; ++axis)
                    sum = (sum ^ std::bit_cast<std::uint32_t>((*end)[axis])) * 0x100000001b3u;
            return tracer.occluded(segment) != ((sum >> 40) % 2048 == 0);
        }
    };
    Work work(ShortTest::none, 70);
    work.settings.adaptive_long_tests = false;
    const lightmesh::LightMesh other{OtherProcessor{{&work.scene}}, work.lights, work.settings};
    Mesh mesh = work.mesh();
    std::vector<float> of_other(other.light_count());
    std::vector<std::vector<float>> own;
    bool differs = false;
    for (std::size_t i = 0; i < work.points.size(); ++i) {
        other.visibility(work.points[i].position, work.points[i].normal, of_other);
        if (i >= 30)
            continue;
        own.push_back(ask(mesh, work.points[i]));
        differs |= own.back() != of_other;
    }
    CHECK(differs);
    const std::size_t known = mesh.statistics().light_points;
    mesh.merge(other.snapshot());
    CHECK(mesh.statistics().light_points > known);
    for (std::size_t i = 0; i < own.size(); ++i)
        CHECK(ask(mesh, work.points[i]) == own[i]);
}

#if defined(__unix__)
TEST_CASE("a snapshot is read from a file that is mapped into memory") {
    const Work work(ShortTest::none, 9);
    const Mesh mesh = work.mesh();
    ask_all(mesh, work, 0, work.points.size());
    const Bytes bytes = mesh.snapshot();
    std::FILE* file = std::tmpfile();
    REQUIRE(file != nullptr);
    REQUIRE(std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size());
    REQUIRE(std::fflush(file) == 0);
    void* const mapped = mmap(nullptr, bytes.size(), PROT_READ, MAP_PRIVATE, fileno(file), 0);
    REQUIRE(mapped != MAP_FAILED);
    std::fclose(file);
    const std::span<const std::byte> read(static_cast<const std::byte*>(mapped), bytes.size());
    {
        const lightmesh::SnapshotView view{read};
        std::vector<float> all(mesh.light_count());
        for (const test::SurfacePoint& point : work.points) {
            CHECK(view.visibility(point.position, point.normal, all) == 0);
            CHECK(all == ask(mesh, point));
        }
    }
    Mesh merged = work.mesh();
    merged.merge(read);
    CHECK(merged.snapshot() == bytes);
    CHECK(munmap(mapped, bytes.size()) == 0);
}
#endif

// Wrong bytes under a right checksum: fuzz/snapshot_fuzzer.cpp.
TEST_CASE("every changed byte and every shorter length of a snapshot is refused in one sentence") {
    Work work(ShortTest::linked, 3, 2);
    const Mesh mesh = work.mesh();
    ask(mesh, work.points[0]);
    std::vector<float> unused(3);
    mesh.visibility({.position = work.points[0].position,
                     .normal = work.points[0].normal,
                     .footprint = 3.0f / work.settings.footprint_scale},
                    unused);
    Bytes bytes = mesh.snapshot();
    const auto refused = [](std::span<const std::byte> some) {
        return !error_of([&] { const lightmesh::SnapshotView view{some}; }).empty();
    };
    CHECK_FALSE(refused(bytes));
    std::size_t accepted = 0;
    for (std::byte& byte : bytes) {
        const std::byte right = byte;
        for (const std::byte change : {std::byte{0x01}, std::byte{0xff}}) {
            byte = right ^ change;
            accepted += refused(bytes) ? 0u : 1u;
        }
        byte = right;
    }
    CHECK(accepted == 0);
    for (std::size_t size = 0; size < bytes.size(); ++size)
        accepted += refused(std::span<const std::byte>(bytes).first(size)) ? 0u : 1u;
    CHECK(accepted == 0);
    CHECK_FALSE(refused(bytes));
    CHECK(refused(std::span<const std::byte>(bytes).subspan(8)));
}

TEST_CASE("a snapshot in which parts are named many times, or never, is refused") {
    const Work work(ShortTest::linked, 9, 2);
    const Mesh mesh = work.mesh();
    ask_all(mesh, work, 0, 2);
    Bytes good = mesh.snapshot();
    lightmesh::detail::SnapshotHeader header;
    std::memcpy(&header, good.data(), sizeof header);
    const auto& section = header.sections[lightmesh::detail::bricks_section];
    const auto error_with = [&](auto&& change) {
        Bytes bytes = good;
        for (std::size_t i = 0; i < section.count; ++i) {
            std::byte* at = bytes.data() + section.offset + i * sizeof(lightmesh::detail::Brick);
            lightmesh::detail::Brick brick;
            std::memcpy(&brick, at, sizeof brick);
            change(brick);
            std::memcpy(at, &brick, sizeof brick);
        }
        sign(bytes);
        return error_of([&] { const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)}; });
    };
    CHECK(error_with([](lightmesh::detail::Brick&) {}).empty());
    std::uint32_t floods = 0;
    const std::string of_floods = error_with([&](lightmesh::detail::Brick& brick) {
        floods = (std::max)(floods, brick.floods);
        brick.floods = floods;
    });
    CHECK(of_floods.find("in its turn") != std::string::npos);
    const std::string of_tiles = error_with([](lightmesh::detail::Brick& brick) { brick.tiles = 1; });
    CHECK(of_tiles.find("in its turn") != std::string::npos);
    const std::string of_nothing =
        error_with([](lightmesh::detail::Brick& brick) { brick.tiles = brick.floods = 0; });
    CHECK(of_nothing.find("nothing names") != std::string::npos);
}

TEST_CASE("a block has the same bytes, however much room its sections had") {
    using Writer = lightmesh::detail::BlockWriter<Header, std::uint32_t, std::uint64_t, std::uint8_t>;
    const auto written = [](const Writer::Counts& room) {
        Writer block(room);
        for (std::uint32_t i = 0; i < 100; ++i) {
            block.add<0>(i);
            *block.extend<1>(3) = i;
            block.add<2>(static_cast<std::uint8_t>(i));
        }
        block.all<0>()[50] = 7;
        return block.finish(Header{});
    };
    const Bytes exact = written({100, 300, 100});
    CHECK(written({0, 0, 0}) == exact);
    CHECK(written({1000, 5000, 70}) == exact);
    const lightmesh::detail::SnapshotBlock<Header> read(exact);
    const auto first = read.section<std::uint32_t>(0);
    const auto second = read.section<std::uint64_t>(1);
    const auto third = read.section<std::uint8_t>(2);
    REQUIRE(first.size() == 100);
    REQUIRE(second.size() == 300);
    REQUIRE(third.size() == 100);
    for (std::size_t i = 0; i < 100; ++i) {
        CHECK(first[i] == (i == 50 ? 7 : i));
        CHECK(second[3 * i] == i);
        CHECK(second[3 * i + 1] == 0);
        CHECK(third[i] == i);
    }
}

TEST_CASE("fill finds what queries need, says how far it is, and can be cancelled") {
    for (const ShortTest short_test : test::all_short_tests) {
        const Work work(short_test, 9, 600);
        std::vector<lightmesh::SurfacePoint> points;
        for (const test::SurfacePoint& point : work.points)
            points.push_back({.position = point.position, .normal = point.normal});
        const Mesh filled = work.mesh();
        std::size_t last = 0;
        CHECK(filled.fill(points, [&](std::size_t done, std::size_t total) {
            CHECK(done > last);
            CHECK(total == points.size());
            last = done;
            return true;
        }));
        CHECK(last == points.size());
        const auto rays = filled.statistics().long_rays;
        CHECK(rays > 0);
        const Mesh fresh = work.mesh();
        std::vector<float> all(points.size() * 9);
        std::vector<float> expected(points.size() * 9);
        filled.visibility(std::span<const lightmesh::SurfacePoint>(points), all);
        for (std::size_t i = 0; i < points.size(); ++i) {
            std::vector<float> one(9);
            fresh.visibility(points[i], one);
            std::ranges::copy(one, expected.begin() + static_cast<std::ptrdiff_t>(9 * i));
        }
        CHECK(all == expected);
        CHECK(filled.statistics().long_rays == rays);

        const Mesh cancelled = work.mesh();
        CHECK_FALSE(cancelled.fill(points, [](std::size_t, std::size_t) { return false; }));
        CHECK(cancelled.statistics().long_rays < rays);
    }
}

}  // namespace snapshot_test
