// SPDX-License-Identifier: MIT
#include "render/on_gpu.hpp"

#include "render/stopwatch.hpp"
#include "render/terminal.hpp"

#include <stdexcept>
#include <utility>

#ifdef LIGHTMESH_WITH_GPU
#include "gpu/compute.hpp"
#include "gpu/gpu_renderer.hpp"
#endif

namespace demo {

#ifdef LIGHTMESH_WITH_GPU
Run run_on_gpu(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
               const RenderOptions& options) {
    Run made = run_begun(algorithm, scene, visibility);
    const Stopwatch stopwatch;
    GpuRenderer::check(algorithm, visibility, options);
    const ComputeDevice device({.device = visibility.device});
    GpuRenderer renderer(device, algorithm, scene, visibility, options);
    made.device = device.name();
    made.seconds_preparing = stopwatch.seconds();
    ProgressBar bar(algorithm);
    GpuPicture picture = renderer.render(
        made.statistics, [&](double done) { bar.show(done); }, &interrupted());
    made.image = std::move(picture.linear);
    made.toned = std::move(picture.toned);
    made.mesh = renderer.mesh();
    made.cache = renderer.cache();
    made.bytes = made.mesh ? made.mesh->bytes : made.cache ? made.cache->bytes : 0;
    made.seconds_device = picture.seconds_device;
    if (visibility.keep_snapshot)
        made.snapshot = renderer.snapshot();
    return made;
}

struct GpuFrames::Parts {
    std::string algorithm;
    VisibilityOptions visibility;
    RenderOptions options;
    ComputeDevice device;
    std::unique_ptr<GpuRenderer> renderer;  ///< null before the first `follow`
    double seconds_device = 0.0;
};

GpuFrames::GpuFrames(const std::string& algorithm, const VisibilityOptions& visibility,
                     const RenderOptions& options) {
    GpuRenderer::check(algorithm, visibility, options);
    parts_ = std::make_unique<Parts>(
        Parts{algorithm, visibility, options, ComputeDevice({.device = visibility.device}), nullptr});
}

std::string GpuFrames::device() const {
    return parts_->device.name() + ", " + parts_->device.driver();
}

void GpuFrames::follow(const EmbreeScene& scene, const SceneChange& change) {
    if (parts_->renderer)
        parts_->renderer->update(scene, change);
    else
        parts_->renderer = std::make_unique<GpuRenderer>(parts_->device, parts_->algorithm, scene,
                                                         parts_->visibility, parts_->options);
}

GpuFrames::Frame GpuFrames::render(RenderStatistics& statistics, const Progress& progress,
                                   const std::atomic<bool>& cancel) {
    GpuPicture picture = parts_->renderer->render(statistics, progress, &cancel);
    parts_->seconds_device += picture.seconds_device;
    return {std::move(picture.linear), std::move(picture.toned)};
}

std::uint64_t GpuFrames::kept_rays() const {
    return parts_->renderer ? demo::kept_rays(*parts_->renderer) : 0;
}

double GpuFrames::seconds_device() const {
    return parts_->seconds_device;
}
#else
namespace {

[[noreturn]] void throw_no_shaders() {
    throw std::runtime_error(
        "--on gpu: this program was built without shaders, which glslc compiles (Debian: "
        "apt-get install glslc)");
}

}  // namespace

Run run_on_gpu(const std::string&, const EmbreeScene&, const VisibilityOptions&, const RenderOptions&) {
    throw_no_shaders();
}

struct GpuFrames::Parts {};
GpuFrames::GpuFrames(const std::string&, const VisibilityOptions&, const RenderOptions&) {
    throw_no_shaders();
}
std::string GpuFrames::device() const {
    throw_no_shaders();
}
void GpuFrames::follow(const EmbreeScene&, const SceneChange&) {
    throw_no_shaders();
}
GpuFrames::Frame GpuFrames::render(RenderStatistics&, const Progress&, const std::atomic<bool>&) {
    throw_no_shaders();
}
std::uint64_t GpuFrames::kept_rays() const {
    throw_no_shaders();
}
double GpuFrames::seconds_device() const {
    throw_no_shaders();
}
#endif

GpuFrames::~GpuFrames() = default;

}  // namespace demo
