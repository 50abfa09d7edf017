// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <string>

namespace demo {

/// An OBJ file's text, checked and with its vertices near the origin.
struct ObjText {
    std::string text;
    glm::dvec3 origin;  ///< was subtracted from all vertices: Assimp keeps them as floats
};

/// Looks at faces and vertices before Assimp does, which trusts them. Throws std::runtime_error that names
/// the line: faces of fewer than three corners, or of vertices that are not there.
ObjText prepare_obj(std::string text);

}  // namespace demo
