// SPDX-License-Identifier: MIT
#include "gpu/gpu_scene.hpp"

#include "gpu/scene_words.hpp"
#include "gpu/wide_bvh.hpp"
#include "render/lamps.hpp"
#include "render/view.hpp"
#include "scene/surface.hpp"

#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>
#include <variant>

namespace demo {

namespace {

/// As scene.glsl has it.
struct FrameWords {
    glm::vec4 eye;
    glm::vec4 forward;
    glm::vec4 middle;
    glm::vec4 right;
    glm::vec4 up;
    glm::vec4 ambient;
    glm::vec4 background;
    glm::uvec4 picture;
    glm::uvec4 tables_at;
    glm::uvec4 numbers;
    glm::uvec4 attributes;
    glm::vec4 output_curve;
};
static_assert(sizeof(FrameWords) == 12 * 16, "glm's vectors must be packed");

FrameWords frame_of(const EmbreeScene& scene, const SceneWords& words, const VisibilityOptions& visibility,
                    const RenderOptions& options) {
    const Scene& model = scene.scene();
    const Camera& camera = model.camera;
    const View view(camera, options.width, options.height);
    const View::Axes axes = view.axes();
    const auto number = [](auto value) {
        return static_cast<std::uint32_t>(value);
    };
    const auto rays = static_cast<float>(visibility.area_samples);
    FrameWords frame{};
    frame.eye = {axes.eye, axes.is_orthographic ? 1.0f : 0.0f};
    frame.forward = {axes.forward, view.pixel_width()};
    frame.middle = {axes.middle, view.pixel_angle()};
    frame.right = {axes.right, camera.z_near};
    frame.up = {axes.up, (std::min)(camera.z_far - camera.z_near, 1e30f)};
    frame.ambient = {model.ambient, scene.offset()};
    frame.background = {model.background, scene.far_away()};
    frame.picture = {number(options.width), number(options.height), number(options.samples),
                     number(options.depth_limit)};
    frame.tables_at = words.tables_at;
    frame.numbers = {number(model.lights.size()), words.words_of_vertex, number(visibility.area_samples),
                     number(std::sqrt(rays))};
    frame.attributes = words.attributes;
    frame.output_curve = {model.exposure, options.tone == Tone::filmic ? 1.0f : 0.0f, 0.0f, 0.0f};
    return frame;
}

template <class T>
std::span<const std::byte> bytes_in(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

/// Writes the pieces of `now` that differ from `there` to a buffer, from a place in it on. Returns how many
/// bytes they are.
std::size_t write_differences(const ComputeBuffer& buffer, std::size_t offset,
                              std::span<const std::byte> there, std::span<const std::byte> now) {
    constexpr std::size_t piece = std::size_t{1} << 16;
    std::vector<ComputeWrite> writes;
    std::size_t written = 0;
    std::size_t first = 0;  // that is to be written
    const auto write_until = [&](std::size_t end) {
        if (end > first)
            writes.push_back({offset + first, now.subspan(first, end - first)});
        written += end - first;
    };
    for (std::size_t at = 0; at < now.size(); at += piece) {
        const std::size_t size = (std::min)(piece, now.size() - at);
        if (std::memcmp(there.data() + at, now.data() + at, size) != 0)
            continue;
        write_until(at);
        first = at + size;
    }
    write_until(now.size());
    buffer.write(writes);
    return written;
}

std::vector<float> sizes_of(const EmbreeScene& scene, const VisibilityOptions& visibility) {
    return sizes_at_ends(lamps_of(scene, visibility), scene.far_away());
}

/// Numbers of bindings.
enum Place : std::size_t { frame_place, nodes, triangles, corners, vertices, tables, texels };

/// A scene's triangles in the order of ray_queries.glsl.
class QueriedTriangles {
public:
    explicit QueriedTriangles(const Scene& scene) {
        std::vector<std::uint32_t> of_others;
        numbers_.push_back(0);
        for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
            const Triangle& triangle = scene.triangles[i];
            const bool is_opaque = !may_let_light_through(scene.materials[triangle.material]);
            (is_opaque ? numbers_ : of_others).push_back(i);
            std::vector<std::uint32_t>& vertices_of_kind = is_opaque ? opaque_ : others_;
            vertices_of_kind.insert(vertices_of_kind.end(), std::begin(triangle.vertex),
                                    std::end(triangle.vertex));
        }
        numbers_[0] = static_cast<std::uint32_t>(numbers_.size() - 1);
        numbers_.insert(numbers_.end(), of_others.begin(), of_others.end());
    }

    ComputeTriangles on(const ComputeDevice& device, const ComputeBuffer& vertex_words,
                        std::size_t bytes_of_vertex) const {
        return {device, vertex_words, bytes_of_vertex, opaque_, others_};
    }

    /// How many are opaque, the scene's numbers of these, and of the others.
    const std::vector<std::uint32_t>& numbers() const { return numbers_; }

private:
    std::vector<std::uint32_t> numbers_;
    std::vector<std::uint32_t> opaque_;  ///< three vertices each
    std::vector<std::uint32_t> others_;
};

}  // namespace

/// All that the device has, but for textures.
struct GpuScene::Copy {
    VisibilityOptions visibility;
    RenderOptions options;
    SceneWords words;
    std::variant<WideBvh, ComputeTriangles> for_rays;  ///< through a BVH, or by ray queries
};

GpuScene::GpuScene(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& visibility,
                   const RenderOptions& options)
    : copy_(std::make_unique<Copy>(
          Copy{visibility, options, words_of(scene.scene(), sizes_of(scene, visibility)), {}})) {
    SceneWords& words = copy_->words;
    const FrameWords frame = frame_of(scene, words, visibility, options);
    const ComputeBuffer vertex_words(device, bytes_in(words.vertices));
    const auto add = [&](std::variant<ComputeBuffer, ComputeTriangles> resource) {
        const auto place = static_cast<std::uint32_t>(bindings_.size());
        bindings_.push_back(
            {.set = 0, .binding = place, .resource = std::move(resource), .is_uniform = place == 0});
    };
    add(ComputeBuffer(device, std::as_bytes(std::span(&frame, 1))));
    if (device.has_ray_queries()) {
        require_no_instances(scene.scene(), "a GPU");
        const QueriedTriangles queried(scene.scene());
        const ComputeTriangles triangles_there =
            queried.on(device, vertex_words, words.words_of_vertex * sizeof(float));
        copy_->for_rays = triangles_there;
        add(triangles_there);
        add(ComputeBuffer(device, bytes_in(queried.numbers())));
    } else {
        const WideBvh& bvh = copy_->for_rays.emplace<WideBvh>(build_wide_bvh(scene.scene()));
        add(ComputeBuffer(device, bytes_in(bvh.nodes)));
        add(ComputeBuffer(device, bytes_in(bvh.triangles)));
    }
    add(ComputeBuffer(device, bytes_in(words.corners)));
    add(vertex_words);
    add(ComputeBuffer(device, bytes_in(words.tables)));
    add(ComputeBuffer(device, bytes_in(words.texels)));
    words.texels = {};
}

GpuScene::~GpuScene() = default;

std::size_t GpuScene::update(const EmbreeScene& scene, const SceneChange& change) {
    Copy& copy = *copy_;
    const auto write = [&](Place place, std::size_t offset, std::span<const std::byte> there,
                           std::span<const std::byte> now) {
        return write_differences(bindings_[place].buffer(), offset, there, now);
    };
    std::size_t written = 0;
    const std::vector<glm::uvec4> lights = lights_of(scene.scene(), sizes_of(scene, copy.visibility));
    const std::size_t lights_at = copy.words.tables_at[1];
    const auto of_lights = std::span(copy.words.tables).subspan(lights_at, lights.size());
    written += write(tables, lights_at * sizeof(glm::uvec4), std::as_bytes(of_lights), bytes_in(lights));
    std::ranges::copy(lights, of_lights.begin());
    // Normals may turn where no corner moves.
    std::vector<float> moved = vertices_of(scene.scene());
    written += write(vertices, 0, bytes_in(copy.words.vertices), bytes_in(moved));
    copy.words.vertices = std::move(moved);
    if (change.changes_triangles()) {
        if (const auto* for_queries = std::get_if<ComputeTriangles>(&copy.for_rays)) {
            for_queries->rebuild();
        } else {
            auto& bvh = std::get<WideBvh>(copy.for_rays);
            const WideBvh before = bvh;
            fit(bvh, scene.scene());
            written += write(nodes, 0, bytes_in(before.nodes), bytes_in(bvh.nodes));
            written += write(triangles, 0, bytes_in(before.triangles), bytes_in(bvh.triangles));
        }
    }
    const FrameWords frame = frame_of(scene, copy.words, copy.visibility, copy.options);
    bindings_[frame_place].buffer().write(0, std::as_bytes(std::span(&frame, 1)));
    return written + sizeof frame;
}

std::vector<ComputeBinding> GpuScene::bindings_with(const ComputeBuffer& asked,
                                                    const ComputeBuffer& found) const {
    std::vector<ComputeBinding> made = bindings_;
    made.push_back({.set = 1, .binding = 0, .resource = asked});
    made.push_back({.set = 1, .binding = 1, .resource = found});
    return made;
}

}  // namespace demo
