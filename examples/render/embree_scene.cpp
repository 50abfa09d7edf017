// SPDX-License-Identifier: MIT

#include "render/embree_scene.hpp"

#include "render/stopwatch.hpp"
#include "scene/blockers.hpp"
#include "scene/light_rig.hpp"
#include "scene/surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <stdexcept>
#include <string>

namespace demo {

namespace {

[[noreturn]] void throw_embree_error(RTCError code, const char* what) {
    throw std::runtime_error("Embree: " + std::string(what) + " failed with error " + std::to_string(code));
}

void check(RTCDevice device, const char* what) {
    const RTCError code = rtcGetDeviceError(device);
    if (code != RTC_ERROR_NONE)
        throw_embree_error(code, what);
}

void copy_positions(const std::vector<glm::vec3>& points, void* buffer) {
    auto* positions = static_cast<float*>(buffer);
    for (const glm::vec3& position : points)
        for (int axis = 0; axis < 3; ++axis)
            *positions++ = position[axis];
}

/// Gives a geometry of a committed scene its vertices' new places.
void move_geometry(RTCScene scene, unsigned number, const std::vector<glm::vec3>& points) {
    RTCGeometry geometry = rtcGetGeometry(scene, number);
    copy_positions(points, rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
}

std::vector<std::uint32_t> corners_of(const Scene& scene, const std::vector<std::uint32_t>& triangles) {
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * triangles.size());
    for (const std::uint32_t t : triangles)
        corners.insert(corners.end(), std::begin(scene.triangles[t].vertex),
                       std::end(scene.triangles[t].vertex));
    return corners;
}

const EmbreeScene& scene_of(const RTCFilterFunctionNArguments* hits) {
    return *static_cast<const EmbreeScene*>(hits->geometryUserPtr);
}

/// Rays that look for surfaces pass holes.
void pass_holes(const RTCFilterFunctionNArguments* hits) {
    const EmbreeScene& scene = scene_of(hits);
    for (unsigned i = 0; i < hits->N; ++i) {
        if (hits->valid[i] == 0)
            continue;
        const std::uint32_t triangle = scene.translucent_triangle(RTCHitN_primID(hits->hit, hits->N, i));
        if (is_hole(scene.scene(), triangle, RTCHitN_u(hits->hit, hits->N, i),
                    RTCHitN_v(hits->hit, hits->N, i)))
            hits->valid[i] = 0;
    }
}

/// Shadow rays pass surfaces by the share of light that these let through.
void pass_light(const RTCFilterFunctionNArguments* hits) {
    const EmbreeScene& scene = scene_of(hits);
    for (unsigned i = 0; i < hits->N; ++i) {
        if (hits->valid[i] == 0)
            continue;
        const std::uint32_t triangle = scene.translucent_triangle(RTCHitN_primID(hits->hit, hits->N, i));
        const float share = share_let_through(scene.scene(), triangle, RTCHitN_u(hits->hit, hits->N, i),
                                              RTCHitN_v(hits->hit, hits->N, i));
        if (EmbreeIntersector::passes(hits, i, triangle, share))
            hits->valid[i] = 0;
    }
}

glm::vec3 interpolated_normal(const Scene& scene, const Triangle& triangle, float u, float v) {
    const glm::vec3& a = scene.normals[triangle.vertex[0]];
    const glm::vec3& b = scene.normals[triangle.vertex[1]];
    const glm::vec3& c = scene.normals[triangle.vertex[2]];
    return (1.0f - u - v) * a + u * b + v * c;
}

}  // namespace

EmbreeScene::EmbreeScene(const Scene& scene, For use)
    : scene_(scene), use_(use), device_(rtcNewDevice(nullptr)) {
    measure();
    if (!device_)
        throw_embree_error(rtcGetDeviceError(nullptr), "opening the device");
    const Stopwatch watch;
    handle_.reset(new_scene());
    check(device_.get(), "making the scene");
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
        (may_let_light_through(scene.materials[scene.triangles[t].material]) ? translucent_ : opaque_)
            .push_back(t);
    RTCGeometry blocking = make_geometry(scene.positions, corners_of(scene, opaque_));
    rtcCommitGeometry(blocking);
    rtcAttachGeometry(handle_.get(), blocking);
    if (!translucent_.empty()) {
        add_translucent();
        add_blockers(blocking);
    }
    rtcReleaseGeometry(blocking);
    rtcCommitScene(handle_.get());
    check(device_.get(), "building the BVH");
    seconds_building_ = watch.seconds();
}

void EmbreeScene::measure() {
    const Bounds bounds = bounds_of(scene_);
    const glm::vec3 farthest = glm::max(glm::abs(bounds.low), glm::abs(bounds.high));
    diagonal_ = bounds.diagonal();
    offset_ = 0x1p-18f * ((std::max)({farthest.x, farthest.y, farthest.z}) + diagonal_);
}

RTCScene EmbreeScene::new_scene() const {
    RTCScene made = rtcNewScene(device_.get());
    if (made != nullptr && use_ == For::films) {
        rtcSetSceneFlags(made, RTC_SCENE_FLAG_DYNAMIC);
        // Of two levels: one BVH over those of the geometries, which have their own quality.
        rtcSetSceneBuildQuality(made, RTC_BUILD_QUALITY_LOW);
    }
    return made;
}

RTCGeometry EmbreeScene::make_geometry(const std::vector<glm::vec3>& points,
                                       const std::vector<std::uint32_t>& corners) const {
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof(float), points.size());
    // One at least: Embree knows no buffer of none.
    const std::size_t count = (std::max)(corners.size() / 3, std::size_t{1});
    auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), count));
    if (positions == nullptr || indices == nullptr) {
        rtcReleaseGeometry(geometry);
        throw_embree_error(rtcGetDeviceError(device_.get()), "allocating the triangles");
    }
    copy_positions(points, positions);
    std::fill_n(indices, 3, 0u);  // a triangle without a size, if there is none
    std::ranges::copy(corners, indices);
    if (use_ == For::films)
        rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
    return geometry;
}

