// SPDX-License-Identifier: MIT
#include "gpu/link_tests.hpp"

#include <bit>
#include <cstddef>

namespace demo {

namespace {

constexpr std::uint32_t link_test_words[] = {
#include "spirv/link_tests.comp.inc"
};

/// Of a dispatch, as for long tests; of a word there are up to 192 rays, and short ones.
std::size_t link_words_at_once(const ComputeDevice& device) {
    return device.is_cpu() ? std::size_t{1} << 11 : std::size_t{1} << 16;
}

}  // namespace

LinkTests::LinkTests(const ComputeDevice& device, const GpuScene& scene)
    : words_(device, scene, link_test_words, link_words_at_once(device)) {}

void LinkTests::operator()(std::span<const lightmesh::LinkWord> words, std::span<lightmesh::OpenLinks> open,
                           const std::atomic<bool>* cancel) {
    words_.find(words, open, cancel, [](const lightmesh::LinkWord& word) {
        constexpr std::uint64_t links_of_cell = 24;
        return links_of_cell * static_cast<std::uint64_t>(std::popcount(word.cells));
    });
}

}  // namespace demo
