// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "render/embree_scene.hpp"
#include "shading_points.hpp"

#include <lightmesh/surface_point.hpp>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

/// What benchmarks of shaders have in common.

namespace bench {

/// The main function of NAME [--device DEVICE] [--gpu-rays queries|bvh]. `run` returns whether all is right.
int run_on_device(const char* name, int argc, char** argv,
                  const std::function<bool(const demo::ComputeDevice&)>& run);

/// The device; and if it traces rays by ray queries the same one, opened to trace them through a BVH.
std::vector<demo::ComputeDevice> by_each_traversal(const demo::ComputeDevice& device);
/// "by ray queries", or "through a BVH".
std::string traversal_of(const demo::ComputeDevice& device);

/// All points, tile by tile.
std::vector<lightmesh::SurfacePoint> surface_points(const ShadingPoints& points);

/// Values that are not the CPU's, rays that are not Embree's, or pixels that are more than a step off.
struct Differing {
    std::size_t count = 0;
    std::size_t all = 0;
};

/// Of what Embree and shaders may see otherwise, at the edges of triangles.
inline constexpr double most_differing = 0.001;
/// True if no greater share differs.
bool are_nearly_all_same(const Differing& differing);

/// Lights that points face, the times it takes shaders to trace rays to them, and Embree's opinion of those.
struct HardShadows {
    std::size_t pairs = 0;      ///< of points and lights that they face
    std::size_t traced = 0;     ///< of these
    std::size_t differing = 0;  ///< of those that were traced, from Embree's
    double seconds = 0.0;       ///< of the device, for those that were traced
    std::string traversal{};    ///< as `traversal_of`

    double rays_a_second() const { return static_cast<double>(traced) / seconds; }
    Differing error() const { return {differing, traced}; }
};
HardShadows hard_shadows(const demo::ComputeDevice& device, const demo::EmbreeScene& scene,
                         const ShadingPoints& points);
/// The same by each traversal, the fastest one first.
std::vector<HardShadows> hard_shadows_by_each_traversal(const demo::ComputeDevice& device,
                                                        const demo::EmbreeScene& scene,
                                                        const ShadingPoints& points);
/// True if the rays of each are Embree's, but for few.
bool are_embrees(std::span<const HardShadows> shadows);

/// The rate of a plain BVH2 on an H100, measured before this project's own traversal was.
inline constexpr double rays_a_second_of_bvh2 = 3.4e9;

/// Rows under the names that figures to reach have, with the error of what was measured: on a CPU that plays
/// a GPU their times decide nothing.
namespace targets {

/// Begins a table. On a CPU that plays a GPU it says that times mean nothing.
void begin(const demo::ComputeDevice& device);
/// Prints a row: values of shaders are the CPU's.
void none_differ(const std::string& what, const Differing& differing);
/// The same of all but a share.
void few_differ(const std::string& what, const Differing& differing, double most);
/// Prints a row. `reach` 0: there is nothing to reach, the figure is reported.
void at_most(const std::string& what, const Differing& differing, double reach, double got, int digits);
void at_least(const std::string& what, const Differing& differing, double reach, double got, int digits);
/// Two rows of what took so many seconds for all the pairs; `reach` is that of the first.
void times_faster_than_hard(const std::string& what, const Differing& differing, double reach,
                            const HardShadows& hard, double seconds);
/// A row of the rays themselves.
void traversal(const std::string& scene, const HardShadows& hard);
/// "park, 64 lights, 2.6 M points: ".
std::string of_points(const std::string& scene, std::size_t lights, std::size_t points);

}  // namespace targets

/// S of all lights of a mesh or a cache, on all threads.
template <class Subject>
std::vector<float> ask_on_cpu(const Subject& subject, std::span<const lightmesh::SurfacePoint> points) {
    constexpr std::size_t block = 1024;
    const std::size_t lights = subject.light_count();
    std::vector<float> all(points.size() * lights);
    tbb::parallel_for(std::size_t{0}, (points.size() + block - 1) / block, [&](std::size_t b) {
        const std::size_t first = b * block;
        const std::size_t size = (std::min)(block, points.size() - first);
        subject.visibility(points.subspan(first, size),
                           std::span(all).subspan(first * lights, size * lights));
    });
    return all;
}

inline bool same_bits(float a, float b) {
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

}  // namespace bench
