// SPDX-License-Identifier: MIT

#include "render/embree_scene.hpp"

#include "render/stopwatch.hpp"
#include "scene/blockers.hpp"
#include "scene/boxes.hpp"
#include "scene/surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

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

void copy_positions(std::span<const glm::vec3> points, void* buffer) {
    auto* positions = static_cast<float*>(buffer);
    for (const glm::vec3& position : points)
        for (int axis = 0; axis < 3; ++axis)
            *positions++ = position[axis];
}

void* vertices_of(RTCScene scene, unsigned number) {
    return rtcGetGeometryBufferData(rtcGetGeometry(scene, number), RTC_BUFFER_TYPE_VERTEX, 0);
}

/// Gives a geometry of a committed scene its vertices' new places.
void move_geometry(RTCScene scene, unsigned number, std::span<const glm::vec3> points) {
    RTCGeometry geometry = rtcGetGeometry(scene, number);
    copy_positions(points, vertices_of(scene, number));
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
}

/// Embree's number of the first instance: those before are geometries of triangles.
constexpr unsigned first_instance = 2;

void set_transform(RTCGeometry geometry, const Instance& instance) {
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &instance.transform[0][0]);
    rtcCommitGeometry(geometry);
}

/// The first geometries, and instances.
void detach(RTCScene scene, unsigned of_triangles, unsigned instances) {
    for (unsigned i = 0; i < of_triangles; ++i)
        rtcDetachGeometry(scene, i);
    for (unsigned i = 0; i < instances; ++i)
        rtcDetachGeometry(scene, first_instance + i);
}

glm::vec3 interpolated_normal(const Scene& scene, const Triangle& triangle, float u, float v) {
    const glm::vec3& a = scene.normals[triangle.vertex[0]];
    const glm::vec3& b = scene.normals[triangle.vertex[1]];
    const glm::vec3& c = scene.normals[triangle.vertex[2]];
    return (1.0f - u - v) * a + u * b + v * c;
}

}  // namespace

/// Rays that look for surfaces pass holes.
void EmbreeScene::pass_holes(const RTCFilterFunctionNArguments* hits) {
    const auto& level = *static_cast<const Level*>(hits->geometryUserPtr);
    for (unsigned i = 0; i < hits->N; ++i) {
        if (hits->valid[i] == 0)
            continue;
        const std::uint32_t triangle = level.translucent[RTCHitN_primID(hits->hit, hits->N, i)];
        if (is_hole(level.owner.scene(), triangle, RTCHitN_u(hits->hit, hits->N, i),
                    RTCHitN_v(hits->hit, hits->N, i)))
            hits->valid[i] = 0;
    }
}

/// Shadow rays pass surfaces by the share of light that these let through.
void EmbreeScene::pass_light(const RTCFilterFunctionNArguments* hits) {
    const auto& level = *static_cast<const Level*>(hits->geometryUserPtr);
    for (unsigned i = 0; i < hits->N; ++i) {
        if (hits->valid[i] == 0)
            continue;
        const std::uint32_t triangle = level.translucent[RTCHitN_primID(hits->hit, hits->N, i)];
        const float share = share_let_through(level.owner.scene(), triangle, RTCHitN_u(hits->hit, hits->N, i),
                                              RTCHitN_v(hits->hit, hits->N, i));
        const std::uint32_t surface =
            level.owner.surface_number(triangle, RTCHitN_instID(hits->hit, hits->N, i, 0));
        if (EmbreeIntersector::passes(hits, i, surface, share))
            hits->valid[i] = 0;
    }
}

EmbreeScene::EmbreeScene(const Scene& scene, For use)
    : scene_(scene), use_(use), device_(rtcNewDevice(nullptr)) {
    measure();
    if (!device_)
        throw_embree_error(rtcGetDeviceError(nullptr), "opening the device");
    const Stopwatch watch;
    build_levels(nullptr, nullptr);
    check(device_.get(), "building the BVH");
    seconds_building_ = watch.seconds();
}

