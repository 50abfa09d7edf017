// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace lightmesh::detail {

/// Blocks from this size on are worth large pages, in bytes.
inline constexpr std::size_t huge_block_bytes = std::size_t{1} << 22;

/// Tells the system that a block is about to be written, mostly all of it, so that it may give large pages: a
/// fault for each small one takes longer than writing it. Changes nothing else, and nothing where the block
/// is small or the system has no such pages.
inline void prefer_huge_pages([[maybe_unused]] void* first, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    if (bytes < huge_block_bytes)
        return;
    // From the beginning of a page, as Linux wants it: what stands there before the block is not hurt.
    // Systems with greater pages do not take the advice.
    constexpr std::size_t page = 4096;
    const std::size_t before = reinterpret_cast<std::uintptr_t>(first) % page;
    // Advice that is not taken is no error.
    static_cast<void>(madvise(static_cast<std::byte*>(first) - before, bytes + before, MADV_HUGEPAGE));
#endif
}

}  // namespace lightmesh::detail
