// SPDX-License-Identifier: MIT
#include "gpu/cache_shadows.hpp"

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

}  // namespace

struct CacheShadows::Parts {
    Parts(const ComputeDevice& on, const EmbreeScene& scene, const GpuScene& copy,
          const VisibilityOptions& of_cache, std::size_t pixels)
        : device(on), options(of_cache), shares(on, copy), cache(cache_of(scene, of_cache)),
          uploaded(on, cache.snapshot()), row_of_pixel(pixels), rows(on, pixels * sizeof(std::uint32_t)),
          answers(on, std::size_t{16}), no_requests(CacheUpload::empty_requests(pixels)),
          requests(on, no_requests) {}

    void upload() { uploaded.update(cache.snapshot()); }

    void fill(std::span<const SurfacePoint> points, const std::atomic<bool>* cancel) {
        fill_by_lists(cache, points, [&](const lightmesh::LampRayList& list) {
            cache.fill_shares(list, [&](auto work, auto found) { shares(work, found, cancel); });
        });
        upload();
    }

    void answer(std::span<const SurfacePoint> points, std::span<const std::uint32_t> of_pixels) {
        const std::size_t lights = cache.light_count();
        const std::size_t first_row = lights == 0 ? 0 : values.size() / lights;
        values.resize((first_row + points.size()) * lights);
        const std::span<float> added = std::span(values).subspan(first_row * lights);
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 256), [&](const auto& part) {
            cache.visibility(points.subspan(part.begin(), part.size()),
                             added.subspan(part.begin() * lights, part.size() * lights));
        });
        for (std::size_t i = 0; i < points.size(); ++i)
            row_of_pixel[of_pixels[i]] = static_cast<std::uint32_t>(first_row + i + 1);
        rows.write(0, std::as_bytes(std::span(row_of_pixel)));
        answers = ComputeBuffer(device, std::as_bytes(std::span(values)));
    }

    ComputeDevice device;
    VisibilityOptions options;
    LampShares shares;
    SceneCache cache;
    UploadedCache uploaded;
    std::vector<std::uint32_t> row_of_pixel;
    ComputeBuffer rows;
    std::vector<float> values;  ///< the host's answers of this round
    ComputeBuffer answers;
    std::vector<std::byte> no_requests;
    ComputeBuffer requests;
    int turns = 0;  ///< of this round
};

CacheShadows::CacheShadows(const ComputeDevice& device, const EmbreeScene& scene, const GpuScene& copy,
                           const VisibilityOptions& options, std::size_t pixels)
    : parts_(std::make_unique<Parts>(device, scene, copy, options, pixels)) {}

CacheShadows::~CacheShadows() = default;

void CacheShadows::update(const EmbreeScene& scene, const SceneChange& change) {
    if (!change.changes_shadows())
        return;
    follow_scene(parts_->cache, lamps_of(scene, parts_->options), change);
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
        parts_->answer(asked, of_pixels);
    return true;
}

lightmesh::CacheStatistics CacheShadows::statistics() const {
    return parts_->cache.statistics();
}

DeviceFill CacheShadows::spent() const {
    return parts_->shares.spent();
}

}  // namespace demo
