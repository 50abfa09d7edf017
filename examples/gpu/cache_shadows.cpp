// SPDX-License-Identifier: MIT
#include "gpu/cache_shadows.hpp"

#include "gpu/cache_fill.hpp"
#include "gpu/host_rows.hpp"
#include "gpu/host_visibility.hpp"
#include "gpu/kept_shadows.hpp"
#include "gpu/lamp_shares.hpp"
#include "render/follow_scene.hpp"
#include "render/lamps.hpp"
#include "render/scene_cache.hpp"

#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/surface_point.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace demo {

namespace {

using lightmesh::CacheUpload;
using lightmesh::SurfacePoint;

/// After so many turns of asking and filling the host answers for points that still ask: rays along an edge
/// may be blocked for the device and open for the host, which then does not know that there is something to
/// fill.
constexpr int enough_fills = 8;

/// A cache whose records the host finds, and shaders the rays to lamps.
class LampCache {
public:
    LampCache(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
              const VisibilityOptions& options)
        : options_(lamp_options(options)), shares_(device, copy), cache_(begun_cache_of(scene, options)) {}

    /// Finds what shaders lack at points.
    void fill(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) {
        fill_by_lists(cache_, points, [&](const lightmesh::LampRayList& list) {
            cache_.fill_shares(list, [&](auto work, auto found) { shares_(work, found, cancel); });
        });
    }

    /// How lit points are: a row of all lights at each.
    void find(std::span<const SurfacePoint> points, std::span<float> lit,
              const std::atomic<bool>* cancel) const {
        const std::size_t lights = light_count();
        in_parts(points.size(), cancel, [&](std::size_t first, std::size_t size) {
            cache_.visibility(points.subspan(first, size), lit.subspan(first * lights, size * lights));
        });
    }

    void update(const EmbreeScene& scene, const SceneChange& change) {
        follow_scene(cache_, lamps_of(scene, options_), change);
    }
    void begin_frame() { cache_.begin_frame(); }
    void merge(std::span<const std::byte> known) { cache_.merge(known); }

    std::size_t light_count() const { return cache_.light_count(); }
    std::vector<std::byte> snapshot() const { return cache_.snapshot(); }
    lightmesh::CacheStatistics cache() const { return cache_.statistics(); }
    DeviceFill spent() const { return shares_.spent(); }

private:
    VisibilityOptions options_;  ///< for lamps
    LampShares shares_;
    SceneCache cache_;
};

/// As shaders ask for it the host finds the places of records and lists what they lack. Where what shaders
/// lack is of no record, it answers for the point.
template <class Host>
class CacheShadows final : public KeptShadows<Host, CacheUpload> {
    using Kept = KeptShadows<Host, CacheUpload>;

public:
    template <class... OfHost>
    CacheShadows(const ComputeDevice& device, const VisibilityOptions& options, std::size_t pixels,
                 OfHost&&... of_host)
        : Kept(device, options.cache.memory_budget, CacheUpload::empty_requests(pixels),
               std::forward<OfHost>(of_host)...),
          rows_(device, pixels) {}

    std::vector<ComputeBinding> bindings() const override {
        std::vector<ComputeBinding> made = Kept::bindings();
        for (ComputeBinding& binding : rows_.bindings(Kept::set, CacheUpload::requests_binding + 1))
            made.push_back(std::move(binding));
        return made;
    }

    void shade(Round& round, const std::atomic<bool>* cancel) override {
        rows_.clear();
        int turns = 0;
        do {
            this->bind(round.kernel());
            round.shade();
            ++turns;
        } while (fill_asked(turns, cancel));
        this->note_use(round, cancel);
    }

    std::optional<lightmesh::CacheStatistics> cache() const override { return this->host().cache(); }
    std::size_t bytes() const override { return this->host().cache().bytes; }

private:
    /// False if nothing was asked.
    bool fill_asked(int& turns, const std::atomic<bool>* cancel) {
        const std::vector<std::byte> bytes = this->requests();
        if (CacheUpload::request_count(bytes) == 0)
            return false;
        const bool fills = turns <= enough_fills;
        std::vector<SurfacePoint> lacking;
        std::vector<SurfacePoint> asked;
        std::vector<std::uint32_t> of_pixels;
        for (const lightmesh::CacheRequest& request : CacheUpload::requests(bytes)) {
            if (request.lacks_values && fills) {
                lacking.push_back(request.point);
            } else {
                asked.push_back(request.point);
                of_pixels.push_back(request.id);
            }
        }
        // A cache that is full keeps no more.
        if (!lacking.empty() && this->fill(lacking, cancel) == 0)
            turns = enough_fills;
        if (!asked.empty())
            rows_.add(of_pixels, this->host().light_count(),
                      [&](std::span<float> lit) { this->host().find(asked, lit, cancel); });
        return true;
    }

    HostRows rows_;
};

}  // namespace

std::unique_ptr<DeviceShadows> make_cache_shadows(const ComputeDevice& device, const std::string& algorithm,
                                                  const EmbreeScene& scene, const GpuScene& copy,
                                                  const VisibilityOptions& options, std::size_t pixels) {
    if (algorithm == "blur-cache")
        return std::make_unique<CacheShadows<HostVisibility>>(device, options, pixels, algorithm, scene,
                                                              options);
    return std::make_unique<CacheShadows<LampCache>>(device, options, pixels, device, scene, copy, options);
}

}  // namespace demo
