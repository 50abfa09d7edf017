// SPDX-License-Identifier: MIT
#include "gpu/cache_shadows.hpp"

#include "gpu/cache_fill.hpp"
#include "gpu/host_rows.hpp"
#include "gpu/host_visibility.hpp"
#include "gpu/lamp_shares.hpp"
#include "gpu/uploaded.hpp"
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
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace demo {

namespace {

using lightmesh::CacheUpload;
using lightmesh::SurfacePoint;

/// After so many turns of asking and filling the host answers for points that still ask: rays along an edge
/// may be blocked for the device and open for the host, which then does not know that there is something to
/// fill.
constexpr int enough_fills = 8;

}  // namespace

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

/// The cache that shaders have a copy of.
using HostCache = std::variant<LampCache, HostVisibility>;

struct CacheShadows::Parts {
    Parts(const ComputeDevice& on, const std::string& algorithm, const EmbreeScene& scene,
          const GpuScene& copy, const VisibilityOptions& options, std::size_t pixels)
        : cache(cache_named(on, algorithm, scene, copy, options)), uploaded(on, snapshot()),
          has_budget(options.cache.memory_budget != lightmesh::CacheSettings{}.memory_budget),
          rows(on, pixels), no_requests(CacheUpload::empty_requests(pixels)), requests(on, no_requests) {}

    static HostCache cache_named(const ComputeDevice& device, const std::string& algorithm,
                                 const EmbreeScene& scene, const GpuScene& copy,
                                 const VisibilityOptions& options) {
        if (algorithm == "blur-cache")
            return HostCache(std::in_place_type<HostVisibility>, algorithm, scene, options);
        return HostCache(std::in_place_type<LampCache>, device, scene, copy, options);
    }

    std::vector<std::byte> snapshot() const {
        return std::visit([](const auto& host) { return host.snapshot(); }, cache);
    }

    /// Returns how many bytes were written.
    std::size_t upload() { return uploaded.update(snapshot()); }

    /// Before shaders see the cache.
    void upload_changes() {
        if (has_changed)
            upload();
        has_changed = false;
    }

    /// False if nothing was found that shaders did not know.
    bool fill(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) {
        find(points, cancel);
        return upload() > 0;
    }

    void find(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) {
        std::visit([&](auto& host) { host.fill(points, cancel); }, cache);
    }

    void answer(std::span<const SurfacePoint> points, std::span<const std::uint32_t> of_pixels,
                const std::atomic<bool>* cancel) {
        std::visit(
            [&](const auto& host) {
                rows.add(of_pixels, host.light_count(),
                         [&](std::span<float> lit) { host.find(points, lit, cancel); });
            },
            cache);
    }

    HostCache cache;
    UploadedCache uploaded;
    bool has_budget;
    bool has_changed = false;  ///< between pictures, since the last upload
    HostRows rows;
    std::vector<std::byte> no_requests;
    ComputeBuffer requests;
    int turns = 0;  ///< of this round
};

CacheShadows::CacheShadows(const ComputeDevice& device, const std::string& algorithm,
                           const EmbreeScene& scene, const GpuScene& copy, const VisibilityOptions& options,
                           std::size_t pixels)
    : parts_(std::make_unique<Parts>(device, algorithm, scene, copy, options, pixels)) {}

CacheShadows::~CacheShadows() = default;

void CacheShadows::update(const EmbreeScene& scene, const SceneChange& change) {
    if (!change.changes_shadows())
        return;
    parts_->has_changed = true;
    std::visit([&](auto& host) { host.update(scene, change); }, parts_->cache);
}

void CacheShadows::begin_frame() {
    if (!parts_->has_budget)
        return;
    parts_->has_changed = true;
    std::visit([](auto& host) { host.begin_frame(); }, parts_->cache);
}

bool CacheShadows::has_budget() const {
    return parts_->has_budget;
}

void CacheShadows::note_use(std::span<const lightmesh::SurfacePoint> points,
                            const std::atomic<bool>* cancel) {
    parts_->find(points, cancel);
}

void CacheShadows::merge(std::span<const std::byte> known) {
    parts_->has_changed = true;
    std::visit([&](auto& host) { host.merge(known); }, parts_->cache);
}

std::vector<ComputeBinding> CacheShadows::bindings() const {
    std::vector<ComputeBinding> made = parts_->uploaded.bindings(set);
    const auto [rows, answers] = parts_->rows.buffers();
    for (const ComputeBuffer& buffer : {parts_->requests, rows, answers})
        made.push_back({.set = set, .binding = static_cast<std::uint32_t>(made.size()), .buffer = buffer});
    return made;
}

void CacheShadows::begin_round() {
    parts_->turns = 0;
    parts_->rows.clear();
}

void CacheShadows::bind(const ComputeKernel& kernel) const {
    parts_->upload_changes();
    for (const ComputeBinding& binding : bindings())
        kernel.bind(binding);
    parts_->requests.write(0, parts_->no_requests);
}

bool CacheShadows::fill(const std::atomic<bool>* cancel) {
    const auto bytes = parts_->requests.read_all<std::byte>();
    if (CacheUpload::request_count(bytes) == 0)
        return false;
    const bool fills = ++parts_->turns <= enough_fills;
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
    if (!lacking.empty() && !parts_->fill(lacking, cancel))
        parts_->turns = enough_fills;
    if (!asked.empty())
        parts_->answer(asked, of_pixels, cancel);
    return true;
}

lightmesh::CacheStatistics CacheShadows::statistics() const {
    return std::visit([](const auto& host) { return host.cache(); }, parts_->cache);
}

std::vector<std::byte> CacheShadows::snapshot() const {
    return parts_->snapshot();
}

DeviceFill CacheShadows::spent() const {
    return std::visit([](const auto& host) { return host.spent(); }, parts_->cache);
}

}  // namespace demo
