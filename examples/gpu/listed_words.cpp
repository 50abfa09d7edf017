// SPDX-License-Identifier: MIT
#include "gpu/listed_words.hpp"

namespace demo {

namespace {

constexpr std::uint32_t link_words[] = {
#include "spirv/link_tests.comp.inc"
};
constexpr std::uint32_t long_test_words[] = {
#include "spirv/long_tests.comp.inc"
};

}  // namespace

std::span<const std::uint32_t> LinkKind::shader() {
    return link_words;
}

std::span<const std::uint32_t> LongTestKind::shader() {
    return long_test_words;
}

}  // namespace demo
