// SPDX-License-Identifier: MIT
#include "hit_tracer.hpp"
#include "plain.hpp"
#include "random_scene.hpp"
#include "snapshot_bytes.hpp"

#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/gpu/upload.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <vector>

namespace upload_of_wrong_parts_test {

namespace {

using lightmesh::SnapshotView;
using test::Bytes;

/// Snapshots with wrong parts under a right checksum: bits that change in any of their words, counts and
/// indices among them.
template <class Header>
Bytes with_wrong_parts(const Bytes& right, test::Random& random) {
    Bytes bytes = right;
    const std::size_t changes = 1 + random.below(3);
    for (std::size_t i = 0; i < changes; ++i) {
        // Half of them near the beginning, where settings, lights and counts are.
        const std::size_t words = bytes.size() / 4;
        const std::size_t most = random.below(2) == 0 ? words : std::min<std::size_t>(words, 160);
        const std::size_t at = 4 * random.below(most);
        std::uint32_t word = 0;
        std::memcpy(&word, bytes.data() + at, 4);
        switch (random.below(4)) {
        case 0:
            word = static_cast<std::uint32_t>(random.below(64));
            break;
        case 1:
            std::memcpy(&word, bytes.data() + 4 * random.below(words), 4);
            break;
        case 2:
            word += static_cast<std::uint32_t>(random.below(9)) - 4u;
            break;
        default:
            word ^= 1u << random.below(32);
        }
        std::memcpy(bytes.data() + at, &word, 4);
    }
    test::sign<Header>(bytes);
    return bytes;
}

struct Tried {
    int refused = 0;  ///< by views
    int uploaded = 0;
};

/// A number of snapshots with wrong parts become uploads, and follow right ones: each is refused, or is laid
/// out in buffers whose size goes with that of the snapshot. A sanitizer tells whether all stays in bounds.
template <class Header, class Upload>
Tried try_wrong_parts(const Bytes& right, const Bytes& other, std::uint64_t seed, int count) {
    test::Random random(seed);
    const SnapshotView right_view{std::span<const std::byte>(right)};
    const SnapshotView other_view{std::span<const std::byte>(other)};
    const auto size_of = [](const Upload& upload) {
        std::size_t size = 0;
        for (const lightmesh::UploadBuffer& buffer : upload.buffers())
            size += buffer.bytes.size();
        return size;
    };
    const std::size_t expected = size_of(Upload(right_view));
    Upload followed(other_view);
    Tried tried;
    for (int i = 0; i < count; ++i) {
        const Bytes bytes = with_wrong_parts<Header>(right, random);
        try {
            const SnapshotView view{std::span<const std::byte>(bytes)};
            ++tried.uploaded;
            CHECK(size_of(Upload(view)) < 16 * (expected + bytes.size()));
            for (const lightmesh::UploadRange& range : followed.update(view))
                REQUIRE(range.offset + range.bytes.size() <= followed.buffers()[range.binding].bytes.size());
            followed.update(right_view);
        } catch (const std::invalid_argument&) {
            ++tried.refused;
        } catch (const std::length_error&) {
            ++tried.refused;
        }
    }
    return tried;
}

}  // namespace

TEST_CASE(
    "uploads of meshes: snapshots with wrong parts under a right checksum are refused or stay in bounds") {
    test::Random random(51);
    const auto scene = test::boxes_on_floor(random, 2);
    const auto lights = test::random_lights(random, 70);
    const auto points = test::surface_points(random, scene, 12);
    const lightmesh::LightMesh mesh{test::PlainTracer{&scene}, lights,
                                    lightmesh::Settings{.radius = 0.8f, .quality = 2.0f}};
    const Bytes empty = mesh.snapshot();
    std::vector<float> all(lights.size());
    for (const test::SurfacePoint& point : points)
        mesh.visibility(point.position, point.normal, all);
    const Tried tried = try_wrong_parts<lightmesh::detail::SnapshotHeader, lightmesh::MeshUpload>(
        mesh.snapshot(), empty, 3, 1500);
    CHECK(tried.refused > 100);
    CHECK(tried.uploaded > 100);
}

TEST_CASE(
    "uploads of caches: snapshots with wrong parts under a right checksum are refused or stay in bounds") {
    test::Random random(52);
    const auto scene = test::boxes_on_floor(random, 2);
    const auto lights = test::random_lights(random, 70);
    const auto points = test::surface_points(random, scene, 12);
    const lightmesh::VisibilityCache cache{
        test::HitTracer{&scene}, lights,
        lightmesh::CacheSettings{.spacing = 0.5f, .detail = 2, .lamp_rays = 2}};
    const Bytes empty = cache.snapshot();
    std::vector<float> all(lights.size());
    for (const test::SurfacePoint& point : points)
        cache.visibility(point.position, point.normal, all);
    const Tried tried = try_wrong_parts<lightmesh::detail::CacheHeader, lightmesh::CacheUpload>(
        cache.snapshot(), empty, 4, 1500);
    CHECK(tried.refused > 100);
    CHECK(tried.uploaded > 100);
}

}  // namespace upload_of_wrong_parts_test
