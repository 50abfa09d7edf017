// SPDX-License-Identifier: MIT
#include "random_scene.hpp"

#include <lightmesh/cache/pool.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_table.hpp>
#include <lightmesh/cache/row.hpp>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <thread>
#include <tuple>
#include <vector>

namespace cache_store_test {

namespace {

using lightmesh::detail::Facing;
using lightmesh::detail::Record;
using lightmesh::detail::RecordEntry;
using lightmesh::detail::RecordKey;
using lightmesh::detail::RecordKind;
using lightmesh::detail::RecordTable;
using lightmesh::detail::RowBytes;
using lightmesh::detail::RowList;
using lightmesh::detail::TileValues;
using lightmesh::detail::UnitPool;

/// What a row knows: a value for each light.
using PlainRow = std::map<std::size_t, std::uint8_t>;

bool equals(const RowBytes& row, const PlainRow& plain) {
    for (std::size_t l = 0; l < 64; ++l) {
        const auto known = plain.find(l);
        if ((row.known >> l & 1u) != (known != plain.end() ? 1u : 0u))
            return false;
        if (row.byte(l) != (known != plain.end() ? known->second : 0))
            return false;
    }
    return true;
}

std::uint8_t random_value(test::Random& random, double grey) {
    const double turn = random.uniform(0.0, 1.0);
    return turn < grey                 ? static_cast<std::uint8_t>(random.uniform(0.0, 256.0))
           : turn < 0.5 * (1.0 + grey) ? 0
                                       : 255;
}

using Words = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;
Words words_of(const RecordKey& key) {
    return {key.words[0], key.words[1], key.words[2]};
}

RecordKey random_key(test::Random& random, double size) {
    const glm::ivec3 index(random.in_box(test::Vec(-size), test::Vec(size)));
    constexpr std::array kinds{RecordKind::fallen, RecordKind::air, RecordKind::probe};
    return {index, kinds[static_cast<std::size_t>(random.uniform(0.0, 3.0))],
            Facing{static_cast<int>(random.uniform(0.0, 3.0)), random.uniform(0.0, 1.0) < 0.5 ? 1.0f : -1.0f},
            static_cast<int>(random.uniform(8.0, 11.0))};
}

/// A record that can be told from others.
Record numbered(int number) {
    Record record;
    record.fall = static_cast<float>(number);
    return record;
}

}  // namespace

TEST_CASE("cache store: rows keep what is added, light by light, and forget what they are told to") {
    test::Random random(5);
    UnitPool pool;
    for (const double grey : {0.0, 0.02, 0.3, 1.0})
        for (int turn = 0; turn < 60; ++turn) {
            std::atomic<std::uint32_t> front{0};
            RowList list(pool, front);
            // The last one is farther than the shortest blocks can say.
            constexpr std::array<std::size_t, 3> tiles{0, 7, 40000};
            std::map<std::size_t, PlainRow> plain;
            std::size_t octets = 0;
            for (int step = 0; step < 12; ++step) {
                const std::size_t tile = tiles[static_cast<std::size_t>(random.uniform(0.0, 3.0))];
                PlainRow& row = plain[tile];
                const double share = random.uniform(0.0, 1.0) < 0.5 ? 0.05 : 0.6;
                std::uint64_t lights = 0;
                TileValues values{};
                for (std::size_t l = 0; l < 64; ++l)
                    if (random.uniform(0.0, 1.0) < share && !row.contains(l)) {
                        lights |= std::uint64_t{1} << l;
                        values[l] = row[l] = random_value(random, grey);
                    }
                octets += list.add(tile, lights, values);
                if (step % 4 == 3) {
                    std::uint64_t gone = 0;
                    std::size_t count = 0;
                    for (std::size_t l = 0; l < 64; ++l)
                        if (random.uniform(0.0, 1.0) < 0.2) {
                            gone |= std::uint64_t{1} << l;
                            count += row.erase(l);
                        }
                    CHECK(list.forget(tile, gone) == count);
                }
                for (const auto& [t, expected] : plain)
                    CHECK(equals(list.gather(t), expected));
            }
            std::map<std::size_t, std::uint64_t> known;
            list.for_each([&](std::size_t tile, std::uint64_t lights) { known[tile] |= lights; });
            for (const auto& [tile, row] : plain)
                CHECK(known[tile] == list.gather(tile).known);
            CHECK(list.give_back() == octets);
            CHECK(front == 0);
        }
}

TEST_CASE("cache store: closed and open lights take fewer bytes than others") {
    const auto bytes_with = [](std::uint8_t value) {
        UnitPool pool;
        const std::size_t before = pool.bytes();
        for (int i = 0; i < 200000; ++i) {
            std::atomic<std::uint32_t> front{0};
            TileValues values{};
            values.fill(value);
            RowList(pool, front).add(0, 0xff, values);
        }
        return pool.bytes() - before;
    };
    CHECK(bytes_with(255) * 10 < bytes_with(100) * 6);
}

TEST_CASE("cache store: bytes of shaft rows tell values and whether they miss something") {
    for (int value = 0; value < 256; ++value)
        for (const bool misses : {false, true})
            for (int at = 0; at < 8; ++at) {
                // Among others that must stay as they are.
                std::uint64_t bytes = 0xff'00'80'01'fe'02'03'fdu;
                std::uint64_t expected = 0xff'00'80'00'fe'02'03'ffu;
                std::uint32_t marks = 0b0001'0011u;
                const std::uint64_t lane = std::uint64_t{255} << 8 * at;
                const std::uint8_t byte =
                    lightmesh::detail::shaft_byte(static_cast<std::uint8_t>(value), misses);
                bytes = (bytes & ~lane) | static_cast<std::uint64_t>(byte) << 8 * at;
                marks = (marks & ~(1u << at)) | (misses ? 1u : 0u) << at;
                CHECK(lightmesh::detail::read_shaft_bytes(bytes) == marks);
                const int read = static_cast<int>(bytes >> 8 * at & 255u);
                CHECK(std::abs(read - value) <= (value > 250 && misses ? 4 : 2));
                if (value == 0 || value == 255)
                    CHECK(read == value);
                CHECK((bytes & ~lane) == (expected & ~lane));
                // Only what is the same all around is 0 or 255.
                CHECK((byte == 0 || byte == 255) == (!misses && (value == 0 || value == 255)));
            }
}

TEST_CASE("cache store: rows that threads add to at once hold what all of them added") {
    UnitPool pool;
    for (int turn = 0; turn < 40; ++turn) {
        std::atomic<std::uint32_t> front{0};
        TileValues values{};
        for (std::size_t l = 0; l < 64; ++l)
            values[l] = static_cast<std::uint8_t>(l % 3 == 0 ? 255 : l % 7 == 0 ? l : 0);
        {
            std::vector<std::jthread> threads;
            for (std::uint64_t t = 0; t < 4; ++t)
                threads.emplace_back([&, t] {
                    for (std::uint64_t i = 0; i < 16; ++i) {
                        const std::uint64_t lights = std::uint64_t{5} << (i * (2 * t + 3) + 7 * t) % 62;
                        RowList(pool, front).add(0, lights, values);
                    }
                });
        }
        const RowBytes row = RowList(pool, front).gather(0);
        CHECK(row.known != 0);
        for (std::size_t l = 0; l < 64; ++l)
            CHECK(row.byte(l) == ((row.known >> l & 1u) != 0 ? values[l] : 0));
        for (std::uint64_t t = 0; t < 4; ++t)
            for (std::uint64_t i = 0; i < 16; ++i) {
                const std::uint64_t lights = std::uint64_t{5} << (i * (2 * t + 3) + 7 * t) % 62;
                CHECK((row.known & lights) == lights);
            }
    }
}

TEST_CASE("cache store: a table finds the records that were added, under their keys and aliases") {
    for (const double size : {3.0, 40.0}) {
        test::Random random(11);
        RecordTable table;
        std::map<Words, int> plain;
        std::map<Words, Words> aliases;
        RecordKey last;
        for (int i = 0; i < 3000; ++i) {
            // Every fourth lies one or two steps above the last, and leads to that.
            const bool is_alias = i % 4 == 3;
            const RecordKey key = is_alias ? last.below(i % 8 < 4 ? -1 : -2) : random_key(random, size);
            if (plain.contains(words_of(key)) || aliases.contains(words_of(key)))
                continue;
            if (is_alias) {
                table.add_alias(key, last);
                aliases[words_of(key)] = words_of(last);
                continue;
            }
            last = key;
            plain[words_of(key)] = i;
            const RecordEntry entry = table.add(key, numbered(i));
            CHECK(entry.key == key);
            CHECK(entry.record->fall == static_cast<float>(i));
            // Once more: what is there stays.
            CHECK(table.add(key, numbered(-5)).record == entry.record);
        }
        const auto check_all = [&] {
            std::size_t records = 0;
            table.for_each_record([&](const RecordEntry& entry) {
                ++records;
                const auto known = plain.find(words_of(entry.key));
                REQUIRE(known != plain.end());
                CHECK(entry.record->fall == static_cast<float>(known->second));
                CHECK(table.find(entry.key).record == entry.record);
            });
            CHECK(records == plain.size());
            std::size_t ways = 0;
            table.for_each_alias([&](const RecordKey& key, const RecordEntry& entry) {
                ++ways;
                CHECK(aliases.at(words_of(key)) == words_of(entry.key));
                CHECK(table.find(key).record == entry.record);
                CHECK(table.find(key).key == entry.key);
            });
            CHECK(ways == aliases.size());
            std::size_t counted = 0;
            for (std::size_t level = 0; level < 16; ++level)
                counted += table.records_of_level(level);
            CHECK(counted == plain.size());
        };
        check_all();
        CHECK(aliases.size() > 20);
        CHECK_FALSE(table.find(RecordKey({100, 100, 100}, RecordKind::air, Facing{}, 9)));

        const auto goes = [](const RecordKey& key) {
            return key.words[2] % 3 != 0;
        };
        const std::size_t forgotten = table.forget(
            [&](const RecordKey& key, const RecordEntry& entry) { return goes(key) || goes(entry.key); },
            [&](const RecordEntry& entry) { return goes(entry.key); });
        const std::size_t before = plain.size();
        const auto key_goes = [](const Words& key) {
            return std::get<2>(key) % 3 != 0;
        };
        std::erase_if(plain, [&](const auto& entry) { return key_goes(entry.first); });
        std::erase_if(aliases,
                      [&](const auto& entry) { return key_goes(entry.first) || key_goes(entry.second); });
        CHECK(forgotten == before - plain.size());
        check_all();
        table.forget([](const RecordKey&, const RecordEntry&) { return true; },
                     [](const RecordEntry&) { return true; });
        CHECK(table.bytes() - table.free_bytes() < RecordTable::least_bytes() + 2 * 64 * 4096);
        plain.clear();
        aliases.clear();
        check_all();
    }
}

}  // namespace cache_store_test
