// SPDX-License-Identifier: MIT
#include "gpu/gpu_renderer.hpp"

#include "gpu/cache_shadows.hpp"
#include "gpu/device_shadows.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/map_shadows.hpp"
#include "gpu/mesh_shadows.hpp"
#include "gpu/volume_shadows.hpp"
#include "render/stopwatch.hpp"
#include "spirv/shade_area.hpp"
#include "spirv/shade_cache.hpp"
#include "spirv/shade_hard.hpp"
#include "spirv/shade_mesh_16.hpp"
#include "spirv/shade_mesh_4.hpp"
#include "spirv/shade_mesh_exact.hpp"
#include "spirv/trace.hpp"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

namespace demo {

/// As paths.glsl has it.
struct BatchWords {
    std::uint32_t first;
    std::uint32_t count;
    std::uint32_t is_first_round;
    std::uint32_t attempt;  ///< roundings that points are farther from their surfaces
};

namespace {

constexpr std::uint32_t host_rows_words[] = {
#include "spirv/shade_host_rows.inc"
};
constexpr std::uint32_t finish_words[] = {
#include "spirv/finish.comp.inc"
};

/// As paths.glsl has it: of the points of a round.
struct RoundWords {
    std::uint32_t point_count = 0;
    std::uint32_t is_failed = 0;
};

constexpr std::size_t bytes_of_ray = 48;
constexpr std::size_t bytes_of_path = 32;
constexpr std::size_t bytes_of_point = 80;
constexpr std::size_t bytes_of_colour = 16;
/// Of a batch of pixels, on the device.
constexpr std::size_t most_bytes = std::size_t{1} << 29;
/// Of a batch of pixels and a round: drivers stop work that takes seconds, and people wish to see how far it
/// is.
constexpr std::size_t most_shadow_rays = std::size_t{1} << 28;
constexpr std::size_t most_shadow_rays_of_cpu = std::size_t{1} << 20;

void refuse(bool is_wanted, const char* what) {
    if (is_wanted)
        throw std::invalid_argument(std::string("--on gpu does not know ") + what);
}

std::span<const std::byte> bytes_in(const BatchWords& batch) {
    return std::as_bytes(std::span(&batch, 1));
}

}  // namespace

const std::vector<std::string>& GpuRenderer::algorithms() {
    static const std::vector<std::string> names{"cache",      "blur-cache",    "whitted",       "area",
                                                "shadow-map", "shadow-volume", "lmm",           "linked",
                                                "express",    "lmm+map",       "linked+map",    "express+map",
                                                "lmm+volume", "linked+volume", "express+volume"};
    return names;
}

void GpuRenderer::check(const std::string& algorithm, const VisibilityOptions& visibility,
                        const RenderOptions& options) {
    const std::vector<std::string>& known = algorithms();
    if (std::ranges::find(known, algorithm) == known.end()) {
        std::string names;
        for (const std::string& name : known)
            names += (names.empty() ? "" : ", ") + name;
        throw std::invalid_argument("--on gpu does not know --algorithm " + algorithm + "; it knows " +
                                    names);
    }
    refuse(visibility.lights.has_value(), "pictures by some of the lights");
    refuse(options.ambient_rays != 0, "ambient rays");
    refuse(options.transparent_background, "transparent backgrounds");
    refuse(!options.tiles.empty(), "parts of pictures");
    if (options.width < 1 || options.width > 65535 || options.height < 1 || options.height > 65535)
        throw std::invalid_argument("--on gpu renders pictures of 1 to 65535 pixels a side, not " +
                                    std::to_string(options.width) + " x " + std::to_string(options.height));
    if (options.samples < 1 || options.samples > 1024 || options.depth_limit < 0 || options.depth_limit > 100)
        throw std::invalid_argument("samples must be in [1, 1024] and the depth limit in [0, 100]");
}

namespace {

bool asks_mesh(const std::string& algorithm) {
    return algorithm.starts_with("lmm") || algorithm.starts_with("linked") ||
           algorithm.starts_with("express");
}

bool asks_cache(const std::string& algorithm) {
    return algorithm == "cache" || algorithm == "blur-cache";
}

bool asks_lookups(const std::string& algorithm) {
    return algorithm == "shadow-map" || algorithm == "shadow-volume";
}

/// With the short test that the algorithm stands for.
VisibilityOptions with_short_test(VisibilityOptions visibility, const std::string& algorithm) {
    if (algorithm.starts_with("linked"))
        visibility.settings.short_test = lightmesh::ShortTest::linked;
    else if (algorithm.starts_with("express"))
        visibility.settings.short_test = lightmesh::ShortTest::none;
    return visibility;
}

std::span<const std::uint32_t> shader_of(const ComputeDevice& device, const std::string& algorithm,
                                         const VisibilityOptions& visibility) {
    if (asks_mesh(algorithm)) {
        const lightmesh::Settings settings = with_short_test(visibility, algorithm).settings;
        if (settings.short_test == lightmesh::ShortTest::exact)
            return spirv::shade_mesh_exact.on(device);
        return (settings.quality <= 4.0f ? spirv::shade_mesh_4 : spirv::shade_mesh_16).on(device);
    }
    if (asks_cache(algorithm))
        return spirv::shade_cache.on(device);
    if (asks_lookups(algorithm))
        return host_rows_words;
    return (algorithm == "area" ? spirv::shade_area : spirv::shade_hard).on(device);
}

}  // namespace

struct GpuRenderer::Parts {
    Parts(const ComputeDevice& on, const std::string& algorithm, const EmbreeScene& model,
          const VisibilityOptions& visibility, const RenderOptions& render)
        : device(on), options(render), pixels(batch_size(algorithm, model, visibility)),
          scene(on, model, visibility, render), paths(on, bytes_of_path * pixels),
          waiting(on, bytes_of_ray * places_of_rays() * pixels), points(on, bytes_of_point * pixels),
          colours(on, bytes_of_colour * pixels), finished(on, 2 * bytes_of_colour * pixels),
          round(on, sizeof(RoundWords)), shadows(shadows_of(algorithm, model, visibility)),
          trace(on, spirv::trace.on(on), bindings({}), sizeof(BatchWords)),
          shade(on, shader_of(on, algorithm, visibility),
                bindings(shadows ? shadows->bindings() : std::vector<ComputeBinding>{}), sizeof(BatchWords)),
          finish(on, finish_words, bindings({}), sizeof(BatchWords)) {}

