// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/fill/mesh_filler.hpp>
#include <lightmesh/fill/source.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/merge.hpp>
#include <lightmesh/mesh/snapshot_reader.hpp>
#include <lightmesh/mesh/snapshot_writer.hpp>
#include <lightmesh/query/query.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/surface_point.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <concepts>
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
template <class Tracer, class Source = Rays>
class LightMesh {
    static_assert(check_intersector<Tracer>());

public:
    /// Copies adapter and lights. Any number of lights, also none. Throws std::invalid_argument that names
    /// the value for settings out of range and lights that are not finite.
    LightMesh(Tracer tracer, std::span<const Light> lights,
              const Settings& settings) requires std::same_as<Source, Rays>
        : filler_(std::make_unique<const Filler>(std::move(tracer), lights, settings)) {}

    /// The same with long tests by something else than rays. `source` is either a `DepthRenderer`, for shadow
    /// maps (LMM+ATK): nothing is rendered before a query needs it. Throws std::invalid_argument also for a
    /// map size out of range, and for a directional light if nobody knows the scene's bounds. Or `source` is
    /// `Occluders`, for shadow volumes (LMM+ATO): S as with rays but within rounding of a shadow's edge;
    /// settings and bounds of shadow maps play no part. Throws what `OccluderTriangles` throws, which names a
    /// triangle that is not finite.
    LightMesh(Tracer tracer, Source source, std::span<const Light> lights,
              const Settings& settings) requires(!std::same_as<Source, Rays>)
        : filler_(std::make_unique<const Filler>(std::move(tracer), lights, settings, std::move(source),
                                                 lights, settings)) {}

    /// Number of lights: the columns of a query's result.
    std::size_t light_count() const { return data().lights().size(); }
    /// As they were passed in.
    std::span<const Light> lights() const { return data().user_lights(); }
    /// The mesh's copy of the adapter.
    const Tracer& tracer() const { return filler_->tracer(); }
    /// Where the light points lie.
    const Grid& grid() const { return data().grid(); }
    /// As they were passed in.
    const Settings& settings() const { return data().settings(); }
    /// How V(L, x) is found.
    LongTest long_test() const {
        constexpr LongTest kind = Filler::LongTestsType::kind;
        return kind == LongTest::shadow_maps && settings().refine_shadow_maps ? LongTest::refined_shadow_maps
                                                                              : kind;
    }

    /// S_i(P) of equation (3) for one light: how lit the point is, 0 in shadow to 1 lit. Throws
    /// std::out_of_range for a light that is not there. `spent`, if given, has this query's cost added.
    float visibility(const glm::vec3& point, const glm::vec3& normal, std::size_t light,
                     QueryStatistics* spent = nullptr) const {
        if (light >= light_count())
            throw_no_such_light(light);
        return detail::query_one(*filler_, point, normal, light, spent);
    }

    /// S_i(P) of every light, in one pass over the neighbours: much cheaper than light by light, and the same
    /// values. Throws std::invalid_argument if `all` does not have exactly `light_count()` places.
    void visibility(const glm::vec3& point, const glm::vec3& normal, std::span<float> all,
                    QueryStatistics* spent = nullptr) const {
        detail::require_size("visibilities", all.size(), light_count());
        detail::BlockQuery(*filler_, spent).run({&point, 1}, {&normal, 1}, all);
    }

    /// S_i(P) of every light for many points, which share the rays' batches: the same values, faster for
    /// points near to each other (a tile of pixels). `all` is row-major, a row of `light_count()` for each
    /// point. Throws std::invalid_argument unless there are as many normals and rows as points.
    void visibility(std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                    std::span<float> all, QueryStatistics* spent = nullptr) const {
        detail::require_size("normals", normals.size(), points.size());
        detail::require_size("visibilities", all.size(), points.size() * light_count());
        detail::BlockQuery(*filler_, spent).run(points, normals, all);
    }

    /// The same for points that carry more than P and n. A light mesh uses these two.
    float visibility(const SurfacePoint& point, std::size_t light, QueryStatistics* spent = nullptr) const {
        return visibility(point.position, point.normal, light, spent);
    }
    /// As above.
    void visibility(const SurfacePoint& point, std::span<float> all, QueryStatistics* spent = nullptr) const {
        visibility(point.position, point.normal, all, spent);
    }
    /// As above.
    void visibility(std::span<const SurfacePoint> points, std::span<float> all,
                    QueryStatistics* spent = nullptr) const {
        detail::require_size("visibilities", all.size(), points.size() * light_count());
        detail::BlockQuery query(*filler_, spent);
        for_each_block(points, [&](std::size_t first, std::span<const glm::vec3> positions,
                                   std::span<const glm::vec3> normals) {
            query.run(positions, normals,
                      all.subspan(first * light_count(), positions.size() * light_count()));
            return true;
        });
    }

