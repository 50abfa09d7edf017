// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/cache/frozen_store.hpp>
#include <lightmesh/cache/query.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/cache/snapshot_reader.hpp>
#include <lightmesh/cache_settings.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/fill/mesh_filler.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/snapshot_reader.hpp>
#include <lightmesh/query/block_query.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/query/view_query.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/surface_point.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

namespace lightmesh {

namespace detail {
struct SnapshotReaders;
}

/// A mesh or a cache that was saved by `LightMesh::snapshot` or `VisibilityCache::snapshot`, read where its
/// bytes stand: in a vector, or in a file that is mapped into memory. Nothing is copied but the lights.
///
/// Queries are const, may be made from any number of threads, and allocate nothing unless a tracer has to
/// find what the snapshot lacks.
class SnapshotView {
public:
    /// `bytes` must outlive the view and begin at a multiple of 16. All of them are checked: throws
    /// std::invalid_argument that says what is wrong.
    explicit SnapshotView(std::span<const std::byte> bytes) {
        if (detail::is_cache_snapshot(bytes))
            cache_ = std::make_unique<const detail::CacheReader>(bytes);
        else
            reader_ = std::make_unique<const detail::SnapshotReader>(bytes);
        if (cache_)
            mesh_settings_ = cache_->row_source().settings();
    }
    /// A view of bytes that are about to vanish is a mistake.
    explicit SnapshotView(std::vector<std::byte>&&) = delete;

    /// Number of lights: the columns of a query's result.
    std::size_t light_count() const { return lights().size(); }
    /// The lights that the mesh or the cache had.
    std::span<const Light> lights() const { return cache_ ? cache_->user_lights() : reader_->user_lights(); }
    /// True if it is of a cache.
    bool is_cache() const { return cache_ != nullptr; }
    /// The settings that the mesh had, but those of shadow maps; the origin is that of its grid. Of a cache
    /// of blur rows: those of its mesh.
    const Settings& settings() const { return cache_ ? mesh_settings_ : reader_->settings(); }
    /// The settings that the cache had, but its memory budget; of a mesh the default.
    CacheSettings cache_settings() const { return cache_ ? cache_->settings() : CacheSettings{}; }

    /// S_i(P) of every light without a tracer, as `LightMesh::visibility`; NaN for what needs a ray or a word
    /// that is not there. So with `ShortTest::none` all that was asked before is answered, but points without
    /// neighbours; with the other short tests lights that cannot reach the point are 0, and all others NaN:
    /// even where all light points around agree, only a ray tells that the point sees one of them.
    /// A point with a footprint is answered where what its levels need was asked before.
    /// Of a cache what was asked before is answered where no ray guards against leaks, which is most of flat
    /// surfaces. Returns the number of NaN, also those of points or normals that are not finite. Throws as
    /// `LightMesh::visibility`.
    std::size_t visibility(const glm::vec3& point, const glm::vec3& normal, std::span<float> all) const {
        return visibility(SurfacePoint{.position = point, .normal = normal}, all);
    }
    /// The same for a point that carries more than P and n.
    std::size_t visibility(const SurfacePoint& at, std::span<float> all) const {
        check_size(all);
        if (cache_)
            return query_cache(at, all);
        const detail::LevelChoice choice = reader_->rule()(at.footprint);
        query_level(choice.level, at, 1.0f, all);
        if (choice.is_between())
            query_level(choice.level + 1, at, choice.coarser_share, all);
        return count_unknown(all);
    }

    /// The same as the live mesh gives, to the bit, if `tracer` is of the same scene: rays of it are short
    /// tests, and find what is not there, each time anew. A snapshot of a mesh with shadow maps or volumes
    /// has the same values only where nothing is missing: long tests here are rays. Throws
    /// std::invalid_argument if the snapshot is of a cache and the tracer has `closest_hit` where the cache's
    /// had not, or has not where that had. `statistics` counts for meshes only.
    template <class Tracer>
    void visibility(const Tracer& tracer, const glm::vec3& point, const glm::vec3& normal,
                    std::span<float> all, QueryStatistics* statistics = nullptr) const {
        visibility(tracer, SurfacePoint{.position = point, .normal = normal}, all, statistics);
    }
    /// The same for a point that carries more than P and n.
    template <class Tracer>
    void visibility(const Tracer& tracer, const SurfacePoint& at, std::span<float> all,
                    QueryStatistics* statistics = nullptr) const {
        static_assert(check_intersector<Tracer>());
        check_size(all);
        if (cache_) {
            query_cache(tracer, at, all);
            return;
        }
        if (statistics != nullptr)
            ++statistics->points;
        const detail::LevelChoice choice = reader_->rule()(at.footprint);
        query_level(tracer, choice.level, at, 1.0f, all, statistics);
        if (choice.is_between())
            query_level(tracer, choice.level + 1, at, choice.coarser_share, all, statistics);
    }

private:
    friend detail::SnapshotReaders;