    /// Null where shaders trace all rays of shadows while they shade.
    std::unique_ptr<DeviceShadows> shadows_of(const std::string& algorithm, const EmbreeScene& model,
                                              const VisibilityOptions& visibility) const {
        if (asks_mesh(algorithm))
            return make_mesh_shadows(device, algorithm, model, scene, with_short_test(visibility, algorithm));
        if (asks_cache(algorithm))
            return make_cache_shadows(device, algorithm, model, scene, visibility, pixels);
        if (algorithm == "shadow-map")
            return std::make_unique<MapShadows>(device, model, visibility, pixels, bindings({}));
        if (algorithm == "shadow-volume")
            return std::make_unique<VolumeShadows>(device, model, visibility, pixels);
        return nullptr;
    }

    /// Rays that wait at most: each step pushes two and pops one.
    std::size_t places_of_rays() const { return static_cast<std::size_t>(options.depth_limit) + 1; }

    std::size_t picture_size() const {
        return static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
    }

    std::size_t batch_size(const std::string& algorithm, const EmbreeScene& model,
                           const VisibilityOptions& visibility) const {
        const std::size_t lights = (std::max)(model.scene().lights.size(), std::size_t{1});
        const std::size_t bytes_of_answers = asks_lookups(algorithm) ? lights * sizeof(float) : 0;
        const std::size_t bytes = bytes_of_path + bytes_of_ray * places_of_rays() + bytes_of_point +
                                  3 * bytes_of_colour + bytes_of_answers;
        const std::size_t rays =
            lights * (algorithm == "area" ? static_cast<std::size_t>(visibility.area_samples) : 1);
        const std::size_t most = (std::min)(
            {most_bytes / bytes,
             device.largest_buffer() / (std::max)(bytes_of_ray * places_of_rays(), bytes_of_answers),
             (device.is_cpu() ? most_shadow_rays_of_cpu : most_shadow_rays) / rays});
        return (std::min)((std::max)(most, std::size_t{group_size}), picture_size());
    }

