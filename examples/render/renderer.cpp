// SPDX-License-Identifier: MIT
#include "render/renderer.hpp"

#include "render/across.hpp"
#include "render/shading.hpp"
#include "render/stopwatch.hpp"
#include "render/view.hpp"
#include "scene/random.hpp"
#include "scene/surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace demo {

namespace {

/// Places for visibilities that a thread holds at most, for points times lights.
constexpr std::size_t most_visibilities = std::size_t{1} << 18;
/// Rays that add less than this to a pixel are not traced.
constexpr float least_weight = 1.0f / 512.0f;

/// A ray on its way, and the share of a pixel that it brings.
struct PathRay {
    glm::vec3 origin;
    glm::vec3 direction;
    glm::vec3 weight;
    int pixel;
    int depth;
    float width;              ///< of the pixel's cone at the origin
    bool is_straight = true;  ///< neither mirrored nor bent so far
};

/// Tiles are rendered in three steps, each for many points at once: rays are followed to all surfaces that
/// add to a pixel, the visibility of the lights is found there, the points are shaded.
class Tile {
public:
    Tile(const EmbreeScene& scene, const LightTable& lights, const Visibility& visibility,
         const RenderOptions& options)
        : scene_(scene), lights_(lights), visibility_(visibility), options_(options),
          tracer_(scene.handle(), EmbreeIntersector::Batches::packets),
          most_points_((std::max)(
              std::size_t{1}, most_visibilities / (std::max)(std::size_t{1}, scene.scene().lights.size()))) {}

