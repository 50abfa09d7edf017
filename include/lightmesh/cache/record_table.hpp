// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/pool.hpp>
#include <lightmesh/cache/record.hpp>
#include <lightmesh/cache/record_brick.hpp>

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

/// A record and what leads to it.
struct RecordEntry {
    Record* record = nullptr;
    RecordBrick* brick = nullptr;
    RecordKey key;  ///< of the record's own lattice point

    explicit operator bool() const { return record != nullptr; }
};

/// Finds records by their keys: hash tables of bricks with open addressing, whose slots are indices into the
/// pool. Looking up takes no lock. Adding locks one of 64 parts; a table that is too full is replaced by one
/// of twice the size, and stays readable as long as the cache lives.
class RecordTable {
public:
    RecordTable() {
        for (Part& part : parts_)
            part.table.store(&part.grow(first_size));
    }

    UnitPool& pool() { return pool_; }

    /// The record of a key, or none. `nearby` is a brick in which it is looked for first, or null; then the
    /// one of the key.
    RecordEntry find(const RecordKey& key, RecordBrick*& nearby) const {
        const RecordKey brick_key = RecordBrick::key_of(key);
        if (nearby == nullptr || !(nearby->key == brick_key))
            nearby = find_brick(brick_key);
        return nearby == nullptr ? RecordEntry() : resolve(find_in(*nearby, key));
    }
    RecordEntry find(const RecordKey& key) const {
        RecordBrick* nearby = nullptr;
        return find(key, nearby);
    }

    /// Adds a copy of a record under its lattice point's key. What another thread has added meanwhile is the
    /// same, and stays. Throws std::bad_alloc; then nothing is added.
    RecordEntry add(const RecordKey& key, const Record& made) {
        const RecordKey brick_key = RecordBrick::key_of(key);
        const std::uint64_t hash = hash_of(brick_key);
        const std::uint32_t tag = RecordBrick::tag_of(key);
        Part& part = parts_[hash >> 58];
        const std::scoped_lock lock(part.adding);
        const std::uint32_t slot = part.tables.back()->find(pool_, brick_key, hash);
        RecordEntry entry;
        if (slot == 0) {
            Table& table = part.with_room(pool_);
            const std::uint32_t at = pool_.allocate(sizeof(RecordBrick) / 8);
            auto* brick = new (pool_.at(at)) RecordBrick;
            brick->key = brick_key;
            brick->first.put(0, tag, made);
            table.put(at, hash);
            ++part.count;
            entry = {&brick->first.records[0], brick, key};
        } else {
            RecordBrick& brick = brick_at(slot);
            entry = find_in(brick, key);
            if (entry)
                return resolve(entry);
            entry = {add_to(brick, tag, made), &brick, key};
        }
        if (!made.is_alias())
            ++counts_[static_cast<std::size_t>(key.level())];
        return resolve(entry);
    }

    /// Makes a second key lead to the record of a lattice point farther down in the same column.
    void add_alias(const RecordKey& key, const RecordKey& target) {
        Record alias;
        alias.fall = static_cast<float>(key.steps_to(target));
        alias.links.store(Record::alias_bit, std::memory_order_relaxed);
        add(key, alias);
    }

    /// Calls visit(entry) for all records there are by now, in no particular order.
    template <class Visitor>
    void for_each_record(Visitor&& visit) const {
        for_each([&](const RecordEntry& entry) {
            if (!entry.record->is_alias())
                visit(entry);
        });
    }
    /// Calls visit(key, entry) for all keys that lead to another key's record.
    template <class Visitor>
    void for_each_alias(Visitor&& visit) const {
        for_each([&](const RecordEntry& entry) {
            if (entry.record->is_alias())
                visit(entry.key, resolve(entry));
        });
    }

