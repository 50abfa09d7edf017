// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_renderer.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/shadows/shadow_map_views.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/made_once.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lightmesh {

/// One renderer for any number of shadow maps, used by one thread at a time.
template <class Renderer>
class SharedDepthRenderer {
public:
    /// Takes a renderer over.
    explicit SharedDepthRenderer(Renderer renderer) : renderer_(std::move(renderer)) {}

    /// Calls use(renderer) while no other thread does.
    template <class Use>
    void with(Use&& use) {
        const std::scoped_lock lock(busy_);
        use(renderer_);
    }

    /// The renderer's own bounds, if it knows them.
    std::optional<Bounds> bounds() const {
        if constexpr (BoundedDepthRenderer<Renderer>)
            return renderer_.bounds();
        return std::nullopt;
    }

private:
    std::mutex busy_;
    Renderer renderer_;
};

/// The knowledge that a shadow map has about a point, from the four texels around it.
enum class ShadowMapLookup {
    dark,  ///< something is before the point
    lit,   ///< nothing is
    edge,  ///< the texels disagree, or a surface is too near to the point to tell: worth a ray
};

/// Shadows of one light from pictures of the distances that it sees (Williams, "Casting Curved Shadows on
/// Curved Surfaces", 1978): V(L, x) by look-up instead of by ray, for points in free space as for points on
/// surfaces.
///
/// Pictures are rendered when a look-up first needs them: those that none needs never are. Look-ups are const
/// and may be made from any number of threads at once, also while pictures are being rendered; their results
/// do not depend on who came first. They allocate memory for new pictures only; they throw what the renderer
/// throws, and std::runtime_error for a picture with NaN or negative distances in it.
///
/// A point at distance D from the light is lit by a texel that holds the distance d if
///
///     D <= d + bias,   bias = b * d * (2 t / resolution) * cos a
///
/// where b is `ShadowMapSettings::bias`, t the tangent of half the picture's angle (1 in a face of a cube),
/// and a the angle between the axis of the picture and the way to the point: the bias is b times the side of
/// the texel where the surface is. (Directional light: b times the side of a texel.) What lies less than that
/// behind a surface counts as lit.
///
/// The four texels whose centres surround the point are asked. If they disagree, and lie on one surface
/// (their distances differ by up to 16 sides of a texel: seen at up to 85 degrees), the plane through them
/// is compared with the point, so that surfaces do not shade themselves; else the majority by bilinear
/// weights decides. Texels beyond the edge of a picture are those of the next face.
///
/// Range and cone of a light play no part: that is for the user of V. A point that is not finite is dark; the
/// light itself is lit. What is outside the map of a directional light has nothing before it, and is lit.
template <class Renderer>
class ShadowMap {
    static_assert(check_depth_renderer<Renderer>());

public:
    /// The parts that several maps may share.
    using Shared = SharedDepthRenderer<Renderer>;

    /// Throws std::invalid_argument that names the value for a light or settings that are not finite or out
    /// of range, and for a directional light without bounds. Nothing is rendered yet.
    ShadowMap(Renderer renderer, const Light& light, const ShadowMapSettings& settings)
        : ShadowMap(std::make_shared<Shared>(std::move(renderer)), light, settings) {}

    /// The same, with a renderer that other maps use too. `name` is what errors call the light.
    ShadowMap(std::shared_ptr<Shared> renderer, const Light& light, const ShadowMapSettings& settings,
              const std::string& name = "light")
        : renderer_(std::move(renderer)), name_(name), views_(light, with_bounds(settings, *renderer_), name),
          resolution_(settings.resolution), bias_(settings.bias),
          pictures_(std::make_unique<Texels[]>(views_.size())) {}

