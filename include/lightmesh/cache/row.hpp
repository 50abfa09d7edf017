// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/pool.hpp>

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Lights are handled in tiles of 64, and their visibilities, a byte each, in octets of 8 lights.
inline constexpr std::size_t lamps_per_tile = 64;

/// The visibilities of a tile of lights at one record, as far as they are known: eight bytes an octet, the
/// first light's in the lowest, 0 until they are known.
struct RowBytes {
    std::uint64_t known = 0;  ///< one bit for each light
    std::array<std::uint64_t, 8> octets{};
};

/// Where the octets of a tile stand; null where no light of the octet is known.
struct TileRow {
    std::uint64_t known = 0;
    std::array<const std::atomic<std::uint64_t>*, 8> octets{};

    std::uint64_t octet(int o) const {
        return octets[static_cast<std::size_t>(o)]->load(std::memory_order_relaxed);
    }
    RowBytes bytes() const {
        RowBytes row;
        row.known = known;
        for (std::size_t o = 0; o < 8; ++o)
            if (octets[o] != nullptr)
                row.octets[o] = octets[o]->load(std::memory_order_relaxed);
        return row;
    }
};

/// The octets of the lights in a mask.
inline std::uint32_t octets_of(std::uint64_t lights) {
    std::uint32_t octets = 0;
    for (int o = 0; o < 8; ++o)
        octets |= static_cast<std::uint32_t>((lights >> 8 * o & 255u) != 0) << o;
    return octets;
}

/// The rows of a record: a list of blocks in the pool, each with some neighbouring octets of a tile. A block
/// is a word {next block: 32 bits, tile: 16, first octet: 8, number of octets: 8}, a word of known lights,
/// and its octets. Blocks are only ever added, at the head; no two have the same octet. Bytes are 0 until
/// they are known, and are or-ed in: what two threads find at once is the same.
class RowList {
public:
    RowList(UnitPool& pool, std::atomic<std::uint32_t>& head) : pool_(pool), head_(head) {}

    TileRow gather(std::size_t tile) const {
        TileRow row;
        for (std::uint32_t at = head_.load(std::memory_order_acquire); at != 0;) {
            const std::atomic<std::uint64_t>* block = pool_.at(at);
            const std::uint64_t header = block[0].load(std::memory_order_relaxed);
            if (tile_of(header) == tile) {
                row.known |= block[1].load(std::memory_order_acquire);
                for (std::size_t o = 0; o < count_of(header); ++o)
                    row.octets[first_of(header) + o] = block + 2 + o;
            }
            at = next_of(header);
        }
        return row;
    }

    /// Calls visit(tile, lights) for each block: those of its lights that are known. A tile may come again.
    template <class Visitor>
    void for_each(Visitor&& visit) const {
        for (std::uint32_t at = head_.load(std::memory_order_acquire); at != 0;) {
            const std::atomic<std::uint64_t>* block = pool_.at(at);
            const std::uint64_t header = block[0].load(std::memory_order_relaxed);
            visit(tile_of(header), block[1].load(std::memory_order_acquire));
            at = next_of(header);
        }
    }

    /// Adds blocks for octets that have none. Throws std::bad_alloc. Returns the number of octets added.
    std::size_t make_room(std::size_t tile, std::uint32_t octets) {
        std::size_t added = 0;
        for (;;) {
            const std::uint32_t head = head_.load(std::memory_order_acquire);
            std::uint32_t there = 0;
            const TileRow row = gather(tile);
            for (std::size_t o = 0; o < 8; ++o)
                there |= static_cast<std::uint32_t>(row.octets[o] != nullptr) << o;
            const std::uint32_t missing = octets & ~there;
            if (missing == 0)
                return added;
            // From the first missing octet as far as there is none in the way.
            const int first = std::countr_zero(missing);
            const std::uint32_t in_the_way = there >> first | 1u << (8 - first);
            const std::uint32_t wanted = missing >> first & ((1u << std::countr_zero(in_the_way)) - 1u);
            const auto count = static_cast<std::uint32_t>(std::bit_width(wanted));
            const std::uint32_t at = pool_.allocate(2 + count);
            pool_.at(at)[0].store(head | static_cast<std::uint64_t>(tile) << 32 |
                                      static_cast<std::uint64_t>(first) << 48 |
                                      static_cast<std::uint64_t>(count) << 56,
                                  std::memory_order_relaxed);
            std::uint32_t expected = head;
            if (head_.compare_exchange_strong(expected, at, std::memory_order_acq_rel))
                added += count;
        }
    }

