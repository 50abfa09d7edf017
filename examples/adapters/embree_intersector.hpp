// SPDX-License-Identifier: MIT
#pragma once

// A light mesh's Intersector on Embree 3 or 4. Copy this file into your program.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <lightmesh/segment.hpp>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace demo {

/// Asks an Embree scene whether segments are blocked. Copies share the scene, which stays alive as long as
/// any of them. The scene must be committed, and must not change but between queries, if the light mesh or
/// the cache is told by `scene_changed`.
class EmbreeIntersector {
public:
    /// The number of segments that are traced at once. The answers are the same.
    enum class Batches {
        packets,  ///< of 16 rays: for the rays of one light towards walls and ground
        streams,  ///< INCOHERENT ones of 64 rays, where each ray soon goes its own way, as in foliage; Embree
                  ///< 3
    };

    /// Chooses the faster of `Batches` by timing both, some milliseconds.
    explicit EmbreeIntersector(RTCScene scene) : EmbreeIntersector(scene, Batches::packets) {
#if RTC_VERSION_MAJOR < 4
        batches_ = faster_batches();
#endif
    }
    EmbreeIntersector(RTCScene scene, Batches batches) : scene_(scene), batches_(batches) {
        rtcRetainScene(scene_);
    }
    EmbreeIntersector(const EmbreeIntersector& other) : EmbreeIntersector(other.scene_, other.batches_) {}
    EmbreeIntersector(EmbreeIntersector&& other) noexcept
        : scene_(std::exchange(other.scene_, nullptr)), batches_(other.batches_) {}
    EmbreeIntersector& operator=(EmbreeIntersector other) noexcept {
        std::swap(scene_, other.scene_);
        std::swap(batches_, other.batches_);
        return *this;
    }
    ~EmbreeIntersector() {
        if (scene_ != nullptr)
            rtcReleaseScene(scene_);
    }

    bool occluded(const lightmesh::Segment& segment) const {
        RTCRay ray = ray_along(segment, 1);
        Context context(&segment, nullptr);
#if RTC_VERSION_MAJOR >= 4
        RTCOccludedArguments arguments = context.arguments();
        rtcOccluded1(scene_, &ray, &arguments);
#else
        rtcOccluded1(scene_, &context.embree, &ray);
#endif
        return is_blocked(ray.tfar);
    }

    /// The place where a segment first meets a surface, which may be an instance's, of one level.
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& segment) const {
        RTCRayHit query{};
        query.ray = ray_along(segment, 0);
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(scene_, &query);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &query);
#endif
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
            return std::nullopt;
        const float length = glm::length(segment.target - segment.origin);
        glm::vec3 normal(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
        if (query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID)
            normal = in_world(normal, query.hit.instID[0]);
        return lightmesh::Hit{query.ray.tfar * length, glm::normalize(normal)};
    }

    Batches batches() const {
        return batches_;
    }

    /// Many segments at once.
    void occluded(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) const {
        trace(segments, hit, nullptr);
    }

    /// As `occluded`, for renderers that want shares of light instead of yes and no: share[i] becomes the
    /// product of what all surfaces along segment i let through, 0 to 1.
    void let_through(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit,
                     std::span<float> share) const {
        std::ranges::fill(share, 1.0f);
        trace(segments, hit, share.data());
        for (std::size_t i = 0; i < segments.size(); ++i)
            share[i] = hit[i] != 0 ? 0.0f : share[i];
    }

    /// For occlusion filters of geometries that light may pass: whether ray i of the packet passes a surface
    /// that lets `share` of the light through. A light mesh has a bit for each light, so it is decided by
    /// chance: by a hash of the segment's two ends, the same in both directions, and of the surface's number.
    static bool passes(const RTCFilterFunctionNArguments* hits, unsigned i, std::uint32_t surface,
                       float share) {
        if (share <= 0.0f || share >= 1.0f)
            return share >= 1.0f;
        const unsigned id = RTCRayN_id(hits->ray, hits->N, i);
        if (id == 0)  // not a ray of this adapter
            return share >= 0.5f;
        const auto* context = reinterpret_cast<const Context*>(hits->context);
        if (context->shares != nullptr) {
            context->shares[id - 1] *= share;
            return true;
        }
        return static_cast<float>(hash_of(context->segments[id - 1], surface)) < share * 0x1p32f;
    }

