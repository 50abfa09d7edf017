// SPDX-License-Identifier: MIT
#pragma once

#include "image/image.hpp"
#include "render/ranks.hpp"
#include "render/renderer.hpp"
#include "render/run.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <lightmesh/statistics.hpp>

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// As `run` by all ranks, but the picture is made by compute shaders on the Vulkan device that the options
/// name: each rank's part of it, which it finds the shadows for alone. Throws std::invalid_argument that
/// names the option for what shaders do not know, and std::runtime_error where this program was built without
/// them or the device fails.
Run run_on_gpu(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
               const RenderOptions& options, Ranks& ranks);

/// Frames of a film by compute shaders: those that `run_on_gpu` makes of each state of the scene.
class GpuFrames {
public:
    /// Opens the device that the options name. Throws as `run_on_gpu`.
    GpuFrames(const std::string& algorithm, const VisibilityOptions& visibility,
              const RenderOptions& options);
    GpuFrames(const GpuFrames&) = delete;
    GpuFrames& operator=(const GpuFrames&) = delete;
    ~GpuFrames();

    /// Name and driver.
    std::string device() const;

    /// Before the first frame, and after each change of the scene, when `scene` was updated. It must be
    /// always the same one, which must outlive this. Throws std::runtime_error where the device fails.
    void follow(const EmbreeScene& scene, const SceneChange& change);

    /// As `GpuRenderer::begin_frame`.
    void begin_frame();

    /// After `follow`. `Run::image` and `Run::toned`; also counts the rays. What was not rendered when
    /// `cancel` was set is black. Throws std::runtime_error where the device fails.
    struct Frame {
        Image linear;
        Image toned;
    };
    Frame render(RenderStatistics& statistics, const Progress& progress, const std::atomic<bool>& cancel);

    // As of `Visibility`, after `follow`.
    std::optional<lightmesh::MeshStatistics> mesh() const;
    std::optional<lightmesh::CacheStatistics> cache() const;
    std::vector<std::byte> snapshot() const;
    void merge(std::span<const std::byte> known);

    /// That the shaders took so far.
    double seconds_device() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
