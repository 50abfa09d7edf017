// SPDX-License-Identifier: MIT
#pragma once

namespace lightmesh::detail {

/// Has a line of memory fetched that is read a little later; any address will do.
inline void prefetch([[maybe_unused]] const void* address) {
#if defined(__GNUC__)
    __builtin_prefetch(address);
#endif
}

}  // namespace lightmesh::detail
