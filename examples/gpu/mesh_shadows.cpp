// SPDX-License-Identifier: MIT
#include "gpu/mesh_shadows.hpp"

#include "gpu/host_visibility.hpp"
#include "gpu/kept_shadows.hpp"
#include "gpu/listed_words.hpp"
#include "gpu/listing.hpp"
#include "gpu/uploaded.hpp"
#include "render/follow_scene.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/lightmesh.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// Points that shaders can ask for at once.
constexpr std::size_t request_capacity = std::size_t{1} << 16;

/// To ask at a point that is a rounding farther from its surface.
constexpr std::uint32_t most_roundings = 64;
/// Of asking and filling: some, since of points close together one asks. After that points ask in turn for
/// what the host does not fill.
constexpr int enough_turns = 16;

/// A mesh whose links and long tests shaders trace.
class MeshByRays {
public:
    MeshByRays(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
               const VisibilityOptions& options)
        : mesh_(scene.intersector(), shapes_of_lights(scene.scene()), mesh_settings_of(options)),
          link_tests_(device, copy), long_tests_(device, copy) {
        if (!options.known.empty())
            mesh_.merge(options.known);
    }

    /// Lets shaders see the mesh as they have it, for `fill`.
    void bind(const UploadedMesh& uploaded) {
        link_tests_.bind(uploaded.bindings(LinkTests::set));
        long_tests_.bind(uploaded.bindings(LongTests::set));
    }

    /// Finds what shaders lack at points.
    void fill(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        const auto links = list_on_all_threads<lightmesh::LinkList>(
            points, [&](auto some, auto& list) { mesh_.list_links(some, list); });
        mesh_.fill_links(links, [&](auto words, auto open) { link_tests_(words, open, cancel); });
        const auto missing = list_on_all_threads<lightmesh::LongTestList>(
            points, [&](auto some, auto& list) { mesh_.list_long_tests(some, list); });
        mesh_.fill(missing, [&](auto words, auto seen) { long_tests_(words, seen, cancel); });
    }

    void update(const EmbreeScene& scene, const SceneChange& change) {
        follow_scene(mesh_, shapes_of_lights(scene.scene()), change);
        mesh_.compact();
    }

    void begin_frame() {
        mesh_.begin_frame();
        mesh_.compact();
    }
    void merge(std::span<const std::byte> known) { mesh_.merge(known); }

    std::vector<std::byte> snapshot() const { return mesh_.snapshot(); }
    lightmesh::MeshStatistics mesh() const { return mesh_.statistics(); }
    DeviceFill spent() const {
        DeviceFill sum = link_tests_.spent();
        sum += long_tests_.spent();
        return sum;
    }

private:
    lightmesh::LightMesh<EmbreeIntersector> mesh_;
    LinkTests link_tests_;
    LongTests long_tests_;
};

/// As shaders ask for it the host lists what is missing.
template <class Host>
class MeshShadows final : public KeptShadows<Host, lightmesh::MeshUpload> {
public:
    template <class... OfHost>
    explicit MeshShadows(const ComputeDevice& device, const VisibilityOptions& options, OfHost&&... of_host)
        : KeptShadows<Host, lightmesh::MeshUpload>(device, options.settings.memory_budget,
                                                   lightmesh::empty_requests(request_capacity),
                                                   std::forward<OfHost>(of_host)...) {}

    void shade(Round& round, const std::atomic<bool>* cancel) override {
        std::uint32_t roundings = 0;
        int turns = 0;
        asked_before_.clear();
        for (auto asked = Asked::points; asked != Asked::nothing;) {
            this->bind(round.kernel());
            round.shade(roundings);
            asked = fill_asked(cancel);
            const bool is_stuck = asked == Asked::same_points || ++turns > enough_turns;
            if (is_stuck && ++roundings > most_roundings)
                throw std::runtime_error("--on gpu: host and device do not agree on what the light mesh "
                                         "lacks at a point");
        }
        this->note_use(round, cancel);
    }

    std::optional<lightmesh::MeshStatistics> mesh() const override { return this->host().mesh(); }
    std::size_t bytes() const override { return this->host().mesh().bytes; }

private:
    enum class Asked { nothing, points, same_points };

    /// Says whether shaders have asked, or asked what they had asked before the last time: rays along an edge
    /// may be blocked for the device and open for the host, which then does not know that there is something
    /// to fill.
    Asked fill_asked(const std::atomic<bool>* cancel) {
        const lightmesh::UploadRequests asked = lightmesh::read_requests(this->requests());
        if (asked.points.empty() && !asked.overflowed)
            return Asked::nothing;
        std::vector<std::array<float, 7>> sorted;
        for (const lightmesh::SurfacePoint& point : asked.points)
            sorted.push_back({point.position.x, point.position.y, point.position.z, point.normal.x,
                              point.normal.y, point.normal.z, point.footprint});
        std::ranges::sort(sorted);
        if (sorted == asked_before_)
            return Asked::same_points;
        asked_before_ = std::move(sorted);
        this->fill(asked.points, cancel);
        return Asked::points;
    }

    std::vector<std::array<float, 7>> asked_before_;  ///< positions, normals and footprints, sorted
};

}  // namespace

std::unique_ptr<DeviceShadows> make_mesh_shadows(const ComputeDevice& device, const std::string& algorithm,
                                                 const EmbreeScene& scene, const GpuScene& copy,
                                                 const VisibilityOptions& options) {
    const bool is_by_rays = algorithm.find('+') == std::string::npos;
    if (is_by_rays)
        return std::make_unique<MeshShadows<MeshByRays>>(device, options, device, scene, copy, options);
    return std::make_unique<MeshShadows<HostVisibility>>(device, options, algorithm, scene, options);
}

}  // namespace demo