    /// V(L, x) from the texels around the point: true for lit.
    bool visible(const glm::vec3& point) const {
        if (!detail::is_finite(point))
            return false;
        const Around around = texels_around(point);
        float lit_weight = 0.0f;
        int lit_count = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            if (!lit(around.coord, around.stored[i], bias_))
                continue;
            lit_weight += around.weight[i];
            ++lit_count;
        }
        if (lit_count == 0 || lit_count == 4)
            return lit_count == 4;
        return is_one_surface(around, 16.0f) ? lit(around.coord, surface(around), bias_) : lit_weight >= 0.5f;
    }

    /// V(L, x) if the map can tell: if all four texels say the same, by more than the side of a texel, or if
    /// the plane through them, seen at up to 70 degrees (their distances differ by up to 4 sides of a texel),
    /// is farther from the point than a tenth of a side.
    ShadowMapLookup look_up(const glm::vec3& point) const {
        if (!detail::is_finite(point))
            return ShadowMapLookup::dark;
        const Around around = texels_around(point);
        int dark = 0;
        int bright = 0;
        for (const float stored : around.stored) {
            dark += lit(around.coord, stored, 1.0f) ? 0 : 1;
            bright += clearly_lit(around.coord, stored, 1.0f) ? 1 : 0;
        }
        if (bright == 4)
            return ShadowMapLookup::lit;
        if (dark == 4)
            return ShadowMapLookup::dark;
        if (!is_one_surface(around, 4.0f))
            return ShadowMapLookup::edge;
        const float plane = surface(around);
        if (clearly_lit(around.coord, plane, 0.1f))
            return ShadowMapLookup::lit;
        return lit(around.coord, plane, 0.1f) ? ShadowMapLookup::edge : ShadowMapLookup::dark;
    }

    /// The share of the light that reaches a point, 0..1, by percentage-closer filtering (Reeves, Salesin,
    /// Cook, "Rendering Antialiased Shadows with Depth Maps", 1987): the mean over the square of `filter`
    /// texels to each side of the point, texels at its rim counted by the part inside. 0 gives `visible`, 0.5
    /// the usual bilinear filter. The bias is 1 + 2 * filter times that of `visible`. Throws
    /// std::invalid_argument for a filter outside [0, 64].
    float visibility(const glm::vec3& point, float filter = 0.5f) const {
        detail::require(filter >= 0.0f && filter <= 64.0f, "the filter's radius", filter,
                        "in [0, 64] texels");
        if (!detail::is_finite(point))
            return 0.0f;
        if (filter == 0.0f)
            return visible(point) ? 1.0f : 0.0f;
        return filtered(views_.locate(point), filter);
    }

    /// Renders all pictures that are not there yet: at once, if the renderer can.
    void render_all() const {
        render([](std::size_t) { return true; });
    }

    /// Forgets the pictures that may show one of these boxes, in which the scene has changed. Nothing else
    /// may use the map meanwhile.
    void forget(std::span<const Bounds> boxes) {
        for (std::size_t i = 0; i < views_.size(); ++i)
            if (std::ranges::any_of(boxes, [&](const Bounds& box) { return views_.may_show(i, box); }))
                pictures_[i].forget();
    }

    /// True if all pictures of another map are taken as these are.
    bool has_views_of(const ShadowMap& other) const { return views_ == other.views_; }

    /// The greatest side of a texel of a light with a position, at distance 1 from it; else 0.
    double texel_angle() const { return views_.texel_angle(); }
    /// The greatest side of a texel of a directional light, in world units; else 0.
    double texel_side() const { return views_.texel_side(); }

    /// The views that may be asked of the renderer: 1 (directional), 6, or 7 views, of which a spot light
    /// needs the first for its cone and the others only for points outside of it.
    std::span<const DepthView> views() const { return views_.all(); }

    /// The distances in the picture of `views()[view]`, row by row; it is rendered if it is not there. Valid
    /// until `forget`. Throws what a look-up throws.
    std::span<const float> distances(std::size_t view) const { return {picture(view), texel_count()}; }

    /// Pictures rendered so far.
    std::size_t rendered() const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < views_.size(); ++i)
            count += pictures_[i].get() != nullptr ? 1u : 0u;
        return count;
    }

    /// Memory held by now, without the renderer's own.
    std::size_t bytes() const {
        return sizeof *this + views_.size() * (sizeof(Texels) + sizeof(DepthView)) +
               rendered() * texel_count() * sizeof(float);
    }

