// SPDX-License-Identifier: MIT
#include "gpu/listed_words.hpp"

#include "spirv/link_tests.hpp"
#include "spirv/long_tests.hpp"

namespace demo {

RayShader LinkKind::shader() {
    return spirv::link_tests;
}

RayShader LongTestKind::shader() {
    return spirv::long_tests;
}

}  // namespace demo