    /// Finds and stores ahead of queries what they will need at these points: then they are as fast as on a
    /// filled mesh. From time to time progress(done, total), in points, is called; if it returns false,
    /// filling ends there. Returns whether it went to the end. May be called from any number of threads, for
    /// parts of the points each.
    template <class Progress>
    bool fill(std::span<const SurfacePoint> points, Progress&& progress) const {
        detail::BlockQuery query(*filler_, nullptr);
        return for_each_block(points, [&](std::size_t first, std::span<const glm::vec3> positions,
                                          std::span<const glm::vec3> normals) {
            query.fill(positions, normals);
            return static_cast<bool>(progress(first + positions.size(), points.size()));
        });
    }
    /// The same without progress.
    void fill(std::span<const SurfacePoint> points) const {
        fill(points, [](std::size_t, std::size_t) { return true; });
    }

    /// All that the mesh knows, as one block of bytes that can be saved, sent, merged into another mesh, and
    /// read in place by a `SnapshotView`. Meshes that know the same have the same bytes. May be taken while
    /// other threads query. Throws std::bad_alloc.
    std::vector<std::byte> snapshot() const { return detail::SnapshotWriter(data()).write(long_test()); }

    /// Adds what a snapshot knows and this mesh lacks: of a mesh with the same radius, quality, origin and
    /// kind of long tests, adaptive or not, of the same scene. Lights belong together by their numbers; those
    /// that differ contribute nothing, nor does anything that may have to do with the boxes in `changed`,
    /// where the scene is another one than it was for the snapshot. `bytes` must begin at a multiple of 16.
    ///
    /// Everything is checked before the mesh is touched: throws std::invalid_argument that says what is wrong
    /// with the bytes, or that more than 1 in 1,000 bits that both know differ. Where fewer differ, as with
    /// another processor's tracer, the mesh keeps its own. An exclusive call: nothing else may use the mesh
    /// meanwhile.
    void merge(std::span<const std::byte> bytes, std::span<const Bounds> changed = {}) {
        const detail::SnapshotReader from(bytes);
        detail::Merge(filler_->data(), from, long_test(), changed).run();
    }

    /// What the mesh holds by now. Walks over all of it.
    MeshStatistics statistics() const { return filler_->statistics(); }

private:
    using Filler = detail::MeshFiller<Tracer, typename detail::LongTestsOf<Source>::Type>;

    const detail::MeshData& data() const { return filler_->data(); }

    /// Calls visit(first, positions, normals) for blocks of points, until it returns false; returns whether
    /// it never did.
    template <class Visitor>
    static bool for_each_block(std::span<const SurfacePoint> points, Visitor&& visit) {
        constexpr std::size_t block = 256;
        std::array<glm::vec3, block> positions;
        std::array<glm::vec3, block> normals;
        for (std::size_t first = 0; first < points.size(); first += block) {
            const std::size_t size = (std::min)(block, points.size() - first);
            for (std::size_t i = 0; i < size; ++i) {
                positions[i] = points[first + i].position;
                normals[i] = points[first + i].normal;
            }
            if (!visit(first, std::span<const glm::vec3>(positions).first(size),
                       std::span<const glm::vec3>(normals).first(size)))
                return false;
        }
        return true;
    }

    [[noreturn]] void throw_no_such_light(std::size_t light) const {
        throw std::out_of_range("lightmesh: there is no light " + std::to_string(light) + "; the mesh has " +
                                std::to_string(light_count()));
    }

    std::unique_ptr<const Filler> filler_;
};

/// Which kernels queries use on this processor, chosen when the first query runs: "AVX-512", "AVX2" or
/// "portable".
inline const char* kernel_name() {
    return detail::kernels().name;
}

/// Long tests by rays, lights from any contiguous range.
template <class Tracer, class Lights>
LightMesh(Tracer, const Lights&, Settings) -> LightMesh<Tracer>;

/// Long tests by a `DepthRenderer` or by `Occluders`, whichever the source is.
template <class Tracer, class Source, class Lights>
LightMesh(Tracer, Source, const Lights&, Settings) -> LightMesh<Tracer, Source>;

}  // namespace lightmesh
