// SPDX-License-Identifier: MIT
#include "gpu/wide_bvh.hpp"

#include "scene/light_rig.hpp"
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
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace demo {

namespace {

constexpr std::size_t slots = 8;
constexpr std::size_t most_of_leaf = 3;

/// What Embree's builder makes: a leaf, or a node with the boxes of its children.
struct BuiltNode {
    std::size_t child_count = 0;
    std::array<BuiltNode*, slots> children{};
    std::array<Bounds, slots> boxes{};
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

void set_boxes(void* node, const RTCBounds** boxes, unsigned count, void*) {
    for (std::size_t i = 0; i < count; ++i)
        static_cast<BuiltNode*>(node)->boxes[i] = {{boxes[i]->lower_x, boxes[i]->lower_y, boxes[i]->lower_z},
                                                   {boxes[i]->upper_x, boxes[i]->upper_y, boxes[i]->upper_z}};
}

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

Bounds box_of(const Scene& scene, const Triangle& triangle) {
    Bounds box{scene.positions[triangle.vertex[0]], scene.positions[triangle.vertex[0]]};
    for (const std::uint32_t vertex : triangle.vertex) {
        box.low = glm::min(box.low, scene.positions[vertex]);
        box.high = glm::max(box.high, scene.positions[vertex]);
    }
    return box;
}

/// By what the rounding of a ray may miss a box.
float rounding_in(const Bounds& all) {
    const glm::vec3 farthest = glm::max(glm::abs(all.low), glm::abs(all.high));
    return 0x1p-21f * ((std::max)({farthest.x, farthest.y, farthest.z}) + all.diagonal());
}

/// The boxes of all triangles, wider on each side by `more`.
std::vector<RTCBuildPrimitive> boxes_of_triangles(const Scene& scene, float more) {
    std::vector<RTCBuildPrimitive> boxes(scene.triangles.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Bounds box = box_of(scene, scene.triangles[i]);
        boxes[i] = {box.low.x - more,  box.low.y - more,  box.low.z - more,  0,
                    box.high.x + more, box.high.y + more, box.high.z + more, static_cast<unsigned>(i)};
    }
    return boxes;
}

/// The children's slots: each child has a gain in each slot, how far it lies to the side that the slot stands
/// for; the greatest gain is taken first.
std::array<std::size_t, slots> slots_of_children(const BuiltNode& node, const Bounds& box) {
    struct Choice {
        float gain;
        std::size_t child;
        std::size_t slot;
    };
    std::vector<Choice> choices;
    for (std::size_t child = 0; child < node.child_count; ++child) {
        const glm::vec3 aside = node.boxes[child].low + node.boxes[child].high - (box.low + box.high);
        for (std::size_t slot = 0; slot < slots; ++slot) {
            float gain = 0.0f;
            for (int axis = 0; axis < 3; ++axis)
                gain += (slot >> axis & 1) != 0 ? aside[axis] : -aside[axis];
            choices.push_back({gain, child, slot});
        }
    }
    std::ranges::stable_sort(choices, std::ranges::greater{}, &Choice::gain);
    std::array<std::size_t, slots> found{};
    std::array<bool, slots> is_placed{};
    std::array<bool, slots> is_taken{};
    for (const Choice& choice : choices) {
        if (is_placed[choice.child] || is_taken[choice.slot])
            continue;
        found[choice.child] = choice.slot;
        is_placed[choice.child] = is_taken[choice.slot] = true;
    }
    return found;
}

/// Powers of two: the steps that a box is cut into.
struct Steps {
    explicit Steps(const Bounds& box) {
        for (int axis = 0; axis < 3; ++axis) {
            const double length = static_cast<double>(box.high[axis]) - static_cast<double>(box.low[axis]);
            int least = 0;
            std::frexp(length / 255.0, &least);
            exponents[static_cast<std::size_t>(axis)] = std::clamp(least, -126, 127);
        }
    }

    /// From the low corner to a place on an axis.
    double count(const Bounds& box, float place, int axis) const {
        return std::ldexp(static_cast<double>(place) - static_cast<double>(box.low[axis]),
                          -exponents[static_cast<std::size_t>(axis)]);
    }

    std::array<int, 3> exponents{};
};

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
        Bounds box = node.boxes[0];
        for (std::size_t i = 1; i < node.child_count; ++i) {
            box.low = glm::min(box.low, node.boxes[i].low);
            box.high = glm::max(box.high, node.boxes[i].high);
        }
        const std::array<std::size_t, slots> slot_of = slots_of_children(node, box);
        std::array<const BuiltNode*, slots> in_slot{};
        std::array<std::uint32_t, WideBvh::words_of_node> words{};
        std::array<std::uint8_t, slots> kinds{};
        std::uint32_t node_slots = 0;
        for (std::size_t child = 0; child < node.child_count; ++child)
            in_slot[slot_of[child]] = node.children[child];
        const std::size_t first_node = bvh_.nodes.size() / WideBvh::words_of_node;
        const std::size_t first_triangle = bvh_.triangles.size() / WideBvh::words_of_triangle;
        for (std::size_t slot = 0; slot < slots; ++slot) {
            if (in_slot[slot] == nullptr)
                continue;
            if (!in_slot[slot]->is_leaf()) {
                node_slots |= 1u << slot;
                kinds[slot] = static_cast<std::uint8_t>(1u << 5 | (24 + slot));
                continue;
            }
            const std::size_t before = bvh_.triangles.size() / WideBvh::words_of_triangle - first_triangle;
            kinds[slot] =
                static_cast<std::uint8_t>(((1u << in_slot[slot]->triangle_count) - 1) << 5 | before);
            write_triangles(*in_slot[slot]);
        }
        words[3] = node_slots << 24;
        words[4] = static_cast<std::uint32_t>(first_node);
        words[5] = static_cast<std::uint32_t>(first_triangle);
        for (std::size_t slot = 0; slot < slots; ++slot)
            words[6 + slot / 4] |= std::uint32_t{kinds[slot]} << 8 * (slot % 4);
        std::ranges::copy(words,
                          bvh_.nodes.begin() + static_cast<std::ptrdiff_t>(number * WideBvh::words_of_node));
        const auto node_count = static_cast<std::size_t>(std::popcount(node_slots));
        bvh_.nodes.resize(bvh_.nodes.size() + node_count * WideBvh::words_of_node);
        std::size_t next = first_node;
        for (std::size_t slot = 0; slot < slots; ++slot)
            if ((node_slots >> slot & 1) != 0)
                write_node(*in_slot[slot], next++, depth + 1);
    }

    void write_triangles(const BuiltNode& leaf) {
        for (const std::uint32_t number : std::span(leaf.triangles).first(leaf.triangle_count)) {
            const Triangle& triangle = scene_.triangles[number];
            const bool is_translucent = may_let_light_through(scene_.materials[triangle.material]);
            for (const std::uint32_t word : {number, is_translucent ? 1u : 0u, 0u}) {
                bvh_.triangles.insert(bvh_.triangles.end(), 3, 0u);
                bvh_.triangles.push_back(word);
            }
        }
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
        const auto words =
            std::span(bvh_.nodes).subspan(number * WideBvh::words_of_node).first<WideBvh::words_of_node>();
        const std::uint32_t node_slots = words[3] >> 24;
        std::array<Bounds, slots> of_slots{};
        Bounds& box = boxes_[number];
        bool is_first = true;
        for (std::size_t slot = 0, next = words[4]; slot < slots; ++slot) {
            const std::uint32_t kind = words[6 + slot / 4] >> 8 * (slot % 4) & 255u;
            if (kind == 0)
                continue;
            of_slots[slot] = (node_slots >> slot & 1) != 0
                                 ? boxes_[next++]
                                 : box_of_leaf(words[5] + (kind & 31u),
                                               static_cast<std::size_t>(std::popcount(kind >> 5)));
            box = is_first ? of_slots[slot] : common(box, of_slots[slot]);
            is_first = false;
        }
        const Steps steps(box);
        words[3] = node_slots << 24;
        for (int axis = 0; axis < 3; ++axis) {
            const auto at = static_cast<std::size_t>(axis);
            words[at] = std::bit_cast<std::uint32_t>(box.low[axis]);
            words[3] |= static_cast<std::uint32_t>(steps.exponents[at] + 127) << 8 * axis;
        }
        std::ranges::fill(words.subspan<8>(), 0u);
        for (std::size_t slot = 0; slot < slots; ++slot)
            if ((words[6 + slot / 4] >> 8 * (slot % 4) & 255u) != 0)
                write_box(words, box, steps, of_slots[slot], slot);
    }

    Bounds box_of_leaf(std::size_t first_triangle, std::size_t count) const {
        Bounds box{glm::vec3(std::numeric_limits<float>::infinity()),
                   glm::vec3(-std::numeric_limits<float>::infinity())};
        for (std::size_t i = first_triangle; i < first_triangle + count; ++i)
            box = common(box, box_of(scene_, triangle_at(i * WideBvh::words_of_triangle)));
        return {box.low - more_, box.high + more_};
    }

    static Bounds common(const Bounds& a, const Bounds& b) {
        return {glm::min(a.low, b.low), glm::max(a.high, b.high)};
    }

    static void write_box(std::span<std::uint32_t, WideBvh::words_of_node> words, const Bounds& box,
                          const Steps& steps, const Bounds& of_child, std::size_t slot) {
        const auto put_byte = [&](std::size_t word, double byte) {
            words[word + slot / 4] |= static_cast<std::uint32_t>(std::clamp(byte, 0.0, 255.0))
                                      << 8 * (slot % 4);
        };
        for (int axis = 0; axis < 3; ++axis) {
            const auto pair = 2 * static_cast<std::size_t>(axis);
            put_byte(8 + pair, std::floor(steps.count(box, of_child.low[axis], axis)));
            put_byte(14 + pair, std::ceil(steps.count(box, of_child.high[axis], axis)));
        }
    }

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
