// SPDX-License-Identifier: MIT

// libFuzzer's target over snapshots of meshes and caches: bytes that are read, asked, laid out for shaders
// and merged. Refusing them is right; so is any visibility from 0 to 1, since bits may be any. All else is a
// fault. It makes its first inputs itself, and gives most of what it changes a right size and checksum, so
// that the checks behind those are met too. Build with clang and -DLIGHTMESH_FUZZ=ON, then
//     tests/lightmesh-fuzz-snapshot -max_len=65536 -max_total_time=600 -rss_limit_mb=1024 -malloc_limit_mb=64

#include "plain.hpp"
#include "random_scene.hpp"

#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/snapshot_format.hpp>
#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/light_mesh.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/snapshot.hpp>
#include <lightmesh/visibility_cache.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <span>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed);

namespace {

using lightmesh::detail::CacheHeader;
using lightmesh::detail::SnapshotHeader;
using Mesh = lightmesh::LightMesh<test::PlainTracer>;
using Bytes = std::vector<std::byte>;

/// Meshes of one small room, which lies in one region of the grid. The last point lies between two levels.
struct Example {
    static constexpr std::array<lightmesh::SurfacePoint, 3> points{
        {{{0.4f, 0.3f, -1.0f}, {0.0f, 0.0f, 1.0f}},
         {{-0.6f, 1.0f, 0.2f}, {0.0f, -1.0f, 0.0f}},
         {{0.2f, -0.3f, -1.0f}, {0.0f, 0.0f, 1.0f}, 0.75f}}};

