// SPDX-License-Identifier: MIT

// Adapters that can do what the contract asks for and nothing else: the library assumes no more.

#include <lightmesh/lightmesh.hpp>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace opaque_adapter_test {

namespace {

/// No default, no assignment, no comparison, no address, no comma, no allocation, no conversion, no heirs.
struct Locked {
    Locked() = delete;
    explicit Locked(int) {}
    Locked(const Locked&) = default;
    Locked& operator=(const Locked&) = delete;
    Locked* operator&() = delete;
    const Locked* operator&() const = delete;
    template <class T>
    void operator,(T&&) const = delete;
    template <class T>
    bool operator==(const T&) const = delete;
    static void* operator new(std::size_t) = delete;
    static void* operator new[](std::size_t) = delete;
};

struct Tracer final : Locked {
    using Locked::Locked;
    bool occluded(const lightmesh::Segment& segment) const {
        return (segment.origin.z > 1.0f) != (segment.target.z > 1.0f);
    }
};

struct Renderer final {
    explicit Renderer(int) {}
    Renderer(Renderer&&) = default;
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;
    Renderer& operator=(Renderer&&) = delete;
    Renderer* operator&() = delete;
    const Renderer* operator&() const = delete;
    void render_depth(const lightmesh::DepthView&, std::span<float> distance) {
        for (float& texel : distance)
            texel = std::numeric_limits<float>::infinity();
    }
};

/// Counts and corners of its own types.
struct Count {
    operator std::size_t() const { return 1; }
};
struct Corners {
    operator std::array<glm::vec3, 3>() const {
        return {glm::vec3(-1e3f, -1e3f, 1.0f), glm::vec3(1e3f, -1e3f, 1.0f), glm::vec3(0.0f, 1e3f, 1.0f)};
    }
};
struct Triangles final : Locked {
    using Locked::Locked;
    Count triangle_count() const { return {}; }
    Corners triangle(std::size_t) const { return {}; }
};

static_assert(lightmesh::check_intersector<Tracer>());
static_assert(lightmesh::check_depth_renderer<Renderer>());
static_assert(lightmesh::check_occluders<Triangles>());
static_assert(lightmesh::Intersector<Tracer> && !lightmesh::BatchIntersector<Tracer>);
static_assert(lightmesh::DepthRenderer<Renderer> && !lightmesh::BatchDepthRenderer<Renderer>);
static_assert(!lightmesh::BoundedDepthRenderer<Renderer>);
static_assert(lightmesh::Occluders<Triangles>);
static_assert(!lightmesh::Intersector<Renderer> && !lightmesh::DepthRenderer<Triangles> &&
              !lightmesh::Occluders<Tracer>);

const std::vector<lightmesh::Light> lights{lightmesh::PointLight{{0.0f, 0.0f, 3.0f}}};

float on_the_ground(const auto& mesh) {
    return mesh.visibility({0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, 0);
}

lightmesh::Settings settings(lightmesh::ShortTest short_test) {
    lightmesh::Settings chosen;
    chosen.radius = 0.5f;
    chosen.short_test = short_test;
    return chosen;
}

}  // namespace

TEST_CASE("adapters with the required members only, and nothing else that types can do") {
    using lightmesh::ShortTest;
    for (const ShortTest short_test : {ShortTest::none, ShortTest::linked, ShortTest::exact}) {
        const lightmesh::Settings chosen = settings(short_test);
        CHECK(on_the_ground(lightmesh::LightMesh{Tracer(1), lights, chosen}) == 0.0f);
        CHECK(on_the_ground(lightmesh::LightMesh{Tracer(1), Renderer(1), lights, chosen}) == 1.0f);
        CHECK(on_the_ground(lightmesh::LightMesh{Tracer(1), Triangles(1), lights, chosen}) == 0.0f);
    }
}

}  // namespace opaque_adapter_test
