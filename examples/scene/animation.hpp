// SPDX-License-Identifier: MIT
#pragma once

#include "scene.hpp"

#include <memory>
#include <string>

namespace demo {

/// The parts of a scene that may move; the rest stays as it is at 0 s.
struct Moving {
    bool objects = true;
    bool lights = true;
    bool camera = true;
};

/// The motion of a scene. Its triangles, materials, textures and lights are the same at all times, in other
/// places.
class Animation {
public:
    virtual ~Animation() = default;

    /// From 0 s to the end. Beyond it there is a pose too.
    virtual double length() const = 0;

    /// Puts what moves in the animation's own scene where it is at a time, whatever pose the scene was in:
    /// positions and normals, shapes of lights, the camera. The same to the last bit each time. Throws
    /// std::runtime_error for a file that cannot be read any more, or not in this pose.
    virtual void pose(Scene& scene, double seconds, const Moving& moving) const = 0;
};

/// A scene at 0 s, and how it moves.
struct AnimatedScene {
    Scene scene;
    std::shared_ptr<const Animation> animation;
};

/// The built-in scenes with what moves in them. `park`: a flight, a walker with a lantern, a swing; `rooms`:
/// doors that open, a lamp that swings; `spheres`: a ball that rolls.
AnimatedScene animate_park();
AnimatedScene animate_rooms();
AnimatedScene animate_spheres();

/// A glTF file with an animation of nodes, bones or morph targets: objects, lights, surfaces that shine and
/// cameras. Errors are those of `import_scene`, and std::runtime_error if there is no animation.
AnimatedScene import_animated(const std::filesystem::path& file, const ImportOptions& options = {});

/// Any of these by its name, or a file. Throws std::runtime_error for a scene that stands still.
AnimatedScene load_animated(const std::string& name_or_file, const ImportOptions& options = {});

}  // namespace demo
