// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/fill/long_test.hpp>
#include <lightmesh/fill/mesh_filler.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/mesh/snapshot_reader.hpp>
#include <lightmesh/query/query.hpp>
#include <lightmesh/query/view_query.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace lightmesh {

/// A mesh that was saved by `LightMesh::snapshot`, read where its bytes stand: in a vector, or in a file that
/// is mapped into memory. Nothing is copied but the lights.
///
/// Queries are const, may be made from any number of threads, and allocate nothing unless a tracer has to
/// find what the snapshot lacks.
class SnapshotView {
public:
    /// `bytes` must outlive the view and begin at a multiple of 16. All of them are checked: throws
    /// std::invalid_argument that says what is wrong.
    explicit SnapshotView(std::span<const std::byte> bytes)
        : reader_(std::make_unique<const detail::SnapshotReader>(bytes)) {}
    /// A view of bytes that are about to vanish is a mistake.
    explicit SnapshotView(std::vector<std::byte>&&) = delete;

    /// Number of lights: the columns of a query's result.
    std::size_t light_count() const { return reader_->user_lights().size(); }
    /// The lights that the mesh had.
    std::span<const Light> lights() const { return reader_->user_lights(); }
    /// The settings that the mesh had, but those of shadow maps; the origin is that of its grid.
    const Settings& settings() const { return reader_->settings(); }

    /// S_i(P) of every light without a tracer, as `LightMesh::visibility`; NaN for what needs a ray or a word
    /// that is not there. So with `ShortTest::none` all that was asked before is answered, but points without
    /// neighbours; with the other short tests lights that cannot reach the point are 0, and all others NaN.
    /// Returns the number of NaN, also those of points or normals that are not finite. Throws as
    /// `LightMesh::visibility`.
    std::size_t visibility(const glm::vec3& point, const glm::vec3& normal, std::span<float> all) const {
        check_size(all);
        return detail::query_view(reader_->view(), point, normal, all);
    }

    /// The same as the live mesh gives, to the bit, if `tracer` is of the same scene: rays of it are short
    /// tests, and find what is not there, each time anew. A snapshot of a mesh with shadow maps or volumes
    /// has the same values only where nothing is missing: long tests here are rays.
    template <class Tracer>
    void visibility(const Tracer& tracer, const glm::vec3& point, const glm::vec3& normal,
                    std::span<float> all, QueryStatistics* spent = nullptr) const {
        static_assert(check_intersector<Tracer>());
        check_size(all);
        try {
            detail::BlockQuery(detail::FrozenFiller<Tracer>(tracer, reader_->view()), spent)
                .run({&point, 1}, {&normal, 1}, all);
        } catch (const detail::NotInSnapshot&) {
            const detail::MeshFiller<Tracer, detail::RayLongTests> fresh(
                tracer, reader_->user_lights(), reader_->settings(), reader_->grid());
            detail::BlockQuery(fresh, spent).run({&point, 1}, {&normal, 1}, all);
        }
    }

private:
    void check_size(std::span<float> all) const {
        detail::require_size("visibilities", all.size(), light_count());
    }

    std::unique_ptr<const detail::SnapshotReader> reader_;
};

}  // namespace lightmesh
