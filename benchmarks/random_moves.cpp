// SPDX-License-Identifier: MIT

// The row "equality to a fresh mesh after 10,000 random moves" of "Scenes that move": lights and objects of a
// small world move, come and go, memory is given back, and after each move values are held against those of a
// new mesh, or cache, of the world as it is then.

#include "mesh_frame.hpp"
#include "render/text_table.hpp"

#include <lightmesh/lightmesh.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

using lightmesh::Bounds;

/// Always the same numbers.
class Numbers {
public:
    std::size_t below(std::size_t end) { return engine_() % end; }
    float between(float low, float high) {
        return low + (high - low) * static_cast<float>(engine_() >> 8) * 0x1p-24f;
    }
    glm::vec3 in_box(const glm::vec3& low, const glm::vec3& high) {
        const float x = between(low.x, high.x);
        const float y = between(low.y, high.y);
        const float z = between(low.z, high.z);
        return {x, y, z};
    }

private:
    std::mt19937 engine_{5};
};

/// Solid boxes, the first of which is the floor.
struct Boxes {
    std::vector<Bounds> all;

    /// The first surface along `way`, inner sides included, in lengths of it, with the normal.
    std::optional<lightmesh::Hit> hit(const glm::vec3& origin, const glm::vec3& way, float first) const {
        std::optional<lightmesh::Hit> nearest;
        for (const Bounds& box : all) {
            float enter = -std::numeric_limits<float>::infinity();
            float leave = std::numeric_limits<float>::infinity();
            int enter_axis = 0;
            int leave_axis = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const float low = box.low[axis] - origin[axis];
                const float high = box.high[axis] - origin[axis];
                if (way[axis] == 0.0f) {
                    if (low > 0.0f || high < 0.0f)
                        leave = -std::numeric_limits<float>::infinity();
                    continue;
                }
                const float from = (std::min)(low / way[axis], high / way[axis]);
                const float to = (std::max)(low / way[axis], high / way[axis]);
                if (from > enter)
                    enter = from, enter_axis = axis;
                if (to < leave)
                    leave = to, leave_axis = axis;
            }
            if (enter > leave || leave <= first)
                continue;
            const bool is_outside = enter > first;
            const float at = is_outside ? enter : leave;
            if (nearest && at >= nearest->distance)
                continue;
            glm::vec3 normal(0.0f);
            normal[is_outside ? enter_axis : leave_axis] = 1.0f;
            nearest = lightmesh::Hit{at, normal};
        }
        return nearest;
    }
};

/// All adapters of the world as it is when they are asked.
struct Tracer {
    const Boxes* boxes;
    bool occluded(const lightmesh::Segment& segment) const { return closest_hit(segment).has_value(); }
    std::optional<lightmesh::Hit> closest_hit(const lightmesh::Segment& segment) const {
        const glm::vec3 way = segment.target - segment.origin;
        auto hit = boxes->hit(segment.origin, way, 0.0f);
        if (!hit || hit->distance >= 1.0f)
            return std::nullopt;
        hit->distance *= glm::length(way);
        return hit;
    }
};
struct Pictures {
    const Boxes* boxes;
    void render_depth(const lightmesh::DepthView& view, std::span<float> distance) const {
        for (int row = 0; row < view.resolution; ++row)
            for (int column = 0; column < view.resolution; ++column) {
                const lightmesh::DepthRay ray = view.ray(column, row);
                const auto hit = boxes->hit(ray.origin, ray.direction,
                                            view.z_near / glm::dot(ray.direction, view.forward));
                distance[static_cast<std::size_t>(row * view.resolution + column)] =
                    hit ? hit->distance : std::numeric_limits<float>::infinity();
            }
    }
    Bounds bounds() const {
        Bounds around = boxes->all[0];
        for (const Bounds& box : boxes->all)
            around = {glm::min(around.low, box.low), glm::max(around.high, box.high)};
        return around;
    }
};
struct Triangles {
    const Boxes* boxes;
    std::size_t triangle_count() const { return 12 * boxes->all.size(); }
    /// Two to a side: low and high ones of each axis.
    std::array<glm::vec3, 3> triangle(std::size_t i) const {
        const Bounds& box = boxes->all[i / 12];
        const auto axis = static_cast<int>(i % 12 / 4);
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        glm::vec3 a = box.low;
        a[axis] = i % 4 / 2 == 0 ? box.low[axis] : box.high[axis];
        glm::vec3 c = a;
        c[u] = box.high[u];
        c[v] = box.high[v];
        glm::vec3 b = a;
        const int turned = i % 2 == 0 ? u : v;
        b[turned] = box.high[turned];
        return {a, b, c};
    }
};

