// SPDX-License-Identifier: MIT
#include "blender/core/session.hpp"

#include "blender/core/light_mesh_core.h"
#include "blender/core/shadow_looks.hpp"
#include "blender/core/triangle_change.hpp"
#include "render/illumination.hpp"
#include "scene/scene_change.hpp"
#include "scene/surface.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace demo {

namespace {

/// The weight of mirrored rays of a surface: those of rough ones are left out.
float mirror_of(const LmMaterial& told, const glm::vec3& head_on) {
    const float sharp = glm::clamp((0.3f - told.roughness) / 0.2f, 0.0f, 1.0f);
    return told.is_matt != 0 ? 0.0f : sharp * glm::dot(head_on, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

glm::dmat3 turn_of(const PlacedMesh& object) {
    const std::array<double, 12>& m = object.matrix;
    return {m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]};
}

glm::dvec3 place_of(const PlacedMesh& object) {
    return {object.matrix[3], object.matrix[7], object.matrix[11]};
}

/// True if rays are as exact in the mesh's own coordinates as in the world's.
bool can_be_instance(const ToldMesh& mesh, const PlacedMesh& object) {
    const glm::dmat3 turn = turn_of(object);
    const double most = (std::max)({glm::length(turn[0]), glm::length(turn[1]), glm::length(turn[2])});
    return mesh.is_near_origin && std::abs(glm::determinant(turn)) > 0.01 * most * most * most;
}

std::vector<Piece> with_keys(const std::vector<PlacedPiece>& placed,
                             const std::vector<std::size_t>& passing) {
    std::vector<Piece> pieces;
    for (const PlacedPiece& each : placed) {
        Piece& piece = pieces.emplace_back(each.piece);
        piece.key = each.place;
        for (const std::int32_t material : each.materials)
            piece.key = lm_hash(piece.key, &passing[static_cast<std::size_t>(material)], sizeof(std::size_t));
    }
    return pieces;
}

/// Those by which chance knows the triangles that let light through: of objects with as many triangles it
/// tells one from the others by their order, so that one goes on with its own while it moves and others come.
void give_surfaces(Scene& scene, std::vector<PlacedPiece>& pieces, const std::vector<Material>& materials) {
    scene.surfaces.assign(scene.triangles.size(), 0);
    std::map<std::uint32_t, std::uint32_t> alike;
    for (PlacedPiece& placed : pieces) {
        const Piece& piece = placed.piece;
        if (std::ranges::none_of(placed.materials, [&](std::int32_t material) {
                return may_let_light_through(materials[static_cast<std::size_t>(material)]);
            }))
            continue;
        const std::uint32_t order = alike[piece.triangle_count]++;
        const auto own =
            static_cast<std::uint32_t>(lm_hash(piece.triangle_count, &order, sizeof order) >> 16);
        placed.place = lm_hash(placed.place, &own, sizeof own);
        for (std::uint32_t t = 0; t < piece.triangle_count; ++t)
            scene.surfaces[piece.first_triangle + t] = piece.instance ? t : own + t;
        if (piece.instance)
            scene.instances[*piece.instance].surface = own;
    }
}

/// The vector of a number among those that lie at `values`; zero if that is null.
glm::vec3 vector_at(const float* values, std::size_t number) {
    if (values == nullptr)
        return glm::vec3(0.0f);
    const float* at = values + 3 * number;
    return {at[0], at[1], at[2]};
}

std::vector<lightmesh::SurfacePoint> surface_points(const LmPoints& points, std::size_t first,
                                                    std::size_t count) {
    std::vector<lightmesh::SurfacePoint> some(count);
    for (std::size_t i = 0; i < count; ++i) {
        some[i].position = vector_at(points.positions, first + i);
        some[i].normal = vector_at(points.normals, first + i);
        some[i].shading_normal = vector_at(points.shading_normals, first + i);
    }
    return some;
}

Camera camera_of(const LmView& view) {
    Camera camera;
    camera.eye = vector(view.eye);
    // A target that is far from a far eye: the difference of close ones would be inexact.
    camera.target = camera.eye + vector(view.ahead) * (1.0f + glm::length(camera.eye));
    camera.up = vector(view.up);
    camera.edges = {view.edges[0], view.edges[1], view.edges[2], view.edges[3]};
    camera.orthographic_height = view.is_orthographic != 0 ? view.edges[3] - view.edges[2] : 0.0f;
    camera.z_near = view.z_near;
    camera.z_far = view.z_far;
    return camera;
}

}  // namespace

void Session::stop() {
    cancel_ = true;
    if (worker_.joinable())
        worker_.join();
}

void Session::begin() {
    stop();
    told_ = {};
}

std::int32_t Session::find_image(std::uint64_t key) {
    for (std::size_t i = 0; i < told_.images.size(); ++i)
        if (told_.images[i].image.key == key)
            return static_cast<std::int32_t>(i);
    for (std::size_t i = 0; i < images_.size(); ++i)
        if (images_[i].key == key) {
            told_.images.push_back({images_[i], std::nullopt, i});
            return static_cast<std::int32_t>(told_.images.size()) - 1;
        }
    return -1;
}

std::int32_t Session::add_image(std::uint64_t key, int width, int height, const std::uint8_t* rgba,
                                std::int32_t flags) {
    if (width < 1 || height < 1)
        throw std::invalid_argument("an image of " + std::to_string(width) + " x " + std::to_string(height) +
                                    " pixels");
    Texture texture;
    texture.width = width;
    texture.height = height;
    texture.rgba.assign(rgba, rgba + 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    texture.is_linear = (flags & LM_IMAGE_LINEAR) != 0;
    texture.blends_encoded = true;
    for (std::size_t i = 3; i < texture.rgba.size() && !texture.has_alpha; i += 4)
        texture.has_alpha = texture.rgba[i] < 255;
    told_.images.push_back({{key, (flags & LM_IMAGE_CLAMP) != 0}, std::move(texture)});
    return static_cast<std::int32_t>(told_.images.size()) - 1;
}

const Texture& Session::texture_of(const ToldImage& image) const {
    return image.texture ? *image.texture : scene_.textures[image.number];
}

std::vector<Texture> Session::take_textures(Told& told) {
    std::vector<Texture> textures;
    images_.clear();  // also if this does not end
    for (ToldImage& image : told.images)
        textures.push_back(std::move(image.texture ? *image.texture : scene_.textures[image.number]));
    return textures;
}

std::int32_t Session::add_material(const LmMaterial& told) {
    const auto images = static_cast<std::int32_t>(told_.images.size());
    if (told.base_image < -1 || told.base_image >= images)
        throw std::out_of_range("a material has image " + std::to_string(told.base_image) + " of " +
                                std::to_string(images));
    const glm::vec3 base = vector(told.base);
    Material made;
    made.diffuse = base * (1.0f - told.metallic) * (1.0f - told.transmission);
    if (told.is_matt == 0) {
        made.highlight = Highlight::ggx;
        made.roughness = told.roughness;
        made.specular = glm::mix(glm::vec3(0.08f * told.specular), base, told.metallic);
    }
    made.metallic = told.metallic;
    made.k_t = (1.0f - told.metallic) * told.transmission;
    made.k_s = mirror_of(told, made.specular);
    made.tint = base;
    made.refraction_index = told.transmission > 0.0f ? told.refraction_index : 1.0f;
    made.emission = vector(told.emission);
    made.opacity = told.alpha;
    bool has_alpha = told.alpha < 1.0f;
    if (told.base_image >= 0) {
        const ToldImage& told_image = told_.images[static_cast<std::size_t>(told.base_image)];
        made.base_map.texture = told.base_image;
        made.base_map.wrap_u = made.base_map.wrap_v = told_image.image.clamps ? Wrap::clamp : Wrap::repeat;
        has_alpha = has_alpha || (told.image_alpha != 0 && texture_of(told_image).has_alpha);
    }
    made.alpha_mode = has_alpha ? AlphaMode::blend : AlphaMode::opaque;
    told_.materials.push_back(std::move(made));
    return static_cast<std::int32_t>(told_.materials.size()) - 1;
}

std::int32_t Session::find_mesh(std::uint64_t hash) {
    if (!meshes_.contains(hash))
        return -1;
    told_.meshes.push_back(hash);
    return static_cast<std::int32_t>(told_.meshes.size()) - 1;
}

std::int32_t Session::add_mesh(std::uint64_t hash, const LmMesh& mesh) {
    meshes_.insert_or_assign(hash, std::make_shared<const ToldMesh>(told_mesh(mesh)));
    told_.meshes.push_back(hash);
    return static_cast<std::int32_t>(told_.meshes.size()) - 1;
}

void Session::add_object(std::int32_t mesh, const double* matrix, std::span<const std::int32_t> materials) {
    if (mesh < 0 || static_cast<std::size_t>(mesh) >= told_.meshes.size())
        throw std::out_of_range("an object has mesh " + std::to_string(mesh) + " of " +
                                std::to_string(told_.meshes.size()));
    PlacedMesh placed{told_.meshes[static_cast<std::size_t>(mesh)], {}, {materials.begin(), materials.end()}};
    std::copy_n(matrix, placed.matrix.size(), placed.matrix.begin());
    if (!std::ranges::all_of(placed.matrix, [](double value) { return std::isfinite(value); }))
        throw std::invalid_argument("the matrix of an object is not finite");
    if (materials.size() < meshes_.at(placed.hash)->slot_count)
        throw std::out_of_range("an object has " + std::to_string(materials.size()) +
                                " materials, and its mesh " +
                                std::to_string(meshes_.at(placed.hash)->slot_count) + " slots");
    for (const std::int32_t material : materials)
        if (material < 0 || static_cast<std::size_t>(material) >= told_.materials.size())
            throw std::out_of_range("an object has material " + std::to_string(material) + " of " +
                                    std::to_string(told_.materials.size()));
    told_.objects.push_back(std::move(placed));
}

void Session::add_light(const LmLight& light) {
    SceneLight made = told_light(light);
    if (light.shadow != LM_NO_SHADOW) {
        LightGroup group = told_group(light, memory_budget_);
        LightGroup& told = told_.groups.try_emplace(group.settings, group).first->second;
        if (!told.options.lights)
            told.options.lights.emplace();
        told.options.lights->push_back(told_.lights.size());
        told.light_ids.push_back(light.id);
    }
    told_.lights.push_back(std::move(made));
}

void Session::place(Scene& scene, const PlacedMesh& object, bool with_uvs) const {
    const ToldMesh& mesh = *meshes_.at(object.hash);
    const glm::dmat3 turn = turn_of(object);
    const glm::dvec3 to = place_of(object);
    const double volume = glm::determinant(turn);
    const glm::mat3 normal_turn(volume != 0.0 ? glm::transpose(glm::inverse(turn)) : turn);
    const auto first = static_cast<std::uint32_t>(scene.positions.size());
    for (const glm::vec3& position : mesh.positions)
        scene.positions.emplace_back(turn * glm::dvec3(position) + to);
    for (const glm::vec3& normal : mesh.normals)
        scene.normals.push_back(normal_turn * normal);
    if (with_uvs) {
        std::vector<glm::vec2>& uvs = scene.texture_coordinates[0];
        uvs.resize(first);
        uvs.insert(uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
        uvs.resize(scene.positions.size());
    }
    for (Triangle triangle : mesh.triangles) {
        for (std::uint32_t& vertex : triangle.vertex)
            vertex += first;
        if (volume < 0.0)  // a mirror image: its front stays in front
            std::swap(triangle.vertex[1], triangle.vertex[2]);
        triangle.material = static_cast<std::uint32_t>(object.materials[triangle.material]);
        scene.triangles.push_back(triangle);
    }
}

void Session::add_copy(Scene& scene, std::vector<PlacedPiece>& pieces, const PlacedMesh& object,
                       bool with_uvs) const {
    const ToldMesh& mesh = *meshes_.at(object.hash);
    pieces.push_back({{0, static_cast<std::uint32_t>(scene.triangles.size()),
                       static_cast<std::uint32_t>(mesh.triangles.size()), std::nullopt},
                      lm_hash(object.hash, object.matrix.data(), sizeof object.matrix),
                      {object.materials.begin(), object.materials.begin() + mesh.slot_count}});
    place(scene, object, with_uvs);
}

void Session::add_part(Scene& scene, std::vector<PlacedPiece>& pieces,
                       const std::vector<const PlacedMesh*>& objects, bool with_uvs) const {
    const PlacedMesh& first = *objects.front();
    const ToldMesh& mesh = *meshes_.at(first.hash);
    const auto number = static_cast<std::uint32_t>(scene.parts.size());
    scene.parts.push_back({static_cast<std::uint32_t>(scene.positions.size()),
                           static_cast<std::uint32_t>(mesh.positions.size()),
                           static_cast<std::uint32_t>(scene.triangles.size()),
                           static_cast<std::uint32_t>(mesh.triangles.size())});
    const std::size_t first_piece = pieces.size();
    add_copy(scene, pieces, {first.hash, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, first.materials}, with_uvs);
    const PlacedPiece of_part = std::move(pieces.back());
    pieces.resize(first_piece);
    for (const PlacedMesh* object : objects) {
        const glm::dmat3 turn = turn_of(*object);
        PlacedPiece& piece = pieces.emplace_back(of_part);
        piece.piece.instance = static_cast<std::uint32_t>(scene.instances.size());
        piece.place = ~lm_hash(object->hash, object->matrix.data(), sizeof object->matrix);
        scene.instances.push_back({number, glm::mat4x3(glm::vec3(turn[0]), glm::vec3(turn[1]),
                                                       glm::vec3(turn[2]), glm::vec3(place_of(*object)))});
    }
}

Session::Placing Session::sort_objects(std::span<const PlacedMesh> objects) const {
    // In the order of the first object of each, which is the same in all frames of a film.
    std::map<std::pair<std::uint64_t, std::vector<std::int32_t>>, std::size_t> numbers;
    std::vector<std::vector<const PlacedMesh*>> groups;
    for (const PlacedMesh& object : objects) {
        if (!can_be_instance(*meshes_.at(object.hash), object))
            continue;
        const auto [number, is_new] = numbers.try_emplace({object.hash, object.materials}, groups.size());
        if (is_new)
            groups.emplace_back();
        groups[number->second].push_back(&object);
    }
    std::set<const PlacedMesh*> shared;
    Placing placing;
    for (std::vector<const PlacedMesh*>& alike : groups) {
        const std::size_t triangles = meshes_.at(alike.front()->hash)->triangles.size();
        const std::size_t saved = (alike.size() - 1) * triangles;
        // Rays through a few small copies take less time than rays through instances.
        if (saved > 0 && (triangles >= 256 || saved >= (std::size_t{1} << 18))) {
            shared.insert(alike.begin(), alike.end());
            placing.parts.push_back(std::move(alike));
        }
    }
    for (const PlacedMesh& object : objects)
        if (!shared.contains(&object))
            placing.copies.push_back(&object);
    return placing;
}

void Session::assemble(Scene& scene, std::vector<PlacedPiece>& pieces) const {
    const Placing placing = sort_objects(told_.objects);
    std::size_t vertices = 0;
    std::size_t triangles = 0;
    const auto count = [&](const PlacedMesh* object) {
        vertices += meshes_.at(object->hash)->positions.size();
        triangles += meshes_.at(object->hash)->triangles.size();
    };
    std::ranges::for_each(placing.copies, count);
    for (const std::vector<const PlacedMesh*>& part : placing.parts)
        count(part.front());
    if (vertices > (std::numeric_limits<std::uint32_t>::max)() - 3)
        throw std::length_error("the scene has " + std::to_string(vertices) + " vertices, more than 2^32");
    scene.positions.reserve(vertices);
    scene.normals.reserve(vertices);
    scene.triangles.reserve(triangles);
    const bool with_uvs = !told_.images.empty();
    for (const PlacedMesh* object : placing.copies)
        add_copy(scene, pieces, *object, with_uvs);
    if (scene.triangles.empty()) {
        // The tracer wants a triangle: one without a size, which no ray meets.
        scene.positions.assign(3, glm::vec3(0.0f));
        scene.normals.assign(3, glm::vec3(0.0f));
        scene.texture_coordinates = {};
        scene.triangles = {Triangle{{0, 1, 2}, 0}};
    }
    for (const std::vector<const PlacedMesh*>& part : placing.parts)
        add_part(scene, pieces, part, with_uvs);
    if (std::ranges::any_of(told_.materials, may_let_light_through))
        give_surfaces(scene, pieces, told_.materials);
}

Passing Session::find_passing() const {
    ShadowLooks before{scene_.materials, {}};
    for (const Texture& texture : scene_.textures)
        before.textures.push_back(&texture);
    ShadowLooks after{told_.materials, {}};
    for (const ToldImage& image : told_.images)
        after.textures.push_back(&texture_of(image));
    return passing_of(before, after);
}

bool Session::has_same_triangles(const Passing& passing) const {
    const bool has_uvs = !scene_.texture_coordinates[0].empty();
    const auto passes_the_same = [&](std::int32_t material) {
        const auto number = static_cast<std::size_t>(material);
        return passing.before[number] == passing.after[number];
    };
    return embree_ && told_.objects == objects_ && (told_.images.empty() || has_uvs || objects_.empty()) &&
           std::ranges::all_of(objects_, [&](const PlacedMesh& object) {
               return std::ranges::all_of(object.materials, passes_the_same);
           });
}

SceneChange Session::replace_scene() {
    if (told_.materials.empty())
        told_.materials.emplace_back();
    Scene next;
    std::vector<PlacedPiece> pieces;
    SceneChange change;
    const Passing passing = find_passing();
    if (has_same_triangles(passing)) {
        next.positions = std::move(scene_.positions);
        next.normals = std::move(scene_.normals);
        next.triangles = std::move(scene_.triangles);
        next.surfaces = std::move(scene_.surfaces);
        next.parts = std::move(scene_.parts);
        next.instances = std::move(scene_.instances);
        next.texture_coordinates = std::move(scene_.texture_coordinates);
        pieces = std::move(pieces_);
    } else {
        assemble(next, pieces);
        if (embree_) {
            const std::vector<Piece> were = with_keys(pieces_, passing.before);
            const std::vector<Piece> are = with_keys(pieces, passing.after);
            change = triangle_change({scene_, were}, {next, are}, passing);
        }
    }
    change.is_another_scene = !embree_;
    next.textures = take_textures(told_);
    next.materials = std::move(told_.materials);
    next.lights = std::move(told_.lights);
    scene_ = std::move(next);
    pieces_ = std::move(pieces);
    for (const ToldImage& image : told_.images)
        images_.push_back(image.image);
    return change;
}

void Session::commit() {
    stop();
    try {
        SceneChange change = replace_scene();
        if (change.is_another_scene) {
            visibility_.reset();
            embree_ = std::make_unique<EmbreeScene>(scene_, EmbreeScene::For::films);
        } else {
            embree_->update(change);
        }
        std::vector<LightGroup> groups;
        for (auto& [settings, group] : told_.groups)
            groups.push_back(std::move(group));
        visibility_ = std::make_unique<GroupedVisibility>(*embree_, scene_.lights.size(), std::move(groups),
                                                          visibility_.get(), change);
        last_change_ = std::move(change);
    } catch (...) {
        visibility_.reset();
        embree_.reset();
        told_ = {};
        throw;
    }
    objects_ = std::move(told_.objects);
    std::set<std::uint64_t> used;
    for (const PlacedMesh& object : objects_)
        used.insert(object.hash);
    std::erase_if(meshes_, [&](const auto& mesh) { return !used.contains(mesh.first); });
    told_ = {};
}

void Session::render(const LmView& view) {
    stop();
    if (!embree_)
        throw std::logic_error("there is no scene to render: lm_commit was not called, or failed");
    if (view.width < 1 || view.height < 1)
        throw std::invalid_argument("a picture of " + std::to_string(view.width) + " x " +
                                    std::to_string(view.height) + " pixels");
    scene_.camera = camera_of(view);
    scene_.background = vector(view.background);
    scene_.ambient = vector(view.ambient);
    RenderOptions options;
    options.width = view.width;
    options.height = view.height;
    options.samples = view.samples;
    options.depth_limit = view.bounces;
    options.threads = view.threads;
    options.ambient_rays = view.ambient_rays;
    options.ambient_distance = view.ambient_distance;
    options.transparent_background = view.is_transparent != 0;
    {
        const std::scoped_lock lock(pixels_mutex_);
        width_ = view.width;
        height_ = view.height;
        pixels_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), glm::vec4(0.0f));
    }
    cancel_ = false;
    progress_ = 0.0f;
    state_ = LM_RUNNING;
    failure_ = nullptr;
    visibility_->set_samples(view.samples);
    visibility_->begin_frame();
    worker_ = std::thread([this, options] { run(options); });
}

void Session::run(const RenderOptions& options) {
    RenderStatistics statistics;
    std::exception_ptr failure;
    try {
        demo::render(
            *embree_, *visibility_, options, statistics, [this](const TilePixels& tile) { put(tile); },
            [this](double done) { progress_ = static_cast<float>(done); }, &cancel_);
    } catch (...) {
        failure = std::current_exception();
    }
    const std::scoped_lock lock(state_mutex_);
    rendered_ = statistics;
    failure_ = failure;
    state_ = statistics.finished || failure ? LM_FINISHED : LM_CANCELLED;
    ended_.notify_all();
}

void Session::put(const TilePixels& tile) {
    const std::scoped_lock lock(pixels_mutex_);
    for (int row = 0; row < tile.height; ++row) {
        const auto line = static_cast<std::size_t>(height_ - 1 - tile.top - row);
        std::copy_n(tile.pixels.begin() + row * tile.width, tile.width,
                    pixels_.begin() + static_cast<std::ptrdiff_t>(line * static_cast<std::size_t>(width_)) +
                        tile.left);
    }
}

LmState Session::poll(std::chrono::duration<double> patience, float& progress) {
    std::unique_lock lock(state_mutex_);
    ended_.wait_for(lock, patience, [this] { return state_ != LM_RUNNING; });
    progress = progress_;
    if (failure_)
        std::rethrow_exception(failure_);
    return state_;
}

void Session::read(std::span<float> rgba) {
    const std::scoped_lock lock(pixels_mutex_);
    if (rgba.size() != 4 * pixels_.size())
        throw std::invalid_argument("a buffer of " + std::to_string(rgba.size()) +
                                    " values for a picture of " + std::to_string(width_) + " x " +
                                    std::to_string(height_) + " pixels");
    float* value = rgba.data();
    for (const glm::vec4& pixel : pixels_)
        for (int channel = 0; channel < 4; ++channel)
            *value++ = pixel[channel];
}

void Session::bake(const LmPoints& points, std::span<float> visible, std::span<float> colours) {
    stop();
    if (!embree_)
        throw std::logic_error("there is no scene to bake: lm_commit was not called, or failed");
    const std::size_t lights = scene_.lights.size();
    const std::size_t all = points.count;
    visibility_->begin_frame();
    constexpr std::size_t chunk = 256;
    const auto bake_chunk = [&](std::size_t number) {
        const std::size_t first = number * chunk;
        const std::size_t count = (std::min)(chunk, all - first);
        const std::vector<lightmesh::SurfacePoint> places = surface_points(points, first, count);
        std::vector<std::uint32_t> seeds(count);
        std::iota(seeds.begin(), seeds.end(), static_cast<std::uint32_t>(first));
        std::vector<float> lit(count * lights);
        VisibilityCost cost;
        visibility_->find({places, seeds}, lit, cost);
        if (!visible.empty())
            std::ranges::copy(lit, visible.begin() + static_cast<std::ptrdiff_t>(first * lights));
        for (std::size_t i = 0; i < (colours.empty() ? 0 : count); ++i) {
            const glm::vec3& normal =
                points.shading_normals == nullptr ? places[i].normal : places[i].shading_normal;
            glm::vec3 sum(0.0f);
            for (std::size_t l = 0; l < lights; ++l) {
                const Illumination light = illuminate(scene_.lights[l], places[i].position);
                sum += lit[i * lights + l] * (std::max)(glm::dot(normal, light.to_light), 0.0f) *
                       light.irradiance;
            }
            for (int channel = 0; channel < 3; ++channel)
                colours[3 * (first + i) + static_cast<std::size_t>(channel)] = sum[channel];
        }
    };
    tbb::parallel_for(std::size_t{0}, (all + chunk - 1) / chunk, bake_chunk);
}

LmStatistics Session::statistics() const {
    LmStatistics all{};
    if (embree_) {
        all.seconds_building = embree_->seconds_building();
        all.triangles = static_cast<std::int64_t>(drawn_triangles(scene_));
        all.stored_triangles = static_cast<std::int64_t>(scene_.triangles.size());
        all.is_new_scene = last_change_.is_another_scene ? 1 : 0;
        all.moved_boxes = static_cast<std::int32_t>(last_change_.boxes.size());
        all.groups = static_cast<std::int32_t>(visibility_->group_count());
        all.kept_rays = static_cast<std::int64_t>(visibility_->kept_rays());
        all.groups_kept = static_cast<std::int32_t>(visibility_->groups_kept());
        if (const auto mesh = visibility_->mesh()) {
            all.light_points = static_cast<std::int64_t>(mesh->light_points);
            all.bytes += static_cast<std::int64_t>(mesh->bytes);
        }
        if (const auto cache = visibility_->cache()) {
            all.records = static_cast<std::int64_t>(cache->records);
            all.bytes += static_cast<std::int64_t>(cache->bytes);
        }
    }
    const std::scoped_lock lock(state_mutex_);
    all.seconds_rendering = rendered_.seconds;
    all.seconds_visibility = rendered_.visibility.seconds;
    all.points = static_cast<std::int64_t>(rendered_.shading_points);
    all.shadow_rays = static_cast<std::int64_t>(rendered_.visibility.shadow_rays);
    return all;
}

}  // namespace demo