private:
    /// Of one picture, row by row; made under the renderer's lock.
    using Texels = detail::MadeOnce<float[]>;

    static ShadowMapSettings with_bounds(ShadowMapSettings settings, const Shared& renderer) {
        if (!settings.scene_bounds)
            settings.scene_bounds = renderer.bounds();
        return settings;
    }

    std::size_t texel_count() const {
        return static_cast<std::size_t>(resolution_) * static_cast<std::size_t>(resolution_);
    }

    int whole(float texels) const { return std::clamp(static_cast<int>(texels), 0, resolution_ - 1); }

    /// The texels whose centres surround a point: left and right of the upper row, then of the lower one.
    struct Around {
        detail::TexelCoord coord;
        int column = 0;
        int row = 0;
        std::array<float, 4> stored{};
        std::array<float, 4> weight{};  // bilinear
    };

    Around texels_around(const glm::vec3& point) const {
        Around around;
        around.coord = views_.locate(point);
        const float left = std::floor(around.coord.column - 0.5f);
        const float top = std::floor(around.coord.row - 0.5f);
        const float x = around.coord.column - 0.5f - left;
        const float y = around.coord.row - 0.5f - top;
        around.column = static_cast<int>(left);
        around.row = static_cast<int>(top);
        for (int i = 0; i < 4; ++i)
            around.stored[static_cast<std::size_t>(i)] =
                texel(around.coord, around.column + i % 2, around.row + i / 2);
        around.weight = {(1.0f - x) * (1.0f - y), x * (1.0f - y), (1.0f - x) * y, x * y};
        return around;
    }

    static bool lit(const detail::TexelCoord& coord, float stored, float bias) {
        return coord.distance <= stored * (1.0f + bias * coord.relative_texel) + bias * coord.absolute_texel;
    }

    /// As `lit`, with the bias to the other side.
    static bool clearly_lit(const detail::TexelCoord& coord, float stored, float bias) {
        return coord.distance * (1.0f + bias * coord.relative_texel) + bias * coord.absolute_texel <= stored;
    }

    /// True if the texels' distances differ by no more than some sides of a texel.
    static bool is_one_surface(const Around& around, float sides) {
        const auto [nearest, farthest] = std::ranges::minmax(around.stored);
        return farthest <=
               nearest * (1.0f + sides * around.coord.relative_texel) + sides * around.coord.absolute_texel;
    }

    /// Distance of the plane through the texels in the direction of the point: along the axis of a
    /// perspective view 1/z, of a parallel view z, is linear on a plane.
    float surface(const Around& around) const {
        const DepthView& view = views_[static_cast<std::size_t>(around.coord.view)];
        float sum = 0.0f;
        for (int i = 0; i < 4; ++i) {
            const auto k = static_cast<std::size_t>(i);
            if (view.orthographic) {
                sum += around.weight[k] * around.stored[k];
            } else {
                const float stretch = glm::length(view.offset(around.column + i % 2, around.row + i / 2));
                sum += around.weight[k] * stretch / around.stored[k];
            }
        }
        return view.orthographic ? sum : around.coord.stretch / sum;
    }

    /// The value of a texel that may lie outside of the picture.
    float texel(const detail::TexelCoord& coord, int column, int row) const {
        if (coord.view < 0)
            return std::numeric_limits<float>::infinity();
        const bool inside = column >= 0 && column < resolution_ && row >= 0 && row < resolution_;
        if (!inside) [[unlikely]] {
            const detail::TexelCoord other = views_.locate_outside(coord.view, column, row);
            return texel(other, whole(other.column), whole(other.row));
        }
        const auto side = static_cast<std::size_t>(resolution_);
        return picture(static_cast<std::size_t>(
            coord.view))[static_cast<std::size_t>(row) * side + static_cast<std::size_t>(column)];
    }

    float filtered(const detail::TexelCoord& coord, float filter) const {
        const auto inside = [filter](float centre, int texel) {
            const auto low = static_cast<float>(texel);
            return (std::min)(centre + filter, low + 1.0f) - (std::max)(centre - filter, low);
        };
        const int last_column = static_cast<int>(std::floor(coord.column + filter));
        const int last_row = static_cast<int>(std::floor(coord.row + filter));
        const float bias = bias_ * (1.0f + 2.0f * filter);
        double sum = 0.0;
        double weights = 0.0;
        for (int row = static_cast<int>(std::floor(coord.row - filter)); row <= last_row; ++row) {
            for (int column = static_cast<int>(std::floor(coord.column - filter)); column <= last_column;
                 ++column) {
                const auto weight =
                    static_cast<double>(inside(coord.row, row) * inside(coord.column, column));
                weights += weight;
                if (lit(coord, texel(coord, column, row), bias))
                    sum += weight;
            }
        }
        return static_cast<float>(sum / weights);
    }

    const float* picture(std::size_t view) const {
        const float* texels = pictures_[view].get();
        if (texels == nullptr) [[unlikely]] {
            render([view](std::size_t other) { return other == view; });
            texels = pictures_[view].get();
        }
        return texels;
    }

    /// Renders the pictures that are wanted and not there.
    template <class Wanted>
    void render(Wanted&& wanted) const {
        renderer_->with([&](Renderer& renderer) {
            std::vector<std::size_t> missing;
            for (std::size_t i = 0; i < views_.size(); ++i)
                if (wanted(i) && pictures_[i].get() == nullptr)
                    missing.push_back(i);
            if constexpr (BatchDepthRenderer<Renderer>) {
                if (missing.size() > 1)
                    return render_batch(renderer, missing);
            }
            for (const std::size_t view : missing) {
                auto distances = std::make_unique<float[]>(texel_count());
                renderer.render_depth(views_[view], std::span<float>(distances.get(), texel_count()));
                publish(view, std::move(distances));
            }
        });
    }

    void render_batch(Renderer& renderer, const std::vector<std::size_t>& missing) const {
        std::vector<DepthView> views;
        std::vector<std::unique_ptr<float[]>> pictures;
        std::vector<std::span<float>> distances;
        for (const std::size_t view : missing) {
            views.push_back(views_[view]);
            pictures.push_back(std::make_unique<float[]>(texel_count()));
            distances.emplace_back(pictures.back().get(), texel_count());
        }
        renderer.render_depth(std::span<const DepthView>(views),
                              std::span<const std::span<float>>(distances));
        for (std::size_t i = 0; i < missing.size(); ++i)
            publish(missing[i], std::move(pictures[i]));
    }

    void publish(std::size_t view, std::unique_ptr<float[]> distances) const {
        check(view, std::span<const float>(distances.get(), texel_count()));
        pictures_[view].publish(std::move(distances));
    }

    void check(std::size_t view, std::span<const float> distances) const {
        const auto wrong = std::ranges::find_if(distances, [](float d) { return !(d >= 0.0f); });
        if (wrong == distances.end())
            return;
        const auto texel = static_cast<std::size_t>(wrong - distances.begin());
        const auto side = static_cast<std::size_t>(resolution_);
        throw std::runtime_error("lightmesh: the DepthRenderer gave the distance " + detail::to_text(*wrong) +
                                 " at row " + std::to_string(texel / side) + ", column " +
                                 std::to_string(texel % side) + " of view " + std::to_string(view) + " of " +
                                 name_ + "; it must be 0 or greater, or +infinity where nothing is hit");
    }

    std::shared_ptr<Shared> renderer_;
    std::string name_;
    detail::ShadowMapViews views_;
    int resolution_;
    float bias_;
    std::unique_ptr<Texels[]> pictures_;
};

}  // namespace lightmesh
