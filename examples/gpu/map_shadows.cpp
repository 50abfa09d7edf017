// SPDX-License-Identifier: MIT
#include "gpu/map_shadows.hpp"

#include "render/depth_renderers.hpp"

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <utility>

namespace demo {

namespace {

constexpr std::uint32_t map_shadows_words[] = {
#include "spirv/map_shadows.comp.inc"
};

constexpr std::size_t most_views = 7;
/// Of `lightmesh::ShadowMapSettings`.
constexpr float bias = lightmesh::ShadowMapSettings{}.bias;

}  // namespace

/// As map_shadows.comp has it.
struct MapWords {
    struct View {
        glm::vec4 eye, forward, right, down;
    };
    std::uint32_t light;
    std::int32_t resolution;
    std::int32_t first_face;
    std::uint32_t there;
    float bias;
    std::array<float, 3> unused;
    std::array<View, most_views> views;
};

namespace {

MapWords words_of(std::span<const lightmesh::DepthView> views, std::size_t light) {
    MapWords words{};
    words.light = static_cast<std::uint32_t>(light);
    words.resolution = views.front().resolution;
    words.first_face = views.size() == most_views ? 1 : 0;
    words.bias = bias;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const lightmesh::DepthView& view = views[i];
        const float half = (std::max)(glm::length(view.right), glm::length(view.down));
        words.views[i] = {{view.eye, 2.0f * half / static_cast<float>(view.resolution)},
                          {view.forward, view.orthographic ? 1.0f : 0.0f},
                          {view.right, 0.0f},
                          {view.down, 0.0f}};
    }
    return words;
}

}  // namespace

/// A shadow map by some renderer.
class LightMap {
public:
    virtual ~LightMap() = default;
    virtual std::span<const lightmesh::DepthView> views() const = 0;
    virtual std::span<const float> distances(std::size_t view) const = 0;
    virtual std::size_t bytes() const = 0;
};

template <class Map>
class LightMapBy final : public LightMap {
public:
    explicit LightMapBy(std::unique_ptr<Map> map) : map_(std::move(map)) {}
    std::span<const lightmesh::DepthView> views() const override { return map_->views(); }
    std::span<const float> distances(std::size_t view) const override { return map_->distances(view); }
    std::size_t bytes() const override { return map_->bytes(); }

private:
    std::unique_ptr<Map> map_;
};

using MakeMap = std::function<std::unique_ptr<LightMap>(std::size_t light)>;

namespace {

/// Of the triangles as they are.
MakeMap make_maps(const EmbreeScene& scene, const VisibilityOptions& options) {
    return with_depth_renderer(scene, options, [&](auto renderer) -> MakeMap {
        return [make = maps_by(std::move(renderer), scene, options)](std::size_t light) {
            auto map = make(light);
            return std::make_unique<LightMapBy<typename decltype(map)::element_type>>(std::move(map));
        };
    });
}

}  // namespace

struct MapShadows::Parts {
    /// A light's map on the device. Kernels of all lights are one program, which the device keeps.
    struct OnDevice {
        std::unique_ptr<LightMap> map;
        MapWords words;
        ComputeBuffer header;
        ComputeKernel kernel;
    };

    /// The maps of all lights, of the triangles as they were when it was made.
    struct Maps {
        Maps(const Parts& parts, const EmbreeScene& scene)
            : answers(parts.device, parts.pixels * scene.scene().lights.size() * sizeof(float)),
              needed(parts.device, scene.scene().lights.size() * sizeof(std::uint32_t)),
              make(make_maps(scene, parts.options)) {
            for (std::size_t light = 0; light < scene.scene().lights.size(); ++light)
                lights.push_back(made(parts, light));
        }

        OnDevice made(const Parts& parts, std::size_t light) const {
            std::unique_ptr<LightMap> map = make(light);
            const MapWords words = words_of(map->views(), light);
            ComputeBuffer header(parts.device, std::as_bytes(std::span(&words, 1)));
            std::vector<ComputeBinding> bindings = parts.bindings_of_pixels;
            std::uint32_t binding = 0;
            for (const ComputeBuffer& buffer : {header, answers, needed})
                bindings.push_back({set, binding++, buffer});
            const ComputeBuffer nothing(parts.device, std::size_t{16});
            for (std::size_t view = 0; view < most_views; ++view)
                bindings.push_back({set, binding++, nothing});
            return {std::move(map), words, header,
                    ComputeKernel(parts.device, map_shadows_words, bindings, bytes_of_batch)};
        }

