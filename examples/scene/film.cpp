// SPDX-License-Identifier: MIT
#include "film.hpp"

#include <utility>

namespace demo {

Film::Film(AnimatedScene animated, const Moving& moving)
    : animation_(std::move(animated.animation)), moving_(moving) {
    std::vector<Texture> textures = std::exchange(animated.scene.textures, {});
    before_ = animated.scene;
    scene_ = std::make_unique<Scene>(std::move(animated.scene));
    scene_->textures = std::move(textures);
}

SceneChange Film::go_to(double seconds) {
    before_.positions = scene_->positions;
    before_.lights = scene_->lights;
    before_.camera = scene_->camera;
    animation_->pose(*scene_, seconds, moving_);
    return difference(before_, *scene_);
}

}  // namespace demo
