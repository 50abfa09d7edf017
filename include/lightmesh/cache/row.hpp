// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lanes.hpp>
#include <lightmesh/cache/pool.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Lights are handled in tiles of 64, and their visibilities, a byte each, in octets of 8 lights.
inline constexpr std::size_t lamps_per_tile = 64;

/// Values of a tile's lights, a byte each.
using TileValues = std::array<std::uint8_t, lamps_per_tile>;

/// The visibilities of a tile of lights at one record, as far as they are known: eight bytes an octet, the
/// first light's in the lowest, 0 until they are known.
struct RowBytes {
    std::uint64_t known;  ///< one bit for each light
    std::array<std::uint64_t, 8> octets;

    std::uint8_t byte(std::size_t l) const { return static_cast<std::uint8_t>(octets[l / 8] >> l % 8 * 8); }
};

/// A byte of a shaft row. 0 and 255: all of the lamp is closed or open, also for what lies around the record.
/// Others are odd where the record does not tell what lies around it, and even where it does. 1 and 253 stand
/// for 0 and 255.
inline std::uint8_t shaft_byte(std::uint8_t value, bool misses) {
    if (!misses)
        return value == 0 || value == 255 ? value : static_cast<std::uint8_t>((std::max)(value & 254, 2));
    return value == 0 ? 1 : value == 255 ? 253 : static_cast<std::uint8_t>(std::clamp(value | 1, 3, 251));
}

/// Reads eight of those: makes them plain values, and returns a bit for each that misses something.
inline std::uint32_t read_shaft_bytes(std::uint64_t& bytes) {
    constexpr std::uint64_t ones = 0x0101010101010101u;
    constexpr std::uint64_t low_bits = 0x7f7f7f7f7f7f7f7fu;
    // In the lowest bit of each byte.
    const auto is_zero = [](std::uint64_t b) {
        return ~(((b & low_bits) + low_bits) | b) >> 7 & ones;
    };
    if ((bytes & ones) == 0)
        return 0;
    const std::uint64_t misses = bytes & ones & ~is_zero(~bytes);
    if (misses == 0)
        return 0;
    bytes = (bytes & ~is_zero(bytes ^ ones)) | is_zero(bytes ^ ones * 253u) << 1;
    return static_cast<std::uint32_t>(gather_low_bits(misses));
}

/// The same for a row.
inline std::uint64_t read_shaft_bytes(RowBytes& row) {
    std::uint64_t misses = 0;
    for (std::size_t o = 0; o < 8; ++o)
        misses |= std::uint64_t{read_shaft_bytes(row.octets[o])} << 8 * o;
    return misses;
}

inline TileValues values_of(const RowBytes& row) {
    TileValues values;
    for (std::size_t l = 0; l < lamps_per_tile; ++l)
        values[l] = row.byte(l);
    return values;
}

/// The octets of the lights in a mask.
inline std::uint32_t octets_of(std::uint64_t lights) {
    constexpr std::uint64_t low_bits = 0x7f7f7f7f7f7f7f7fu;
    const std::uint64_t highest = (((lights & low_bits) + low_bits) | lights) >> 7 & 0x0101010101010101u;
    return static_cast<std::uint32_t>(highest * 0x0102040810204080u >> 56);
}

/// The lights of some octets.
inline std::uint64_t lights_of(std::uint32_t octets) {
    std::uint64_t lights = 0;
    for (int o = 0; o < 8; ++o)
        lights |= std::uint64_t{(octets >> o & 1u) * 255u} << 8 * o;
    return lights;
}

