// SPDX-License-Identifier: MIT
#include "gpu/cache_shadows.hpp"

#include "gpu/ask_host.hpp"
#include "gpu/cache_fill.hpp"
#include "gpu/lamp_shares.hpp"
#include "gpu/uploaded.hpp"
#include "render/follow_scene.hpp"
#include "render/lamps.hpp"
#include "render/scene_cache.hpp"

#include <lightmesh/cache/lamp_ray_list.hpp>
#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/surface_point.hpp>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace demo {

namespace {

using lightmesh::CacheUpload;
using lightmesh::SurfacePoint;

/// After so many turns of asking and filling the host answers for points that still ask: rays along an edge
/// may be blocked for the device and open for the host, which then does not know that there is something to
/// fill.
constexpr int enough_fills = 8;

/// The cache that shaders have a copy of.
class HostCache {
public:
    virtual ~HostCache() = default;

    /// Finds what shaders lack at points.
    virtual void fill(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) = 0;
    /// How lit points are: a row of all lights at each.
    virtual void find(std::span<const SurfacePoint> points, std::span<float> lit,
                      const std::atomic<bool>* cancel) const = 0;
    virtual void update(const EmbreeScene& scene, const SceneChange& change) = 0;
    virtual std::size_t light_count() const = 0;
    virtual std::vector<std::byte> snapshot() const = 0;
    virtual lightmesh::CacheStatistics statistics() const = 0;
    /// By shaders.
    virtual DeviceFill spent() const { return {}; }
};

/// Records by the host, rays to lamps by shaders.
class LampCache final : public HostCache {
public:
    LampCache(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
              const VisibilityOptions& options)
        : options_(options), shares_(device, copy), cache_(begun_cache_of(scene, options)) {
        options_.known.clear();
    }

    void fill(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) override {
        fill_by_lists(cache_, points, [&](const lightmesh::LampRayList& list) {
            cache_.fill_shares(list, [&](auto work, auto found) { shares_(work, found, cancel); });
        });
    }

    void find(std::span<const SurfacePoint> points, std::span<float> lit,
              const std::atomic<bool>* cancel) const override {
        const std::size_t lights = light_count();
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 256), [&](const auto& part) {
            check_cancelled(cancel);
            cache_.visibility(points.subspan(part.begin(), part.size()),
                              lit.subspan(part.begin() * lights, part.size() * lights));
        });
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        follow_scene(cache_, lamps_of(scene, options_), change);
    }

    std::size_t light_count() const override { return cache_.light_count(); }
    std::vector<std::byte> snapshot() const override { return cache_.snapshot(); }
    lightmesh::CacheStatistics statistics() const override { return cache_.statistics(); }
    DeviceFill spent() const override { return shares_.spent(); }

private:
    VisibilityOptions options_;
    LampShares shares_;
    SceneCache cache_;
};

/// All by the host: a light mesh seen through a cache.
class BlurCache final : public HostCache {
public:
    BlurCache(const EmbreeScene& scene, const VisibilityOptions& options)
        : shadows_(make_visibility("blur-cache", scene, options)), light_count_(scene.scene().lights.size()) {
    }

    void fill(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) override {
        ask_host(*shadows_, light_count_, points, cancel, [](std::size_t, std::span<const float>) {});
    }

    void find(std::span<const SurfacePoint> points, std::span<float> lit,
              const std::atomic<bool>* cancel) const override {
        ask_host(*shadows_, light_count_, points, cancel,
                 [&](std::size_t first, std::span<const float> found) {
                     std::ranges::copy(found, lit.subspan(first * light_count_).begin());
                 });
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        light_count_ = scene.scene().lights.size();
        shadows_->update(scene, change);
    }

    std::size_t light_count() const override { return light_count_; }
    std::vector<std::byte> snapshot() const override { return shadows_->snapshot(); }
    lightmesh::CacheStatistics statistics() const override { return shadows_->cache().value(); }

private:
    std::unique_ptr<Visibility> shadows_;
    std::size_t light_count_;
};

}  // namespace

struct CacheShadows::Parts {
    Parts(const ComputeDevice& on, const std::string& algorithm, const EmbreeScene& scene,
          const GpuScene& copy, const VisibilityOptions& options, std::size_t pixels)
        : device(on), cache(cache_named(on, algorithm, scene, copy, options)),
          uploaded(on, cache->snapshot()), row_of_pixel(pixels), rows(on, pixels * sizeof(std::uint32_t)),
          answers(on, std::size_t{16}), no_requests(CacheUpload::empty_requests(pixels)),
          requests(on, no_requests) {}

    static std::unique_ptr<HostCache> cache_named(const ComputeDevice& device, const std::string& algorithm,
                                                  const EmbreeScene& scene, const GpuScene& copy,
                                                  const VisibilityOptions& options) {
        if (algorithm == "blur-cache")
            return std::make_unique<BlurCache>(scene, options);
        return std::make_unique<LampCache>(device, scene, copy, options);
    }

    void upload() { uploaded.update(cache->snapshot()); }

    void fill(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) {
        cache->fill(points, cancel);
        upload();
    }

    void answer(std::span<const SurfacePoint> points, std::span<const std::uint32_t> of_pixels,
                const std::atomic<bool>* cancel) {
        const std::size_t lights = cache->light_count();
        const std::size_t first_row = lights == 0 ? 0 : values.size() / lights;
        values.resize((first_row + points.size()) * lights);
        cache->find(points, std::span(values).subspan(first_row * lights), cancel);
        for (std::size_t i = 0; i < points.size(); ++i)
            row_of_pixel[of_pixels[i]] = static_cast<std::uint32_t>(first_row + i + 1);
        rows.write(0, std::as_bytes(std::span(row_of_pixel)));
        answers = ComputeBuffer(device, std::as_bytes(std::span(values)));
    }

    ComputeDevice device;
    std::unique_ptr<HostCache> cache;
    UploadedCache uploaded;
    std::vector<std::uint32_t> row_of_pixel;
    ComputeBuffer rows;
    std::vector<float> values;  ///< the host's answers of this round
    ComputeBuffer answers;
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
    parts_->cache->update(scene, change);
    parts_->upload();
}

std::vector<ComputeBinding> CacheShadows::bindings() const {
    std::vector<ComputeBinding> made = parts_->uploaded.bindings(set);
    for (const ComputeBuffer& buffer : {parts_->requests, parts_->rows, parts_->answers})
        made.push_back({.set = set, .binding = static_cast<std::uint32_t>(made.size()), .buffer = buffer});
    return made;
}

void CacheShadows::begin_round() {
    parts_->turns = 0;
    if (parts_->values.empty())
        return;
    parts_->values.clear();
    std::ranges::fill(parts_->row_of_pixel, 0u);
    parts_->rows.write(0, std::as_bytes(std::span(parts_->row_of_pixel)));
}

void CacheShadows::bind(const ComputeKernel& kernel) const {
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
    if (!lacking.empty())
        parts_->fill(lacking, cancel);
    if (!asked.empty())
        parts_->answer(asked, of_pixels, cancel);
    return true;
}

lightmesh::CacheStatistics CacheShadows::statistics() const {
    return parts_->cache->statistics();
}

std::vector<std::byte> CacheShadows::snapshot() const {
    return parts_->cache->snapshot();
}

DeviceFill CacheShadows::spent() const {
    return parts_->cache->spent();
}

}  // namespace demo
