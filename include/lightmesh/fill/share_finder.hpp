// SPDX-License-Identifier: MIT
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh {

/// The caller's own shaders that find shares of lamps, for `VisibilityCache::fill_shares`:
///
///     void find(std::span<const std::byte> work, std::span<std::uint32_t> found);
///
/// `work` is what lamp_shares.glsl reads, a storage buffer, of up to 18 MiB and 64 bytes for each light;
/// `found` what it has written to the other one, from 1 to `most_listed_shares` words. The answers of the
/// shaders' tracer should be those of the cache's `Intersector`. What it throws leaves `fill_shares`, and
/// nothing is stored of what the call was about.
template <class Find>
concept ShareFinder = std::invocable<Find&, std::span<const std::byte>, std::span<std::uint32_t>>;

/// The most shares of a call of a `ShareFinder`.
inline constexpr std::size_t most_listed_shares = std::size_t{1} << 17;

}  // namespace lightmesh
