// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/visibility_store.hpp>
#include <lightmesh/query/kernels/kernels.hpp>
#include <lightmesh/query/query.hpp>
#include <lightmesh/query/query_many.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lightmesh {

/// Soft shadows from many lights: equations (1) to (3) of the light mesh method (Debelov, Sevastyanov,
/// Novikov, Vasilyeva, "Ray Tracing Based on Interpolation of Visibility of Point Light Sources", Springer
/// SCI 441, 2013).
///
/// A mesh starts empty and fills itself as it is queried. All queries are const and may be called from any
/// number of threads at once; their results do not depend on the number of threads or on the order of
/// queries. A query on a filled mesh allocates nothing; one that is the first to touch some part of space may
/// add memory to the mesh (and throw std::bad_alloc). Lights, settings and the scene behind the adapters are
/// fixed for the life of a mesh.
///
/// In a query, `point` is a surface point P in world units, and `normal` the geometric normal there, on the
/// side that is shaded; its length does not matter. A point or normal that is not finite gives NaN. A zero
/// normal has no hemisphere: the result is the exact shadow ray of the case m = 0, with chi = 1. A finite
/// point whose light points have no index (farther than 2^24 steps from the origin) throws std::out_of_range.
template <class Tracer, class LongTest = detail::RayLongTest, class Kernel = detail::FastestKernel>
class LightMesh {
    static_assert(check_intersector<Tracer>());

public:
    /// Copies adapter and lights. Any number of lights, also none. Throws std::invalid_argument that names
    /// the value for settings out of range and lights that are not finite.
    LightMesh(Tracer tracer, std::span<const Light> lights, const Settings& settings)
        : store_(std::make_unique<const Store>(std::move(tracer), lights, settings)),
          lights_(lights.begin(), lights.end()) {}

    /// The same with long tests by something else than rays. `source` is either a `DepthRenderer`, for shadow
    /// maps (LMM+ATK): nothing is rendered before a query needs it. Throws std::invalid_argument also for a
    /// map size out of range, and for a directional light if nobody knows the scene's bounds. Or `source` is
    /// `Occluders`, for shadow volumes (LMM+ATO): S as with rays but within rounding of a shadow's edge;
    /// settings and bounds of shadow maps play no part. Throws what `OccluderTriangles` throws, which names a
    /// triangle that is not finite.
    template <class Source>
    LightMesh(Tracer tracer, Source source, std::span<const Light> lights, const Settings& settings)
        : store_(std::make_unique<const Store>(std::move(tracer), lights, settings, std::move(source), lights,
                                               settings)),
          lights_(lights.begin(), lights.end()) {}

    /// Number of lights: the columns of a query's result.
    std::size_t light_count() const { return store_->lights().size(); }
    /// As they were passed in.
    std::span<const Light> lights() const { return lights_; }
    /// The mesh's copy of the adapter.
    const Tracer& tracer() const { return store_->tracer(); }
    /// Where the light points lie.
    const Grid& grid() const { return store_->grid(); }
    /// As they were passed in.
    const Settings& settings() const { return store_->settings(); }

    /// S_i(P) of equation (3) for one light: how lit the point is, 0 in shadow to 1 lit. Throws
    /// std::out_of_range for a light that is not there. `spent`, if given, has this query's cost added.
    float visibility(const glm::vec3& point, const glm::vec3& normal, std::size_t light,
                     QueryStatistics* spent = nullptr) const {
        if (light >= light_count())
            throw_no_such_light(light);
        detail::BrickPoints memory[detail::Hemisphere::max_entries];
        return Query(*store_, point, normal, spent).one(light, memory);
    }

    /// S_i(P) of every light, in one pass over the neighbours: much cheaper than light by light, and the same
    /// values. Throws std::invalid_argument if `all` does not have exactly `light_count()` places.
    void visibility(const glm::vec3& point, const glm::vec3& normal, std::span<float> all,
                    QueryStatistics* spent = nullptr) const {
        if (all.size() != light_count())
            throw_wrong_size("visibilities", all.size(), light_count());
        detail::BrickPoints memory[detail::Hemisphere::max_entries];
        Query(*store_, point, normal, spent).all(all, memory);
    }

    /// S_i(P) of every light for many points, which share the rays' batches: the same values, faster for
    /// points near to each other (a tile of pixels). `all` is row-major, a row of `light_count()` for each
    /// point. Throws std::invalid_argument unless there are as many normals and rows as points.
    void visibility(std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                    std::span<float> all, QueryStatistics* spent = nullptr) const {
        if (normals.size() != points.size())
            throw_wrong_size("normals", normals.size(), points.size());
        if (all.size() != points.size() * light_count())
            throw_wrong_size("visibilities", all.size(), points.size() * light_count());
        detail::query_many<Kernel>(*store_, points, normals, all, spent);
    }

    /// What the mesh holds by now. Walks over all of it.
    MeshStatistics statistics() const { return store_->statistics(); }

private:
    using Store = detail::VisibilityStore<Tracer, LongTest>;
    using Query = detail::Query<Store, Kernel>;

    [[noreturn]] void throw_no_such_light(std::size_t light) const {
        throw std::out_of_range("lightmesh: there is no light " + std::to_string(light) + "; the mesh has " +
                                std::to_string(light_count()));
    }
    [[noreturn]] static void throw_wrong_size(const char* what, std::size_t size, std::size_t expected) {
        throw std::invalid_argument("lightmesh: the span of " + std::string(what) + " has " +
                                    std::to_string(size) + " places; it must have " +
                                    std::to_string(expected));
    }

    std::unique_ptr<const Store> store_;
    std::vector<Light> lights_;
};

/// Long tests by rays, lights from any contiguous range.
template <class Tracer, class Lights>
LightMesh(Tracer, const Lights&, Settings) -> LightMesh<Tracer>;

/// Long tests by a `DepthRenderer` or by `Occluders`, whichever the source is.
template <class Tracer, class Source, class Lights>
LightMesh(Tracer, Source, const Lights&, Settings) -> LightMesh<Tracer, detail::LongTestFrom<Source>>;

}  // namespace lightmesh
