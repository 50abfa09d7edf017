// SPDX-License-Identifier: MIT
#include "render/visibility.hpp"

#include <glm/vec3.hpp>

#include <functional>
#include <numeric>
#include <stdexcept>

namespace demo {

namespace {

using lightmesh::LongTest;
using lightmesh::ShortTest;

struct Entry {
    Algorithm algorithm;
    std::function<std::unique_ptr<Visibility>(const EmbreeScene&, const VisibilityOptions&)> make;
};

/// A light mesh; `short_test` if it is not for the options to choose.
auto mesh_with(LongTest long_test, std::optional<ShortTest> short_test) {
    return [=](const EmbreeScene& scene, VisibilityOptions options) {
        options.settings.short_test = short_test.value_or(options.settings.short_test);
        return make_light_mesh(scene, options, long_test);
    };
}

void add_mesh_family(std::vector<Entry>& entries, const std::string& suffix, const std::string& by,
                     LongTest long_test) {
    entries.push_back({{"lmm" + suffix, "light mesh, long tests by " + by + ", short tests by --short-test"},
                       mesh_with(long_test, std::nullopt)});
    entries.push_back({{"linked" + suffix, "light mesh, long tests by " + by + ", short tests over links"},
                       mesh_with(long_test, ShortTest::linked)});
    entries.push_back({{"express" + suffix, "light mesh, long tests by " + by + ", no short tests"},
                       mesh_with(long_test, ShortTest::none)});
}

std::vector<Entry> make_entries() {
    std::vector<Entry> entries;
    entries.push_back({{"cache", "penumbrae of lamps with sizes, by a visibility cache"}, make_cache});
    entries.push_back(
        {{"blur-cache", "a light mesh through a visibility cache: its blur without steps"}, make_blur_cache});
    entries.push_back({{"whitted", "hard shadows, one ray per light"}, make_hard_shadows});
    entries.push_back(
        {{"area", "penumbrae of lamps with sizes, --area-samples rays per light"}, make_area_shadows});
    entries.push_back({{"shadow-map", "hard shadows by shadow maps alone"}, make_shadow_maps});
    entries.push_back({{"shadow-volume", "hard shadows by shadow volumes alone"},
                       [](const EmbreeScene& scene, const VisibilityOptions&) {
                           return make_shadow_volumes(scene);
                       }});
    add_mesh_family(entries, "", "rays", LongTest::rays);
    add_mesh_family(entries, "+map", "shadow maps", LongTest::shadow_maps);
    add_mesh_family(entries, "+volume", "shadow volumes", LongTest::shadow_volumes);
    return entries;
}

const std::vector<Entry>& entries() {
    static const std::vector<Entry> made = make_entries();
    return made;
}

}  // namespace

std::vector<std::size_t> numbers_of_lights(const Scene& scene, const VisibilityOptions& options) {
    if (options.lights)
        return *options.lights;
    std::vector<std::size_t> all(scene.lights.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    return all;
}

std::vector<lightmesh::Light> shapes_of_lights(const Scene& scene,
                                               const std::optional<std::vector<std::size_t>>& numbers) {
    if (!numbers)
        return shapes_of_lights(scene);
    std::vector<lightmesh::Light> shapes;
    for (const std::size_t light : *numbers)
        shapes.push_back(light == no_light ? lightmesh::Light{lightmesh::PointLight{glm::vec3(0.0f), 0.0f}}
                                           : scene.lights.at(light).shape);
    return shapes;
}

const std::vector<Algorithm>& algorithms() {
    static const std::vector<Algorithm> all = [] {
        std::vector<Algorithm> list;
        for (const Entry& entry : entries())
            list.push_back(entry.algorithm);
        return list;
    }();
    return all;
}

bool keeps_snapshot(const std::string& algorithm) {
    return algorithm == "cache" || algorithm == "lmm" || algorithm == "linked" || algorithm == "express";
}

std::unique_ptr<Visibility> make_visibility(const std::string& algorithm, const EmbreeScene& scene,
                                            const VisibilityOptions& options) {
    std::string names;
    for (const Entry& entry : entries()) {
        if (entry.algorithm.name == algorithm)
            return entry.make(scene, options);
        names += (names.empty() ? "" : ", ") + entry.algorithm.name;
    }
    throw std::runtime_error("there is no algorithm '" + algorithm + "'; there are " + names);
}

}  // namespace demo