private:
#if RTC_VERSION_MAJOR >= 4
    using EmbreeContext = RTCRayQueryContext;
#else
    using EmbreeContext = RTCIntersectContext;
#endif

    /// The data that filters find behind Embree's own context. A ray's id is the number of its segment,
    /// from 1.
    struct Context {
        EmbreeContext embree;
        const lightmesh::Segment* segments;
        float* shares;  ///< null: passing is decided by chance

        Context(const lightmesh::Segment* of_rays, float* of_light) : segments(of_rays), shares(of_light) {
#if RTC_VERSION_MAJOR >= 4
            rtcInitRayQueryContext(&embree);
#else
            rtcInitIntersectContext(&embree);
#endif
        }
#if RTC_VERSION_MAJOR >= 4
        RTCOccludedArguments arguments() {
            RTCOccludedArguments made;
            rtcInitOccludedArguments(&made);
            made.context = &embree;
            return made;
        }
#endif
    };

    /// A normal that Embree gives of an instance, in the instance's own coordinates.
    glm::vec3 in_world(const glm::vec3& normal, unsigned instance) const {
        std::array<float, 12> columns;
        rtcGetGeometryTransform(rtcGetGeometry(scene_, instance), 0.0f, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                columns.data());
        const glm::vec3 x(columns[0], columns[1], columns[2]);
        const glm::vec3 y(columns[3], columns[4], columns[5]);
        const glm::vec3 z(columns[6], columns[7], columns[8]);
        return normal.x * glm::cross(y, z) + normal.y * glm::cross(z, x) + normal.z * glm::cross(x, y);
    }

    static std::uint32_t mixed(std::uint32_t hash, std::uint32_t value) {
        hash = (hash ^ value) * 0x9e3779b1u;
        hash ^= hash >> 15;
        hash *= 0x85ebca77u;
        return hash ^ hash >> 13;
    }

    static std::uint32_t hash_of(const lightmesh::Segment& segment, std::uint32_t surface) {
        std::array<std::array<std::uint32_t, 3>, 2> ends;
        for (int axis = 0; axis < 3; ++axis) {
            ends[0][static_cast<std::size_t>(axis)] = std::bit_cast<std::uint32_t>(segment.origin[axis]);
            ends[1][static_cast<std::size_t>(axis)] = std::bit_cast<std::uint32_t>(segment.target[axis]);
        }
        std::ranges::sort(ends);
        std::uint32_t hash = mixed(0x2545f491u, surface);
        for (const auto& end : ends)
            for (const std::uint32_t coordinate : end)
                hash = mixed(hash, coordinate);
        return hash;
    }

    void trace(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit,
               float* shares) const {
        const std::size_t most = batches_ == Batches::packets ? 16 : 64;
        for (std::size_t first = 0; first < segments.size(); first += most) {
            const std::size_t count = (std::min)(segments.size() - first, most);
            const auto some = segments.subspan(first, count);
            const auto hit_of_some = hit.subspan(first, count);
            float* shares_of_some = shares != nullptr ? shares + first : nullptr;
#if RTC_VERSION_MAJOR < 4
            if (batches_ == Batches::streams) {
                trace_stream(some, hit_of_some, shares_of_some);
                continue;
            }
#endif
            trace_packet(some, hit_of_some, shares_of_some);
        }
    }

