// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/pool.hpp>
#include <lightmesh/cache/record.hpp>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Finds records by their keys: hash tables with open addressing, whose slots are indices into the pool.
/// Looking up takes no lock. Adding locks one of 64 parts; a table that is too full is replaced by one of
/// twice the size, and stays readable as long as the cache lives.
class RecordTable {
public:
    RecordTable() {
        for (Part& part : parts_)
            part.table.store(&part.grow(first_size));
    }

    UnitPool& pool() { return pool_; }

    /// The record of a key, or nullptr.
    Record* find(const RecordKey& key) const {
        const std::uint64_t hash = hash_of(key);
        const Part& part = parts_[hash >> 58];
        return resolve(part.table.load(std::memory_order_acquire)->find(pool_, key, hash));
    }

    /// Adds a record that lies at its own lattice point's key. What another thread has added meanwhile is
    /// the same, and stays. Throws std::bad_alloc; then nothing is added.
    Record* add(const Record& made) {
        const std::uint32_t index = add(made.key, [&] {
            const std::uint32_t at = pool_.allocate(sizeof(Record) / 8);
            auto* record = new (pool_.at(at)) Record;
            record->key = made.key;
            record->fall = made.fall;
            for (int k = 0; k < 3; ++k)
                record->normal[k] = made.normal[k];
            ++counts_[static_cast<std::size_t>(made.key.level())];
            return at;
        });
        return resolve(index);
    }

    /// Makes a second key lead to a record of this table.
    Record* add_alias(const RecordKey& key, const Record& target) {
        const std::uint32_t index = add(key, [&] {
            const std::uint32_t record =
                parts_[hash_of(target.key) >> 58].table.load()->find(pool_, target.key, hash_of(target.key));
            const std::uint32_t at = pool_.allocate(sizeof(Alias) / 8);
            new (pool_.at(at)) Alias{key, record};
            return at | alias_bit;
        });
        return resolve(index);
    }

    /// Calls visit(record) for all records there are by now, in no particular order.
    template <class Visitor>
    void for_each_record(Visitor&& visit) const {
        for_each_slot([&](std::uint32_t slot) {
            if ((slot & alias_bit) == 0)
                visit(*reinterpret_cast<const Record*>(pool_.at(slot)));
        });
    }
    /// Calls visit(key, record) for all keys that lead to another key's record.
    template <class Visitor>
    void for_each_alias(Visitor&& visit) const {
        for_each_slot([&](std::uint32_t slot) {
            if ((slot & alias_bit) != 0)
                visit(key_of(pool_, slot), *resolve(slot));
        });
    }

    /// Forgets the aliases for which alias_goes(key, record) holds, then the records for which
    /// record_goes(record) does: that may do away with what they hold. No alias of such a record may stay.
    /// Nobody else may use the table meanwhile. Returns the number of records.
    template <class AliasGoes, class RecordGoes>
    std::size_t forget(AliasGoes&& alias_goes, RecordGoes&& record_goes) {
        std::size_t forgotten = 0;
        for (Part& part : parts_)
            forget_in(part, [&](std::uint32_t slot) {
                const bool goes =
                    (slot & alias_bit) != 0 && alias_goes(key_of(pool_, slot), std::as_const(*resolve(slot)));
                if (goes)
                    pool_.give_back(slot & ~alias_bit, sizeof(Alias) / 8);
                return goes;
            });
        for (Part& part : parts_)
            forget_in(part, [&](std::uint32_t slot) {
                if ((slot & alias_bit) != 0 || !record_goes(*resolve(slot)))
                    return false;
                --counts_[static_cast<std::size_t>(key_of(pool_, slot).level())];
                pool_.give_back(slot, sizeof(Record) / 8);
                ++forgotten;
                return true;
            });
        return forgotten;
    }

    std::size_t bytes() const {
        std::size_t sum = pool_.bytes();
        for (const Part& part : parts_)
            sum += part.bytes.load(std::memory_order_relaxed);
        return sum;
    }
    /// Those of a table with nothing in it.
    static constexpr std::size_t least_bytes() {
        return UnitPool::least_bytes() + 64 * first_size * sizeof(std::uint32_t);
    }
    /// Of these what waits for its next use.
    std::size_t free_bytes() const { return pool_.free_bytes(); }
    std::size_t records_of_level(std::size_t level) const {
        return counts_[level].load(std::memory_order_relaxed);
    }

private:
    static constexpr std::uint32_t alias_bit = 1u << 31;
    static constexpr std::uint32_t first_size = 16;

    struct Table {
        explicit Table(std::uint32_t size)
            : mask(size - 1), slots(std::make_unique<std::atomic<std::uint32_t>[]>(size)) {}

