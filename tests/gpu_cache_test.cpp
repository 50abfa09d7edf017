// SPDX-License-Identifier: MIT
#include "gpu/compute.hpp"

#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

/// These tests need a Vulkan driver (Mesa's lavapipe will do) and the validation layers, and fail without
/// them.

namespace {

constexpr std::uint32_t query_words[] = {
#include "shaders/cache_query.comp.inc"
};
constexpr std::uint32_t query_with_rays_words[] = {
#include "shaders/cache_query_rays.comp.inc"
};

using Corners = std::vector<glm::vec4>;  // three of each triangle

float volume_of(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
    const glm::vec3 x = b - a;
    const glm::vec3 y = c - a;
    const glm::vec3 z = d - a;
    const glm::vec3 across(y.y * z.z - z.y * y.z, y.z * z.x - z.z * y.x, y.x * z.y - z.x * y.y);
    return (x.x * across.x + x.y * across.y) + x.z * across.z;
}

/// All triangles of a list: no quotient decides whether a segment meets one, so that shaders do the same.
struct SolidTracer {
    const Corners* corners;

    static bool meets(const lightmesh::Segment& s, const glm::vec3& a, const glm::vec3& b,
                      const glm::vec3& c) {
        if ((volume_of(s.origin, a, b, c) > 0.0f) == (volume_of(s.target, a, b, c) > 0.0f))
            return false;
        const std::array sides{volume_of(s.origin, s.target, a, b), volume_of(s.origin, s.target, b, c),
                               volume_of(s.origin, s.target, c, a)};
        return (sides[0] >= 0.0f && sides[1] >= 0.0f && sides[2] >= 0.0f) ||
               (sides[0] <= 0.0f && sides[1] <= 0.0f && sides[2] <= 0.0f);
    }
    bool occluded(const lightmesh::Segment& s) const {
        for (std::size_t i = 0; i < corners->size(); i += 3)
            if (meets(s, (*corners)[i], (*corners)[i + 1], (*corners)[i + 2]))
                return true;
        return false;
    }
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& s) const {
        std::optional<lightmesh::Hit> nearest;
        for (std::size_t i = 0; i < corners->size(); i += 3) {
            const glm::vec3 a((*corners)[i]);
            const glm::vec3 b((*corners)[i + 1]);
            const glm::vec3 c((*corners)[i + 2]);
            if (!meets(s, a, b, c))
                continue;
            const float before = volume_of(s.origin, a, b, c);
            const float share = before / (before - volume_of(s.target, a, b, c));
            const float distance = share * glm::length(s.target - s.origin);
            if (!nearest || distance < nearest->distance)
                nearest = lightmesh::Hit{distance, glm::normalize(glm::cross(b - a, c - a))};
        }
        return nearest;
    }
};

