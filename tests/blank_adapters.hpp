// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/gpu/upload.hpp>
#include <lightmesh/lightmesh.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

/// A scene in which there is nothing: for programs that are there to be compiled.

namespace test {

struct BlankTracer {
    bool occluded(const lightmesh::Segment&) const { return false; }
};

/// The same with all that may be added.
struct BlankHits : BlankTracer {
    using BlankTracer::occluded;
    void occluded(std::span<const lightmesh::Segment>, std::span<std::uint8_t> hit) const {
        std::ranges::fill(hit, std::uint8_t{0});
    }
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment&) const { return std::nullopt; }
};

struct BlankPictures {
    void render_depth(const lightmesh::DepthView&, std::span<float> distance) {
        for (float& texel : distance)
            texel = std::numeric_limits<float>::infinity();
    }
};

struct BlankTriangles {
    std::size_t triangle_count() const { return 0; }
    std::array<glm::vec3, 3> triangle(std::size_t) const { return {}; }
};

/// The sum of all that a light mesh can be asked for one point and its two lights, 6 if all is well.
template <class Mesh>
float sum_of_queries(const Mesh& mesh) {
    const std::array points{glm::vec3(0.5f, 0.0f, 0.0f)};
    const std::array normals{glm::vec3(0.0f, 0.0f, 1.0f)};
    std::array<float, 2> all{};
    std::array<float, 2> many{};
    mesh.visibility(points[0], normals[0], all);
    mesh.visibility(points, normals, many);
    return all[0] + all[1] + many[0] + many[1] + mesh.visibility(points[0], normals[0], 0) +
           mesh.visibility(points[0], normals[0], 1);
}

/// The same for all kinds of light mesh and for visibility caches: 30.
inline float sum_of_meshes() {
    const std::vector<lightmesh::Light> lights{
        lightmesh::PointLight{{0.0f, 0.0f, 3.0f}},
        lightmesh::SpotLight{{0.0f, 0.0f, 3.0f}, {0.0f, 0.0f, -1.0f}, 1.0f},
    };
    const lightmesh::Settings settings;
    return sum_of_queries(lightmesh::LightMesh{BlankTracer{}, lights, settings}) +
           sum_of_queries(lightmesh::LightMesh{BlankTracer{}, BlankPictures{}, lights, settings}) +
           sum_of_queries(lightmesh::LightMesh{BlankTracer{}, BlankTriangles{}, lights, settings}) +
           sum_of_queries(lightmesh::VisibilityCache{BlankTracer{}, lights, lightmesh::CacheSettings{}}) +
           sum_of_queries(lightmesh::VisibilityCache{lightmesh::LightMesh{BlankTracer{}, lights, settings},
                                                     lightmesh::CacheSettings{}});
}

inline const lightmesh::SurfacePoint blank_point{.position = {0.5f, 0.0f, 0.0f},
                                                 .normal = {0.0f, 0.0f, 1.0f}};

/// Queries of surface points, all ways to change lights and scene, and to save and restore. Returns whether
/// all is open, as it should be.
template <class Kept>
bool is_open_whatever_is_done(Kept&& kept) {
    const std::array points{blank_point, blank_point};
    std::array<float, 2> all{};
    std::array<float, 4> many{};
    kept.fill(points);
    const bool is_filled = kept.fill(points, [](std::size_t, std::size_t) { return true; });
    kept.visibility(points, many);
    const std::vector<std::byte> bytes = kept.snapshot();
    const lightmesh::SnapshotView view(bytes);
    view.visibility(kept.tracer(), blank_point, all);
    view.visibility(blank_point, all);
    view.visibility(blank_point.position, blank_point.normal, all);
    view.visibility(kept.tracer(), blank_point.position, blank_point.normal, all);
    kept.scene_changed(lightmesh::Bounds{glm::vec3(-1.0f), glm::vec3(1.0f)});
    kept.merge(bytes);
    kept.begin_frame();
    kept.set_light(1, lightmesh::RectLight{.position = {0.0f, 0.0f, 3.0f}});
    kept.remove_light(kept.add_light(lightmesh::DirectionalLight{}));
    kept.compact();
    kept.visibility(blank_point, std::span(many).first(kept.light_count()));
    return is_filled && view.light_count() == 2 && view.lights().size() == 2 && kept.lights().size() == 3 &&
           std::bit_cast<std::uint32_t>(kept.visibility(blank_point, 0)) ==
               std::bit_cast<std::uint32_t>(many[0]) &&
           many[0] > 0.0f && kept.settings().memory_budget > 0 && kept.statistics().bytes > 0;
}

