// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace demo {

/// A number that differs, but by accident, for scenes with different shadows: of their triangles, of what
/// lets light through, and of the places of lights.
std::uint64_t shadow_fingerprint(const Scene& scene);

/// As `shadow_fingerprint`, for scenes that look different.
std::uint64_t look_fingerprint(const Scene& scene);

/// Writes a light mesh's snapshot with the fingerprint of its scene: a snapshot alone cannot tell whether an
/// empty mesh is of the same triangles. The file is whole at any time: the old one or the new one. Throws
/// std::runtime_error that names it if it cannot be written.
void save_mesh(const std::filesystem::path& file, std::span<const std::byte> snapshot, const Scene& scene);

/// The snapshot in a file. Throws std::runtime_error that names the file and says what is wrong: it cannot be
/// read, is damaged, or is of another scene.
std::vector<std::byte> load_mesh(const std::filesystem::path& file, const Scene& scene);

}  // namespace demo