/// A floor, boxes of any direction, and a round one; with points on all of them.
class World {
public:
    World(std::uint32_t seed, const glm::vec3& middle, bool is_tall) : random_(seed), middle_(middle) {
        add_quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0});
        add_quad({-4, 3.5f, 0}, {8, 0, 0}, {0, 0, 3});
        for (int i = 0; i < 3; ++i)
            add_box(vector(2.5f), i == 0 ? 0.0f : between(0.0f, 3.0f));
        // A roof at 45 degrees, and a fan of facets.
        add_quad({-3, -3, 1}, {0, 1.5f, 0}, {1.2f, 0, 1.2f});
        if (is_tall)
            for (int i = 0; i < 8; ++i) {
                const auto corner = [&](int k) {
                    return glm::vec3(1.5f * std::cos(0.35f * static_cast<float>(k)), -1.0f,
                                     1.5f * std::sin(0.35f * static_cast<float>(k)));
                };
                add_quad(corner(i), corner(i + 1) - corner(i), {0, 2, 0});
            }
    }

    const Corners& corners() const { return corners_; }
    SolidTracer tracer() const { return {&corners_}; }
    float between(float low, float high) {
        return low + (high - low) * static_cast<float>(random_()) * 0x1p-32f;
    }
    glm::vec3 vector(float size) {
        const float x = between(-size, size);
        const float y = between(-size, size);
        return {x, y, between(-size, size)};
    }
    glm::vec3 place(const glm::vec3& from_middle) const { return middle_ + from_middle; }
    std::uint32_t number(std::uint32_t below) { return random_() % below; }

    /// Points on surfaces, some of them near to each other; `is_odd`: with all that may come with points.
    std::vector<lightmesh::SurfacePoint> points(std::size_t count, bool is_odd) {
        std::vector<lightmesh::SurfacePoint> points;
        while (points.size() < count) {
            const std::size_t i = 3 * number(static_cast<std::uint32_t>(corners_.size() / 3));
            const glm::vec3 a(corners_[i]);
            const glm::vec3 u = glm::vec3(corners_[i + 1]) - a;
            const glm::vec3 v = glm::vec3(corners_[i + 2]) - a;
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
                lights.push_back(lightmesh::SpotLight{at, vector(1), between(0.1f, 3.1f), range, between(0, 0.2f)});
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
        const auto add = [&](const glm::vec3& corner) { corners_.emplace_back(place(corner), 0.0f); };
        add(at), add(at + u), add(at + u + v);
        add(at), add(at + u + v), add(at + v);
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
    Corners corners_;
};

struct GpuPoint {
    glm::vec4 position;
    glm::vec4 normal;
    glm::vec4 shading_normal;
};

/// What a shader says.
struct Answers {
    std::vector<float> shares;         ///< a row for each point; -1: not known
    std::vector<glm::uvec2> unknown;   ///< for each point and tile
    std::vector<lightmesh::CacheRequest> requests;
    std::uint32_t asked = 0;
};

/// A device that is watched.
class Gpu {
public:
    Gpu() : device_({.validate = true, .on_message = [this](const std::string& text) { messages_.push_back(text); }}) {}

    const std::vector<std::string>& messages() const { return messages_; }

    Answers ask(const lightmesh::SnapshotView& view, std::span<const lightmesh::SurfacePoint> points,
                const Corners* corners, std::uint32_t room = 100'000) const {
        const lightmesh::CacheUpload upload(view);
        std::vector<GpuPoint> gpu_points;
        for (const lightmesh::SurfacePoint& p : points)
            gpu_points.push_back({glm::vec4(p.position, p.footprint), glm::vec4(p.normal, 0.0f),
                                  glm::vec4(p.shading_normal, 0.0f)});
        const std::size_t tiles = (view.light_count() + 63) / 64;
        const auto empty = lightmesh::CacheUpload::empty_requests(room);
        const demo::ComputeBuffer requests(device_, empty);
        const demo::ComputeBuffer shares(device_, points.size() * view.light_count() * sizeof(float));
        const demo::ComputeBuffer unknown(device_, points.size() * tiles * sizeof(glm::uvec2));
        std::vector<demo::ComputeBinding> bindings{
            {0, 0, demo::ComputeBuffer(device_, upload.places())},
            {0, 1, demo::ComputeBuffer(device_, upload.values())},
            {0, 2, requests},
            {1, 0, demo::ComputeBuffer(device_, std::as_bytes(std::span(gpu_points)))},
            {1, 1, shares},
            {1, 2, unknown}};
        if (corners != nullptr)
            bindings.push_back({1, 3, demo::ComputeBuffer(device_, std::as_bytes(std::span(*corners)))});
        const std::span<const std::uint32_t> words =
            corners != nullptr ? std::span<const std::uint32_t>(query_with_rays_words) : query_words;
        const demo::ComputeKernel kernel(device_, words, bindings);
        device_.run([&](const demo::ComputeCommands& commands) {
            commands.dispatch(kernel, static_cast<std::uint32_t>((points.size() + 63) / 64));
        });
        std::vector<std::byte> bytes(requests.size());
        requests.read(0, bytes);
        Answers answers;
        answers.shares = shares.read_all<float>();
        answers.unknown = unknown.read_all<glm::uvec2>();
        answers.asked = lightmesh::CacheUpload::request_count(bytes);
        answers.requests = lightmesh::CacheUpload::requests(bytes);
        return answers;
    }

private:
    std::vector<std::string> messages_;
    demo::ComputeDevice device_;
};

bool same_bits(float a, float b) {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

struct Differences {
    std::size_t values = 0;   ///< known on both sides, and not the same
    std::size_t known = 0;    ///< known on one side only
    std::size_t compared = 0;
    std::size_t between = 0;  ///< of those, neither 0 nor 1
};

/// What a snapshot knows without rays from points to lamps.
class KnownStore : public lightmesh::detail::FrozenCacheStore<SolidTracer> {
public:
    using FrozenCacheStore::FrozenCacheStore;

    template <class... Arguments>
    void exact(const Arguments&...) const {
        throw lightmesh::detail::NotInCacheSnapshot();
    }
};

/// Against the CPU: with `corners` links that are not known and ways to lattice points are traced.
Differences compare(std::span<const std::byte> bytes, std::span<const lightmesh::SurfacePoint> points,
                    const Corners* corners, const Answers& answers) {
    Differences found;
    const lightmesh::SnapshotView view(bytes);
    const lightmesh::detail::CacheReader reader(bytes);
    const SolidTracer tracer{corners};
    const KnownStore store(tracer, reader);
    lightmesh::detail::CacheQuery query(store);
    std::vector<float> all(view.light_count());
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (corners == nullptr)
            view.visibility(points[i], all);
        for (std::size_t l = 0; l < all.size(); ++l) {
            if (corners != nullptr) {
                try {
                    all[l] = query.one(points[i], l);
                } catch (const lightmesh::detail::NotInCacheSnapshot&) {
                    all[l] = std::numeric_limits<float>::quiet_NaN();
                }
            }
            const float share = answers.shares[i * all.size() + l];
            if (std::isnan(all[l]) != (share == -1.0f)) {
                ++found.known;
                continue;
            }
            if (std::isnan(all[l]))
                continue;
            found.values += same_bits(share, all[l]) ? 0 : 1;
            ++found.compared;
            found.between += share > 0.0f && share < 1.0f ? 1 : 0;
        }
    }
    return found;
}

}  // namespace

TEST_CASE("dev") {
    const Gpu gpu;
    for (const std::uint32_t count : {1u, 63u, 64u, 65u, 256u}) for (int k=0;k<2;++k) {
        World world(count, k ? glm::vec3(100000.0f,-300000.0f,20000.0f): glm::vec3(0.0f), true);
        const auto lights = world.lights(count);
        lightmesh::VisibilityCache cache{world.tracer(), lights, lightmesh::CacheSettings{.spacing = 0.25f, .detail = 2, .lamp_rays = 4}};
        auto points = world.points(400, true);
        cache.fill(std::span(points).first(300));
        const auto bytes = cache.snapshot();
        const lightmesh::SnapshotView view(bytes);
        const Corners* c=std::getenv("RAYS")?&world.corners():nullptr;
        const Answers answers = gpu.ask(view, points, c);
        const Differences d = compare(bytes, points, c, answers);
        MESSAGE(count << ": values " << d.values << " known " << d.known << " of " << d.compared << " between " << d.between << " of " << points.size() * count << " asked " << answers.asked);
    }
    CHECK(gpu.messages().empty());
}
