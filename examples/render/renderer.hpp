// SPDX-License-Identifier: MIT
#pragma once

#include "image/image.hpp"
#include "render/embree_scene.hpp"
#include "render/visibility.hpp"

#include <glm/vec4.hpp>

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace demo {

/// Pictures are rendered by tiles of so many pixels a side, or what is left of these at the right and below.
inline constexpr int tile_size = 16;

struct RenderOptions {
    int width = 960;
    int height = 720;
    int samples = 1;           ///< per pixel, stratified, in [1, 1024]; 1: through its middle
    int depth_limit = 5;       ///< mirrored and refracted rays after each other, in [0, 100]
    int threads = 0;           ///< 0: all cores
    Tone tone = Tone::linear;  ///< for who writes the picture: `render` gives linear values
    /// Rays at each point to find the share of the ambient light that arrives, in [0, 1024]; 0: all of it
    /// does.
    int ambient_rays = 0;
    float ambient_distance = std::numeric_limits<float>::infinity();  ///< beyond which nothing hides it
    /// True if the background is left out where it is seen directly, not in mirrors and glass.
    bool transparent_background = false;
    std::vector<int> tiles{};  ///< numbers of those to render, row by row from 0; empty: all
};

struct RenderStatistics {
    std::uint64_t primary_rays = 0;
    std::uint64_t secondary_rays = 0;  ///< mirrored and refracted
    std::uint64_t shading_points = 0;
    VisibilityCost visibility;
    double seconds = 0.0;          ///< from start to end
    double seconds_tracing = 0.0;  ///< in primary and secondary rays, summed over threads
    double seconds_shading = 0.0;  ///< in materials, summed over threads
    bool finished = true;          ///< false if cancelled: the picture has black tiles

    RenderStatistics& operator+=(const RenderStatistics& tile);
};

/// A finished part of a picture: linear RGB, and the share that is not seen background; row-major, row 0 on
/// top.
struct TilePixels {
    int left;
    int top;
    int width;
    int height;
    std::span<const glm::vec4> pixels;
};

/// Takes parts of a picture as they are finished, from any thread but one at a time.
using TileSink = std::function<void(const TilePixels& tile)>;

/// Called now and then while rendering, from any thread but by one at a time: the share that is done, 0..1.
using Progress = std::function<void(double done)>;

/// Whitted's ray tracer, equation (1): recursion by k_s and k_t, Lambert and Blinn-Phong for Omega,
/// visibility from elsewhere. The picture is the same to the last bit for any number of threads. `cancel` may
/// be set by a signal handler. Throws std::invalid_argument for options out of range.
Image render(const EmbreeScene& scene, const Visibility& visibility, const RenderOptions& options,
             RenderStatistics& statistics, const Progress& progress = {},
             const std::atomic<bool>* cancel = nullptr);

/// The same, with alpha, part by part.
void render(const EmbreeScene& scene, const Visibility& visibility, const RenderOptions& options,
            RenderStatistics& statistics, const TileSink& sink, const Progress& progress = {},
            const std::atomic<bool>* cancel = nullptr);

}  // namespace demo
