// SPDX-License-Identifier: MIT

// A second file of the same program that includes all of the library and uses it: what is defined twice does
// not link.

#include "blank_adapters.hpp"

#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/gpu/upload.hpp>
#include <lightmesh/lightmesh.hpp>
#include <lightmesh/tune.hpp>

float sum_in_another_file();

float sum_in_another_file() {
    return test::all_else_is_open() ? test::sum_of_meshes() : 0.0f;
}