    std::vector<ComputeBinding> bindings(const std::vector<ComputeBinding>& more) const {
        std::vector<ComputeBinding> made = scene.bindings();
        for (const ComputeBuffer& buffer : {paths, waiting, points, colours, finished, round})
            made.push_back({.binding = static_cast<std::uint32_t>(made.size()), .resource = buffer});
        made.insert(made.end(), more.begin(), more.end());
        return made;
    }

    static std::uint32_t groups_of(const BatchWords& batch) {
        return (batch.count + group_size - 1) / group_size;
    }

    /// Some rounds for a batch: rays to the next point of each pixel, and its shading.
    void run_rounds(BatchWords batch, int rounds) {
        seconds += device.run([&](const ComputeCommands& commands) {
            for (int i = 0; i < rounds; ++i) {
                commands.fill(round, 0, sizeof(RoundWords), 0);
                commands.dispatch(trace, groups_of(batch), 1, 1, bytes_in(batch));
                if (!shadows)
                    commands.dispatch(shade, groups_of(batch), 1, 1, bytes_in(batch));
                batch.is_first_round = 0;
            }
        });
    }

    RoundWords last_round() const {
        RoundWords found;
        round.read(0, std::as_writable_bytes(std::span(&found, 1)));
        return found;
    }

    /// The points of a batch that `trace` has found.
    class TracedRound final : public Round {
    public:
        TracedRound(Parts& parts, const BatchWords& batch) : parts_(parts), batch_(batch) {}

        Points points(std::uint32_t of_pixels) const override {
            const std::size_t count = batch_.count;
            std::vector<glm::uvec4> states(2 * count);
            parts_.paths.read(0, std::as_writable_bytes(std::span(states)));
            std::vector<glm::vec4> words(3 * count);
            parts_.points.read(0, std::as_writable_bytes(std::span(words)));
            Points found;
            for (std::uint32_t i = 0; i < batch_.count; i += of_pixels) {
                if (states[2 * i + 1].w == 0)
                    continue;
                found.points.push_back({.position = glm::vec3(words[i]),
                                        .normal = glm::vec3(words[count + i]),
                                        .footprint = words[i].w,
                                        .shading_normal = glm::vec3(words[2 * count + i])});
                found.pixels.push_back(i);
            }
            return found;
        }

        const ComputeKernel& kernel() const override { return parts_.shade; }
        void shade(std::uint32_t roundings) override {
            batch_.attempt = roundings;
            parts_.seconds += parts_.device.run([&](const ComputeCommands& commands) {
                commands.dispatch(parts_.shade, groups(), 1, 1, push());
            });
            if (parts_.last_round().is_failed != 0)
                throw std::out_of_range("--on gpu: a point lies farther from the origin than a light mesh or "
                                        "a cache reaches");
        }

        std::span<const std::byte> push() const override { return bytes_in(batch_); }
        std::uint32_t groups() const override { return groups_of(batch_); }

    private:
        Parts& parts_;
        BatchWords batch_;
    };

    void shade_by_host(const BatchWords& batch, const std::atomic<bool>* cancel) {
        tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
        arena.execute([&] {
            TracedRound traced(*this, batch);
            shadows->shade(traced, cancel);
        });
    }

    /// False if cancelled.
    bool follow(BatchWords batch, const std::atomic<bool>* cancel) {
        constexpr int most_rounds = 8;
        for (int rounds = 1;; rounds = shadows ? 1 : (std::min)(2 * rounds, most_rounds)) {
            if (cancel != nullptr && cancel->load(std::memory_order_relaxed))
                return false;
            run_rounds(batch, rounds);
            batch.is_first_round = 0;
            const RoundWords found = last_round();
            if (found.point_count == 0)
                return true;
            if (shadows)
                shade_by_host(batch, cancel);
        }
    }

