// SPDX-License-Identifier: MIT
#pragma once

#include "animation.hpp"
#include "scene_change.hpp"

#include <memory>

namespace demo {

/// A scene that is posed from time to time, with what each pose changes.
class Film {
public:
    /// At 0 s.
    explicit Film(AnimatedScene animated, const Moving& moving = {});

    /// In the pose of the last `go_to`; in one place as long as the film is there, also if that is moved.
    const Scene& scene() const { return *scene_; }
    /// Of the animation, in seconds.
    double length() const { return animation_->length(); }
    const Moving& moving() const { return moving_; }

    /// Poses the scene, and returns what differs from its last pose. The pose does not depend on the last
    /// one. Throws what `Animation::pose` throws, and leaves the last pose then.
    SceneChange go_to(double seconds);

private:
    std::unique_ptr<Scene> scene_;
    Scene before_;  ///< the last pose, without textures
    std::shared_ptr<const Animation> animation_;
    Moving moving_;
};

}  // namespace demo
