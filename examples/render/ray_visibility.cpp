// SPDX-License-Identifier: MIT
#include "render/across.hpp"
#include "render/illumination.hpp"
#include "render/lamps.hpp"
#include "render/stopwatch.hpp"
#include "render/visibility.hpp"
#include "scene/random.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

namespace demo {

namespace {

/// Segments on their way to the tracer, each with the value that it adds to by the light that it lets
/// through.
class Batch {
public:
    explicit Batch(const EmbreeIntersector& tracer) : tracer_(tracer) {}

    void add(const lightmesh::Segment& segment, float& value, float share) {
        segments_[size_] = segment;
        values_[size_] = &value;
        shares_[size_++] = share;
        if (size_ == segments_.size())
            flush();
    }

    void flush() {
        tracer_.let_through(std::span(segments_).first(size_), std::span(hit_).first(size_),
                            std::span(open_).first(size_));
        for (std::size_t i = 0; i < size_; ++i)
            *values_[i] += shares_[i] * open_[i];
        rays_ += size_;
        size_ = 0;
    }

    std::uint64_t rays() const { return rays_; }

private:
    const EmbreeIntersector& tracer_;
    std::array<lightmesh::Segment, 64> segments_;
    std::array<float*, 64> values_;
    std::array<float, 64> shares_;
    std::array<std::uint8_t, 64> hit_;
    std::array<float, 64> open_;
    std::size_t size_ = 0;
    std::uint64_t rays_ = 0;
};

/// Shadow rays to points of the lights, as a subclass chooses them.
class RayVisibility : public Visibility {
public:
    RayVisibility(const EmbreeScene& scene, const VisibilityOptions& options)
        : scene_(scene), tracer_(scene.intersector()), numbers_(numbers_of_lights(scene.scene(), options)) {}

    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost& cost) const override {
        const Stopwatch watch;
        const std::vector<SceneLight>& lights = scene_.scene().lights;
        std::ranges::fill(lit, 0.0f);
        Batch batch(tracer_);
        for (std::size_t i = 0; i < points.points.size(); ++i) {
            const lightmesh::SurfacePoint& at = points.points[i];
            for (std::size_t place = 0; place < numbers_.size(); ++place) {
                const std::size_t l = numbers_[place];
                const Illumination light = illuminate(lights[l], at.position);
                if (glm::dot(at.normal, light.to_light) < 0.0f || light.irradiance == glm::vec3(0.0f))
                    continue;
                const lightmesh::Segment middle =
                    shadow_segment(lights[l], at.position, at.normal, scene_.offset(), scene_.far_away());
                const auto seed = points.seeds[i] ^ (static_cast<std::uint32_t>(l) * 0x9e3779b9u);
                add_rays(batch, middle, place, seed, lit[i * numbers_.size() + place]);
            }
        }
        batch.flush();
        cost.shadow_rays += batch.rays();
        cost.seconds += watch.seconds();
    }

protected:
    /// Rays for one point and the light in a place among those asked for; the shares that they add to `value`
    /// make 1.
    virtual void add_rays(Batch& batch, const lightmesh::Segment& middle, std::size_t place,
                          std::uint32_t seed, float& value) const = 0;

    const lightmesh::Light& shape(std::size_t place) const {
        return scene_.scene().lights[numbers_[place]].shape;
    }

private:
    const EmbreeScene& scene_;
    EmbreeIntersector tracer_;
    std::vector<std::size_t> numbers_;
};

class HardShadows final : public RayVisibility {
public:
    using RayVisibility::RayVisibility;

    void update(const EmbreeScene&, const SceneChange&) override {}  // each query asks the scene

protected:
    void add_rays(Batch& batch, const lightmesh::Segment& middle, std::size_t, std::uint32_t,
                  float& value) const override {
        batch.add(middle, value, 1.0f);
    }
};

/// Lights as spheres: the disc of the sphere that faces the point, in strata of equal area. Rectangles have
/// their own size.
class AreaShadows final : public RayVisibility {
public:
    AreaShadows(const EmbreeScene& scene, const VisibilityOptions& options)
        : RayVisibility(scene, options), options_(options), samples_(options.area_samples),
          rings_(static_cast<int>(std::sqrt(static_cast<float>(samples_)))), sizes_(sizes_in(scene)) {}