/// Eight bytes, 255 where a bit is set.
inline std::uint64_t bytes_of(std::uint64_t bits) {
    const std::uint64_t apart = bits * 0x0101010101010101u & 0x8040201008040201u;
    return ((apart + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u) * 255u;
}

/// The rows of a record: a list of blocks in the pool. Most values are 0 or 255, closed or open, and take a
/// bit; others take a byte. A block begins with a word, its head:
///
///     bits of an octet    next block: 30 bits, 1, tile: 14, octet: 3, known lights: 8, open ones: 8
///     bits of a tile      next block: 30 bits, 0, tile: 16, 1; a word of known lights, one of open ones
///     bytes               next block: 30 bits, 0, tile: 16, 0, first octet: 3, number of octets less one: 3,
///                         if that is one its known lights: 8; else a word of known lights; the octets
///
/// Blocks are only ever added, at the front; no two have bytes of the same octet. A light may be known in
/// several. Bits and bytes are 0 until they are known, and are or-ed in: what two threads find at once is the
/// same.
class RowList {
public:
    RowList(UnitPool& pool, std::atomic<std::uint32_t>& front) : pool_(pool), front_(front) {}

    /// All that is known of a tile.
    RowBytes gather(std::size_t tile) const {
        RowBytes row{};
        for_each_block([&](const Block& block) {
            if (block.tile() != tile)
                return;
            row.known |= block.known();
            const std::size_t first = block.first();
            if (block.is_octet_of_bits()) {
                row.octets[first] |= bytes_of(block.head >> open_shift);
                return;
            }
            if (block.is_tile_of_bits()) {
                const std::uint64_t open = block.words[2].load(std::memory_order_relaxed);
                for (std::size_t o = 0; o < 8; ++o)
                    row.octets[o] |= bytes_of(open >> 8 * o & 255u);
                return;
            }
            const std::size_t count = block.count();
            const std::atomic<std::uint64_t>* octets = block.octets();
            for (std::size_t o = 0; o < count; ++o)
                row.octets[first + o] |= octets[o].load(std::memory_order_relaxed);
        });
        return row;
    }

    /// Calls visit(tile, lights) for each block: those of its lights that are known. A tile may come again.
    template <class Visitor>
    void for_each(Visitor&& visit) const {
        for_each_block([&](const Block& block) { visit(block.tile(), block.known()); });
    }

    /// Makes the values of some lights of a tile known. Throws std::bad_alloc; then none of them is. Returns
    /// the number of octets for which there is room now and was none.
    std::size_t add(std::size_t tile, std::uint64_t lights, const TileValues& values) {
        std::uint64_t grey = 0;
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(rest));
            if (values[l] != 0 && values[l] != 255)
                grey |= rest & (~rest + 1u);
        }
        std::size_t added = 0;
        const std::uint64_t in_bytes = make_room(tile, octets_of(lights), octets_of(grey), added);
        for_each_block([&](const Block& block) {
            if (block.tile() == tile)
                publish(block, block.is_bits() ? lights & ~in_bytes : lights & in_bytes, values);
        });
        return added;
    }

    /// Makes lights of a tile unknown again; their room stays. Returns how many were known. Nobody may use
    /// the record meanwhile.
    std::size_t forget(std::size_t tile, std::uint64_t lights) {
        std::uint64_t forgotten = 0;
        for_each_block([&](const Block& block) {
            const std::uint64_t gone = block.known() & lights;
            if (gone == 0 || block.tile() != tile)
                return;
            forgotten |= gone;
            if (block.has_known_in_head()) {
                const std::uint64_t of_octet = gone >> 8 * block.first() & 255u;
                const std::uint64_t open = block.is_bits() ? of_octet << open_shift : 0;
                block.words[0].fetch_and(~(of_octet << block.known_shift() | open),
                                         std::memory_order_relaxed);
            } else {
                block.words[1].fetch_and(~gone, std::memory_order_relaxed);
            }
            if (block.is_tile_of_bits())
                block.words[2].fetch_and(~gone, std::memory_order_relaxed);
            for (std::size_t o = 0; o < block.count() && !block.is_bits(); ++o)
                block.octets()[o].fetch_and(~bytes_of(gone >> 8 * (block.first() + o) & 255u),
                                            std::memory_order_relaxed);
        });
        return static_cast<std::size_t>(std::popcount(forgotten));
    }

    /// Gives all blocks back to the pool. Nobody may use the record meanwhile. Returns for how many octets
    /// they had room.
    std::size_t give_back() {
        std::size_t octets = 0;
        for (std::uint32_t at = front_.exchange(0, std::memory_order_relaxed); at != 0;) {
            const Block block(pool_, at);
            octets += block.count();
            pool_.give_back(at, block.size());
            at = block.next();
        }
        return octets;
    }