#if RTC_VERSION_MAJOR < 4
    void trace_stream(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit,
                      float* shares) const {
        RTCRay rays[64];
        for (std::size_t i = 0; i < segments.size(); ++i)
            rays[i] = ray_along(segments[i], static_cast<unsigned>(i + 1));
        Context context(segments.data(), shares);
        rtcOccluded1M(scene_, &context.embree, rays, static_cast<unsigned int>(segments.size()),
                      sizeof(RTCRay));
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = is_blocked(rays[i].tfar) ? 1 : 0;
    }

    /// By the clock: 32 times the rays from some place in the scene to a block of 4x4x4 points beside a
    /// surface, the work of long tests; the least of three times each.
    Batches faster_batches() const {
        RTCBounds bounds{};
        rtcGetSceneBounds(scene_, &bounds);
        const glm::vec3 low(bounds.lower_x, bounds.lower_y, bounds.lower_z);
        const glm::vec3 size = glm::vec3(bounds.upper_x, bounds.upper_y, bounds.upper_z) - low;
        if (!(glm::length(size) < 0x1p60f) || std::min({size.x, size.y, size.z}) < 0.0f)
            return batches_;  // an empty scene
        std::uint32_t random = 1;
        const auto place = [&] {
            glm::vec3 share;
            for (int axis = 0; axis < 3; ++axis) {
                random = random * 747796405u + 2891336453u;
                share[axis] = static_cast<float>(random >> 8) * 0x1p-24f;
            }
            return low + share * size;
        };
        constexpr std::size_t of_block = 64;
        std::array<std::array<lightmesh::Segment, of_block>, 32> blocks;
        const float step = 0.01f * glm::length(size);
        for (auto& block : blocks) {
            const lightmesh::Segment path{place(), place()};
            const auto hit = closest_hit(path);
            const glm::vec3 way = path.target - path.origin;
            const float length = glm::length(way);
            const glm::vec3 at =
                hit && length > 0.0f ? path.origin + way * (hit->distance / length) : path.target;
            const glm::vec3 light = place();
            for (std::size_t i = 0; i < of_block; ++i)
                block[i] = {light, at + step * glm::vec3(i % 4, i / 4 % 4, i / 16)};
        }
        std::array<double, 2> least{1.0, 1.0};
        std::array<std::uint8_t, of_block> hit;
        for (int round = 0; round < 6; ++round) {
            const auto tried = round % 2 == 0 ? Batches::packets : Batches::streams;
            const EmbreeIntersector with(scene_, tried);
            const auto start = std::chrono::steady_clock::now();
            for (const auto& block : blocks)
                with.occluded(block, hit);
            const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
            double& of_tried = least[static_cast<std::size_t>(tried)];
            of_tried = (std::min)(of_tried, spent.count());
        }
        return least[0] <= least[1] ? Batches::packets : Batches::streams;
    }
#endif

    static RTCRay ray_along(const lightmesh::Segment& segment, unsigned id) {
        RTCRay ray{};
        ray.id = id;
        ray.org_x = segment.origin.x;
        ray.org_y = segment.origin.y;
        ray.org_z = segment.origin.z;
        ray.dir_x = segment.target.x - segment.origin.x;
        ray.dir_y = segment.target.y - segment.origin.y;
        ray.dir_z = segment.target.z - segment.origin.z;
        // Embree takes no rays of 2^60 and more: what is farther away than that is cut off.
        const float longest = (std::max)({std::abs(ray.dir_x), std::abs(ray.dir_y), std::abs(ray.dir_z)});
        if (!(longest < 0x1p60f)) {
            const float scale = longest < std::numeric_limits<float>::infinity() ? 0x1p40f / longest : 0.0f;
            ray.dir_x *= scale;
            ray.dir_y *= scale;
            ray.dir_z *= scale;
        }
        ray.tfar = 1.0f;
        ray.mask = ~0u;
        return ray;
    }

    /// Embree marks a blocked ray by tfar = -infinity.
    static bool is_blocked(float tfar) {
        return tfar < 0.0f;
    }

    void trace_packet(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit,
                      float* shares) const {
        alignas(64) int valid[16] = {};
        alignas(64) RTCRay16 rays{};
        for (std::size_t i = 0; i < segments.size(); ++i) {
            const RTCRay ray = ray_along(segments[i], static_cast<unsigned>(i + 1));
            valid[i] = -1;
            rays.id[i] = ray.id;
            rays.org_x[i] = ray.org_x;
            rays.org_y[i] = ray.org_y;
            rays.org_z[i] = ray.org_z;
            rays.dir_x[i] = ray.dir_x;
            rays.dir_y[i] = ray.dir_y;
            rays.dir_z[i] = ray.dir_z;
            rays.tfar[i] = ray.tfar;
            rays.mask[i] = ray.mask;
        }
        Context context(segments.data(), shares);
#if RTC_VERSION_MAJOR >= 4
        RTCOccludedArguments arguments = context.arguments();
        rtcOccluded16(valid, scene_, &rays, &arguments);
#else
        rtcOccluded16(valid, scene_, &context.embree, &rays);
#endif
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = is_blocked(rays.tfar[i]) ? 1 : 0;
    }

    RTCScene scene_;
    Batches batches_ = Batches::packets;
};

}  // namespace demo
