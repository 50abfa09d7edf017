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
    std::string picture;           ///< a PNG file's bytes
    std::string difference;        ///< the same, to the reference: amplified and negated
    double mean_difference = 0.0;  ///< mean absolute, linear values
};

/// Pictures by candidates, and the one that they are compared with.
struct PictureStrip {
    std::string reference_name;  ///< for people
    std::string reference;       ///< a PNG file's bytes
    std::vector<CandidatePicture> pictures;
    std::size_t candidates = 0;  ///< how many there are, with and without picture
};

/// The pictures of a report, all of the same view.
struct ReportPictures {
    int width = 0;
    int height = 0;
    float amplification = 0.0f;  ///< of differences
    /// What is recommended of caches and of each radius, beside lamps of many rays; empty if there is but
    /// one.
    PictureStrip kinds;
    PictureStrip meshes;  ///< frontier of the middle radius, the fastest first, beside an exact mesh
    PictureStrip caches;  ///< frontier of caches, the fastest first, beside the same lamps
};

/// Renders them with a progress bar each, and keeps them as PNG files in the folder. Throws
/// std::runtime_error if Ctrl-C was pressed.
ReportPictures render_pictures(const EmbreeScene& scene, const TuneOptions& options, const Report& report,
                               const std::filesystem::path& folder);

}  // namespace demo
