// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <glm/vec3.hpp>

#include <cstddef>
#include <filesystem>

namespace demo {

/// The parts that all poses of a file share, as its first one has it.
struct FilmOfFile {
    glm::dvec3 origin{0.0};
    glm::vec3 centre{0.0f};  ///< where cameras look
    std::size_t lamps = 0;   ///< lights that the file has as such, the first ones of the scene
    double length = 0.0;     ///< of the animation; 0: no pose has been imported
};

/// As `import_scene`, at `options.time`, with all triangles, also those that have no area in this pose. The
/// first call fills `film`; later ones take it, and give places only: no textures, no lamps of surfaces that
/// shine.
Scene import_pose(const std::filesystem::path& file, const ImportOptions& options, FilmOfFile& film);

}  // namespace demo
