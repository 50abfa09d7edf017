// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/query/kernels/avx2.hpp>
#include <lightmesh/query/kernels/avx512.hpp>
#include <lightmesh/query/kernels/portable.hpp>

namespace lightmesh::detail {

/// The fastest kernel that the compiler's own target flags allow.
#if defined(LIGHTMESH_HAS_AVX512_KERNEL)
using FastestKernel = Avx512Kernel;
#elif defined(LIGHTMESH_HAS_AVX2_KERNEL)
using FastestKernel = Avx2Kernel;
#else
using FastestKernel = PortableKernel;
#endif

}  // namespace lightmesh::detail