void EmbreeScene::build_levels(SceneHandle top, SceneHandle top_blockers) {
    add_level({0, own_vertices(scene_), 0, own_triangles(scene_)});
    for (const MeshPart& part : scene_.parts)
        add_level(part);
    const bool lets_light_through =
        std::ranges::any_of(levels_, [](const Level& level) { return !level.translucent.empty(); });
    for (std::size_t part = 1; part < levels_.size(); ++part)
        build(levels_[part], !levels_[part].translucent.empty());
    levels_.front().handle = std::move(top);
    if (lets_light_through)
        levels_.front().blockers = std::move(top_blockers);
    build(levels_.front(), lets_light_through);
}

void EmbreeScene::rebuild() {
    const Stopwatch watch;
    Level& top = levels_.front();
    detach(top.handle.get(), top.translucent.empty() ? 1 : 2, top.instance_count);
    if (top.blockers)
        detach(top.blockers.get(), top.has_cut_blockers ? 2 : 1, top.instance_count);
    SceneHandle handle = std::move(top.handle);
    SceneHandle blockers = std::move(top.blockers);
    levels_.clear();
    build_levels(std::move(handle), std::move(blockers));
    seconds_building_ = watch.seconds();
}

/// What chance knows a surface by: other instances of a triangle are other ones.
std::uint32_t EmbreeScene::surface_number(std::uint32_t triangle, unsigned instance) const {
    const bool is_placed = instance != RTC_INVALID_GEOMETRY_ID;
    if (scene_.surfaces.empty())
        return triangle + (is_placed ? 0x9e3779b9u * (instance + 1) : 0);
    return scene_.surfaces[triangle] + (is_placed ? scene_.instances[instance - first_instance].surface : 0);
}

void EmbreeScene::add_level(const MeshPart& triangles) {
    Level& level = levels_.emplace_back(Level{*this, triangles});
    for (std::uint32_t t = 0; t < triangles.triangle_count; ++t) {
        const std::uint32_t number = triangles.first_triangle + t;
        (may_let_light_through(scene_.materials[scene_.triangles[number].material]) ? level.translucent
                                                                                    : level.opaque)
            .push_back(number);
    }
}

void EmbreeScene::build(Level& level, bool with_blockers) {
    if (!level.handle)
        level.handle.reset(new_scene());
    check(device_.get(), "making the scene");
    RTCGeometry blocking = make_geometry(points_of(level), corners_of(level, level.opaque));
    rtcCommitGeometry(blocking);
    rtcAttachGeometry(level.handle.get(), blocking);
    if (!level.translucent.empty())
        add_translucent(level);
    if (&level == &levels_.front())
        level.instance_count = static_cast<unsigned>(scene_.instances.size());
    if (with_blockers)
        add_blockers(level, blocking);
    rtcReleaseGeometry(blocking);
    if (&level == &levels_.front())
        add_instances(level.handle.get(), false);
    rtcCommitScene(level.handle.get());
}

void EmbreeScene::measure() {
    const Bounds bounds = bounds_of(scene_);
    const glm::vec3 farthest = glm::max(glm::abs(bounds.low), glm::abs(bounds.high));
    diagonal_ = diagonal_of(bounds);
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

std::span<const glm::vec3> EmbreeScene::points_of(const Level& level) const {
    return std::span(scene_.positions).subspan(level.triangles.first_vertex, level.triangles.vertex_count);
}

std::vector<std::uint32_t> EmbreeScene::corners_of(const Level& level,
                                                   const std::vector<std::uint32_t>& numbers) const {
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * numbers.size());
    for (const std::uint32_t t : numbers)
        for (const std::uint32_t vertex : scene_.triangles[t].vertex)
            corners.push_back(vertex - level.triangles.first_vertex);
    return corners;
}

