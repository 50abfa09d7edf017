// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

namespace demo {

// The plan of the storey, in metres.

inline constexpr int rooms_per_side = 6;
inline constexpr float room_size = 6.0f;
inline constexpr float wall_height = 3.0f;
inline constexpr float half_wall = 0.04f;
inline constexpr float door_half_width = 0.55f;
inline constexpr float door_height = 2.1f;
inline constexpr float half_storey = 0.5f * room_size * rooms_per_side;

/// The place of a wall's doorway, measured along the wall from the middle of the room.
inline float door_offset(int column, int row, bool along_x) {
    return 0.7f * static_cast<float>((column * 7 + row * 3 + (along_x ? 1 : 0)) % 5 - 2);
}

/// On the floor.
inline glm::vec3 room_middle(int column, int row) {
    return {(static_cast<float>(column) + 0.5f) * room_size - half_storey,
            (static_cast<float>(row) + 0.5f) * room_size - half_storey, 0.0f};
}

/// The middle of the wall between a room and the one before it in its row (`along_x` false: the wall runs
/// along y) or in its column.
inline glm::vec3 wall_middle(int column, int row, bool along_x) {
    const glm::vec3 aside = along_x ? glm::vec3{0, 0.5f * room_size, 0} : glm::vec3{0.5f * room_size, 0, 0};
    return room_middle(column, row) - aside;
}

}  // namespace demo