/// What the caller's own tracers fill, and what shaders read of it.
inline bool is_open_for_shaders(const std::vector<lightmesh::Light>& lights) {
    const std::array points{blank_point};
    const auto trace = [](std::span<const lightmesh::Segment>, std::span<std::uint8_t> hit) {
        std::ranges::fill(hit, std::uint8_t{0});
    };
    const lightmesh::LightMesh mesh{BlankTracer{}, lights, lightmesh::Settings{}};
    lightmesh::LinkList links;
    mesh.list_links(points, links);
    mesh.fill_links(links,
                    [&](std::span<const lightmesh::LinkWord> words, std::span<lightmesh::OpenLinks> open) {
                        (void)mesh.link_segment(words[0], 0, 0);
                        std::ranges::fill(open, lightmesh::OpenLinks{});
                    });
    lightmesh::LongTestList tests;
    mesh.list_long_tests(points, tests);
    mesh.fill(tests, [&](std::span<const lightmesh::LongTestWord> words, std::span<std::uint64_t> seen) {
        (void)mesh.long_segment(words[0], 0);
        std::ranges::fill(seen, ~std::uint64_t{0});
    });
    const std::vector<std::byte> of_mesh = mesh.snapshot();
    lightmesh::MeshUpload mesh_upload{lightmesh::SnapshotView(of_mesh)};
    const std::vector<std::byte> asked = lightmesh::empty_requests(4);

    const lightmesh::VisibilityCache cache{BlankHits{}, lights, lightmesh::CacheSettings{}};
    lightmesh::LampRayList shares;
    cache.list_lamp_rays(points, shares);
    cache.fill(shares, trace);
    cache.fill_shares(shares, [](std::span<const std::byte>, std::span<std::uint32_t> found) {
        std::ranges::fill(found, 255u);
    });
    lightmesh::LampRayList none;
    shares.add(none);
    const std::vector<std::byte> of_cache = cache.snapshot();
    lightmesh::CacheUpload cache_upload{lightmesh::SnapshotView(of_cache)};
    const std::vector<std::byte> missed = lightmesh::CacheUpload::empty_requests(4);
    return !tests.is_empty() && !links.is_empty() && none.is_empty() && mesh_upload.max_quality() > 0 &&
           mesh_upload.update(lightmesh::SnapshotView(of_mesh)).empty() &&
           mesh_upload.buffers().size() == lightmesh::MeshUpload::buffer_count &&
           lightmesh::read_requests(asked).points.empty() &&
           cache_upload.update(lightmesh::SnapshotView(of_cache)).empty() &&
           cache_upload.buffers().size() == lightmesh::CacheUpload::buffer_count &&
           lightmesh::CacheUpload::requests(missed).empty();
}

/// All that else is public.
inline bool all_else_is_open() {
    const std::vector<lightmesh::Light> lights{lightmesh::PointLight{{0.0f, 0.0f, 3.0f}},
                                               lightmesh::PointLight{{1.0f, 0.0f, 3.0f}}};
    const lightmesh::Settings settings;
    const lightmesh::CacheSettings of_cache;
    const lightmesh::ShadowRays rays(lights, 0.1f);
    std::size_t reached = 0;
    rays.for_each(blank_point.position, blank_point.normal,
                  [&](std::size_t light, const lightmesh::Segment& segment) {
                      reached += BlankTracer{}.occluded(segment) ? 0 : light + 1;
                  });
    return reached == 3 && is_open_whatever_is_done(lightmesh::LightMesh{BlankTracer{}, lights, settings}) &&
           is_open_whatever_is_done(
               lightmesh::LightMesh{BlankTracer{}, BlankTriangles{}, lights, settings}) &&
           is_open_whatever_is_done(lightmesh::VisibilityCache{BlankTracer{}, lights, of_cache}) &&
           is_open_whatever_is_done(lightmesh::VisibilityCache{BlankHits{}, lights, of_cache}) &&
           is_open_whatever_is_done(
               lightmesh::VisibilityCache{lightmesh::LightMesh{BlankHits{}, lights, settings}, of_cache}) &&
           lightmesh::VisibilityCache{lightmesh::LightMesh{BlankHits{}, lights, settings}, of_cache}
                   .mesh()
                   .light_count() == 2 &&
           is_open_for_shaders(lights);
}

}  // namespace test
