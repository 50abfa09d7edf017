// SPDX-License-Identifier: MIT
#include "gpu/long_tests.hpp"

#include <bit>
#include <cstddef>

namespace demo {

namespace {

constexpr std::uint32_t long_test_words[] = {
#include "spirv/long_tests.comp.inc"
};

/// Of a dispatch: millions of rays on a GPU, about a second of them on a CPU that plays one.
std::size_t words_at_once(const ComputeDevice& device) {
    return device.is_cpu() ? std::size_t{1} << 12 : std::size_t{1} << 17;
}

}  // namespace

LongTests::LongTests(const ComputeDevice& device, const GpuScene& scene)
    : words_(device, scene, long_test_words, words_at_once(device)) {}

void LongTests::operator()(std::span<const lightmesh::LongTestWord> words, std::span<std::uint64_t> seen,
                           const std::atomic<bool>* cancel) {
    words_.find(words, seen, cancel, [](const lightmesh::LongTestWord& word) {
        return static_cast<std::uint64_t>(std::popcount(word.points));
    });
}

}  // namespace demo
