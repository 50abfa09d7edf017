// SPDX-License-Identifier: MIT
#include "gpu/wide_bvh.hpp"

#include "scene/boxes.hpp"
#include "scene/surface.hpp"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace demo {

namespace {

constexpr std::size_t slots = WideBvh::children_of_node;
constexpr std::size_t most_of_leaf = 3;
constexpr std::size_t fours_of_node = WideBvh::words_of_node / 4;

/// A part of the tree that Embree's builder makes: a leaf or a node.
struct BuiltNode {
    std::size_t child_count = 0;
    std::array<BuiltNode*, slots> children{};
    std::size_t triangle_count = 0;
    std::array<std::uint32_t, most_of_leaf> triangles{};

    bool is_leaf() const { return child_count == 0; }
};

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
    return new (rtcThreadLocalAlloc(allocator, sizeof(BuiltNode), alignof(BuiltNode))) BuiltNode;
}

void set_children(void* node, void** children, unsigned count, void*) {
    auto& built = *static_cast<BuiltNode*>(node);
    built.child_count = count;
    for (std::size_t i = 0; i < count; ++i)
        built.children[i] = static_cast<BuiltNode*>(children[i]);
}

/// Of no use: see `Fitter`.
void set_boxes(void*, const RTCBounds**, unsigned, void*) {}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count,
                  void*) {
    auto* leaf = new (rtcThreadLocalAlloc(allocator, sizeof(BuiltNode), alignof(BuiltNode))) BuiltNode;
    leaf->triangle_count = count;
    for (std::size_t i = 0; i < count; ++i)
        leaf->triangles[i] = primitives[i].primID;
    return leaf;
}

struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
};

/// By what the rounding of a ray may miss a box.
float rounding_in(const Bounds& all) {
    const glm::vec3 farthest = glm::max(glm::abs(all.low), glm::abs(all.high));
    return 0x1p-21f * ((std::max)({farthest.x, farthest.y, farthest.z}) + diagonal_of(all));
}

/// The boxes of all triangles, wider on each side by `more`.
std::vector<RTCBuildPrimitive> boxes_of_triangles(const Scene& scene, float more) {
    std::vector<RTCBuildPrimitive> boxes(scene.triangles.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Bounds box = around(corners_of(scene, scene.triangles[i]));
        boxes[i] = {box.low.x - more,  box.low.y - more,  box.low.z - more,  0,
                    box.high.x + more, box.high.y + more, box.high.z + more, static_cast<unsigned>(i)};
    }
    return boxes;
}

/// The last words of a node.
std::span<std::uint32_t, slots> children_of(WideBvh& bvh, std::size_t node) {
    return std::span(bvh.nodes).subspan(node * WideBvh::words_of_node + 24).first<slots>();
}

/// Writes all but boxes and corners: see `fit`.
class Writer {
public:
    explicit Writer(const Scene& scene) : scene_(scene) {}

    WideBvh write(BuiltNode& root) {
        bvh_.nodes.resize(WideBvh::words_of_node);
        BuiltNode above;
        above.child_count = 1;
        above.children[0] = &root;
        write_node(root.is_leaf() ? above : root, 0, 1);
        return std::move(bvh_);
    }

private:
    void write_node(const BuiltNode& node, std::size_t number, std::uint32_t depth) {
        if (depth > most_bvh_depth)
            throw std::runtime_error("the scene's BVH is deeper than " + std::to_string(most_bvh_depth) +
                                     " nodes, which shaders do not follow");
        bvh_.depth = (std::max)(bvh_.depth, depth);
        const auto children = std::span(node.children).first(node.child_count);
        std::array<std::uint32_t, slots> words{};
        words.fill(WideBvh::leaf);
        const std::size_t first_node = bvh_.nodes.size() / WideBvh::words_of_node;
        std::size_t next = first_node;
        for (std::size_t slot = 0; slot < children.size(); ++slot)
            words[slot] = children[slot]->is_leaf() ? write_triangles(*children[slot])
                                                    : static_cast<std::uint32_t>(next++ * fours_of_node);
        bvh_.nodes.resize(next * WideBvh::words_of_node);
        std::ranges::copy(words, children_of(bvh_, number).begin());
        next = first_node;
        for (const BuiltNode* child : children)
            if (!child->is_leaf())
                write_node(*child, next++, depth + 1);
    }

    std::uint32_t write_triangles(const BuiltNode& leaf) {
        const std::size_t first = bvh_.triangles.size() / WideBvh::words_of_triangle;
        for (const std::uint32_t number : std::span(leaf.triangles).first(leaf.triangle_count)) {
            const Triangle& triangle = scene_.triangles[number];
            const bool is_translucent = may_let_light_through(scene_.materials[triangle.material]);
            for (const std::uint32_t word : {number, is_translucent ? 1u : 0u, 0u}) {
                bvh_.triangles.insert(bvh_.triangles.end(), 3, 0u);
                bvh_.triangles.push_back(word);
            }
        }
        return WideBvh::leaf | static_cast<std::uint32_t>(first << 2 | leaf.triangle_count);
    }

