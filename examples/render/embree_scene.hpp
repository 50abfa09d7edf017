// SPDX-License-Identifier: MIT
#pragma once

#include "adapters/embree_intersector.hpp"
#include "scene/scene.hpp"
#include "scene/scene_change.hpp"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace demo {

/// The place where a ray first meets a surface.
struct Hit {
    glm::vec3 position;
    glm::vec3 geometric_normal;  ///< unit length, towards where the ray came from
    glm::vec3 shading_normal;    ///< unit length, on the same side
    std::uint32_t triangle;      ///< of an instance the part's
    float u, v;                  ///< weights of the triangle's second and third vertex
    std::uint32_t material;
    bool from_inside;  ///< whether the ray came from the back of the triangle
};

/// A scene's triangles in an Embree BVH. Those that light may pass lie in a geometry of their own, where
/// filters ask the materials. The parts that instances show have BVHs of their own, each once. Const members
/// may be used by any number of threads.
class EmbreeScene {
public:
    /// The use that the BVH is made for: `films` takes an `update` in a fraction of the time to build it, and
    /// more memory.
    enum class For { stills, films };

    /// Builds the BVH, on all cores. The scene must outlive this. Throws std::runtime_error with Embree's own
    /// words.
    explicit EmbreeScene(const Scene& scene, For use = For::stills);
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    /// After the scene's triangles have changed: takes them anew, as a new object of the same scene would.
    /// Where they have only moved, the BVHs of films keep their shape, and only their boxes are fitted.
    /// `handle()` stays; `blockers()` does if there were some before and after. Not while another thread uses
    /// this, or anything that was made from it. Throws std::invalid_argument for another scene,
    /// std::runtime_error with Embree's own words.
    void update(const SceneChange& change);

    const Scene& scene() const { return scene_; }
    RTCScene handle() const { return levels_.front().handle.get(); }
    /// The surfaces that throw full shadows, for depth maps: triangles that light may pass are cut along
    /// their masks, and left out where they let more than half of it through. The same as `handle()` if there
    /// are none.
    RTCScene blockers() const { return levels_.front().blocking(); }
    EmbreeIntersector intersector() const { return EmbreeIntersector(handle()); }

    /// Seconds that the BVH took.
    double seconds_building() const { return seconds_building_; }
    /// The distance by which rays leave surfaces behind them, along the normal: world units, by the size of
    /// the coordinates.
    float offset() const { return offset_; }
    /// Of the box around all triangles.
    float diagonal() const { return diagonal_; }
    /// A distance beyond everything: where rays to directional lights end.
    float far_away() const { return 2.0f * diagonal_; }

    /// The first surface on origin + t * direction, 0 < t < length.
    std::optional<Hit> trace(const glm::vec3& origin, const glm::vec3& direction,
                             float length = std::numeric_limits<float>::infinity()) const;

private:
    struct Release {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    using SceneHandle = std::unique_ptr<RTCSceneTy, Release>;

    /// Triangles with a BVH of their own: those that lie where they are drawn, or those of a part.
    struct Level {
        const EmbreeScene& owner;
        MeshPart triangles;
        /// Triangles that block everywhere, and those that may not, by their number in the scene.
        std::vector<std::uint32_t> opaque{};
        std::vector<std::uint32_t> translucent{};
        SceneHandle handle{};
        SceneHandle blockers{};         ///< null: the same
        bool has_cut_blockers = false;  ///< as the second geometry of `blockers`
        unsigned instance_count = 0;    ///< in either of the two

        RTCScene blocking() const { return blockers ? blockers.get() : handle.get(); }
    };

    static void pass_holes(const RTCFilterFunctionNArguments* hits);
    static void pass_light(const RTCFilterFunctionNArguments* hits);

    void measure();
    /// In scenes of Embree's without geometries; null: in new ones.
    void build_levels(SceneHandle top, SceneHandle top_blockers);
    void rebuild();
    void add_level(const MeshPart& triangles);
    void build(Level& level, bool with_blockers);
    RTCScene new_scene() const;
    std::span<const glm::vec3> points_of(const Level& level) const;
    /// By their number among the level's vertices.
    std::vector<std::uint32_t> corners_of(const Level& level,
                                          const std::vector<std::uint32_t>& numbers) const;
    RTCGeometry make_geometry(std::span<const glm::vec3> points,
                              const std::vector<std::uint32_t>& corners) const;
    void add_translucent(Level& level);
    void add_blockers(Level& level, RTCGeometry opaque);
    void add_instances(RTCScene to, bool of_blockers);
    std::uint32_t surface_number(std::uint32_t triangle, unsigned instance) const;
    void update(Level& level);

    const Scene& scene_;
    For use_;
    double seconds_building_;
    float offset_;
    float diagonal_;
    std::unique_ptr<RTCDeviceTy, Release> device_;
    /// First the triangles that lie where they are drawn, whose BVHs have the instances too; then the parts.
    std::deque<Level> levels_;
};

}  // namespace demo