    static const std::vector<test::Triangle>& scene() {
        static const std::vector<test::Triangle> made = [] {
            std::vector<test::Triangle> triangles;
            test::add_quad(triangles, {-3.0, -3.0, -1.0}, {6.0, 0.0, 0.0}, {0.0, 6.0, 0.0});
            test::add_quad(triangles, {-3.0, 1.0, -1.0}, {5.0, 0.0, 0.0}, {0.0, 0.0, 2.0});
            test::add_quad(triangles, {0.0, -0.5, 0.1}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
            return triangles;
        }();
        return made;
    }

    std::vector<lightmesh::Light> lights;
    lightmesh::Settings settings;

    Example(lightmesh::ShortTest short_test, int light_count) {
        test::Random random(17);
        lights = test::random_lights(random, light_count);
        settings = {.radius = 0.8f,
                    .quality = 2.0f,
                    .short_test = short_test,
                    .footprint_scale = 1.0f,
                    .origin = glm::vec3(-6.4f)};
    }

    Mesh mesh() const { return Mesh{test::PlainTracer{&scene()}, lights, settings}; }

    Bytes snapshot(std::span<const lightmesh::SurfacePoint> of) const {
        const Mesh asked = mesh();
        std::vector<float> lit(lights.size());
        for (const lightmesh::SurfacePoint& point : of)
            asked.visibility(point, lit);
        return asked.snapshot();
    }
};

/// Few lights, and more than one tile of them.
const std::vector<Example>& examples() {
    static const std::vector<Example> made = [] {
        std::vector<Example> all;
        for (const lightmesh::ShortTest short_test : test::all_short_tests)
            for (const int light_count : {3, 70})
                all.emplace_back(short_test, light_count);
        return all;
    }();
    return made;
}

using Cache = lightmesh::VisibilityCache<test::PlainTracer>;

/// A cache of the same room.
Cache example_cache() {
    test::Random random(17);
    return Cache{test::PlainTracer{&Example::scene()}, test::random_lights(random, 3),
                 lightmesh::CacheSettings{.spacing = 0.4f, .detail = 1}};
}

Bytes cache_snapshot(std::span<const lightmesh::SurfacePoint> of) {
    const Cache cache = example_cache();
    std::vector<float> lit(cache.light_count());
    for (const lightmesh::SurfacePoint& point : of)
        cache.visibility(point, lit);
    return cache.snapshot();
}

/// What the fuzzer starts from: of each example, and of the cache, what its first point, its last two and all
/// need.
const std::vector<Bytes>& first_inputs() {
    static const std::vector<Bytes> made = [] {
        std::vector<Bytes> all;
        for (const Example& example : examples()) {
            const std::span<const lightmesh::SurfacePoint> points = Example::points;
            for (const auto& some : {points.first(1), points.last(2), points})
                all.push_back(example.snapshot(some));
        }
        const std::span<const lightmesh::SurfacePoint> points = Example::points;
        for (const auto& some : {points.first(1), points.last(2), points})
            all.push_back(cache_snapshot(some));
        return all;
    }();
    return made;
}

void require(bool right, const char* what) {
    if (right)
        return;
    std::cerr << "fault: " << what << '\n';
    std::abort();
}

void check_visibilities(std::span<const float> lit) {
    for (const float s : lit)
        require(std::isnan(s) || (s >= 0.0f && s <= 1.0f), "a visibility is not from 0 to 1");
}

/// Whether `action` went to its end; it may throw instead, but not for want of memory.
template <class Action>
bool succeeds(Action&& action) {
    try {
        action();
    } catch (const std::bad_alloc&) {
        require(false, "more memory than there is");
    } catch (const std::exception&) {
        return false;
    }
    return true;
}

void ask(const lightmesh::SnapshotView& view) {
    // What takes long is no fault: many lights of a fine grid.
    if (view.light_count() > 200)
        return;
    std::vector<float> lit(view.light_count());
    for (const lightmesh::SurfacePoint& point : Example::points) {
        const bool has_answers = succeeds([&] { view.visibility(point, lit); });
        if (has_answers)
            check_visibilities(lit);
        if (view.is_cache() || view.settings().quality > 3.0f)
            continue;
        const bool has_traced =
            succeeds([&] { view.visibility(test::PlainTracer{&Example::scene()}, point, lit); });
        if (has_traced)
            check_visibilities(lit);
    }
}

/// What is laid out for shaders from a view.
void lay_out(const lightmesh::SnapshotView& view) {
    const bool is_laid_out = succeeds([&] {
        if (view.is_cache())
            require(lightmesh::CacheUpload(view).buffers().size() == lightmesh::CacheUpload::buffer_count,
                    "a buffer is missing");
        else
            require(lightmesh::MeshUpload(view).buffers().size() == lightmesh::MeshUpload::buffer_count,
                    "a buffer is missing");
    });
    require(is_laid_out || !view.is_cache(), "a cache that was accepted cannot be laid out");
}

/// As `merge`.
void merge_into_cache(const Bytes& known, const Bytes& bytes, std::span<const lightmesh::Bounds> changed) {
    Cache cache = example_cache();
    if (!known.empty())
        cache.merge(known);
    const Bytes before = cache.snapshot();
    const bool is_merged = succeeds([&] { cache.merge(bytes, changed); });
    const Bytes after = cache.snapshot();
    require(is_merged || after == before, "bytes that were refused have changed the cache");
    require(succeeds([&] { const lightmesh::SnapshotView view{std::span<const std::byte>(after)}; }),
            "the bytes of a cache cannot be read");
}

/// A mesh that took bytes answers, and its own bytes can be read; one that refused them is as it was.
void merge(const Example& example, const Bytes& known, const Bytes& bytes,
           std::span<const lightmesh::Bounds> changed) {
    Mesh mesh = example.mesh();
    if (!known.empty())
        mesh.merge(known);
    const Bytes before = mesh.snapshot();
    const bool is_merged = succeeds([&] { mesh.merge(bytes, changed); });
    const Bytes after = mesh.snapshot();
    require(is_merged || after == before, "bytes that were refused have changed the mesh");
    if (!is_merged)
        return;
    require(after.size() <= before.size() + 16 * bytes.size(), "the mesh grew by more than the bytes hold");
    require(succeeds([&] { const lightmesh::SnapshotView view{std::span<const std::byte>(after)}; }),
            "the bytes of a mesh cannot be read");
    std::vector<float> lit(mesh.light_count());
    for (const lightmesh::SurfacePoint& point : Example::points) {
        mesh.visibility(point, lit);
        check_visibilities(lit);
    }
}

template <class Header>
Header header_of(const std::uint8_t* data) {
    Header header;
    std::memcpy(&header, data, sizeof header);
    return header;
}

/// Bytes shorter than this are replaced by first inputs.
constexpr std::size_t least_size = (std::max)(sizeof(SnapshotHeader), sizeof(CacheHeader));

bool is_of_cache(const std::uint8_t* data, std::size_t size) {
    return lightmesh::detail::is_cache_snapshot(std::as_bytes(std::span<const std::uint8_t>(data, size)));
}

/// Gives the bytes, of which there are a header's at least, a right size and checksum.
template <class Header>
void sign(std::uint8_t* data, std::size_t size) {
    Header header = header_of<Header>(data);
    header.magic = Header::right_magic;
    header.version = Header::right_version;
    header.byte_order = Header::right_byte_order;
    header.size = size;
    header.checksum =
        lightmesh::detail::checksum_of(header, std::as_bytes(std::span<const std::uint8_t>(data, size)));
    std::memcpy(data, &header, sizeof header);
}

/// One of the 32-bit words of a section becomes a small number, another word, or off by a little: indices,
/// counts and masks are such words.
template <class Header>
void change_word(std::uint8_t* data, std::size_t size, test::Random& random) {
    const Header header = header_of<Header>(data);
    const auto& section = header.sections[random.below(header.sections.size())];
    const std::size_t words = size / 4;
    std::size_t first = 0;
    std::size_t count = sizeof header / 4;
    if (random.below(4) != 0 && section.offset / 4 < words) {
        first = static_cast<std::size_t>(section.offset / 4);
        count = words - first;
        if (section.count < count)  // A struct has a word at least, and 16 often.
            count = (std::min)(count, static_cast<std::size_t>(section.count) * 16);
    }
    if (count == 0)
        return;
    const std::size_t at = 4 * (first + random.below(count));
    std::uint32_t word = 0;
    std::memcpy(&word, data + at, 4);
    switch (random.below(4)) {
    case 0:
        word = static_cast<std::uint32_t>(random.below(64));
        break;
    case 1:
        std::memcpy(&word, data + 4 * random.below(words), 4);
        break;
    case 2:
        word += static_cast<std::uint32_t>(random.below(9)) - 4;
        break;
    default:
        word ^= 1u << random.below(32);
    }
    std::memcpy(data + at, &word, 4);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto read = std::as_bytes(std::span<const std::uint8_t>(data, size));
    const Bytes bytes(read.begin(), read.end());
    std::size_t light_count = 0;
    bool is_cache = false;
    const bool is_read = succeeds([&] {
        const lightmesh::SnapshotView view{std::span<const std::byte>(bytes)};
        light_count = view.light_count();
        is_cache = view.is_cache();
        ask(view);
        lay_out(view);
    });
    if (!is_read)
        return 0;
    constexpr std::array<lightmesh::Bounds, 1> box{{{{0.2f, 0.2f, 0.0f}, {0.3f, 0.4f, 0.2f}}}};
    if (is_cache) {
        const Bytes& known = first_inputs()[3 * examples().size() + 1];
        merge_into_cache({}, bytes, {});
        merge_into_cache(known, bytes, {});
        merge_into_cache(known, bytes, box);
        return 0;
    }
    for (std::size_t i = 0; i < examples().size(); ++i) {
        if (examples()[i].lights.size() != light_count)
            continue;
        const Bytes& known = first_inputs()[3 * i + 1];
        merge(examples()[i], {}, bytes, {});
        merge(examples()[i], known, bytes, {});
        merge(examples()[i], known, bytes, box);
        break;
    }
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
    test::Random random(seed);
    if (size < least_size) {
        const Bytes& first = first_inputs()[random.below(first_inputs().size())];
        if (first.size() > max_size)
            return LLVMFuzzerMutate(data, size, max_size);
        std::memcpy(data, first.data(), first.size());
        return first.size();
    }
    // Before any of the bytes change: of what kind they are.
    const bool is_cache = is_of_cache(data, size);
    if (random.below(3) == 0) {
        size = LLVMFuzzerMutate(data, size, max_size);
    } else {
        const std::size_t changes = 1 + random.below(3);
        for (std::size_t i = 0; i < changes; ++i)
            is_cache ? change_word<CacheHeader>(data, size, random)
                     : change_word<SnapshotHeader>(data, size, random);
    }
    if (size >= least_size && random.below(16) != 0)
        is_cache ? sign<CacheHeader>(data, size) : sign<SnapshotHeader>(data, size);
    return size;
}