/// A floor with boxes that move about on it, and up to 16 lights.
class World {
public:
    World() {
        boxes_.all.push_back({{-5.0f, -5.0f, -0.5f}, {5.0f, 5.0f, 0.0f}});
        for (int i = 0; i < 6; ++i)
            boxes_.all.push_back(new_box());
        for (int i = 0; i < 10; ++i)
            lights_.push_back(new_light());
        is_there_.assign(lights_.size(), true);
    }
    World(const World&) = delete;
    World& operator=(const World&) = delete;

    const Boxes& boxes() const { return boxes_; }
    std::span<const lightmesh::Light> lights() const { return lights_; }
    Numbers& numbers() { return numbers_; }

    /// A light or an object moves, comes or goes.
    template <class Subject>
    void move(Subject& subject) {
        const std::size_t i = numbers_.below(lights_.size());
        const std::size_t kind = numbers_.below(10);
        if (kind < 5)
            return move_boxes(subject);
        if (kind < 8 || (kind == 9 && !is_there_[i])) {
            lights_[i] = new_light();
            is_there_[i] = true;
            return subject.set_light(i, lights_[i]);
        }
        if (kind == 9) {
            lights_[i] = lightmesh::PointLight{.range = 0.0f};
            is_there_[i] = false;
            return subject.remove_light(i);
        }
        if (lights_.size() == 16 && std::ranges::find(is_there_, false) == is_there_.end())
            return move_boxes(subject);
        const lightmesh::Light light = new_light();
        const std::size_t added = subject.add_light(light);
        if (added == lights_.size()) {
            lights_.emplace_back();
            is_there_.push_back(true);
        }
        lights_[added] = light;
        is_there_[added] = true;
    }

    /// On the floor, or on a box as it is now.
    lightmesh::SurfacePoint point() {
        const Bounds& box = boxes_.all[numbers_.below(boxes_.all.size())];
        lightmesh::SurfacePoint point{.position = numbers_.in_box(box.low, box.high),
                                      .normal = glm::vec3(0.0f)};
        const auto side = static_cast<int>(numbers_.below(6));
        const int axis = side == 0 ? 2 : side % 3;
        const bool is_high = side < 4;
        point.position[axis] = is_high ? box.high[axis] : box.low[axis];
        point.normal[axis] = is_high ? 1.0f : -1.0f;
        point.footprint = numbers_.below(2) == 0 ? 0.0f : numbers_.between(0.02f, 2.0f);
        return point;
    }

private:
    template <class Subject>
    void move_boxes(Subject& subject) {
        std::vector<Bounds> changed;
        for (std::size_t count = 1 + numbers_.below(2); count > 0; --count) {
            Bounds& box = boxes_.all[1 + numbers_.below(boxes_.all.size() - 1)];
            changed.push_back(box);
            const glm::vec3 by = numbers_.in_box({-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.1f});
            box = numbers_.below(3) == 0 ? new_box() : Bounds{box.low + by, box.high + by};
            changed.push_back(box);
        }
        subject.scene_changed(changed);
    }
    Bounds new_box() {
        const glm::vec3 low = numbers_.in_box({-4.0f, -4.0f, 0.0f}, {3.0f, 3.0f, 0.5f});
        return {low, low + numbers_.in_box({0.2f, 0.2f, 0.3f}, {1.2f, 1.2f, 2.0f})};
    }
    lightmesh::Light new_light() {
        const glm::vec3 position = numbers_.in_box({-4.0f, -4.0f, 1.0f}, {4.0f, 4.0f, 5.0f});
        switch (numbers_.below(4)) {
        case 0:
            return lightmesh::SpotLight{position, {0.2f, 0.1f, -1.0f}, numbers_.between(0.3f, 1.2f)};
        case 1:
            return lightmesh::DirectionalLight{numbers_.in_box({-1, -1, -2}, {1, 1, -0.5f}), 0.02f};
        case 2:
            return lightmesh::PointLight{.position = position, .range = numbers_.between(2.0f, 8.0f)};
        default:
            return lightmesh::PointLight{.position = position, .radius = 0.2f};
        }
    }

