// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/adapters/occluders.hpp>
#include <lightmesh/fill/map_source.hpp>
#include <lightmesh/fill/volume_source.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/shadow_rays.hpp>
#include <lightmesh/surface_point.hpp>
#include <lightmesh/tune/candidate.hpp>
#include <lightmesh/tune/require.hpp>
#include <lightmesh/tune/watch.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace lightmesh::tune {

/// Shading points to measure on: where the user's own renderer asks for visibility. Both spans have one
/// entry per point and must outlive the subject.
///
/// Order them as the renderer does. The best sample of a frame is some hundred of its tiles, spread over it,
/// a block of neighbouring pixels after the other: times then profit from neighbours as the frame will. Some
/// 10,000 points are plenty.
struct Samples {
    std::span<const glm::vec3> points;   ///< world units
    std::span<const glm::vec3> normals;  ///< geometric, on the shaded side
    /// The number of points that a whole frame asks for; 0: as many as there are samples.
    std::size_t points_per_frame = 0;
    /// All points of a frame, in any order, or none. With them the light points of a frame are counted, in
    /// empty space; without, they are estimated from how the samples share light points, which can be wrong
    /// by several times where the radius is small.
    std::span<const glm::vec3> frame_points{};
    std::span<const glm::vec3> frame_normals{};  ///< as many
    /// Of caches: how wide pixels are at the points, as `SurfacePoint::footprint`, or none. Without them a
    /// cache is refined beyond what pixels show.
    std::span<const float> footprints{};
    std::span<const float> frame_footprints{};  ///< the same at the points of the frame
};

namespace detail {

/// Points that are asked for together, as `LightMesh::visibility` for many points likes it.
inline constexpr std::size_t block_size = 64;

/// Points with what is known of them, as a cache takes them.
inline std::vector<SurfacePoint> surface_points(std::span<const glm::vec3> points,
                                                std::span<const glm::vec3> normals,
                                                std::span<const float> footprints) {
    std::vector<SurfacePoint> known(points.size());
    for (std::size_t i = 0; i < known.size(); ++i)
        known[i] = {.position = points[i],
                    .normal = normals[i],
                    .footprint = footprints.empty() ? 0.0f : footprints[i]};
    return known;
}

/// The work that a `BorrowedRenderer` has done.
struct RendererCost {
    double seconds = 0.0;
    std::size_t texels = 0;
};

/// A `DepthRenderer` that many meshes use one after the other, and that keeps count of what they ask for.
template <class Renderer>
class BorrowedRenderer {
public:
    BorrowedRenderer(Renderer& renderer, RendererCost& cost) : renderer_(&renderer), cost_(&cost) {}

    void render_depth(const DepthView& view, std::span<float> distance) {
        const Watch watch;
        renderer_->render_depth(view, distance);
        cost_->seconds += watch.seconds();
        cost_->texels += distance.size();
    }

    void render_depth(std::span<const DepthView> views,
                      std::span<const std::span<float>> distances) requires BatchDepthRenderer<Renderer> {
        const Watch watch;
        renderer_->render_depth(views, distances);
        cost_->seconds += watch.seconds();
        for (const std::span<float>& distance : distances)
            cost_->texels += distance.size();
    }

    Bounds bounds() const requires BoundedDepthRenderer<Renderer> { return renderer_->bounds(); }

private:
    Renderer* renderer_;
    RendererCost* cost_;
};

}  // namespace detail

/// The subject that is tuned: a tracer, its lights, and the points that it shades.
///
///     lightmesh::tune::Subject subject{Tracer{...}, lights, samples};
///     lightmesh::tune::Subject subject{Tracer{...}, lights, samples, Rasteriser{...}, Triangles{...}};
///
/// `Sources` are what the user has for long tests other than rays: a `DepthRenderer` and `Occluders`, either
/// or both. They are adapters as `LightMesh` takes them and stay here; meshes that are tried borrow them.
template <class Tracer, class... Sources>
class Subject {
    static_assert(check_intersector<Tracer>());
    static_assert(((DepthRenderer<Sources> || Occluders<Sources>)&&...),
                  "lightmesh: each source of long tests must be a DepthRenderer or Occluders");

public:
    /// Throws std::invalid_argument that names the value for no points, a number of normals other than that
    /// of points, points or normals that are not finite, points of a frame that are not as many as a frame
    /// has, no lights, and lights that `LightMesh` would refuse.
    Subject(Tracer tracer, std::span<const Light> lights, Samples samples, Sources... sources)
        : tracer_(std::move(tracer)), lights_(lights.begin(), lights.end()), samples_(samples),
          sources_(std::move(sources)...) {
        check_samples();
        if (samples_.points_per_frame == 0)
            samples_.points_per_frame =
                samples_.frame_points.empty() ? samples_.points.size() : samples_.frame_points.size();
        check_frame();
        if (lights_.empty())
            throw std::invalid_argument("lightmesh: there are no lights; tuning needs at least one");
        find_diagonal();
        static_cast<void>(ShadowRays(lights_, resolution()));  // Throws for lights that are not fit.
    }

    /// The user's tracer.
    const Tracer& tracer() const { return tracer_; }
    /// The user's lights.
    const std::vector<Light>& lights() const { return lights_; }
    /// The user's shading points, `points_per_frame` filled in.
    const Samples& samples() const { return samples_; }
    /// Of the box around the samples, world units.
    float diagonal() const { return diagonal_; }
    /// For `ShadowRays`: the smallest radius that the scene may ask for, world units.
    float resolution() const { return diagonal_ > 0.0f ? diagonal_ / 500.0f : 1.0f; }

