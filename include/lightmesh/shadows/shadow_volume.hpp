// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/occluders.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/shadows/cube_faces.hpp>
#include <lightmesh/shadows/shadow_map_views.hpp>
#include <lightmesh/shadows/shadow_volume_grid.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>
#include <lightmesh/support/made_once.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace lightmesh {

/// Shadows of one light by shadow volumes (Crow, "Shadow Algorithms for Computer Graphics", 1977): V(L, x) of
/// a point x is 0 if x lies in the space that a triangle hides from the light, a pyramid without end, cut off
/// by the triangle. Exact: no maps, no rays, no bias; computed in double from the triangles as they are.
///
/// The volumes are found by the direction from the light: six grids of lists (one for a directional light),
/// each made when a look-up first needs it. Look-ups are const and may be made from any number of threads at
/// once; their results do not depend on who came first. They allocate memory for new grids only, and throw
/// only std::bad_alloc.
///
/// The answer is that of a ray but where the ray cannot tell: within rounding of a silhouette or of a
/// surface. A point on a triangle, or between the light and it, is not hidden by it. A triangle seen exactly
/// from its edge hides nothing.
///
/// Range and cone of a light play no part: that is for the user of V. A point that is not finite is dark.
class ShadowVolumes {
public:
    /// Triangles nearer to the light than `clearance`, along the way to a point, do not hide it, nor, from a
    /// point that is nearer than twice that, those on the light's half of the way. World units, finite, not
    /// negative; it plays no part for directional lights. `name` is what errors call the light. Throws
    /// std::invalid_argument that names the value.
    ShadowVolumes(std::shared_ptr<const OccluderTriangles> triangles, const Light& light,
                  float clearance = 0.0f, const std::string& name = "light")
        : triangles_(std::move(triangles)), clearance_(static_cast<double>(clearance)) {
        detail::check_light(light, name);
        detail::require(clearance >= 0.0f && std::isfinite(clearance), name + ": shadow volumes' clearance",
                        clearance, "finite and not negative");
        if (const auto* sun = std::get_if<DirectionalLight>(&light)) {
            frames_.push_back(parallel_frame(*sun));
        } else {
            add_cube(detail::shape_of(light).at);
        }
        grids_ = std::make_unique<LazyGrid[]>(frames_.size());
        side_ = side_of_grid();
    }

    /// The same, for a light of its own.
    template <class Source>
        requires(!std::convertible_to<Source, std::shared_ptr<const OccluderTriangles>>)
    ShadowVolumes(const Source& source, const Light& light, float clearance = 0.0f)
        : ShadowVolumes(std::make_shared<const OccluderTriangles>(source), light, clearance) {}

    /// V(L, x): true for lit.
    bool visible(const glm::vec3& point) const {
        if (!detail::is_finite(point))
            return false;
        const std::size_t face = face_of(point);
        const detail::SeenPoint seen = frames_[face].see(point);
        if (frames_[face].parallel && !(std::abs(seen.xyw.x) <= 1.0 && std::abs(seen.xyw.y) <= 1.0))
            return true;
        const double distance = glm::length(seen.xyw);
        const double clearance = distance > 2.0 * clearance_ ? clearance_ / distance : 0.5;
        return !grid(face).dark(*triangles_, seen, clearance);
    }

    /// lit[i] = 1 if points[i] is lit, else 0. Throws std::invalid_argument if the spans differ in size.
    void visible(std::span<const glm::vec3> points, std::span<std::uint8_t> lit) const {
        detail::require(points.size() == lit.size(), "the size of the span of answers", lit.size(),
                        "that of the span of points");
        for (std::size_t i = 0; i < points.size(); ++i)
            lit[i] = visible(points[i]) ? 1 : 0;
    }

    /// True if how the light looks depends on where the triangles are: that of a directional light.
    bool fits_triangles() const { return frames_.front().parallel; }
    /// The distance of a light with a position from the origin, along the axis where that is most; world
    /// units.
    float distance() const {
        const glm::dvec3 at = (glm::abs)(frames_.front().eye);
        return fits_triangles() ? 0.0f : static_cast<float>((std::max)((std::max)(at.x, at.y), at.z));
    }
    /// True if the light of another one looks along the same axes at the same scale: then both say the same
    /// of points that only triangles hide which both have.
    bool has_frames_of(const ShadowVolumes& other) const {
        return frames_ == other.frames_ && clearance_ == other.clearance_;
    }

