// SPDX-License-Identifier: MIT
#include "scene.hpp"

namespace demo {

const std::vector<std::string>& built_in_scenes() {
    static const std::vector<std::string> names{"park", "spheres", "rooms"};
    return names;
}

Scene load_scene(const std::string& name_or_file) {
    if (name_or_file == "park") {
        return make_park();
    }
    if (name_or_file == "spheres") {
        return make_spheres();
    }
    if (name_or_file == "rooms") {
        return make_rooms();
    }
    return import_scene(name_or_file);
}

}  // namespace demo
