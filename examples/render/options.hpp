// SPDX-License-Identifier: MIT
#pragma once

#include "render/open_scene.hpp"
#include "render/renderer.hpp"
#include "render/visibility.hpp"
#include "scene/scene.hpp"

#include <CLI/CLI.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace demo {

/// CLI11's own lets NaN pass.
extern const CLI::Validator finite_positive;

/// CLI11's own range lets NaN pass.
CLI::Validator finite_range(float low, float high);

/// Opens a scene, with its remarks on the screen.
Scene show_scene(const SceneOptions& options);

/// Options of all commands of `lightmesh-render`.
struct CommonOptions : SceneOptions {
    std::optional<float> radius;   ///< else the scene's own
    std::optional<float> quality;  ///< else the scene's own
    std::string short_test = "exact";
    std::string depth = "vulkan";
    RenderOptions render;
    VisibilityOptions visibility;
};

/// The options about pictures and machines.
void add_render_options(CLI::App& command, CommonOptions& options);
/// The options of what renders.
void add_on_options(CLI::App& command, std::string& on, VisibilityOptions& visibility);
/// Throws std::invalid_argument for some that do not go together.
void check_on_options(const std::string& on, const VisibilityOptions& visibility);
/// The curve of PNG files.
void add_tone_option(CLI::App& command, CommonOptions& options);
/// The options about the scene itself: file, view, lights, exposure.
void add_file_options(CLI::App& command, SceneOptions& options);
/// The options about scenes and algorithms.
void add_scene_options(CLI::App& command, CommonOptions& options);
/// The names of all algorithms.
std::vector<std::string> algorithm_names();

/// Throws std::invalid_argument for a radius that dwarfs the scene: floats would not hold the grid.
void check_radius(float radius, const Scene& scene);

/// The options with what they leave to the scene.
VisibilityOptions visibility_options(const CommonOptions& options, const Scene& scene);

}  // namespace demo