    /// Of what is in `all` the values of the level replace `share`.
    void query_level(int k, const SurfacePoint& at, float share, std::span<float> all) const {
        if (const detail::SnapshotLevel* level = reader_->find(k))
            detail::query_view(level->view(), at.position, at.normal, share, all);
        else
            detail::query_nothing(reader_->grid_of(k), reader_->lights(), at.position, at.normal, all);
    }

    /// The same; what the snapshot lacks is found anew.
    template <class Tracer>
    void query_level(const Tracer& tracer, int k, const SurfacePoint& at, float share, std::span<float> all,
                     QueryStatistics* statistics) const {
        const detail::PointBatch batch{
            .positions = {&at.position, 1}, .normals = {&at.normal, 1}, .shares = {&share, 1}};
        if (const detail::SnapshotLevel* level = reader_->find(k)) {
            try {
                detail::BlockQuery(detail::FrozenFiller<Tracer>(tracer, level->view()), statistics)
                    .run(batch, all);
                return;
            } catch (const detail::NotInSnapshot&) {
            }
        }
        const detail::RayLongTests long_tests;
        const detail::MeshFiller<Tracer, detail::RayLongTests> fresh(
            tracer, long_tests, reader_->user_lights(), detail::settings_of_level(reader_->settings(), k),
            reader_->grid_of(k));
        detail::BlockQuery(fresh, statistics).run(batch, all);
    }

    static std::size_t count_unknown(std::span<const float> all) {
        return static_cast<std::size_t>(
            std::ranges::count_if(all, [](float lit) { return std::isnan(lit); }));
    }

    std::size_t query_cache(const SurfacePoint& at, std::span<float> all) const {
        const detail::NoTracer nothing;
        const detail::FrozenCacheStore<detail::NoTracer> store(nothing, *cache_);
        detail::CacheQuery query(store);
        try {
            query.all(at, all);
        } catch (const detail::NotInCacheSnapshot&) {
            for (std::size_t light = 0; light < all.size(); ++light) {
                try {
                    all[light] = query.one(at, light);
                } catch (const detail::NotInCacheSnapshot&) {
                    all[light] = std::numeric_limits<float>::quiet_NaN();
                }
            }
        }
        return count_unknown(all);
    }

    template <class Tracer>
    void query_cache(const Tracer& tracer, const SurfacePoint& at, std::span<float> all) const {
        if (detail::hit_kind<Tracer>() != cache_->hits())
            throw std::invalid_argument("lightmesh: one of tracer and snapshot has found surfaces by "
                                        "closest_hit, the other by bisection");
        const detail::FrozenCacheStore<Tracer> store(tracer, *cache_);
        try {
            detail::CacheQuery(store).all(at, all);
        } catch (const detail::NotInCacheSnapshot&) {
            if (cache_->row_source().is_mesh == 0)
                VisibilityCache<Tracer>(tracer, lights(), cache_->settings()).visibility(at, all);
            else
                VisibilityCache{LightMesh<Tracer>(tracer, lights(), mesh_settings_), cache_->settings()}
                    .visibility(at, all);
        }
    }

    void check_size(std::span<float> all) const {
        detail::require_size("visibilities", all.size(), light_count());
    }

    std::unique_ptr<const detail::SnapshotReader> reader_;  ///< null for a cache
    std::unique_ptr<const detail::CacheReader> cache_;      ///< null for a mesh
    Settings mesh_settings_;                                ///< of a cache's mesh
};

namespace detail {

/// The source that a view reads from, for what is laid out anew from it.
struct SnapshotReaders {
    /// Null for a cache.
    static const SnapshotReader* mesh(const SnapshotView& view) { return view.reader_.get(); }
    /// Null for a mesh.
    static const CacheReader* cache(const SnapshotView& view) { return view.cache_.get(); }
};

}  // namespace detail

}  // namespace lightmesh