private:
    static constexpr std::uint64_t next_mask = (1u << 30) - 1u;
    static constexpr std::uint64_t octet_of_bits = 1u << 30;
    static constexpr int tile_shift = 31;
    static constexpr int bits_octet_shift = 45;
    static constexpr std::uint64_t tile_of_bits = std::uint64_t{1} << 47;
    static constexpr int first_shift = 48;
    static constexpr int count_shift = 51;
    static constexpr int open_shift = 56;
    static constexpr std::size_t few_tiles = 1u << 14;  ///< that heads of bits of octets can name
    static_assert(static_cast<std::uint64_t>(UnitPool::chunk_limit) * UnitPool::chunk_units <= next_mask + 1);

    /// A block, or, without words, what its head says.
    struct Block {
        explicit Block(std::uint64_t head_alone) : words(nullptr), head(head_alone) {}
        Block(const UnitPool& pool, std::uint32_t at)
            : words(pool.at(at)), head(words[0].load(std::memory_order_acquire)) {}

        std::atomic<std::uint64_t>* words;
        std::uint64_t head;

        std::uint32_t next() const { return static_cast<std::uint32_t>(head & next_mask); }
        bool is_octet_of_bits() const { return (head & octet_of_bits) != 0; }
        bool is_tile_of_bits() const { return !is_octet_of_bits() && (head & tile_of_bits) != 0; }
        bool is_bits() const { return is_octet_of_bits() || (head & tile_of_bits) != 0; }
        std::size_t tile() const {
            return head >> tile_shift & (is_octet_of_bits() ? few_tiles - 1u : 0xffffu);
        }
        std::size_t first() const {
            return is_octet_of_bits()  ? head >> bits_octet_shift & 7u
                   : is_tile_of_bits() ? 0
                                       : head >> first_shift & 7u;
        }
        /// Of octets.
        std::size_t count() const {
            return is_octet_of_bits() ? 1 : is_tile_of_bits() ? 8 : (head >> count_shift & 7u) + 1;
        }
        bool has_known_in_head() const { return count() == 1; }
        int known_shift() const { return is_octet_of_bits() ? 48 : 54; }
        std::uint64_t known() const {
            return has_known_in_head() ? (head >> known_shift() & 255u) << 8 * first()
                                       : words[1].load(std::memory_order_acquire);
        }
        std::atomic<std::uint64_t>* octets() const { return words + (has_known_in_head() ? 1 : 2); }
        /// In units of the pool.
        std::uint32_t size() const {
            return is_octet_of_bits()  ? 1
                   : is_tile_of_bits() ? 3
                                       : static_cast<std::uint32_t>(count() + (has_known_in_head() ? 1 : 2));
        }
    };

    template <class Visitor>
    void for_each_block(Visitor&& visit) const {
        for (std::uint32_t at = front_.load(std::memory_order_acquire); at != 0;) {
            const Block block(pool_, at);
            visit(block);
            at = block.next();
        }
    }

    /// Adds blocks, so that there is room for values of some octets, of which those in `grey` need bytes.
    /// Returns the lights that go there.
    std::uint64_t make_room(std::size_t tile, std::uint32_t octets, std::uint32_t grey, std::size_t& added) {
        for (;;) {
            const std::uint32_t front = front_.load(std::memory_order_acquire);
            std::uint32_t bits = 0;
            std::uint32_t bytes = 0;
            for (std::uint32_t at = front; at != 0;) {
                const Block block(pool_, at);
                if (block.tile() == tile)
                    (block.is_bits() ? bits : bytes) |= ((1u << block.count()) - 1u) << block.first();
                at = block.next();
            }
            const std::uint32_t lacking = octets & ~bytes & (grey | ~bits);
            if (lacking == 0)
                return lights_of(bytes);
            const std::uint64_t head =
                (lacking & grey) != 0 ? head_of_bytes(lacking & grey, bytes) : head_of_bits(lacking, tile);
            const std::uint32_t at = pool_.allocate(Block(head).size());
            pool_.at(at)[0].store(head | front | static_cast<std::uint64_t>(tile) << tile_shift,
                                  std::memory_order_relaxed);
            std::uint32_t expected = front;
            if (front_.compare_exchange_strong(expected, at, std::memory_order_acq_rel))
                added += Block(head).count();
        }
    }

    /// From the first octet as far as there is none with bytes in the way.
    static std::uint64_t head_of_bytes(std::uint32_t octets, std::uint32_t bytes) {
        const int first = std::countr_zero(octets);
        const std::uint32_t in_the_way = bytes >> first | 1u << (8 - first);
        const std::uint32_t wanted = octets >> first & ((1u << std::countr_zero(in_the_way)) - 1u);
        return static_cast<std::uint64_t>(first) << first_shift |
               static_cast<std::uint64_t>(std::bit_width(wanted) - 1) << count_shift;
    }
    static std::uint64_t head_of_bits(std::uint32_t octets, std::size_t tile) {
        if (std::popcount(octets) > 2 || tile >= few_tiles)
            return tile_of_bits;
        return octet_of_bits | static_cast<std::uint64_t>(std::countr_zero(octets)) << bits_octet_shift;
    }

    /// Makes those of some lights known for which a block has room.
    static void publish(const Block& block, std::uint64_t lights, const TileValues& values) {
        lights &= lights_of(((1u << block.count()) - 1u) << block.first());
        if (lights == 0)
            return;
        std::uint64_t open = 0;
        for (std::uint64_t rest = lights; rest != 0 && block.is_bits(); rest &= rest - 1)
            if (values[static_cast<std::size_t>(std::countr_zero(rest))] != 0)
                open |= rest & (~rest + 1u);
        if (block.is_octet_of_bits()) {
            const std::size_t down = 8 * block.first();
            block.words[0].fetch_or((lights >> down) << block.known_shift() | (open >> down) << open_shift,
                                    std::memory_order_release);
            return;
        }
        if (block.is_tile_of_bits())
            block.words[2].fetch_or(open, std::memory_order_relaxed);
        for (std::size_t o = 0; o < block.count() && !block.is_bits(); ++o) {
            std::uint64_t bytes = 0;
            for (std::size_t b = 0; b < 8; ++b)
                if (const std::size_t l = 8 * (block.first() + o) + b; (lights >> l & 1u) != 0)
                    bytes |= static_cast<std::uint64_t>(values[l]) << 8 * b;
            if (bytes != 0)
                block.octets()[o].fetch_or(bytes, std::memory_order_relaxed);
        }
        if (block.has_known_in_head())
            block.words[0].fetch_or((lights >> 8 * block.first()) << block.known_shift(),
                                    std::memory_order_release);
        else
            block.words[1].fetch_or(lights, std::memory_order_release);
    }

    UnitPool& pool_;
    std::atomic<std::uint32_t>& front_;
};

}  // namespace lightmesh::detail