    /// Makes the values of some lights of a tile known. Their octets have room.
    void publish(std::size_t tile, std::uint64_t lights,
                 const std::array<std::uint8_t, lamps_per_tile>& values) {
        for (std::uint32_t at = head_.load(std::memory_order_acquire); at != 0;) {
            std::atomic<std::uint64_t>* block = pool_.at(at);
            const std::uint64_t header = block[0].load(std::memory_order_relaxed);
            if (tile_of(header) == tile) {
                std::uint64_t stored = 0;
                for (std::size_t o = first_of(header); o < first_of(header) + count_of(header); ++o) {
                    std::uint64_t bytes = 0;
                    for (std::size_t b = 0; b < 8; ++b)
                        if ((lights >> (8 * o + b) & 1u) != 0)
                            bytes |= static_cast<std::uint64_t>(values[8 * o + b]) << 8 * b;
                    block[2 + o - first_of(header)].fetch_or(bytes, std::memory_order_relaxed);
                    stored |= lights & std::uint64_t{255} << 8 * o;
                }
                block[1].fetch_or(stored, std::memory_order_release);
            }
            at = next_of(header);
        }
    }

    /// Makes lights of a tile unknown again; their room stays. Returns how many were known. Nobody may use
    /// the record meanwhile.
    std::size_t forget(std::size_t tile, std::uint64_t lights) {
        std::size_t forgotten = 0;
        for (std::uint32_t at = head_.load(std::memory_order_relaxed); at != 0;) {
            std::atomic<std::uint64_t>* block = pool_.at(at);
            const std::uint64_t header = block[0].load(std::memory_order_relaxed);
            const std::uint64_t known = block[1].load(std::memory_order_relaxed);
            if (const std::uint64_t gone = known & lights; gone != 0 && tile_of(header) == tile) {
                forgotten += static_cast<std::size_t>(std::popcount(gone));
                block[1].store(known & ~gone, std::memory_order_relaxed);
                for (std::uint64_t rest = gone; rest != 0; rest &= rest - 1) {
                    const auto l = static_cast<std::size_t>(std::countr_zero(rest));
                    block[2 + l / 8 - first_of(header)].fetch_and(~(std::uint64_t{255} << l % 8 * 8),
                                                                  std::memory_order_relaxed);
                }
            }
            at = next_of(header);
        }
        return forgotten;
    }

    /// Gives all blocks back to the pool. Nobody may use the record meanwhile. Returns how many octets they
    /// had.
    std::size_t give_back() {
        std::size_t octets = 0;
        for (std::uint32_t at = head_.exchange(0, std::memory_order_relaxed); at != 0;) {
            const std::uint64_t header = pool_.at(at)[0].load(std::memory_order_relaxed);
            octets += count_of(header);
            pool_.give_back(at, static_cast<std::uint32_t>(2 + count_of(header)));
            at = next_of(header);
        }
        return octets;
    }

private:
    static std::uint32_t next_of(std::uint64_t header) { return static_cast<std::uint32_t>(header); }
    static std::size_t tile_of(std::uint64_t header) { return header >> 32 & 0xffffu; }
    static std::size_t first_of(std::uint64_t header) { return header >> 48 & 0xffu; }
    static std::size_t count_of(std::uint64_t header) { return header >> 56; }

    UnitPool& pool_;
    std::atomic<std::uint32_t>& head_;
};

}  // namespace lightmesh::detail
