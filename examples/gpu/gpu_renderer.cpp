// SPDX-License-Identifier: MIT
#include "gpu/gpu_renderer.hpp"

#include "gpu/cache_shadows.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/map_shadows.hpp"
#include "gpu/mesh_shadows.hpp"
#include "gpu/volume_shadows.hpp"
#include "render/stopwatch.hpp"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

namespace demo {

namespace {

constexpr std::uint32_t trace_words[] = {
#include "spirv/trace.comp.inc"
};
constexpr std::uint32_t hard_words[] = {
#include "spirv/shade_hard.inc"
};
constexpr std::uint32_t area_words[] = {
#include "spirv/shade_area.inc"
};
constexpr std::uint32_t host_rows_words[] = {
#include "spirv/shade_host_rows.inc"
};
constexpr std::uint32_t mesh_4_words[] = {
#include "spirv/shade_mesh_4.inc"
};
constexpr std::uint32_t mesh_16_words[] = {
#include "spirv/shade_mesh_16.inc"
};
constexpr std::uint32_t mesh_exact_words[] = {
#include "spirv/shade_mesh_exact.inc"
};
constexpr std::uint32_t cache_words[] = {
#include "spirv/shade_cache.comp.inc"
};
constexpr std::uint32_t finish_words[] = {
#include "spirv/finish.comp.inc"
};

/// As paths.glsl has it.
struct BatchWords {
    std::uint32_t first;
    std::uint32_t count;
    std::uint32_t is_first_round;
    std::uint32_t attempt;
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

/// To ask a light mesh at a point that is a rounding farther from its surface.
constexpr std::uint32_t most_attempts = 64;
/// Of asking and filling: some, since of points close together one asks. After that points ask in turn for
/// what the host does not fill.
constexpr int enough_turns = 16;

/// One in so many points tells the host what shaders use of a light mesh or a cache with a memory budget: a
/// brick, or a record, is seen from many. They are the same pixels in each frame: what only others see is
/// forgotten, and found again. Each round all paths and points are read for it, 80 bytes a pixel.
constexpr std::uint32_t pixels_of_use = 7;

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

std::span<const std::uint32_t> shader_of(const std::string& algorithm, const VisibilityOptions& visibility) {
    if (asks_mesh(algorithm)) {
        const lightmesh::Settings settings = with_short_test(visibility, algorithm).settings;
        if (settings.short_test == lightmesh::ShortTest::exact)
            return mesh_exact_words;
        return settings.quality <= 4.0f ? std::span<const std::uint32_t>(mesh_4_words) : mesh_16_words;
    }
    if (asks_cache(algorithm))
        return cache_words;
    if (asks_lookups(algorithm))
        return host_rows_words;
    return algorithm == "area" ? std::span<const std::uint32_t>(area_words) : hard_words;
}

}  // namespace

struct GpuRenderer::Parts {
    Parts(const ComputeDevice& on, const std::string& algorithm, const EmbreeScene& model,
          const VisibilityOptions& visibility, const RenderOptions& render)
        : device(on), options(render), pixels(batch_size(algorithm, model, visibility)),
          scene(on, model, visibility, render), paths(on, bytes_of_path * pixels),
          waiting(on, bytes_of_ray * places_of_rays() * pixels), points(on, bytes_of_point * pixels),
          colours(on, bytes_of_colour * pixels), finished(on, 2 * bytes_of_colour * pixels),
          round(on, sizeof(RoundWords)), mesh(mesh_of(algorithm, model, visibility)),
          cache(asks_cache(algorithm)
                    ? std::make_unique<CacheShadows>(on, algorithm, model, scene, visibility, pixels)
                    : nullptr),
          maps(algorithm == "shadow-map"
                   ? std::make_unique<MapShadows>(on, model, visibility, pixels, bindings({}))
                   : nullptr),
          volumes(algorithm == "shadow-volume"
                      ? std::make_unique<VolumeShadows>(on, model, visibility, pixels)
                      : nullptr),
          trace(on, trace_words, bindings({}), sizeof(BatchWords)),
          shade(on, shader_of(algorithm, visibility),
                bindings(mesh      ? mesh->bindings()
                         : cache   ? cache->bindings()
                         : maps    ? maps->bindings()
                         : volumes ? volumes->bindings()
                                   : std::vector<ComputeBinding>{}),
                sizeof(BatchWords)),
          finish(on, finish_words, bindings({}), sizeof(BatchWords)) {}

