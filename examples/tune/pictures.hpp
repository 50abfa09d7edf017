// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "tune/report.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace demo {

/// A picture by a candidate.
struct CandidatePicture {
    lightmesh::tune::Measurement measurement;
    std::string picture;     ///< a PNG file's bytes
    std::string difference;  ///< the same: amplified and negated; empty if there is nothing to compare with
    double mean_difference = 0.0;  ///< mean absolute, linear values
};

/// The pictures of a report, all of the same view.
struct ReportPictures {
    int width = 0;
    int height = 0;
    float amplification = 0.0f;              ///< of differences
    CandidatePicture reference;              ///< exact, with as high a quality as pictures can wait for
    std::vector<CandidatePicture> frontier;  ///< of the middle radius, the fastest first
    std::size_t frontier_size = 0;           ///< how many there are, with and without picture
    std::vector<CandidatePicture> radii;     ///< what is recommended of each radius and of caches, if several
};

/// Renders them with a progress bar each, and keeps them as PNG files in the folder. Throws
/// std::runtime_error if Ctrl-C was pressed.
ReportPictures render_pictures(const EmbreeScene& scene, const TuneOptions& options, const Report& report,
                               const std::filesystem::path& folder);

}  // namespace demo
