// SPDX-License-Identifier: MIT
#include "animation.hpp"
#include "scene.hpp"

#include <stdexcept>

namespace demo {

const std::vector<std::string>& built_in_scenes() {
    static const std::vector<std::string> names{"park", "spheres", "rooms", "street"};
    return names;
}

Scene load_scene(const std::string& name_or_file, const ImportOptions& options) {
    if (name_or_file == "park") {
        return make_park();
    }
    if (name_or_file == "spheres") {
        return make_spheres();
    }
    if (name_or_file == "rooms") {
        return make_rooms();
    }
    if (name_or_file == "street") {
        return make_street();
    }
    return import_scene(name_or_file, options);
}

AnimatedScene load_animated(const std::string& name_or_file, const ImportOptions& options) {
    if (name_or_file == "park")
        return animate_park();
    if (name_or_file == "rooms")
        return animate_rooms();
    if (name_or_file == "spheres")
        return animate_spheres();
    if (name_or_file == "street")
        throw std::runtime_error("street stands still; there are films of park, rooms and spheres, and of "
                                 "glTF files with an animation");
    return import_animated(name_or_file, options);
}

}  // namespace demo
