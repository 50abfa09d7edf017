// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// The kind of a record: fallen onto a surface against one of six facings, in the air at a lattice point, or
/// of a cell of four columns (a probe, one for each of the six facings).
enum class RecordKind : std::uint32_t {
    fallen = 0,  // + facing
    air = 6,     // + facing
    probe = 12,  // + facing
};

/// The side of surfaces that records are on: sign * axis; they fall along -sign * axis.
struct Facing {
    int axis = 0;
    float sign = 1.0f;  ///< of the surface's normal along the axis

    bool operator==(const Facing& other) const = default;
    std::uint32_t number() const { return static_cast<std::uint32_t>(2 * axis) + (sign < 0.0f ? 1u : 0u); }
    int u() const { return axis == 2 ? 0 : axis + 1; }
    int v() const { return axis == 0 ? 2 : axis - 1; }
    glm::vec3 up() const {
        glm::vec3 direction(0.0f);
        direction[axis] = sign;
        return direction;
    }
};

/// A record's lattice point, kind and level: all that its contents depend on, but for the lights.
struct RecordKey {
    std::uint32_t words[3] = {};

    RecordKey() = default;
    RecordKey(const glm::ivec3& index, RecordKind kind, const Facing& facing, int level) {
        const std::uint32_t what = static_cast<std::uint32_t>(kind) + facing.number();  // 5 bits
        words[0] = (static_cast<std::uint32_t>(index.x) & index_mask) | what << 27;
        words[1] = (static_cast<std::uint32_t>(index.y) & index_mask) | static_cast<std::uint32_t>(level)
                                                                            << 27;
        words[2] = static_cast<std::uint32_t>(index.z) & index_mask;
    }

    int level() const { return static_cast<int>(words[1] >> 27); }
    /// Of all kinds and facings, below `kind_count`.
    std::uint32_t what() const { return words[0] >> 27; }
    static constexpr std::uint32_t kind_count = 18;
    bool is_probe() const { return what() >= static_cast<std::uint32_t>(RecordKind::probe); }
    Facing facing() const { return {static_cast<int>(what() % 6 / 2), what() % 2 == 0 ? 1.0f : -1.0f}; }
    glm::ivec3 index() const {
        const auto extended = [](std::uint32_t word) {
            return static_cast<std::int32_t>(word << 5) >> 5;
        };
        return {extended(words[0]), extended(words[1]), extended(words[2])};
    }
    bool operator==(const RecordKey& other) const {
        return ((words[0] ^ other.words[0]) | (words[1] ^ other.words[1]) | (words[2] ^ other.words[2])) == 0;
    }

    /// The number of steps by which the lattice point of another key is farther down, of the same column.
    int steps_to(const RecordKey& lower) const {
        const Facing along = facing();
        return (index()[along.axis] - lower.index()[along.axis]) * static_cast<int>(along.sign);
    }
    /// The key of the lattice point so many steps farther down.
    RecordKey below(int steps) const {
        RecordKey key = *this;
        const int axis = facing().axis;
        const auto index =
            static_cast<std::uint32_t>(this->index()[axis] - steps * static_cast<int>(facing().sign));
        key.words[axis] = (words[axis] & ~index_mask) | (index & index_mask);
        return key;
    }

    static constexpr std::uint32_t index_mask = (1u << 27) - 1u;
};

/// The mixing step of SplitMix64 (Steele, Lea and Flood 2014).
inline std::uint64_t mix_bits(std::uint64_t bits) {
    bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
    bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
    return bits ^ bits >> 31;
}

inline std::uint64_t hash_of(const RecordKey& key) {
    return mix_bits((key.words[0] | static_cast<std::uint64_t>(key.words[1]) << 32) ^
                    key.words[2] * 0x9e3779b97f4a7c15u);
}

/// A place that visibilities are kept for. Everything but links and rows is final before the record can be
/// found.
struct alignas(8) Record {
    /// The first of its row blocks; 0: none.
    std::atomic<std::uint32_t> rows{0};
    /// The distance from its lattice point against its facing, world units; negative: it found no surface,
    /// and lies at the lattice point. Of an alias how many steps farther down the lattice point of its record
    /// is.
    float fall = -1.0f;
    /// The geometric normal there times 32767, on the side of the lattice point.
    std::int16_t normal[3] = {};
    /// True if the segments to two neighbouring lattice points are known to be free: see `link_bit`.
    std::atomic<std::uint16_t> links{0};

    /// Among the links of an alias: a lattice point whose record is the one of a nearer lattice point in the
    /// same column.
    static constexpr std::uint16_t alias_bit = 1u << 15;

    Record() = default;
    Record(const Record& other) { *this = other; }
    /// For records that nobody else uses meanwhile.
    Record& operator=(const Record& other) {
        if (this == &other)
            return *this;
        rows.store(other.rows.load(std::memory_order_relaxed), std::memory_order_relaxed);
        fall = other.fall;
        for (int k = 0; k < 3; ++k)
            normal[k] = other.normal[k];
        links.store(other.links.load(std::memory_order_relaxed), std::memory_order_relaxed);
        return *this;
    }

    bool is_alias() const { return (links.load(std::memory_order_relaxed) & alias_bit) != 0; }
    bool is_on_surface() const { return fall >= 0.0f; }
    glm::vec3 unit_normal() const { return glm::vec3(normal[0], normal[1], normal[2]) * (1.0f / 32767.0f); }
    void set_normal(const glm::vec3& unit) {
        for (int k = 0; k < 3; ++k)
            normal[k] = static_cast<std::int16_t>(std::lround(unit[k] * 32767.0f));
    }
};

/// The place in `Record::links` of the link to the neighbour at +1 along u (direction 0) or v (1), and at
/// -1, 0 or +1 along the record's axis; the bit six places higher says that it is open.
inline int link_bit(int direction, int rise) {
    return 3 * direction + rise + 1;
}

}  // namespace lightmesh::detail
