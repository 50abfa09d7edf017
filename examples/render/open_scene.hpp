// SPDX-License-Identifier: MIT
#pragma once

#include "scene/animation.hpp"
#include "scene/film.hpp"
#include "scene/scene.hpp"

#include <glm/vec3.hpp>

#include <cstddef>
#include <optional>
#include <string>

namespace demo {

/// Options of the command line for a scene.
struct SceneOptions {
    std::string scene;       ///< a built-in scene's name, or a file
    std::size_t lights = 0;  ///< so many spread over it; 0: its own
    ImportOptions import;
    std::optional<glm::vec3> eye;     ///< in the file's coordinates, as the next
    std::optional<glm::vec3> target;  ///< otherwise the middle of the scene
    std::optional<glm::vec3> up;
    std::optional<float> field_of_view;  ///< vertical, in degrees
    /// Factor of the picture's values as a power of two; empty: by what the camera sees, for files.
    std::optional<float> exposure;
};

/// Loads a scene and gives a file what it does not have: a view from inside, if it is a building without
/// camera, lights where that looks, a radius that suits the view, an exposure. Remarks say so.
Scene open_scene(const SceneOptions& options);

/// The same of a scene that moves: all is chosen by what it is at 0 s. A view that the options ask for stays
/// as it is, and so do lights that they spread. Throws std::invalid_argument if they name a time.
Film open_film(const SceneOptions& options, Moving moving = {});

}  // namespace demo
