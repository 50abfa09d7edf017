// SPDX-License-Identifier: MIT
#include "render/on_gpu.hpp"

#include "render/merge_ranks.hpp"
#include "render/share_out.hpp"
#include "render/stopwatch.hpp"
#include "render/terminal.hpp"

#include <cstring>
#include <stdexcept>
#include <utility>

#ifdef LIGHTMESH_WITH_GPU
#include "gpu/compute.hpp"
#include "gpu/gpu_renderer.hpp"
#endif

namespace demo {

#ifdef LIGHTMESH_WITH_GPU
namespace {

/// One of as many parts of a picture as there are ranks.
PixelRange part_of(const Image& picture, std::size_t part, const Ranks& ranks) {
    const std::size_t parts = static_cast<std::size_t>(ranks.size());
    return {picture.pixels.size() * part / parts, picture.pixels.size() * (part + 1) / parts};
}

/// By all ranks, which must call this together; whole on rank 0.
GpuPicture render_parts(Ranks& ranks, GpuRenderer& renderer, const RenderOptions& options,
                        RenderStatistics& statistics, ProgressBar& bar) {
    const Stopwatch stopwatch;
    GpuPicture whole{Image(options.width, options.height), Image(options.width, options.height)};
    const auto work = [&](std::size_t i, WorkWatch& watch) {
        const PixelRange part = part_of(whole.linear, i, ranks);
        RenderStatistics spent;
        Bytes bytes;
        watch.look_during([&] {
            const GpuPicture picture = renderer.render(
                part, spent, [&](double done) { bar.show(done); }, &watch.is_in_vain());
            whole.seconds_device += picture.seconds_device;
            for (const Image* image : {&picture.linear, &picture.toned}) {
                const auto pixels =
                    std::as_bytes(std::span(image->pixels).subspan(part.first, part.end - part.first));
                bytes.insert(bytes.end(), pixels.begin(), pixels.end());
            }
        });
        statistics += spent;
        return bytes;
    };
    const auto take = [&](std::size_t i, int, const Bytes& bytes) {
        const PixelRange part = part_of(whole.linear, i, ranks);
        const std::size_t size = (part.end - part.first) * sizeof(whole.linear.pixels[0]);
        if (bytes.size() != 2 * size)
            throw std::runtime_error("another rank has sent another part of the picture");
        if (size == 0)
            return;
        std::memcpy(&whole.linear.pixels[part.first], bytes.data(), size);
        std::memcpy(&whole.toned.pixels[part.first], bytes.data() + size, size);
    };
    share_out(ranks, static_cast<std::size_t>(ranks.size()), work, take);
    statistics.seconds = stopwatch.seconds();
    return whole;
}

/// Beside the name of a device.
std::string ray_query_note(const ComputeDevice& device) {
    return device.has_ray_queries() ? ", ray queries" : "";
}

ComputeOptions device_options(const VisibilityOptions& visibility) {
    return {.device = visibility.device, .ray_queries = visibility.ray_queries};
}

}  // namespace

Run run_on_gpu(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
               const RenderOptions& options, Ranks& ranks) {
    Run made = run_begun(algorithm, scene, visibility);
    const Stopwatch stopwatch;
    GpuRenderer::check(algorithm, visibility, options);
    const ComputeDevice device(device_options(visibility));
    GpuRenderer renderer(device, algorithm, scene, visibility, options);
    made.device = device.name() + ray_query_note(device);
    made.seconds_preparing = stopwatch.seconds();
    ProgressBar bar(algorithm, progress_elsewhere(ranks));
    GpuPicture picture = ranks.size() > 1
                             ? render_parts(ranks, renderer, options, made.statistics, bar)
                             : renderer.render(
                                   made.statistics, [&](double done) { bar.show(done); }, &interrupted());
    made.image = std::move(picture.linear);
    made.toned = std::move(picture.toned);
    made.mesh = renderer.mesh();
    made.cache = renderer.cache();
    made.bytes = renderer.bytes();
    made.seconds_device = picture.seconds_device;
    if (ranks.size() > 1) {
        add_other_ranks(made, ranks);
        if (visibility.keep_snapshot)
            RankMerge().run(ranks, renderer);
    }
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
        Parts{algorithm, visibility, options, ComputeDevice(device_options(visibility)), nullptr});
}

std::string GpuFrames::device() const {
    return parts_->device.name() + ", " + parts_->device.driver() + ray_query_note(parts_->device);
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

void GpuFrames::begin_frame() {
    parts_->renderer->begin_frame();
}

std::optional<lightmesh::MeshStatistics> GpuFrames::mesh() const {
    return parts_->renderer->mesh();
}

std::optional<lightmesh::CacheStatistics> GpuFrames::cache() const {
    return parts_->renderer->cache();
}

std::vector<std::byte> GpuFrames::snapshot() const {
    return parts_->renderer->snapshot();
}

void GpuFrames::merge(std::span<const std::byte> known) {
    parts_->renderer->merge(known);
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

Run run_on_gpu(const std::string&, const EmbreeScene&, const VisibilityOptions&, const RenderOptions&,
               Ranks&) {
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
void GpuFrames::begin_frame() {
    throw_no_shaders();
}
std::optional<lightmesh::MeshStatistics> GpuFrames::mesh() const {
    throw_no_shaders();
}
std::optional<lightmesh::CacheStatistics> GpuFrames::cache() const {
    throw_no_shaders();
}
std::vector<std::byte> GpuFrames::snapshot() const {
    throw_no_shaders();
}
void GpuFrames::merge(std::span<const std::byte>) {
    throw_no_shaders();
}
double GpuFrames::seconds_device() const {
    throw_no_shaders();
}
#endif

GpuFrames::~GpuFrames() = default;

}  // namespace demo