    /// Renders the pixels from (left, top) on, as far as there are any.
    TilePixels render(const View& view, int left, int top) {
        const Stopwatch watch;
        pixel_angle_ = view.pixel_angle();
        const int width = (std::min)(tile_size, options_.width - left);
        const int height = (std::min)(tile_size, options_.height - top);
        colours_.assign(static_cast<std::size_t>(width * height), glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
        for (int pixel = 0; pixel < width * height; ++pixel) {
            const int column = left + pixel % width;
            const int row = top + pixel / width;
            random_ = Random(static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(options_.width) +
                             static_cast<std::uint64_t>(column));
            follow_samples(view, column, row, pixel);
        }
        shade_points();
        statistics_.seconds_tracing =
            watch.seconds() - statistics_.visibility.seconds - statistics_.seconds_shading;
        for (glm::vec4& colour : colours_)
            colour = {model().exposure * glm::vec3(colour), glm::clamp(colour.a, 0.0f, 1.0f)};
        return {left, top, width, height, colours_};
    }

    const RenderStatistics& statistics() const { return statistics_; }

private:
    const Scene& model() const { return scene_.scene(); }

    void follow_samples(const View& view, int column, int row, int pixel) {
        const auto count = static_cast<float>(options_.samples);
        const glm::vec2 shift{random_.uniform(), random_.uniform()};
        for (int s = 0; s < options_.samples; ++s) {
            const glm::vec2 place =
                options_.samples == 1 ? glm::vec2(0.5f) : glm::fract(sample_place(s) + shift);
            const float x = static_cast<float>(column) + place.x;
            const float y = static_cast<float>(row) + place.y;
            ++statistics_.primary_rays;
            const glm::vec3 direction = view.direction(x, y);
            const Camera& camera = model().camera;
            const float stretch = view.stretch(direction);
            const float ahead = camera.z_near * stretch;
            rays_.push_back({view.origin(x, y) + ahead * direction, direction, glm::vec3(1.0f / count), pixel,
                             0, view.pixel_width() + ahead * view.pixel_angle()});
            follow_rays((camera.z_far - camera.z_near) * stretch);
        }
    }

    /// The s-th place of a Hammersley set.
    glm::vec2 sample_place(int s) const {
        float y = 0.0f;
        float half = 0.5f;
        for (int digits = s; digits != 0; digits /= 2, half *= 0.5f)
            y += static_cast<float>(digits % 2) * half;
        return {(static_cast<float>(s) + 0.5f) / static_cast<float>(options_.samples), y};
    }

    /// `length` is that of the ray from the eye.
    void follow_rays(float length) {
        while (!rays_.empty()) {
            const PathRay ray = rays_.back();
            rays_.pop_back();
            const float reach = ray.depth == 0 ? length : std::numeric_limits<float>::infinity();
            const std::optional<Hit> hit = scene_.trace(ray.origin, ray.direction, reach);
            if (hit)
                add_point(ray, *hit);
            else
                add_background(ray);
        }
    }

    void add_background(const PathRay& ray) {
        glm::vec4& colour = colours_[static_cast<std::size_t>(ray.pixel)];
        if (ray.is_straight && options_.transparent_background)
            colour.a -= (ray.weight.x + ray.weight.y + ray.weight.z) / 3.0f;
        else
            colour += glm::vec4(ray.weight * model().background, 0.0f);
    }

    void add_point(const PathRay& ray, const Hit& hit) {
        hits_.push_back(hit);
        arrivals_.push_back(ray);
        // Mirrors and glass are taken for flat: the cone goes on as wide as it has become.
        const float width = ray.width + pixel_angle_ * glm::distance(ray.origin, hit.position);
        points_.push_back({hit.position, hit.geometric_normal, width, hit.shading_normal});
        seeds_.push_back(random_.next());
        follow_on(ray, hit, width);
        if (hits_.size() == most_points_)
            shade_points();
    }

    void follow_on(const PathRay& ray, const Hit& hit, float width) {
        if (ray.depth >= options_.depth_limit)
            return;
        const Material& material = model().materials[hit.material];
        if (material.k_s == 0.0f && material.k_t == 0.0f && material.alpha_mode != AlphaMode::blend)
            return;  // most surfaces
        const Surface surface = surface_at(model(), material, hit.triangle, hit.u, hit.v);
        const glm::vec3 way = scene_.offset() * hit.geometric_normal;
        const glm::vec3 mirrored = glm::reflect(ray.direction, hit.shading_normal);
        follow_on(ray, hit.position + way, mirrored, glm::vec3(surface.k_s), width, false);
        const glm::vec3 through = refracted(hit, ray.direction, material.refraction_index);
        const bool enters = glm::dot(through, hit.geometric_normal) < 0.0f;
        follow_on(ray, hit.position + (enters ? -way : way), through, surface.k_t, width,
                  material.k_t == 0.0f && material.refraction_index == 1.0f);
    }

    void follow_on(const PathRay& ray, const glm::vec3& origin, const glm::vec3& direction,
                   const glm::vec3& share, float width, bool is_straight) {
        const glm::vec3 weight = share * ray.weight;
        if ((std::max)({weight.x, weight.y, weight.z}) * static_cast<float>(options_.samples) < least_weight)
            return;
        ++statistics_.secondary_rays;
        rays_.push_back(
            {origin, direction, weight, ray.pixel, ray.depth + 1, width, ray.is_straight && is_straight});
    }

    void shade_points() {
        const std::size_t light_count = model().lights.size();
        lit_.resize(hits_.size() * light_count);
        visibility_.find({points_, seeds_}, lit_, statistics_.visibility);
        const Stopwatch watch;
        for (std::size_t i = 0; i < hits_.size(); ++i) {
            const PathRay& ray = arrivals_[i];
            const std::span<const float> lit = std::span(lit_).subspan(i * light_count, light_count);
            const float ambient = options_.ambient_rays > 0 ? ambient_share(i) : 1.0f;
            colours_[static_cast<std::size_t>(ray.pixel)] +=
                glm::vec4(ray.weight * shade(model(), lights_, hits_[i], ray.direction, lit, ambient), 0.0f);
        }
        statistics_.seconds_shading += watch.seconds();
        statistics_.shading_points += hits_.size();
        hits_.clear();
        arrivals_.clear();
        points_.clear();
        seeds_.clear();
    }

    /// By rays of equal weight, more of them towards the normal.
    float ambient_share(std::size_t i) {
        const glm::vec3& normal = hits_[i].shading_normal;
        const auto [right, up] = across(normal);
        const glm::vec3 origin = points_[i].position + scene_.offset() * points_[i].normal;
        const float length = (std::min)(options_.ambient_distance, scene_.far_away());
        const auto count = static_cast<std::size_t>(options_.ambient_rays);
        Random random(seeds_[i]);
        ambient_.resize(count);
        ambient_hits_.resize(count);
        const float turned = random.uniform();
        for (std::size_t k = 0; k < count; ++k) {
            const float area = (static_cast<float>(k) + random.uniform()) / static_cast<float>(count);
            // By the golden ratio around the normal.
            const glm::vec2 around = circle_point(glm::fract(turned + 0.61803399f * static_cast<float>(k)));
            const glm::vec3 direction =
                std::sqrt(area) * (around.x * right + around.y * up) + std::sqrt(1.0f - area) * normal;
            ambient_[k] = {origin, origin + length * direction};
        }
        tracer_.occluded(ambient_, ambient_hits_);
        const auto blocked = std::ranges::count_if(ambient_hits_, [](std::uint8_t hit) { return hit != 0; });
        return 1.0f - static_cast<float>(blocked) / static_cast<float>(count);
    }

    const EmbreeScene& scene_;
    const LightTable& lights_;
    const Visibility& visibility_;
    const RenderOptions& options_;
    EmbreeIntersector tracer_;
    std::size_t most_points_;
    RenderStatistics statistics_;
    Random random_{0};  // the pixel's own
    float pixel_angle_ = 0.0f;
    std::vector<PathRay> rays_;
    std::vector<glm::vec4> colours_;

    // The points that wait to be shaded.
    std::vector<Hit> hits_;
    std::vector<PathRay> arrivals_;
    std::vector<lightmesh::SurfacePoint> points_;
    std::vector<std::uint32_t> seeds_;
    std::vector<float> lit_;
    std::vector<lightmesh::Segment> ambient_;
    std::vector<std::uint8_t> ambient_hits_;
};

void require_in_range(const char* what, int value, int low, int high) {
    if (value < low || value > high)
        throw std::invalid_argument(std::string(what) + " must be in [" + std::to_string(low) + ", " +
                                    std::to_string(high) + "], not " + std::to_string(value));
}

void check(const RenderOptions& options) {
    require_in_range("the width", options.width, 1, 65536);
    require_in_range("the height", options.height, 1, 65536);
    require_in_range("samples", options.samples, 1, 1024);
    require_in_range("the depth limit", options.depth_limit, 0, 100);
    require_in_range("threads", options.threads, 0, 4096);
    require_in_range("ambient rays", options.ambient_rays, 0, 1024);
}

}  // namespace

RenderStatistics& RenderStatistics::operator+=(const RenderStatistics& tile) {
    primary_rays += tile.primary_rays;
    secondary_rays += tile.secondary_rays;
    shading_points += tile.shading_points;
    visibility += tile.visibility;
    seconds_tracing += tile.seconds_tracing;
    seconds_shading += tile.seconds_shading;
    return *this;
}

Image render(const EmbreeScene& scene, const Visibility& visibility, const RenderOptions& options,
             RenderStatistics& statistics, const Progress& progress, const std::atomic<bool>* cancel) {
    check(options);
    Image image(options.width, options.height);
    const auto put = [&image](const TilePixels& tile) {
        for (std::size_t i = 0; i < tile.pixels.size(); ++i)
            image.at(tile.left + static_cast<int>(i) % tile.width,
                     tile.top + static_cast<int>(i) / tile.width) = glm::vec3(tile.pixels[i]);
    };
    render(scene, visibility, options, statistics, put, progress, cancel);
    return image;
}

void render(const EmbreeScene& scene, const Visibility& visibility, const RenderOptions& options,
            RenderStatistics& statistics, const TileSink& sink, const Progress& progress,
            const std::atomic<bool>* cancel) {
    check(options);
    const Stopwatch watch;
    const View view(scene.scene().camera, options.width, options.height);
    const LightTable lights(scene.scene().lights);
    const int columns = (options.width + tile_size - 1) / tile_size;
    const int rows = (options.height + tile_size - 1) / tile_size;
    const int tiles = options.tiles.empty() ? columns * rows : static_cast<int>(options.tiles.size());
    statistics = {};
    std::mutex one_at_a_time;
    int done = 0;
    const auto render_tile = [&](int i) {
        if (cancel != nullptr && cancel->load(std::memory_order_relaxed))
            return;
        const int index = options.tiles.empty() ? i : options.tiles[static_cast<std::size_t>(i)];
        Tile tile(scene, lights, visibility, options);
        const TilePixels pixels = tile.render(view, index % columns * tile_size, index / columns * tile_size);
        const std::scoped_lock lock(one_at_a_time);
        sink(pixels);
        statistics += tile.statistics();
        ++done;
        if (progress)
            progress(static_cast<double>(done) / static_cast<double>(tiles));
    };
    tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
    arena.execute([&] { tbb::parallel_for(0, tiles, render_tile); });
    statistics.finished = done == tiles;
    statistics.seconds = watch.seconds();
}

}  // namespace demo
