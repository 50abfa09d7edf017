// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// Rays of a light mesh that the host lists in words, by the shaders' traversal of a scene: an `Answer` for
/// each `Word`.
template <class Word, class Answer>
class ListedWords {
public:
    /// Descriptor set where the shader sees the mesh; in the next one it sees the words and its answers.
    static constexpr std::uint32_t set = 1;

    /// `spirv`: a shader that includes listed_words.glsl. `at_once`: words of a dispatch, fewer if the device
    /// has no room for them.
    ListedWords(const ComputeDevice& device, const GpuScene& scene, std::span<const std::uint32_t> spirv,
                std::size_t at_once)
        : device_(device),
          at_once_((std::max)(
              (std::min)(at_once, device.largest_buffer() / (std::max)(sizeof(Word), sizeof(Answer))),
              words_of_group)),
          words_(device, at_once_ * sizeof(Word)), answers_(device, at_once_ * sizeof(Answer)),
          kernel_(device, spirv, bindings_of(scene), sizeof(std::uint32_t)) {}

    /// Which mesh words are of from now on: as `UploadedMesh::bindings` gives it for `set`.
    void bind(std::span<const ComputeBinding> mesh) const {
        for (const ComputeBinding& binding : mesh)
            kernel_.bind(binding);
    }

    /// rays_of(word) is the number of its rays. Throws `Cancelled` between two dispatches if that is set, and
    /// what `compute.hpp` throws.
    template <class RaysOf>
    void find(std::span<const Word> words, std::span<Answer> answers, const std::atomic<bool>* cancel,
              RaysOf&& rays_of) {
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
                spent_.rays += rays_of(word);
        }
    }

    const DeviceFill& spent() const { return spent_; }

private:
    /// As listed_words.glsl has it: 64 lanes, 16 a word.
    static constexpr std::size_t words_of_group = 4;

    std::vector<ComputeBinding> bindings_of(const GpuScene& scene) const {
        std::vector<ComputeBinding> made = scene.bindings();
        const ComputeBuffer nothing(device_, std::size_t{16});
        for (std::uint32_t i = 0; i <= lightmesh::MeshUpload::requests_binding; ++i)
            made.push_back({.set = set, .binding = i, .buffer = nothing});
        made.push_back({.set = set + 1, .binding = 0, .buffer = words_});
        made.push_back({.set = set + 1, .binding = 1, .buffer = answers_});
        return made;
    }

    ComputeDevice device_;
    std::size_t at_once_;
    ComputeBuffer words_;
    ComputeBuffer answers_;
    ComputeKernel kernel_;
    DeviceFill spent_;
};

}  // namespace demo
