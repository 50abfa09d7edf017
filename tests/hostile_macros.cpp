// SPDX-License-Identifier: MIT

// The library after headers that leave macros behind: those of <windows.h>, X11 and the math library. What
// the library itself includes comes first, since the macros break the standard library and GLM too.

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#undef PI
#undef M_PI
#define near
#define far
#define min(a, b) (((a) < (b)) ? (a) : (b))
#define max(a, b) (((a) > (b)) ? (a) : (b))
#define PI 3.14
#define M_PI 3.14
#define TWO_PI 6.28
#define EPSILON 1e-3
#define IN
#define OUT
#define OPTIONAL
#define CONST const
#define VOID void
#define TRUE 1
#define FALSE 0
#define ERROR 0
#define DELETE 0x10000L
#define DIFFERENCE 11
#define OPAQUE 2
#define TRANSPARENT 1
#define small char
#define hyper long long
#define interface struct
#define Yield()
#define GetObject GetObjectA
#define None 0L
#define Bool int
#define Status int
#define Success 0
#define True 1
#define False 0
#define Always 2
#define Complex 0
#define Unsorted 0
#define unix 1
#define linux 1
#define major(x) (x)
#define minor(x) (x)

#include "blank_adapters.hpp"

#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/gpu/upload.hpp>
#include <lightmesh/lightmesh.hpp>
#include <lightmesh/tune.hpp>

float sum_under_hostile_macros();

float sum_under_hostile_macros() {
    // Blank tracers block nothing: one sentence each.
    const auto make_tracer = [](std::span<const std::array<glm::vec3, 3>>) {
        return test::BlankTracer{};
    };
    const bool is_told = lightmesh::check_tracer(test::BlankTracer{}, lightmesh::Bounds{}).size() == 1 &&
                         !lightmesh::check_tracer(make_tracer).empty();
    return is_told && test::all_else_is_open() ? test::sum_of_meshes() : 0.0f;
}
