// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/ray_shader.hpp"

#include <lightmesh/fill/link_list.hpp>
#include <lightmesh/fill/long_test_list.hpp>
#include <lightmesh/gpu/mesh_upload.hpp>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// Links, for `ListedWords`.
struct LinkKind {
    using Word = lightmesh::LinkWord;
    using Answer = lightmesh::OpenLinks;
    static RayShader shader();
    /// Of a dispatch, as for long tests; of a word there are up to 192 rays, and short ones.
    static constexpr std::size_t at_once = std::size_t{1} << 16;
    static constexpr std::size_t at_once_on_cpu = std::size_t{1} << 11;
    static std::uint64_t rays_of(const Word& word) {
        return 24 * static_cast<std::uint64_t>(std::popcount(word.cells));
    }
};

/// Long tests, for `ListedWords`.
struct LongTestKind {
    using Word = lightmesh::LongTestWord;
    using Answer = std::uint64_t;
    static RayShader shader();
    /// Of a dispatch: millions of rays on a GPU, about a second of them on a CPU that plays one.
    static constexpr std::size_t at_once = std::size_t{1} << 17;
    static constexpr std::size_t at_once_on_cpu = std::size_t{1} << 12;
    static std::uint64_t rays_of(const Word& word) {
        return static_cast<std::uint64_t>(std::popcount(word.points));
    }
};

/// Rays of a light mesh that the host lists in words, by shaders through a scene: an answer for
/// each word, of the mesh that is bound. `Kind` has their types, a shader that includes listed_words.glsl,
/// the number of words for a dispatch, and that of a word's rays.
template <class Kind>
class ListedWords {
public:
    using Word = typename Kind::Word;
    using Answer = typename Kind::Answer;

    /// Descriptor set where the shader sees the mesh; in the next one it sees the words and its answers.
    static constexpr std::uint32_t set = 1;

    ListedWords(const ComputeDevice& device, const GpuScene& scene)
        : device_(device), at_once_(words_at_once(device)), words_(device, at_once_ * sizeof(Word)),
          answers_(device, at_once_ * sizeof(Answer)),
          kernel_(device, Kind::shader().on(device), bindings_of(scene), sizeof(std::uint32_t)) {}

    /// Which mesh words are of from now on: as `UploadedMesh::bindings` gives it for `set`.
    void bind(std::span<const ComputeBinding> mesh) const {
        for (const ComputeBinding& binding : mesh)
            kernel_.bind(binding);
    }

    /// Throws `Cancelled` between two dispatches if that is set, and what `compute.hpp` throws.
    void operator()(std::span<const Word> words, std::span<Answer> answers, const std::atomic<bool>* cancel) {
        for (std::size_t first = 0; first < words.size(); first += at_once_) {
            check_cancelled(cancel);
            const auto some = words.subspan(first, (std::min)(at_once_, words.size() - first));
            const auto count = static_cast<std::uint32_t>(some.size());
            words_.write(0, std::as_bytes(some));
            spent_.seconds_device += device_.run([&](const ComputeCommands& commands) {
                commands.dispatch(kernel_,
                                  static_cast<std::uint32_t>((count + words_of_group - 1) / words_of_group),
                                  1, 1, std::as_bytes(std::span(&count, 1)));
            });
            answers_.read(0, std::as_writable_bytes(answers.subspan(first, some.size())));
            ++spent_.dispatches;
            for (const Word& word : some)
                spent_.rays += Kind::rays_of(word);
        }
    }

    const DeviceFill& spent() const { return spent_; }

private:
    /// As listed_words.glsl has it: 64 lanes, 16 a word.
    static constexpr std::size_t words_of_group = 4;

    /// Of a dispatch: fewer if the device has no room for them.
    static std::size_t words_at_once(const ComputeDevice& device) {
        const std::size_t room = device.largest_buffer() / (std::max)(sizeof(Word), sizeof(Answer));
        return (std::max)((std::min)(device.is_cpu() ? Kind::at_once_on_cpu : Kind::at_once, room),
                          words_of_group);
    }

    std::vector<ComputeBinding> bindings_of(const GpuScene& scene) const {
        std::vector<ComputeBinding> made = scene.bindings();
        const ComputeBuffer nothing(device_, std::size_t{16});
        for (std::uint32_t i = 0; i <= lightmesh::MeshUpload::requests_binding; ++i)
            made.push_back({.set = set, .binding = i, .resource = nothing});
        made.push_back({.set = set + 1, .binding = 0, .resource = words_});
        made.push_back({.set = set + 1, .binding = 1, .resource = answers_});
        return made;
    }

    ComputeDevice device_;
    std::size_t at_once_;
    ComputeBuffer words_;
    ComputeBuffer answers_;
    ComputeKernel kernel_;
    DeviceFill spent_;
};

/// A `lightmesh::LinkTracer`.
using LinkTests = ListedWords<LinkKind>;
/// A `lightmesh::LongTestTracer`.
using LongTests = ListedWords<LongTestKind>;

}  // namespace demo