        ComputeBuffer answers, needed;
        MakeMap make;
        std::vector<OnDevice> lights;
    };

    Parts(const ComputeDevice& on, const EmbreeScene& scene, const VisibilityOptions& with, std::size_t count,
          const std::vector<ComputeBinding>& of_pixels)
        : device(on), options(with), pixels(count), bindings_of_pixels(of_pixels), rows(rows_of(on, count)),
          maps(*this, scene) {}

    /// Each pixel has its own.
    static ComputeBuffer rows_of(const ComputeDevice& device, std::size_t count) {
        std::vector<std::uint32_t> rows(count);
        std::iota(rows.begin(), rows.end(), 1u);
        return {device, std::as_bytes(std::span(rows))};
    }

    /// Renders pictures, a bit for each view, and copies them to the device.
    static void load(const ComputeDevice& device, OnDevice& light, std::uint32_t views) {
        for (std::uint32_t view = 0; view < most_views; ++view)
            if ((views >> view & 1) != 0)
                light.kernel.bind(
                    {set, 3 + view, ComputeBuffer(device, std::as_bytes(light.map->distances(view)))});
        light.words.there |= views;
        light.header.write(0, std::as_bytes(std::span(&light.words, 1)));
    }

    static constexpr std::size_t bytes_of_batch = 16;

    ComputeDevice device;
    VisibilityOptions options;
    std::size_t pixels;
    std::vector<ComputeBinding> bindings_of_pixels;
    ComputeBuffer rows;
    Maps maps;
    DeviceFill spent;
};

MapShadows::MapShadows(const ComputeDevice& device, const EmbreeScene& scene,
                       const VisibilityOptions& options, std::size_t pixels,
                       const std::vector<ComputeBinding>& bindings)
    : parts_(std::make_unique<Parts>(device, scene, options, pixels, bindings)) {}

MapShadows::~MapShadows() = default;

void MapShadows::update(const EmbreeScene& scene, const SceneChange& change) {
    Parts::Maps& maps = parts_->maps;
    if (change.changes_triangles() || scene.scene().lights.size() != maps.lights.size()) {
        maps = Parts::Maps(*parts_, scene);
        return;
    }
    std::vector<Parts::OnDevice> changed;
    for (const std::size_t light : change.lights)
        changed.push_back(maps.made(*parts_, light));
    for (std::size_t i = 0; i < changed.size(); ++i)
        maps.lights[change.lights[i]] = std::move(changed[i]);
}

void MapShadows::shade(Round& round, const std::atomic<bool>* cancel) {
    const ComputeDevice& device = parts_->device;
    Parts::Maps& maps = parts_->maps;
    std::vector<std::size_t> asked(maps.lights.size());
    std::iota(asked.begin(), asked.end(), std::size_t{0});
    while (!asked.empty()) {
        check_cancelled(cancel);
        parts_->spent.seconds_device += device.run([&](const ComputeCommands& commands) {
            commands.fill(maps.needed, 0, maps.needed.size(), 0);
            for (const std::size_t light : asked)
                commands.dispatch(maps.lights[light].kernel, round.groups(), 1, 1, round.push());
        });
        parts_->spent.dispatches += asked.size();
        const auto needed = maps.needed.read_all<std::uint32_t>();
        std::erase_if(asked, [&](std::size_t light) { return needed[light] == 0; });
        for (const std::size_t light : asked) {
            check_cancelled(cancel);
            Parts::load(device, maps.lights[light], needed[light]);
        }
    }
    for (const ComputeBinding& binding : bindings())
        round.kernel().bind(binding);
    round.shade();
}

std::vector<ComputeBinding> MapShadows::bindings() const {
    return {{set, 0, parts_->rows}, {set, 1, parts_->maps.answers}};
}

DeviceFill MapShadows::spent() const {
    return parts_->spent;
}

std::size_t MapShadows::bytes() const {
    std::size_t sum = 0;
    for (const Parts::OnDevice& light : parts_->maps.lights)
        sum += light.map->bytes();
    return sum;
}

}  // namespace demo