    std::unique_ptr<MeshShadows> mesh_of(const std::string& algorithm, const EmbreeScene& model,
                                         const VisibilityOptions& visibility) const {
        return asks_mesh(algorithm) ? std::make_unique<MeshShadows>(device, algorithm, model, scene,
                                                                    with_short_test(visibility, algorithm))
                                    : nullptr;
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
            made.push_back({.binding = static_cast<std::uint32_t>(made.size()), .buffer = buffer});
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
                if (!asks_host())
                    commands.dispatch(shade, groups_of(batch), 1, 1, bytes_in(batch));
                batch.is_first_round = 0;
            }
        });
    }

    /// True if shading waits for what the host finds.
    bool asks_host() const { return mesh || cache || maps || volumes; }

    RoundWords last_round() const {
        RoundWords found;
        round.read(0, std::as_writable_bytes(std::span(&found, 1)));
        return found;
    }

    void shade_once(const BatchWords& batch) {
        seconds += device.run([&](const ComputeCommands& commands) {
            commands.dispatch(shade, groups_of(batch), 1, 1, bytes_in(batch));
        });
        if (last_round().is_failed != 0)
            throw std::out_of_range("--on gpu: a point lies farther from the origin than a light mesh or a "
                                    "cache reaches");
    }

    /// Shades a round's points by the light mesh, until it knows all that it takes.
    void shade_by_mesh(BatchWords batch, const std::atomic<bool>* cancel) {
        int turns = 0;
        for (auto asked = MeshShadows::Asked::points; asked != MeshShadows::Asked::nothing;) {
            mesh->bind(shade);
            shade_once(batch);
            asked = mesh->fill(cancel);
            const bool is_stuck = asked == MeshShadows::Asked::same_points || ++turns > enough_turns;
            if (is_stuck && ++batch.attempt > most_attempts)
                throw std::runtime_error("--on gpu: host and device do not agree on what the light mesh "
                                         "lacks at a point");
        }
    }

    void shade_by(const std::vector<ComputeBinding>& answers, const BatchWords& batch) {
        for (const ComputeBinding& binding : answers)
            shade.bind(binding);
        shade_once(batch);
    }

    /// A round's points, of every so many pixels those that have one.
    struct Asked {
        std::vector<lightmesh::SurfacePoint> points;
        std::vector<std::uint32_t> pixels;
    };
    Asked read_points(const BatchWords& batch, std::uint32_t of_pixels) const {
        const std::size_t count = batch.count;
        std::vector<glm::uvec4> states(2 * count);
        paths.read(0, std::as_writable_bytes(std::span(states)));
        std::vector<glm::vec4> words(3 * count);
        points.read(0, std::as_writable_bytes(std::span(words)));
        Asked asked;
        for (std::uint32_t i = 0; i < batch.count; i += of_pixels) {
            if (states[2 * i + 1].w == 0)
                continue;
            asked.points.push_back({.position = glm::vec3(words[i]),
                                    .normal = glm::vec3(words[count + i]),
                                    .footprint = words[i].w,
                                    .shading_normal = glm::vec3(words[2 * count + i])});
            asked.pixels.push_back(i);
        }
        return asked;
    }

    /// Asks the host about a round's points.
    void ask_volumes(const BatchWords& batch, const std::atomic<bool>* cancel) {
        const Asked asked = read_points(batch, 1);
        volumes->find(asked.points, asked.pixels, cancel);
    }

    void shade_by_host(const BatchWords& batch, const std::atomic<bool>* cancel) {
        tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
        arena.execute([&] {
            if (mesh) {
                shade_by_mesh(batch, cancel);
                if (mesh->has_budget())
                    mesh->note_use(read_points(batch, pixels_of_use).points, cancel);
                return;
            }
            if (maps) {
                seconds += maps->find(bytes_in(batch), groups_of(batch), cancel);
                shade_by(maps->bindings(), batch);
                return;
            }
            if (volumes) {
                ask_volumes(batch, cancel);
                shade_by(volumes->bindings(), batch);
                return;
            }
            cache->begin_round();
            do {
                cache->bind(shade);
                shade_once(batch);
            } while (cache->fill(cancel));
            if (cache->has_budget())
                cache->note_use(read_points(batch, pixels_of_use).points, cancel);
        });
    }

    /// False if cancelled.
    bool follow(BatchWords batch, const std::atomic<bool>* cancel) {
        constexpr int most_rounds = 8;
        for (int rounds = 1;; rounds = asks_host() ? 1 : (std::min)(2 * rounds, most_rounds)) {
            if (cancel != nullptr && cancel->load(std::memory_order_relaxed))
                return false;
            run_rounds(batch, rounds);
            batch.is_first_round = 0;
            const RoundWords found = last_round();
            if (found.point_count == 0)
                return true;
            if (asks_host())
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
    // Shadows are found by one of these, or by rays.
    std::unique_ptr<MeshShadows> mesh;
    std::unique_ptr<CacheShadows> cache;
    std::unique_ptr<MapShadows> maps;
    std::unique_ptr<VolumeShadows> volumes;
    ComputeKernel trace, shade, finish;
};

GpuRenderer::GpuRenderer(const ComputeDevice& device, const std::string& algorithm, const EmbreeScene& scene,
                         const VisibilityOptions& visibility, const RenderOptions& options) {
    check(algorithm, visibility, options);
    parts_ = std::make_unique<Parts>(device, algorithm, scene, visibility, options);
}

GpuRenderer::~GpuRenderer() = default;

std::optional<lightmesh::MeshStatistics> GpuRenderer::mesh() const {
    if (!parts_->mesh)
        return std::nullopt;
    return parts_->mesh->statistics();
}

std::optional<lightmesh::CacheStatistics> GpuRenderer::cache() const {
    if (!parts_->cache)
        return std::nullopt;
    return parts_->cache->statistics();
}

std::vector<std::byte> GpuRenderer::snapshot() const {
    return parts_->mesh    ? parts_->mesh->snapshot()
           : parts_->cache ? parts_->cache->snapshot()
                           : std::vector<std::byte>{};
}

DeviceFill GpuRenderer::filled() const {
    return parts_->mesh ? parts_->mesh->spent() : parts_->cache ? parts_->cache->spent() : DeviceFill{};
}

void GpuRenderer::update(const EmbreeScene& scene, const SceneChange& change) {
    parts_->scene.update(scene, change);
    if (parts_->mesh)
        parts_->mesh->update(scene, change);
    if (parts_->cache)
        parts_->cache->update(scene, change);
    if (parts_->maps)
        parts_->maps->update(scene, change);
    if (parts_->volumes)
        parts_->volumes->update(scene, change);
}

void GpuRenderer::begin_frame() {
    if (parts_->mesh)
        parts_->mesh->begin_frame();
    if (parts_->cache)
        parts_->cache->begin_frame();
}

void GpuRenderer::merge(std::span<const std::byte> known) {
    if (parts_->mesh)
        parts_->mesh->merge(known);
    if (parts_->cache)
        parts_->cache->merge(known);
}

std::size_t GpuRenderer::bytes() const {
    return parts_->mesh      ? parts_->mesh->statistics().bytes
           : parts_->cache   ? parts_->cache->statistics().bytes
           : parts_->maps    ? parts_->maps->bytes()
           : parts_->volumes ? parts_->volumes->bytes()
                             : 0;
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
