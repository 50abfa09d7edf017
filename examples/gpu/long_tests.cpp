// SPDX-License-Identifier: MIT
#include "gpu/long_tests.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>

#include <algorithm>
#include <bit>
#include <vector>

namespace demo {

namespace {

constexpr std::uint32_t long_test_words[] = {
#include "spirv/long_tests.comp.inc"
};

/// As long_tests.comp has it: 64 lanes, 16 a word.
constexpr std::size_t words_of_group = 4;

/// Of a dispatch: millions of rays on a GPU, about a second of them on a CPU that plays one.
std::size_t words_at_once(const ComputeDevice& device) {
    const std::size_t most = device.is_cpu() ? std::size_t{1} << 12 : std::size_t{1} << 17;
    return (std::max)((std::min)(most, device.largest_buffer() / sizeof(lightmesh::LongTestWord)),
                      words_of_group);
}

std::vector<ComputeBinding> bindings_of(const ComputeDevice& device, const GpuScene& scene,
                                        const ComputeBuffer& words, const ComputeBuffer& seen) {
    std::vector<ComputeBinding> made = scene.bindings();
    const ComputeBuffer nothing(device, std::size_t{16});
    for (std::uint32_t i = 0; i <= lightmesh::MeshUpload::requests_binding; ++i)
        made.push_back({.set = LongTests::set, .binding = i, .buffer = nothing});
    made.push_back({.set = LongTests::set + 1, .binding = 0, .buffer = words});
    made.push_back({.set = LongTests::set + 1, .binding = 1, .buffer = seen});
    return made;
}

}  // namespace

LongTests::LongTests(const ComputeDevice& device, const GpuScene& scene)
    : device_(device), at_once_(words_at_once(device)),
      words_(device, at_once_ * sizeof(lightmesh::LongTestWord)),
      seen_(device, at_once_ * sizeof(std::uint64_t)),
      kernel_(device, long_test_words, bindings_of(device, scene, words_, seen_), sizeof(std::uint32_t)) {}

void LongTests::bind(std::span<const ComputeBinding> mesh) const {
    for (const ComputeBinding& binding : mesh)
        kernel_.bind(binding);
}

void LongTests::operator()(std::span<const lightmesh::LongTestWord> words, std::span<std::uint64_t> seen,
                           const std::atomic<bool>* cancel) {
    for (std::size_t first = 0; first < words.size(); first += at_once_) {
        check_cancelled(cancel);
        const auto some = words.subspan(first, (std::min)(at_once_, words.size() - first));
        const auto count = static_cast<std::uint32_t>(some.size());
        words_.write(0, std::as_bytes(some));
        spent_.seconds_device += device_.run([&](const ComputeCommands& commands) {
            commands.dispatch(kernel_,
                              static_cast<std::uint32_t>((count + words_of_group - 1) / words_of_group), 1, 1,
                              std::as_bytes(std::span(&count, 1)));
        });
        seen_.read(0, std::as_writable_bytes(seen.subspan(first, some.size())));
        ++spent_.dispatches;
        for (const lightmesh::LongTestWord& word : some)
            spent_.rays += static_cast<std::uint64_t>(std::popcount(word.points));
    }
}

}  // namespace demo