    /// Takes the grids of another one, of a light that looks in the same way, that hold none of the triangles
    /// which differ: `changed` are the numbers of those, and of both there are as many. Nothing else may use
    /// either of the two meanwhile.
    void take_grids(ShadowVolumes& other, std::span<const std::uint32_t> changed) {
        if (!has_frames_of(other) || triangles_->size() != other.triangles_->size())
            return;
        for (std::size_t f = 0; f < frames_.size(); ++f) {
            if (other.grids_[f].grid.get() == nullptr)
                continue;
            const auto is_held = [&](std::uint32_t i) {
                return detail::ShadowVolumeGrid::may_hold(frames_[f], (*triangles_)[i]) ||
                       detail::ShadowVolumeGrid::may_hold(frames_[f], (*other.triangles_)[i]);
            };
            if (std::ranges::none_of(changed, is_held))
                grids_[f].grid.publish(other.grids_[f].grid.take());
        }
    }

    /// Grids made so far.
    std::size_t made() const {
        std::size_t count = 0;
        for (std::size_t f = 0; f < frames_.size(); ++f)
            count += grids_[f].grid.get() != nullptr ? 1u : 0u;
        return count;
    }

    /// Memory held by now, without the triangles.
    std::size_t bytes() const {
        std::size_t sum = sizeof *this + frames_.size() * (sizeof(detail::LightFrame) + sizeof(LazyGrid));
        for (std::size_t i = 0; i < frames_.size(); ++i)
            if (const auto* made = grids_[i].grid.get())
                sum += made->bytes();
        return sum;
    }

private:
    struct LazyGrid {
        detail::MadeOnce<detail::ShadowVolumeGrid> grid;
        std::mutex making;
    };

    /// Cells of a grid to each side: as many cells in all grids as there are triangles, or half as many
    /// again.
    int side_of_grid() const {
        const double root = std::sqrt(static_cast<double>(triangles_->size()));
        return std::clamp(static_cast<int>(frames_.size() == 1 ? root : 0.5 * root), 8, 2048);
    }

    void add_cube(const glm::vec3& position) {
        for (std::size_t face = 0; face < detail::cube_face_count; ++face) {
            const DepthView view = detail::view_along(position, detail::cube_face_axis(face), 1);
            frames_.push_back({glm::dvec3(position), glm::dvec3(view.right), glm::dvec3(view.down),
                               glm::dvec3(view.forward), false});
        }
    }

    /// Just large enough for all triangles.
    detail::LightFrame parallel_frame(const DirectionalLight& sun) const {
        const DepthView view = detail::view_along(glm::vec3(0.0f), detail::unit_or_zero(sun.direction), 1);
        detail::LightFrame frame{glm::dvec3(0.0), glm::dvec3(view.right), glm::dvec3(view.down),
                                 glm::dvec3(view.forward), true};
        glm::dvec3 low(0.0);
        glm::dvec3 high(0.0);
        for (std::size_t i = 0; i < triangles_->size(); ++i) {
            for (const glm::vec3& corner : (*triangles_)[i]) {
                const detail::SeenPoint seen = frame.see(corner);
                const glm::dvec3 at(seen.xyw.x, seen.xyw.y, seen.depth);
                const bool first = i == 0 && &corner == &(*triangles_)[0][0];
                low = first ? at : (glm::min)(low, at);
                high = first ? at : (glm::max)(high, at);
            }
        }
        const glm::dvec3 centre = 0.5 * (low + high);
        const glm::dvec3 half = (glm::max)(0.5000001 * (high - low), glm::dvec3(1e-30));
        frame.eye = centre.x * frame.right + centre.y * frame.down + centre.z * frame.forward;
        frame.right /= half.x;
        frame.down /= half.y;
        return frame;
    }

    std::size_t face_of(const glm::vec3& point) const {
        return frames_.size() == 1 ? 0 : detail::cube_face_of(glm::dvec3(point) - frames_.front().eye);
    }

    const detail::ShadowVolumeGrid& grid(std::size_t face) const {
        LazyGrid& lazy = grids_[face];
        if (const auto* made = lazy.grid.get())
            return *made;
        const std::scoped_lock lock(lazy.making);
        if (lazy.grid.get() == nullptr)
            lazy.grid.publish(std::make_unique<detail::ShadowVolumeGrid>(*triangles_, frames_[face], side_));
        return *lazy.grid.get();
    }

    std::shared_ptr<const OccluderTriangles> triangles_;
    double clearance_;
    std::vector<detail::LightFrame> frames_;
    std::unique_ptr<LazyGrid[]> grids_;
    int side_ = 8;
};

}  // namespace lightmesh
