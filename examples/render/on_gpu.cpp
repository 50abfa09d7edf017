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
    if (!visibility.known.empty())
        throw std::invalid_argument("--on gpu does not know --mesh");
    if (visibility.keep_snapshot)
        throw std::invalid_argument("--on gpu does not know --save-mesh");
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
    return made;
}
#else
Run run_on_gpu(const std::string&, const EmbreeScene&, const VisibilityOptions&, const RenderOptions&) {
    throw std::runtime_error(
        "--on gpu: this program was built without shaders, which glslc compiles (Debian: "
        "apt-get install glslc)");
}
#endif

}  // namespace demo