    /// Throws std::invalid_argument that names the candidate if its settings are out of range, or if it wants
    /// a source that is not there; std::out_of_range if a point lies outside the grid of a mesh or the
    /// lattice of a cache.
    void check(const Candidate& candidate, const Settings& base) const {
        const std::string name = "candidate (" + describe(candidate) + "): ";
        if (is_cache(candidate)) {
            // A cache without lights refuses the same, and traces nothing.
            const VisibilityCache cache{tracer_, std::span<const Light>{}, cache_settings_of(candidate)};
            cache.visibility(samples_.points, samples_.normals, std::span<float>{});
            cache.visibility(samples_.frame_points, samples_.frame_normals, std::span<float>{});
            return;
        }
        const Grid grid(settings_of(candidate, base));
        for (const std::span<const glm::vec3> points : {samples_.points, samples_.frame_points})
            for (const glm::vec3& point : points)
                static_cast<void>(grid.locate(point));
        if (uses_shadow_maps(candidate.long_test)) {
            if constexpr (!has_renderer)
                throw std::invalid_argument("lightmesh: " + name + "it needs a DepthRenderer");
            detail::require(candidate.shadow_map_size >= 1 && candidate.shadow_map_size <= 16384,
                            name + "Candidate::shadow_map_size", candidate.shadow_map_size, "in [1, 16384]");
        } else {
            detail::require(candidate.shadow_map_size == 0, name + "Candidate::shadow_map_size",
                            candidate.shadow_map_size, "0, since there are no shadow maps");
        }
        if constexpr (!has_occluders)
            if (candidate.long_test == LongTest::shadow_volumes)
                throw std::invalid_argument("lightmesh: " + name + "it needs Occluders");
    }

    /// Makes the mesh of a candidate that has passed `check` and is no cache, and calls use(mesh). What
    /// shadow maps cost is added to `cost`.
    template <class Use>
    void with_mesh(const Candidate& candidate, const Settings& base, detail::RendererCost& cost,
                   Use&& use) const {
        const Settings settings = settings_of(candidate, base);
        if constexpr (has_renderer) {
            if (uses_shadow_maps(candidate.long_test)) {
                auto& renderer = std::get<find_renderer()>(sources_);
                use(LightMesh{tracer_, detail::BorrowedRenderer(renderer, cost), lights_, settings});
                return;
            }
        }
        if constexpr (has_occluders) {
            if (candidate.long_test == LongTest::shadow_volumes) {
                use(LightMesh{tracer_, std::get<find_occluders()>(sources_), lights_, settings});
                return;
            }
        }
        use(LightMesh{tracer_, lights_, settings});
    }

    /// Makes a cache with every k-th of the lights so that there are at most `most_lights`, and calls
    /// use(cache).
    template <class Use>
    void with_cache(const Candidate& candidate, std::size_t most_lights, Use&& use) const {
        std::vector<Light> some;
        const std::size_t count = (std::min)(most_lights, lights_.size());
        for (std::size_t i = 0; i < count; ++i)
            some.push_back(lights_[i * lights_.size() / count]);
        use(VisibilityCache{tracer_, some, cache_settings_of(candidate)});
    }

private:
    void find_diagonal() {
        glm::vec3 low = samples_.points.front();
        glm::vec3 high = low;
        for (const glm::vec3& point : samples_.points) {
            low = (glm::min)(low, point);
            high = (glm::max)(high, point);
        }
        diagonal_ = static_cast<float>(glm::length(glm::dvec3(high) - glm::dvec3(low)));
    }

    static constexpr bool has_renderer = (DepthRenderer<Sources> || ...);
    static constexpr bool has_occluders = (Occluders<Sources> || ...);

    static constexpr std::size_t first_of(std::initializer_list<bool> flags) {
        std::size_t i = 0;
        for (const bool flag : flags) {
            if (flag)
                return i;
            ++i;
        }
        return i;
    }
    static constexpr std::size_t find_renderer() { return first_of({DepthRenderer<Sources>...}); }
    static constexpr std::size_t find_occluders() { return first_of({Occluders<Sources>...}); }

    void check_samples() const {
        if (samples_.points.empty())
            throw std::invalid_argument("lightmesh: there are no sample points; tuning needs at least one");
        check_points(samples_.points, samples_.normals, "sample");
        check_footprints(samples_.footprints, samples_.points.size(), "Samples::footprints");
    }

    void check_frame() const {
        check_points(samples_.frame_points, samples_.frame_normals, "frame");
        check_footprints(samples_.frame_footprints, samples_.frame_points.size(),
                         "Samples::frame_footprints");
        if (!samples_.frame_points.empty())
            detail::require(samples_.points_per_frame == samples_.frame_points.size(),
                            "Samples::points_per_frame", samples_.points_per_frame,
                            "as many as there are frame_points, or 0");
    }

    static void check_footprints(std::span<const float> footprints, std::size_t count,
                                 const std::string& name) {
        if (!footprints.empty())
            detail::require(footprints.size() == count, "the size of " + name, footprints.size(),
                            "that of the points, or 0");
    }

    static void check_points(std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                             const std::string& whose) {
        if (normals.size() != points.size())
            throw std::invalid_argument("lightmesh: the span of " + whose + " normals has " +
                                        std::to_string(normals.size()) + " places; it must have " +
                                        std::to_string(points.size()));
        for (std::size_t i = 0; i < points.size(); ++i) {
            using detail::is_finite;
            detail::require(is_finite(points[i]), whose + " point " + std::to_string(i), points[i], "finite");
            detail::require(is_finite(normals[i]), whose + " normal " + std::to_string(i), normals[i],
                            "finite");
        }
    }

    Tracer tracer_;
    std::vector<Light> lights_;
    Samples samples_;
    // Rendering changes a renderer, but not what a subject is.
    float diagonal_ = 0.0f;
    mutable std::tuple<Sources...> sources_;
};

}  // namespace lightmesh::tune
