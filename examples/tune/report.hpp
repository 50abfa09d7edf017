// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "tune/options.hpp"
#include "tune/sampling.hpp"
#include "tune/tuning.hpp"

#include <lightmesh/tune.hpp>

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace demo {

/// All that a report says, but its pictures.
struct Report {
    std::string scene;
    std::size_t triangle_count = 0;
    std::size_t light_count = 0;
    /// All that measurements depend on: they can only be taken up again where all of it is equal.
    std::vector<std::pair<std::string, std::string>> context;
    int threads = 1;  ///< that a frame is shared among
    lightmesh::tune::Wishes wishes;
    Tuning tuning;
    lightmesh::tune::Recommendation recommended;  ///< a mesh of the middle radius, or a cache
    /// Of each radius its mesh, in their order; and the cache.
    std::vector<lightmesh::tune::Recommendation> by_radius;
    std::vector<std::size_t> frontier;  ///< of all radii and of caches: indices of the measurements
};

/// Scene, samples and machine.
std::vector<std::pair<std::string, std::string>>
describe_context(const EmbreeScene& scene, const ShadingPoints& samples, const TuneOptions& options);

/// Adds recommendations and frontier.
void judge(Report& report);

/// The radii of the measurements, in their order; 0 for caches.
std::vector<float> radii_of(const Report& report);

/// For scripts. Numbers that are not finite become null.
std::string to_json(const Report& report);

/// The measurements of an earlier report in the folder. Throws std::runtime_error that names the file and
/// what is wrong with it: not there, no report, or of another scene, machine or number of points.
std::vector<lightmesh::tune::Measurement> measurements_from_json(const std::filesystem::path& file,
                                                                 const Report& current);

}  // namespace demo