    /// Forgets the aliases for which alias_goes(key, entry) holds, then the records for which
    /// record_goes(entry) does: that may do away with what they hold. No alias of such a record may stay.
    /// Nobody else may use the table meanwhile. Returns the number of records.
    template <class AliasGoes, class RecordGoes>
    std::size_t forget(AliasGoes&& alias_goes, RecordGoes&& record_goes) {
        std::size_t forgotten = 0;
        for_each_brick([&](RecordBrick& brick) {
            forget_in(brick, [&](const RecordEntry& entry) {
                return entry.record->is_alias() && alias_goes(entry.key, resolve(entry));
            });
        });
        for_each_brick([&](RecordBrick& brick) {
            forget_in(brick, [&](const RecordEntry& entry) {
                if (entry.record->is_alias() || !record_goes(entry))
                    return false;
                --counts_[static_cast<std::size_t>(entry.key.level())];
                ++forgotten;
                return true;
            });
        });
        for (Part& part : parts_)
            drop_empty_bricks(part);
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

    std::size_t record_count() const {
        std::size_t sum = 0;
        for (const std::atomic<std::size_t>& count : counts_)
            sum += count.load(std::memory_order_relaxed);
        return sum;
    }

private:
    static constexpr std::uint32_t first_size = 16;

    struct Table {
        explicit Table(std::uint32_t size)
            : mask(size - 1), slots(std::make_unique<std::atomic<std::uint32_t>[]>(size)) {}

        /// The slot's value of a brick's key, 0 if it is not there.
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
        /// The table in use, or a greater one, with room for one more. Throws std::bad_alloc.
        Table& with_room(const UnitPool& pool) {
            Table& now = *tables.back();
            if (4 * (count + 1) <= 3 * (now.mask + 1))
                return now;
            Table& greater = grow(2 * (now.mask + 1));
            for (std::uint32_t i = 0; i <= now.mask; ++i)
                if (const std::uint32_t slot = now.slots[i].load(std::memory_order_relaxed); slot != 0)
                    greater.put(slot, hash_of(key_of(pool, slot)));
            table.store(&greater, std::memory_order_release);
            return greater;
        }
        /// Nobody is in the others any more.
        void keep_last() {
            for (std::size_t i = 0; i + 1 < tables.size(); ++i)
                bytes.fetch_sub((tables[i]->mask + std::size_t{1}) * sizeof(std::uint32_t),
                                std::memory_order_relaxed);
            tables.erase(tables.begin(), tables.end() - 1);
        }
    };

    RecordBrick* find_brick(const RecordKey& brick_key) const {
        const std::uint64_t hash = hash_of(brick_key);
        const Table* table = parts_[hash >> 58].table.load(std::memory_order_acquire);
        const std::uint32_t slot = table->find(pool_, brick_key, hash);
        return slot == 0 ? nullptr : &brick_at(slot);
    }

    template <class Visitor>
    void for_each_brick(Visitor&& visit) const {
        constexpr std::uint32_t slots_ahead = 8;
        for (const Part& part : parts_) {
            const Table& table = *part.table.load(std::memory_order_acquire);
            const auto slot_at = [&table](std::uint32_t i) {
                return table.slots[i & table.mask].load(std::memory_order_acquire);
            };
            for (std::uint32_t i = 0; i <= table.mask; ++i) {
                if (const std::uint32_t ahead = slot_at(i + slots_ahead); ahead != 0)
                    pool_.fetch_ahead(ahead);
                if (const std::uint32_t slot = slot_at(i); slot != 0)
                    visit(brick_at(slot));
            }
        }
    }

    /// Calls visit(group, its header) for the groups of a brick, until that returns true.
    template <class Visitor>
    void for_each_group(RecordBrick& brick, Visitor&& visit) const {
        RecordGroup* group = &brick.first;
        for (;;) {
            const std::uint64_t header = group->header.load(std::memory_order_acquire);
            const std::uint32_t next = RecordGroup::next_of(header);
            if (visit(*group, header) || next == 0)
                return;
            group = &group_at(next);
        }
    }

    /// Calls visit(entry) for all records and aliases.
    template <class Visitor>
    void for_each(Visitor&& visit) const {
        for_each_brick([&](RecordBrick& brick) {
            for_each_group(brick, [&](RecordGroup& group, std::uint64_t header) {
                for (std::size_t i = 0; i < RecordGroup::size; ++i)
                    if (const std::uint32_t tag = RecordGroup::tag_of(header, i); tag != 0)
                        visit(RecordEntry{&group.records[i], &brick, brick.record_key(tag)});
                return false;
            });
        });
    }

    /// The record or alias of a key in its brick, or none.
    RecordEntry find_in(RecordBrick& brick, const RecordKey& key) const {
        const std::uint32_t tag = RecordBrick::tag_of(key);
        for (RecordGroup* group = &brick.first;;) {
            const std::uint64_t header = group->header.load(std::memory_order_acquire);
            if (const std::size_t i = RecordGroup::find(header, tag); i != RecordGroup::size)
                return {&group->records[i], &brick, key};
            const std::uint32_t next = RecordGroup::next_of(header);
            if (next == 0)
                return {};
            group = &group_at(next);
        }
    }

    Record* add_to(RecordBrick& brick, std::uint32_t tag, const Record& made) {
        Record* added = nullptr;
        RecordGroup* last = nullptr;
        for_each_group(brick, [&](RecordGroup& group, std::uint64_t header) {
            last = &group;
            const std::size_t i = RecordGroup::find(header, 0);
            if (i == RecordGroup::size)
                return false;
            group.put(i, tag, made);
            added = &group.records[i];
            return true;
        });
        if (added != nullptr)
            return added;
        const std::uint32_t at = pool_.allocate(sizeof(RecordGroup) / 8);
        auto* group = new (pool_.at(at)) RecordGroup;
        group->put(0, tag, made);
        last->header.fetch_or(static_cast<std::uint64_t>(at) << 32, std::memory_order_release);
        return &group->records[0];
    }

    template <class Goes>
    void forget_in(RecordBrick& brick, Goes&& goes) {
        for_each_group(brick, [&](RecordGroup& group, std::uint64_t header) {
            // Of an alias there is none.
            for (const Record& record : group.records)
                if (const std::uint32_t rows = record.rows.load(std::memory_order_relaxed); rows != 0)
                    pool_.fetch_ahead(rows);
            for (std::size_t i = 0; i < RecordGroup::size; ++i)
                if (const std::uint32_t tag = RecordGroup::tag_of(header, i);
                    tag != 0 && goes(RecordEntry{&group.records[i], &brick, brick.record_key(tag)}))
                    group.take_out(i);
            return false;
        });
    }

    /// Gives back the groups in which nothing is left.
    void drop_empty_groups(RecordBrick& brick) {
        RecordGroup* group = &brick.first;
        for (;;) {
            const std::uint64_t header = group->header.load(std::memory_order_relaxed);
            const std::uint32_t next = RecordGroup::next_of(header);
            if (next == 0)
                return;
            const std::uint64_t next_header = group_at(next).header.load(std::memory_order_relaxed);
            if (RecordGroup::has_tags(next_header)) {
                group = &group_at(next);
                continue;
            }
            group->header.store((header & 0xffffffffu) |
                                    static_cast<std::uint64_t>(RecordGroup::next_of(next_header)) << 32,
                                std::memory_order_relaxed);
            pool_.give_back(next, sizeof(RecordGroup) / 8);
        }
    }

    void drop_empty_bricks(Part& part) {
        part.keep_last();
        Table& table = *part.tables.back();
        for (std::uint32_t i = 0; i <= table.mask;) {
            const std::uint32_t slot = table.slots[i].load(std::memory_order_relaxed);
            if (slot != 0)
                drop_empty_groups(brick_at(slot));
            if (slot == 0 || brick_at(slot).first.header.load(std::memory_order_relaxed) != 0) {
                ++i;
                continue;
            }
            // What moves up into the slot is looked at next.
            table.take_out(pool_, i);
            pool_.give_back(slot, sizeof(RecordBrick) / 8);
            --part.count;
        }
    }

    static RecordBrick& brick_in(const UnitPool& pool, std::uint32_t at) {
        return *reinterpret_cast<RecordBrick*>(pool.at(at));
    }
    RecordBrick& brick_at(std::uint32_t at) const { return brick_in(pool_, at); }
    RecordGroup& group_at(std::uint32_t at) const { return *reinterpret_cast<RecordGroup*>(pool_.at(at)); }
    static const RecordKey& key_of(const UnitPool& pool, std::uint32_t slot) {
        return brick_in(pool, slot).key;
    }

    /// The record that an alias leads to; others lead to themselves.
    RecordEntry resolve(const RecordEntry& entry) const {
        if (!entry || !entry.record->is_alias())
            return entry;
        return find(entry.key.below(static_cast<int>(entry.record->fall)));
    }

    mutable UnitPool pool_;
    std::array<Part, 64> parts_;
    std::array<std::atomic<std::size_t>, 16> counts_{};
};

}  // namespace lightmesh::detail