    void take(const BatchWords& batch, GpuPicture& picture, RenderStatistics& statistics) {
        seconds += device.run([&](const ComputeCommands& commands) {
            commands.dispatch(finish, groups_of(batch), 1, 1, bytes_in(batch));
        });
        std::vector<glm::vec4> values(2 * std::size_t{batch.count});
        finished.read(0, std::as_writable_bytes(std::span(values)));
        std::vector<glm::uvec4> states(2 * std::size_t{batch.count});
        paths.read(0, std::as_writable_bytes(std::span(states)));
        for (std::size_t i = 0; i < batch.count; ++i) {
            picture.linear.pixels[batch.first + i] = glm::vec3(values[i]);
            picture.toned.pixels[batch.first + i] = glm::vec3(values[batch.count + i]);
            const glm::uvec4& counts = states[2 * i + 1];
            statistics.shading_points += counts[0];
            statistics.secondary_rays += counts[1];
            statistics.visibility.shadow_rays += counts[2];
        }
        statistics.primary_rays += batch.count * static_cast<std::uint64_t>(options.samples);
    }

    ComputeDevice device;
    RenderOptions options;
    std::size_t pixels;  ///< of a batch
    double seconds = 0.0;

    GpuScene scene;
    ComputeBuffer paths, waiting, points, colours, finished, round;
    std::unique_ptr<DeviceShadows> shadows;  ///< null: by rays of the shading kernel
    ComputeKernel trace, shade, finish;
};

GpuRenderer::GpuRenderer(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
                         const VisibilityOptions& visibility, const RenderOptions& options) {
    check(algorithm, visibility, options);
    parts_ = std::make_unique<Parts>(device, algorithm, scene, visibility, options);
}

GpuRenderer::~GpuRenderer() = default;

std::optional<lightmesh::MeshStatistics> GpuRenderer::mesh() const {
    return parts_->shadows ? parts_->shadows->mesh() : std::nullopt;
}

std::optional<lightmesh::CacheStatistics> GpuRenderer::cache() const {
    return parts_->shadows ? parts_->shadows->cache() : std::nullopt;
}

std::vector<std::byte> GpuRenderer::snapshot() const {
    return parts_->shadows ? parts_->shadows->snapshot() : std::vector<std::byte>{};
}

DeviceFill GpuRenderer::filled() const {
    return parts_->shadows ? parts_->shadows->spent() : DeviceFill{};
}

void GpuRenderer::update(const EmbreeScene& scene, const SceneChange& change) {
    parts_->scene.update(scene, change);
    if (parts_->shadows)
        parts_->shadows->update(scene, change);
}

void GpuRenderer::begin_frame() {
    if (parts_->shadows)
        parts_->shadows->begin_frame();
}

void GpuRenderer::merge(std::span<const std::byte> known) {
    if (parts_->shadows)
        parts_->shadows->merge(known);
}

std::size_t GpuRenderer::bytes() const {
    return parts_->shadows ? parts_->shadows->bytes() : 0;
}

GpuPicture GpuRenderer::render(RenderStatistics& statistics, const Progress& progress,
                               const std::atomic<bool>* cancel) {
    return render({0, parts_->picture_size()}, statistics, progress, cancel);
}

GpuPicture GpuRenderer::render(const PixelRange& part, RenderStatistics& statistics, const Progress& progress,
                               const std::atomic<bool>* cancel) {
    const Stopwatch watch;
    Parts& parts = *parts_;
    statistics = {};
    GpuPicture picture{Image(parts.options.width, parts.options.height),
                       Image(parts.options.width, parts.options.height)};
    parts.seconds = 0.0;
    const double filled_before = filled().seconds_device;
    for (std::size_t first = part.first; first < part.end; first += parts.pixels) {
        const BatchWords batch{static_cast<std::uint32_t>(first),
                               static_cast<std::uint32_t>((std::min)(parts.pixels, part.end - first)), 1, 0};
        try {
            statistics.finished = parts.follow(batch, cancel);
        } catch (const Cancelled&) {
            statistics.finished = false;
        }
        if (!statistics.finished)
            break;
        parts.take(batch, picture, statistics);
        if (progress)
            progress(static_cast<double>(first + batch.count - part.first) /
                     static_cast<double>(part.end - part.first));
    }
    picture.seconds_device = parts.seconds + filled().seconds_device - filled_before;
    statistics.seconds = watch.seconds();
    return picture;
}

}  // namespace demo