    Numbers numbers_;
    Boxes boxes_;
    std::vector<lightmesh::Light> lights_;
    std::vector<bool> is_there_;
};

constexpr std::size_t no_budget = (std::numeric_limits<std::size_t>::max)();

lightmesh::Settings mesh_settings(std::size_t budget) {
    return {.radius = 0.8f, .quality = 3.0f, .shadow_map_size = 16, .memory_budget = budget};
}

/// make(world, budget) knows nothing yet, and may keep no more than its budget from frame to frame.
template <class Make>
void count_differences(const std::string& name, int moves, const Make& make) {
    const auto begin = std::chrono::steady_clock::now();
    World world;
    const std::size_t least = make(world, no_budget).statistics().bytes;
    auto subject = make(world, least + std::size_t{300'000});
    std::vector<lightmesh::SurfacePoint> points;
    for (int i = 0; i < 16; ++i)
        points.push_back(world.point());
    std::size_t compared = 0;
    std::size_t differing = 0;
    for (int move = 1; move <= moves; ++move) {
        world.move(subject);
        if (move % 8 == 0)
            subject.begin_frame();
        if (move % 50 == 0)
            subject.compact();
        points[world.numbers().below(points.size())] = world.point();
        const auto fresh = make(world, no_budget);
        std::vector<float> values(subject.light_count());
        std::vector<float> expected(values.size());
        for (int i = 0; i < 3; ++i) {
            const lightmesh::SurfacePoint& point = points[world.numbers().below(points.size())];
            subject.visibility(point, values);
            fresh.visibility(point, expected);
            for (std::size_t l = 0; l < values.size(); ++l)
                differing += values[l] != expected[l] ? 1u : 0u;
            compared += values.size();
        }
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    bench::print_row("equality to a fresh mesh after " + std::to_string(moves) + " random moves: " + name,
                     static_cast<double>(differing), 0.0, false,
                     "differences, of " + std::to_string(compared) + " values; " + demo::fixed(seconds, 0) +
                         " s");
}

}  // namespace

/// Another number of moves may be given.
int main(int argument_count, char** arguments) {
    const int moves = argument_count > 1 ? std::atoi(arguments[1]) : 10000;
    const auto by_rays = [](const World& world, std::size_t budget) {
        return lightmesh::LightMesh{Tracer{&world.boxes()}, world.lights(), mesh_settings(budget)};
    };
    const auto by_maps = [](const World& world, std::size_t budget) {
        return lightmesh::LightMesh{Tracer{&world.boxes()}, Pictures{&world.boxes()}, world.lights(),
                                    mesh_settings(budget)};
    };
    const auto by_volumes = [](const World& world, std::size_t budget) {
        return lightmesh::LightMesh{Tracer{&world.boxes()}, Triangles{&world.boxes()}, world.lights(),
                                    mesh_settings(budget)};
    };
    const auto cache_of = [](const auto& make_mesh) {
        return [&make_mesh](const World& world, std::size_t budget) {
            return lightmesh::VisibilityCache{
                make_mesh(world, budget),
                lightmesh::CacheSettings{.spacing = 0.4f, .detail = 1, .memory_budget = budget}};
        };
    };
    count_differences("a mesh by rays", moves, by_rays);
    count_differences("a mesh by shadow maps", moves, by_maps);
    count_differences("a mesh by shadow volumes", moves, by_volumes);
    count_differences("a cache of lamps, by rays", moves, [](const World& world, std::size_t budget) {
        return lightmesh::VisibilityCache{
            Tracer{&world.boxes()}, world.lights(),
            lightmesh::CacheSettings{.spacing = 0.4f, .detail = 2, .lamp_rays = 16, .memory_budget = budget}};
    });
    count_differences("a cache of a mesh by rays", moves, cache_of(by_rays));
    count_differences("a cache of a mesh by shadow maps", moves, cache_of(by_maps));
    count_differences("a cache of a mesh by shadow volumes", moves, cache_of(by_volumes));
}
