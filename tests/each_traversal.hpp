// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"

#include <doctest/doctest.h>

#include <stdexcept>
#include <string>

namespace test {

/// True if the device of tests has ray queries, as Mesa's lavapipe from 24.1 on.
inline bool there_are_ray_queries() {
    static const bool are_there = [] {
        try {
            return demo::ComputeDevice({.ray_queries = true}).has_ray_queries();
        } catch (const std::runtime_error& error) {
            if (std::string(error.what()).find("has no ray queries") == std::string::npos)
                throw;
            MESSAGE(error.what());
            return false;
        }
    }();
    return are_there;
}

/// The options for a device, in a test that is run once for each of shaders' traversals that there are: it
/// must begin with this, and have no other subcases.
inline demo::ComputeOptions each_traversal() {
    demo::ComputeOptions options{.ray_queries = false};
    SUBCASE("through a BVH") {}
    if (there_are_ray_queries()) {
        SUBCASE("by ray queries") {
            options.ray_queries = true;
        }
    }
    return options;
}

}  // namespace test
