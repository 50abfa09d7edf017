// SPDX-License-Identifier: MIT
#pragma once

#include "image/image.hpp"
#include "render/renderer.hpp"
#include "render/run.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

namespace demo {

/// As `run`, but the picture is made by compute shaders on the Vulkan device that the options name. Throws
/// std::invalid_argument that names the option for what shaders do not know, and std::runtime_error where
/// this program was built without them or the device fails.
Run run_on_gpu(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
               const RenderOptions& options);

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

    /// After `follow`. `Run::image` and `Run::toned`; also counts the rays. What was not rendered when
    /// `cancel` was set is black. Throws std::runtime_error where the device fails.
    struct Frame {
        Image linear;
        Image toned;
    };
    Frame render(RenderStatistics& statistics, const Progress& progress, const std::atomic<bool>& cancel);

    /// Rays that were traced for what a mesh or a cache keeps, so far.
    std::uint64_t kept_rays() const;
    /// That the shaders took so far.
    double seconds_device() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
