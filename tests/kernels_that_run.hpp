// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/kernels/kernels.hpp>
#include <lightmesh/query/kernels/kernels.hpp>

#include <vector>

namespace test {

/// All kernels that this processor can run.
inline std::vector<const lightmesh::detail::Kernels*> kernels_that_run() {
    std::vector<const lightmesh::detail::Kernels*> all{&lightmesh::detail::portable_kernels};
#if defined(LIGHTMESH_HAS_AVX2_KERNEL)
    if (lightmesh::detail::can_run_avx2())
        all.push_back(&lightmesh::detail::avx2_kernels);
#endif
#if defined(LIGHTMESH_HAS_AVX512_KERNEL)
    if (lightmesh::detail::can_run_avx512())
        all.push_back(&lightmesh::detail::avx512_kernels);
#endif
    return all;
}

/// The same of a visibility cache.
inline std::vector<const lightmesh::detail::CacheKernels*> cache_kernels_that_run() {
    std::vector<const lightmesh::detail::CacheKernels*> all{&lightmesh::detail::portable_cache_kernels};
#if defined(LIGHTMESH_HAS_AVX2_KERNEL)
    if (lightmesh::detail::can_run_avx2())
        all.push_back(&lightmesh::detail::avx2_cache_kernels);
#endif
    return all;
}

}  // namespace test
