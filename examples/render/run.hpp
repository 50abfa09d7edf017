// SPDX-License-Identifier: MIT
#pragma once

#include "image/image.hpp"
#include "render/ranks.hpp"
#include "render/renderer.hpp"
#include "render/visibility.hpp"

#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace demo {

/// A picture and what it took.
struct Run {
    std::string algorithm;
    lightmesh::Settings settings;
    float spacing = 0.0f;      ///< g, of a visibility cache
    bool shaft_rows = true;    ///< of a visibility cache
    bool exact_edges = false;  ///< of a visibility cache
    std::string lamp_sizes;    ///< of algorithms that know sizes, for people
    Image image;
    Image toned;                  ///< by `RenderOptions::tone`, of `run_on_gpu`; else empty
    std::string device;           ///< of `run_on_gpu`; else empty
    double seconds_device = 0.0;  ///< that its shaders took
    RenderStatistics statistics;
    double seconds_preparing = 0.0;  ///< until the first ray: devices opened, triangles copied
    std::optional<lightmesh::MeshStatistics> mesh;
    std::optional<lightmesh::CacheStatistics> cache;
    std::size_t bytes = 0;            ///< of the mesh, of the cache, or of maps and volumes
    std::vector<std::byte> snapshot;  ///< of the mesh, if `VisibilityOptions::keep_snapshot`
    int ranks = 1;                    ///< whose points and rays are summed; all else is of rank 0

    double seconds() const { return seconds_preparing + statistics.seconds; }
};

/// A run of which nothing is known but what was asked for.
Run run_begun(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility);

/// Renders one picture with a progress bar, until Ctrl-C or SIGTERM.
Run run(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
        const RenderOptions& options);
/// The same by all ranks, which must call this together. The picture and all counts are on rank 0; the
/// snapshot is of what all know. Where there are several, throws `Interrupted` instead of returning a picture
/// that is not finished.
Run run(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
        const RenderOptions& options, Ranks& ranks);

/// On rank 0 the counts of `made`, a rank's part, become those of all, which must call this together.
void add_other_ranks(Run& made, Ranks& ranks);

/// The cost of a run, line by line.
std::string report(const Run& run, const EmbreeScene& scene);

/// Makes the folder if it is not there. Throws std::runtime_error that names it if no file can be written
/// into it.
void prepare_folder(const std::filesystem::path& folder);

/// As `prepare_folder` for the folder of a file. Throws std::runtime_error that names the file if there is
/// something else than a file in its place.
void prepare_file(const std::filesystem::path& file);
/// The same for a picture, whose name must end in .png or .exr.
void prepare_picture(const std::filesystem::path& file);

}  // namespace demo
