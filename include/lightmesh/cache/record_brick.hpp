// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/record.hpp>

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace lightmesh::detail {

/// Four records of a brick. Those that are there have tags, which say where in the brick they belong.
struct alignas(8) RecordGroup {
    static constexpr std::size_t size = 4;

    /// The tags, a byte each, 0 where there is no record; and 32 bits higher, where the next group stands in
    /// the pool, or 0.
    std::atomic<std::uint64_t> header{0};
    std::array<Record, size> records;

    static std::uint32_t next_of(std::uint64_t header) { return static_cast<std::uint32_t>(header >> 32); }
    static std::uint32_t tag_of(std::uint64_t header, std::size_t i) {
        return static_cast<std::uint32_t>(header >> 8 * i & 255u);
    }
    static bool has_tags(std::uint64_t header) { return static_cast<std::uint32_t>(header) != 0; }

    /// The number of the record that has a tag, or `size`; of tag 0 that of a free one.
    static std::size_t find(std::uint64_t header, std::uint32_t tag) {
        // The lowest byte that is 0 is found without a doubt, and no other is asked for.
        const std::uint32_t apart = static_cast<std::uint32_t>(header) ^ tag * 0x01010101u;
        const std::uint32_t zeros = (apart - 0x01010101u) & ~apart & 0x80808080u;
        return static_cast<std::size_t>(std::countr_zero(zeros)) / 8;
    }

    /// Makes a copy of a record found under a tag, in the place of a free one.
    void put(std::size_t i, std::uint32_t tag, const Record& record) {
        records[i] = record;
        header.fetch_or(static_cast<std::uint64_t>(tag) << 8 * i, std::memory_order_release);
    }
    /// Nobody may use the group meanwhile.
    void take_out(std::size_t i) {
        records[i] = Record();
        header.fetch_and(~(std::uint64_t{255} << 8 * i), std::memory_order_relaxed);
    }
};

/// The records of 4 x 4 x 4 lattice points of one level and one facing, of all kinds: most of their keys is
/// the same. Records are only ever added while there is more than one thread.
struct alignas(8) RecordBrick {
    RecordKey key;  ///< as of a fallen record at the least indices
    /// The last frame, modulo 2^16, in which a query asked for one of them.
    std::atomic<std::uint16_t> used{0};
    RecordGroup first;

    /// The key of a record's brick.
    static RecordKey key_of(const RecordKey& record) {
        RecordKey key;
        key.words[0] = (record.words[0] & RecordKey::index_mask & ~3u) | record.what() % 6 << 27;
        key.words[1] = record.words[1] & ~3u;
        key.words[2] = record.words[2] & ~3u;
        return key;
    }
    /// The number that tells a record from others of its brick, 1 to 192.
    static std::uint32_t tag_of(const RecordKey& record) {
        return 1 + (record.words[0] & 3u) + 4 * (record.words[1] & 3u) + 16 * (record.words[2] & 3u) +
               64 * (record.what() / 6);
    }
    RecordKey record_key(std::uint32_t tag) const {
        const std::uint32_t number = tag - 1;
        RecordKey record = key;
        record.words[0] += (number & 3u) + (6 * (number >> 6) << 27);
        record.words[1] += number >> 2 & 3u;
        record.words[2] += number >> 4 & 3u;
        return record;
    }
};

}  // namespace lightmesh::detail