    void update(const EmbreeScene& scene, const SceneChange&) override { sizes_ = sizes_in(scene); }

protected:
    void add_rays(Batch& batch, const lightmesh::Segment& middle, std::size_t place, std::uint32_t seed,
                  float& value) const override {
        const float size = sizes_[place];
        if (const auto* pane = std::get_if<lightmesh::RectLight>(&shape(place))) {
            add_rays_to_pane(batch, middle, *pane, seed, value);
            return;
        }
        const float distance = glm::length(middle.target - middle.origin);
        const glm::vec3 axis = (middle.target - middle.origin) / distance;
        // A fixture does not hide its own lamp: see `lightmesh::VisibilityCache`.
        const float way = (std::max)(0.3f, 1.0f - 1.15f * size / distance);
        const auto [right, up] = across(axis);
        Random random(seed);
        for (int s = 0; s < samples_; ++s) {
            // Ring by ring; each ring has its share of the samples, and of the disc's area.
            const int ring = s * rings_ / samples_;
            const int first = (ring * samples_ + rings_ - 1) / rings_;
            const int count = ((ring + 1) * samples_ + rings_ - 1) / rings_ - first;
            const float inner = static_cast<float>(first) / static_cast<float>(samples_);
            const float width = static_cast<float>(count) / static_cast<float>(samples_);
            const float radius = size * std::sqrt(inner + width * random.uniform());
            const float turn = (static_cast<float>(s - first) + random.uniform()) / static_cast<float>(count);
            const glm::vec2 around = circle_point(turn);
            const glm::vec3 target = middle.target + radius * (around.x * right + around.y * up);
            batch.add({middle.origin, middle.origin + way * (target - middle.origin)}, value,
                      1.0f / static_cast<float>(samples_));
        }
    }

private:
    /// As for discs, in rows of equal area. The rays end as far short of the pane as that to its middle.
    void add_rays_to_pane(Batch& batch, const lightmesh::Segment& middle, const lightmesh::RectLight& pane,
                          std::uint32_t seed, float& value) const {
        Random random(seed);
        for (int s = 0; s < samples_; ++s) {
            const int row = s * rings_ / samples_;
            const int first = (row * samples_ + rings_ - 1) / rings_;
            const int count = ((row + 1) * samples_ + rings_ - 1) / rings_ - first;
            const float v = (static_cast<float>(first) + static_cast<float>(count) * random.uniform()) /
                            static_cast<float>(samples_);
            const float u = (static_cast<float>(s - first) + random.uniform()) / static_cast<float>(count);
            const glm::vec3 aside = (2.0f * u - 1.0f) * pane.half_u + (2.0f * v - 1.0f) * pane.half_v;
            batch.add({middle.origin, middle.target + aside}, value, 1.0f / static_cast<float>(samples_));
        }
    }

    std::vector<float> sizes_in(const EmbreeScene& scene) const {
        return sizes_at_ends(lamps_of(scene, options_), scene.far_away());
    }

    VisibilityOptions options_;
    int samples_;
    int rings_;
    std::vector<float> sizes_;  ///< of the lamps, as the scene is now
};

}  // namespace

std::unique_ptr<Visibility> make_hard_shadows(const EmbreeScene& scene, const VisibilityOptions& options) {
    return std::make_unique<HardShadows>(scene, options);
}

std::unique_ptr<Visibility> make_area_shadows(const EmbreeScene& scene, const VisibilityOptions& options) {
    if (options.area_samples < 1 || options.area_samples > 1024)
        throw std::invalid_argument("area lights take 1 to 1024 rays, not " +
                                    std::to_string(options.area_samples));
    return std::make_unique<AreaShadows>(scene, options);
}

}  // namespace demo