void EmbreeScene::add_translucent() {
    RTCGeometry geometry = make_geometry(scene_.positions, corners_of(scene_, translucent_));
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryIntersectFilterFunction(geometry, pass_holes);
    rtcSetGeometryOccludedFilterFunction(geometry, pass_light);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(handle_.get(), geometry);
    rtcReleaseGeometry(geometry);
}

void EmbreeScene::add_blockers(RTCGeometry opaque) {
    blockers_.reset(new_scene());
    rtcAttachGeometry(blockers_.get(), opaque);
    const Blockers cut = cut_blockers(scene_, translucent_);
    has_cut_blockers_ = !cut.indices.empty();
    if (has_cut_blockers_) {
        RTCGeometry geometry = make_geometry(cut.positions, cut.indices);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(blockers_.get(), geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(blockers_.get());
}

void EmbreeScene::update(const SceneChange& change) {
    if (change.is_another_scene)
        throw std::invalid_argument("EmbreeScene::update: the scene has other triangles than before");
    if (change.boxes.empty())
        return;
    measure();
    move_geometry(handle_.get(), 0, scene_.positions);
    if (!translucent_.empty())
        move_geometry(handle_.get(), 1, scene_.positions);
    if (has_cut_blockers_)
        move_geometry(blockers_.get(), 1, cut_blockers(scene_, translucent_).positions);
    rtcCommitScene(handle_.get());
    if (blockers_)
        rtcCommitScene(blockers_.get());
    check(device_.get(), "fitting the BVH");
}

std::optional<Hit> EmbreeScene::trace(const glm::vec3& origin, const glm::vec3& direction,
                                      float length) const {
    RTCRayHit query{};
    query.ray.org_x = origin.x;
    query.ray.org_y = origin.y;
    query.ray.org_z = origin.z;
    query.ray.dir_x = direction.x;
    query.ray.dir_y = direction.y;
    query.ray.dir_z = direction.z;
    query.ray.tfar = length;
    query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(handle_.get(), &query);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(handle_.get(), &context, &query);
#endif
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return std::nullopt;

    const std::uint32_t number = (query.hit.geomID == 0 ? opaque_ : translucent_)[query.hit.primID];
    const Triangle& triangle = scene_.triangles[number];
    const glm::vec3& a = scene_.positions[triangle.vertex[0]];
    const glm::vec3& b = scene_.positions[triangle.vertex[1]];
    const glm::vec3& c = scene_.positions[triangle.vertex[2]];
    const float u = query.hit.u;
    const float v = query.hit.v;
    Hit hit{};
    // By its weights on the triangle a point is more precise than by the length of the ray.
    hit.position = (1.0f - u - v) * a + u * b + v * c;
    glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
    hit.from_inside = glm::dot(normal, direction) > 0.0f;
    hit.geometric_normal = hit.from_inside ? -normal : normal;
    hit.shading_normal = hit.geometric_normal;
    if (!scene_.normals.empty()) {
        const glm::vec3 smooth = interpolated_normal(scene_, triangle, u, v);
        const float size = glm::length(smooth);
        if (size > 0.0f)
            hit.shading_normal = smooth / (glm::dot(smooth, hit.geometric_normal) < 0.0f ? -size : size);
    }
    hit.triangle = number;
    hit.u = u;
    hit.v = v;
    hit.material = triangle.material;
    return hit;
}

}  // namespace demo