RTCGeometry EmbreeScene::make_geometry(std::span<const glm::vec3> points,
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

void EmbreeScene::add_translucent(Level& level) {
    RTCGeometry geometry = make_geometry(points_of(level), corners_of(level, level.translucent));
    rtcSetGeometryUserData(geometry, &level);
    rtcSetGeometryIntersectFilterFunction(geometry, pass_holes);
    rtcSetGeometryOccludedFilterFunction(geometry, pass_light);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(level.handle.get(), geometry);
    rtcReleaseGeometry(geometry);
}

void EmbreeScene::add_blockers(Level& level, RTCGeometry opaque) {
    if (!level.blockers)
        level.blockers.reset(new_scene());
    rtcAttachGeometry(level.blockers.get(), opaque);
    const Blockers cut = cut_blockers(scene_, level.translucent);
    level.has_cut_blockers = !cut.indices.empty();
    if (level.has_cut_blockers) {
        RTCGeometry geometry = make_geometry(cut.positions, cut.indices);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(level.blockers.get(), geometry);
        rtcReleaseGeometry(geometry);
    }
    if (&level == &levels_.front())
        add_instances(level.blockers.get(), true);
    rtcCommitScene(level.blockers.get());
}

void EmbreeScene::add_instances(RTCScene to, bool of_blockers) {
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
        const Instance& instance = scene_.instances[i];
        const Level& part = levels_[instance.part + 1];
        RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, of_blockers ? part.blocking() : part.handle.get());
        set_transform(geometry, instance);
        rtcAttachGeometryByID(to, geometry, first_instance + static_cast<unsigned>(i));
        rtcReleaseGeometry(geometry);
    }
}

void EmbreeScene::update(const SceneChange& change) {
    if (change.is_another_scene)
        throw std::invalid_argument("EmbreeScene::update: the scene is another one than before");
    if (!change.changes_triangles())
        return;
    measure();
    if (change.has_other_triangles) {
        rebuild();
        check(device_.get(), "building the BVH anew");
        return;
    }
    for (std::size_t part = 1; part < levels_.size(); ++part) {
        const std::span<const glm::vec3> points = points_of(levels_[part]);
        if (std::memcmp(vertices_of(levels_[part].handle.get(), 0), points.data(), points.size_bytes()) != 0)
            update(levels_[part]);
    }
    update(levels_.front());
    check(device_.get(), "fitting the BVH");
}

void EmbreeScene::update(Level& level) {
    move_geometry(level.handle.get(), 0, points_of(level));
    if (!level.translucent.empty())
        move_geometry(level.handle.get(), 1, points_of(level));
    if (level.has_cut_blockers)
        move_geometry(level.blockers.get(), 1, cut_blockers(scene_, level.translucent).positions);
    for (RTCScene bvh : {level.handle.get(), level.blockers.get()}) {
        if (bvh == nullptr)
            continue;
        for (std::size_t i = 0; &level == &levels_.front() && i < scene_.instances.size(); ++i)
            set_transform(rtcGetGeometry(bvh, first_instance + static_cast<unsigned>(i)),
                          scene_.instances[i]);
        rtcCommitScene(bvh);
    }
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
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(handle(), &query);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(handle(), &context, &query);
#endif
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return std::nullopt;

    const Instance* instance = query.hit.instID[0] == RTC_INVALID_GEOMETRY_ID
                                   ? nullptr
                                   : &scene_.instances[query.hit.instID[0] - first_instance];
    const Level& level = levels_[instance == nullptr ? 0 : instance->part + 1];
    const std::uint32_t number = (query.hit.geomID == 0 ? level.opaque : level.translucent)[query.hit.primID];
    const Triangle& triangle = scene_.triangles[number];
    const auto corner = [&](int k) {
        const glm::vec3& point = scene_.positions[triangle.vertex[k]];
        return instance == nullptr ? point : placed(*instance, point);
    };
    const glm::vec3 a = corner(0);
    const glm::vec3 b = corner(1);
    const glm::vec3 c = corner(2);
    const float u = query.hit.u;
    const float v = query.hit.v;
    Hit hit{};
    // By its weights on the triangle a point is more precise than by the length of the ray.
    hit.position = (1.0f - u - v) * a + u * b + v * c;
    glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
    if (instance != nullptr && is_mirrored(*instance))
        normal = -normal;
    hit.from_inside = glm::dot(normal, direction) > 0.0f;
    hit.geometric_normal = hit.from_inside ? -normal : normal;
    hit.shading_normal = hit.geometric_normal;
    if (!scene_.normals.empty()) {
        glm::vec3 smooth = interpolated_normal(scene_, triangle, u, v);
        if (instance != nullptr)
            smooth = placed_normal(*instance, smooth);
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