        /// The slot's value of a key, 0 if it is not there.
        std::uint32_t find(const UnitPool& pool, const RecordKey& key, std::uint64_t hash) const {
            for (auto i = static_cast<std::uint32_t>(hash);; ++i) {
                const std::uint32_t slot = slots[i & mask].load(std::memory_order_acquire);
                if (slot == 0 || key_of(pool, slot) == key)
                    return slot;
            }
        }
        void put(std::uint32_t value, std::uint64_t hash) {
            auto i = static_cast<std::uint32_t>(hash);
            while (slots[i & mask].load(std::memory_order_relaxed) != 0)
                ++i;
            slots[i & mask].store(value, std::memory_order_release);
        }

        /// Empties a slot and closes the gap: what follows moves up, as far as it may. Nobody else may use
        /// the table meanwhile.
        void take_out(const UnitPool& pool, std::uint32_t gap) {
            for (std::uint32_t i = gap;;) {
                i = (i + 1) & mask;
                const std::uint32_t slot = slots[i].load(std::memory_order_relaxed);
                if (slot == 0)
                    break;
                const auto home = static_cast<std::uint32_t>(hash_of(key_of(pool, slot))) & mask;
                // It may stand in the gap, if that is not before its home.
                if (((i - home) & mask) >= ((i - gap) & mask)) {
                    slots[gap].store(slot, std::memory_order_relaxed);
                    gap = i;
                }
            }
            slots[gap].store(0, std::memory_order_relaxed);
        }

        std::uint32_t mask;
        std::unique_ptr<std::atomic<std::uint32_t>[]> slots;
    };

    struct Part {
        std::atomic<const Table*> table{nullptr};
        std::atomic<std::size_t> bytes{0};
        std::uint32_t count = 0;
        std::vector<std::unique_ptr<Table>> tables;  ///< the last is in use
        std::mutex adding;

        Table& grow(std::uint32_t size) {
            tables.reserve(tables.size() + 1);
            tables.push_back(std::make_unique<Table>(size));
            bytes.fetch_add(size * sizeof(std::uint32_t), std::memory_order_relaxed);
            return *tables.back();
        }
        /// Nobody is in the others any more.
        void keep_last() {
            for (std::size_t i = 0; i + 1 < tables.size(); ++i)
                bytes.fetch_sub((tables[i]->mask + std::size_t{1}) * sizeof(std::uint32_t),
                                std::memory_order_relaxed);
            tables.erase(tables.begin(), tables.end() - 1);
        }
    };

    template <class Visitor>
    void for_each_slot(Visitor&& visit) const {
        for (const Part& part : parts_) {
            const Table& table = *part.table.load(std::memory_order_acquire);
            for (std::uint32_t i = 0; i <= table.mask; ++i)
                if (const std::uint32_t slot = table.slots[i].load(std::memory_order_acquire); slot != 0)
                    visit(slot);
        }
    }

    template <class Goes>
    void forget_in(Part& part, Goes&& goes) {
        part.keep_last();
        Table& table = *part.tables.back();
        for (std::uint32_t i = 0; i <= table.mask;) {
            const std::uint32_t slot = table.slots[i].load(std::memory_order_relaxed);
            if (slot == 0 || !goes(slot)) {
                ++i;
                continue;
            }
            // What moves up into the slot is looked at next.
            table.take_out(pool_, i);
            --part.count;
        }
    }

    static const RecordKey& key_of(const UnitPool& pool, std::uint32_t slot) {
        // Records and aliases begin with their keys.
        const void* at = pool.at(slot & ~alias_bit);
        return *static_cast<const RecordKey*>(at);
    }

    Record* resolve(std::uint32_t slot) const {
        if (slot == 0)
            return nullptr;
        if ((slot & alias_bit) != 0)
            slot = reinterpret_cast<const Alias*>(pool_.at(slot & ~alias_bit))->record;
        return reinterpret_cast<Record*>(pool_.at(slot));
    }

    template <class Make>
    std::uint32_t add(const RecordKey& key, const Make& make) {
        const std::uint64_t hash = hash_of(key);
        Part& part = parts_[hash >> 58];
        const std::scoped_lock lock(part.adding);
        Table* table = part.tables.back().get();
        if (const std::uint32_t known = table->find(pool_, key, hash); known != 0)
            return known;
        if (4 * (part.count + 1) > 3 * (table->mask + 1)) {
            Table& greater = part.grow(2 * (table->mask + 1));
            for (std::uint32_t i = 0; i <= table->mask; ++i)
                if (const std::uint32_t slot = table->slots[i].load(std::memory_order_relaxed); slot != 0)
                    greater.put(slot, hash_of(key_of(pool_, slot)));
            table = &greater;
            part.table.store(table, std::memory_order_release);
        }
        const std::uint32_t value = make();
        table->put(value, hash);
        ++part.count;
        return value;
    }

    mutable UnitPool pool_;
    std::array<Part, 64> parts_;
    std::array<std::atomic<std::size_t>, 16> counts_{};
};

}  // namespace lightmesh::detail