    const Scene& scene_;
    WideBvh bvh_;
};

/// Brings boxes and corners to where the triangles are.
class Fitter {
public:
    /// `more`: by what boxes are wider than what they hold, on each side.
    Fitter(WideBvh& bvh, const Scene& scene, float more)
        : bvh_(bvh), scene_(scene), more_(more), boxes_(bvh.nodes.size() / WideBvh::words_of_node) {}

    void fit() {
        for (std::size_t at = 0; at < bvh_.triangles.size(); at += WideBvh::words_of_triangle)
            place_triangle(at);
        // Children lie behind their parents.
        for (std::size_t node = boxes_.size(); node-- > 0;)
            fit_node(node);
    }

private:
    const Triangle& triangle_at(std::size_t word) const { return scene_.triangles[bvh_.triangles[word + 3]]; }

    void place_triangle(std::size_t at) {
        const Triangle& triangle = triangle_at(at);
        for (std::size_t corner = 0; corner < 3; ++corner)
            for (int axis = 0; axis < 3; ++axis)
                bvh_.triangles[at + 4 * corner + static_cast<std::size_t>(axis)] =
                    std::bit_cast<std::uint32_t>(scene_.positions[triangle.vertex[corner]][axis]);
    }

    void fit_node(std::size_t number) {
        const auto children = children_of(bvh_, number);
        std::array<Bounds, slots> of_children{};
        Bounds& box = boxes_[number];
        box = nothing();
        for (std::size_t slot = 0; slot < slots; ++slot) {
            of_children[slot] = box_of_child(children[slot]);
            box = common(box, of_children[slot]);
        }
        const auto words = std::span(bvh_.nodes).subspan(number * WideBvh::words_of_node);
        for (std::size_t slot = 0; slot < slots; ++slot) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto i = static_cast<int>(axis);
                words[8 * axis + slot] = std::bit_cast<std::uint32_t>(of_children[slot].low[i]);
                words[8 * axis + 4 + slot] = std::bit_cast<std::uint32_t>(of_children[slot].high[i]);
            }
        }
    }

    Bounds box_of_child(std::uint32_t child) const {
        if ((child & WideBvh::leaf) == 0)
            return boxes_[child / fours_of_node];
        Bounds box = nothing();
        const std::size_t first = (child & ~WideBvh::leaf) >> 2;
        for (std::size_t i = first; i < first + (child & 3u); ++i)
            box = common(box, around(corners_of(scene_, triangle_at(i * WideBvh::words_of_triangle))));
        return {box.low - more_, box.high + more_};
    }

    /// It ends before it begins, for all rays; shaders need not know infinity.
    static Bounds nothing() { return {glm::vec3(1e30f), glm::vec3(-1e30f)}; }

    WideBvh& bvh_;
    const Scene& scene_;
    float more_;
    std::vector<Bounds> boxes_;  ///< of the nodes
};

}  // namespace

WideBvh build_wide_bvh(const Scene& scene) {
    require_no_instances(scene, "a GPU");
    const std::unique_ptr<RTCDeviceTy, Release> device(rtcNewDevice(nullptr));
    const auto fail = [&](const char* what) {
        throw std::runtime_error("Embree: " + std::string(what) + " failed with error " +
                                 std::to_string(rtcGetDeviceError(device.get())));
    };
    if (!device)
        fail("opening the device");
    const std::unique_ptr<RTCBVHTy, Release> bvh(rtcNewBVH(device.get()));
    std::vector<RTCBuildPrimitive> boxes = boxes_of_triangles(scene, rounding_in(bounds_of(scene)));
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.maxBranchingFactor = slots;
    arguments.maxDepth = most_bvh_depth;
    arguments.maxLeafSize = most_of_leaf;
    arguments.bvh = bvh.get();
    arguments.primitives = boxes.data();
    arguments.primitiveCount = boxes.size();
    arguments.primitiveArrayCapacity = boxes.size();
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_boxes;
    arguments.createLeaf = create_leaf;
    auto* root = static_cast<BuiltNode*>(rtcBuildBVH(&arguments));
    if (root == nullptr)
        fail("building the BVH");
    WideBvh written = Writer(scene).write(*root);
    fit(written, scene);
    return written;
}

void fit(WideBvh& bvh, const Scene& scene) {
    Fitter(bvh, scene, rounding_in(bounds_of(scene))).fit();
}

}  // namespace demo
