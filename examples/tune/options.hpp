// SPDX-License-Identifier: MIT
#pragma once

#include "render/open_scene.hpp"
#include "render/renderer.hpp"
#include "render/visibility.hpp"

#include <lightmesh/tune.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace demo {

/// Options of the command line of `lightmesh-tune`.
struct TuneOptions : SceneOptions {
    // Empty: chosen by the program.
    std::vector<float> radii;
    std::vector<float> qualities;
    std::vector<std::string> short_tests;
    std::vector<std::string> long_tests;
    std::vector<int> map_sizes;
    std::vector<float> spacings;
    std::vector<int> details;
    std::vector<int> lamp_rays;
    std::vector<std::string> shaft_rows;  ///< "on", "off"
    bool caches = true;                   ///< whether caches are tried, and not light meshes alone

    lightmesh::tune::Wishes wishes;
    std::size_t points = 4096;
    std::size_t reference_points = 128;
    double lamp_angle = 0.3;  ///< radians: see `lightmesh::tune::suggest_radii`
    int picture_width = 320;  ///< of the report's pictures; 0: none
    std::string output;       ///< empty: tune-SCENE
    bool resume = false;
    RenderOptions render;          ///< the frame; threads are those of the frame and of the reference
    VisibilityOptions visibility;  ///< what renders shadow maps
};

/// Adds everything to the program. What does not fit becomes a CLI::ValidationError.
void add_tune_options(CLI::App& program, TuneOptions& options);

/// "200" and "200ns" limit the nanoseconds per point, "0.5s" and "500ms" the seconds per frame. Throws
/// std::invalid_argument that shows the text if it is neither.
void read_budget(const std::string& text, lightmesh::tune::Wishes& wishes);

/// "0.01" or "1%". Throws std::invalid_argument that shows the text if it is no share in [0, 1].
double read_share(const std::string& text);

/// The candidates to try: what the options ask for, and where they are silent, all that is worth a try.
/// Shadow maps that nobody asked for are only tried with `middle_radius` and linked short tests. Caches
/// follow, by default with spacings of a half and a quarter of `middle_radius`, with and without shaft rows.
std::vector<lightmesh::tune::Candidate>
choose_candidates(const TuneOptions& options, const std::vector<float>& radii, float middle_radius);

}  // namespace demo
