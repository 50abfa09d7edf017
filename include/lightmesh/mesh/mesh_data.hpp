// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/mesh/pool.hpp>
#include <lightmesh/mesh/region_table.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/support/atomics.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// The visibilities of up to 64 lights from all light points of a brick: bit p of word l is V(L, x) of the
/// light in slot l of the tile from light point p.
using BrickWords = std::array<std::uint64_t, lights_per_tile>;

/// The knowledge of a brick's tile light by light, beside that of whole groups: where some lights of a
/// group were forgotten, or came from elsewhere without the others.
struct KeptLights {
    std::array<std::uint64_t, cells_per_brick> cells{};  ///< lights known in a cell beside `BrickTile::known`
    std::uint64_t sampled = 0;  ///< lights of which samples have told, beside the groups in `sampled`
    std::uint64_t stale = 0;    ///< lights of which cells may hold what is not true any more

    std::uint64_t anywhere() const {
        std::uint64_t lights = 0;
        for (const std::uint64_t in_cell : cells)
            lights |= in_cell;
        return lights;
    }
    bool is_nothing() const { return (anywhere() | sampled) == 0; }

    /// The cells, one bit each at their first light points, in which light l is kept.
    std::uint64_t cells_with(std::size_t l) const {
        std::uint64_t first_points = 0;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            first_points |= (cells[cell] >> l & 1) << (8 * cell);
        return first_points;
    }
};

/// All that is known about light points: settings, lights, and what has been found out so far. Knows no
/// tracer. Any number of threads may read, through a `view`, while others add to it; what is there does not
/// change then, and what two threads add at once is the same.
///
/// What changes lights or forgets something is for one thread, while nobody else uses the data.
class MeshData {
public:
    /// Throws what `LightTable` and `Grid` throw.
    MeshData(std::span<const Light> lights, const Settings& settings)
        : MeshData(lights, settings, Grid(settings)) {}
    /// The same with a grid that may have its origin from elsewhere.
    MeshData(std::span<const Light> lights, const Settings& settings, const Grid& grid)
        : settings_(settings), grid_(grid), lights_(lights, grid_),
          user_lights_(std::make_shared<const std::vector<Light>>(lights.begin(), lights.end())) {
        grow_table();
    }
    /// Nothing known yet about the lights of another mesh, which are shared.
    MeshData(const MeshData& other, const Settings& settings)
        : settings_(settings), grid_(settings), lights_(other.lights_, grid_),
          user_lights_(other.user_lights_) {
        grow_table();
    }
    MeshData(const MeshData&) = delete;
    MeshData& operator=(const MeshData&) = delete;

    const Settings& settings() const { return settings_; }
    const Grid& grid() const { return grid_; }
    const LightTable& lights() const { return lights_; }
    /// True if long tests are found by samples (see `Settings::adaptive_long_tests`).
    bool is_adaptive() const {
        return settings_.adaptive_long_tests && settings_.short_test != ShortTest::exact;
    }
    /// As they were passed in.
    std::span<const Light> user_lights() const { return *user_lights_; }

    /// The data that is there by now, and what comes later in regions that are there.
    MeshView view() const {
        const SlotTable* table = table_.load(std::memory_order_acquire);
        return {&settings_,           &grid_,          &lights_,
                table->as_view(),     regions_.view(), bricks_.view(),
                tile_indices_.view(), tiles_.view(),   rows_.view(),
                words_.view()};
    }

    /// The brick of these coordinates, made if it is not there. Throws what `Pool::allocate` throws.
    Brick& find_or_make_brick(const glm::ivec3& coord) {
        if (const Brick* brick = view().find_brick(coord))
            return const_cast<Brick&>(*brick);
        const std::scoped_lock lock(growing_);
        Region& region = find_or_make_region(Region::key_of(coord));
        std::uint32_t& entry = region.bricks[Region::slot(coord)];
        if (entry != 0)
            return bricks_[entry - 1];
        const std::size_t tile_count = lights_.tile_count();
        const std::uint32_t tiles = tile_count > 1 ? tile_indices_.allocate(tile_count) : 0;
        const std::uint32_t index = bricks_.allocate();
        Brick& brick = bricks_[index];
        brick.coord = {coord.x, coord.y, coord.z};
        brick.tiles = tiles;
        brick.used = frame_;
        store_release(entry, index + 1);
        return brick;
    }

    /// Stores units of a tile of a brick (see `BrickTile::known`), and what samples tell of their lights;
    /// what is there stays as it is: it has the same value. Groups must be sampled before, or as, the first
    /// of their units are stored, or never. Throws what `Pool::allocate` throws.
    void publish(const Brick& brick, std::size_t t, std::uint64_t fresh, const BrickWords& lit,
                 const UniformLights& samples = {}) {
        const SpinLock lock(const_cast<Brick&>(brick).lock);
        BrickTile& tile = find_or_make_tile(brick, t);
        fresh &= ~tile.known;
        KeptLights* const kept = kept_of(brick, t);
        const KeptLights before = kept != nullptr ? *kept : KeptLights{};
        const std::uint32_t sampled = samples.sampled & ~tile.sampled;
        const std::uint64_t of_sampled = lights_of_groups(sampled);
        CellsToStore store{.uniform = tile.uniform | (samples.uniform & of_sampled),
                           .lit = tile.lit | (samples.lit & samples.uniform & of_sampled)};
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            store.lights[cell] = lights_in_cell(fresh, cell) & ~before.cells[cell];
        const std::array<std::uint32_t, cells_per_brick> cells = stored_cells(tile, store, before, lit);
        if (kept != nullptr)
            note_superseded(tile.cells, cells);
        // From here on nothing throws.
        if (kept != nullptr) {
            for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
                kept->cells[cell] &= ~lights_in_cell(fresh, cell);
            kept->sampled &= ~of_sampled;
            kept->stale &= ~store.uniform;
        }
        or_relaxed(tile.lit, store.lit);
        or_release(tile.uniform, store.uniform);
        or_release(tile.sampled, sampled);
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            if (cells[cell] != tile.cells[cell])
                store_release(tile.cells[cell], cells[cell]);
        or_release(tile.known, fresh);
    }

    /// Stores what is known of some lights of groups of which others are not known: `known.cells`, and of
    /// `known.sampled` what samples have told. For one thread, while nobody else uses the data. Throws
    /// std::bad_alloc.
    void keep_lights(const Brick& brick, std::size_t t, const KeptLights& known, const BrickWords& lit,
                     const UniformLights& samples) {
        BrickTile& tile = find_or_make_tile(brick, t);
        if (kept_.size() < tiles_.size())
            kept_.resize(tiles_.size());
        KeptLights& kept = *kept_of(brick, t);
        const std::uint64_t sampled = known.sampled & ~kept.sampled & ~lights_of_groups(tile.sampled);
        CellsToStore store{.uniform = tile.uniform | (samples.uniform & sampled),
                           .lit = tile.lit | (samples.lit & samples.uniform & sampled)};
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            store.lights[cell] = known.cells[cell] & ~kept.cells[cell] & ~lights_in_cell(tile.known, cell);
        const std::array<std::uint32_t, cells_per_brick> cells = stored_cells(tile, store, kept, lit);
        note_superseded(tile.cells, cells);
        // From here on nothing throws.
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            kept.cells[cell] |= store.lights[cell];
        kept.sampled |= sampled;
        kept.stale &= ~store.uniform;
        tile.uniform = store.uniform;
        tile.lit = store.lit;
        tile.cells = cells;
    }

    /// All that is known of a tile light by light. Beside it other threads may publish.
    KeptLights find_kept(const Brick& brick, std::size_t t) const {
        if (kept_.empty())
            return {};
        const SpinLock lock(const_cast<Brick&>(brick).lock);
        const KeptLights* const kept = kept_of(brick, t);
        return kept != nullptr ? *kept : KeptLights{};
    }

    /// Gets ready for `forget` and `set_lights`, which do not throw then. Throws std::bad_alloc.
    void prepare_update() { kept_.resize(tiles_.size()); }

    /// Takes other lights in the slots of those that are there.
    void set_lights(const LightTable& lights, const std::shared_ptr<const std::vector<Light>>& user_lights) {
        lights_.share(lights);
        user_lights_ = user_lights;
    }

    /// Forgets what a tile of a brick knows of some of its lights. Returns the number of visibilities.
    std::size_t forget(const Brick& brick, std::size_t t, std::uint64_t lights) {
        KeptLights* const kept = kept_of(brick, t);
        if (kept == nullptr)
            return 0;
        BrickTile& tile = tiles_[view().tile_index(brick, t) - 1];
        const auto groups = cell_bits(lights);
        const std::uint64_t units = tile.known & (every_byte * groups);
        const std::uint64_t are_there =
            ~std::uint64_t{0} >> (lights_per_tile - static_cast<std::size_t>(lights_.tile_size(t)));
        std::size_t count = 0;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            std::uint64_t& in_cell = kept->cells[cell];
            in_cell |= lights_in_cell(units, cell) & are_there;
            count += 8 * static_cast<std::size_t>(std::popcount(in_cell & lights));
            in_cell &= ~lights;
        }
        kept->sampled = (kept->sampled | (lights_of_groups(tile.sampled & groups) & are_there)) & ~lights;
        kept->stale |= lights;
        tile.known &= ~units;
        tile.sampled &= ~groups;
        tile.uniform &= ~lights;
        tile.lit &= ~lights;
        return count;
    }

    /// Forgets the links of a brick. Returns their number.
    std::size_t forget_links(const Brick& brick) {
        auto& changed = const_cast<Brick&>(brick);
        const auto count = static_cast<std::size_t>(std::popcount(changed.links_known));
        changed.links = {};
        changed.links_known = 0;
        return 24 * count;
    }

    /// Forgets the floods of a brick's light points. Returns their number.
    std::size_t forget_floods(const Brick& brick) {
        auto& changed = const_cast<Brick&>(brick);
        const std::size_t slots = FloodBox::slots(grid_.quality());
        std::size_t count = 0;
        for (std::uint32_t flood = std::exchange(changed.floods, 0); flood != 0;) {
            const FloodView view(&words_[flood - 1]);
            const std::uint32_t next = view.next();
            words_.give_back(flood - 1, view.size(slots));
            flood = next;
            ++count;
        }
        return count;
    }

    /// Makes the memory of what was superseded since the last call free for new cells.
    void reuse_superseded() {
        for (const std::uint32_t cell : superseded_) {
            const CellIndex at{cell};
            if (at.is_words())
                words_.give_back(at.index(), words_of_cell(&words_[at.index()]));
            else
                rows_.give_back(at.index());
        }
        superseded_.clear();
    }

    /// The number of the frame, modulo 2^16.
    std::uint16_t frame() const { return frame_; }
    void set_frame(std::uint16_t frame) { frame_ = frame; }
    /// Notes that a query asks for a brick.
    void mark_used(const Brick& brick) const {
        if (load_relaxed(brick.used) != frame_)
            store_relaxed(const_cast<Brick&>(brick).used, frame_);
    }
    /// The number of frames since a query last asked for a brick.
    std::uint16_t frames_unused(const Brick& brick) const {
        return static_cast<std::uint16_t>(frame_ - brick.used);
    }

    /// True if lights were changed, or anything was forgotten, since it was made.
    bool was_updated() const { return !kept_.empty() || !lights_.has_own_order(); }

    /// Stores all that another mesh with the same lights in the same slots knows of a tile; returns false,
    /// and does nothing, if a part of it is known already.
    bool publish_copy(const Brick& brick, std::size_t t, const MeshView& from, const BrickTile& copied) {
        const SpinLock lock(const_cast<Brick&>(brick).lock);
        BrickTile& tile = find_or_make_tile(brick, t);
        if ((copied.known & ~tile.known) == 0 && (copied.sampled & ~tile.sampled) == 0)
            return true;
        const KeptLights* const kept = kept_of(brick, t);
        if ((tile.known | tile.sampled) != 0 || (kept != nullptr && !kept->is_nothing()) ||
            std::ranges::any_of(tile.cells, [](std::uint32_t cell) { return cell != 0; }))
            return false;
        or_relaxed(tile.lit, copied.lit);
        or_release(tile.uniform, copied.uniform);
        or_release(tile.sampled, copied.sampled);
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            const CellIndex at{copied.cells[cell]};
            if (at.is_nothing())
                continue;
            if (at.is_words()) {
                const std::uint64_t* record = &from.words[at.index()];
                const std::size_t size = words_of_cell(record);
                const std::uint32_t index = words_.allocate(size);
                std::copy_n(record, size, &words_[index]);
                store_release(tile.cells[cell], CellIndex::words(index).value);
            } else {
                const std::uint32_t index = rows_.allocate();
                rows_[index] = from.rows[at.index()];
                store_release(tile.cells[cell], CellIndex::row(index).value);
            }
        }
        or_release(tile.known, copied.known);
        return true;
    }

    /// Takes over all that another mesh with the same lights in the same slots knows, while this one is
    /// untouched. For one thread, while nobody else uses the data. Throws what `Pool::allocate` throws;
    /// nothing has changed then.
    void restore(const LevelParts& parts) {
        auto table = std::make_unique<SlotTable>(parts.slots);
        regions_.reserve_first(parts.regions.size());
        bricks_.reserve_first(parts.bricks.size());
        tile_indices_.reserve_first(parts.tile_indices.size());
        tiles_.reserve_first(parts.tiles.size());
        rows_.reserve_first(parts.rows.size());
        words_.reserve_first(parts.words.size());
        // From here on nothing throws.
        regions_.allocate_first(parts.regions);
        bricks_.allocate_first(parts.bricks);
        tile_indices_.allocate_first(parts.tile_indices);
        tiles_.allocate_first(parts.tiles);
        rows_.allocate_first(parts.rows);
        words_.allocate_first(parts.words);
        region_count_ = parts.regions.size();
        table_.store(table.get(), std::memory_order_release);
        tables_.back() = std::move(table);
        if (frame_ != 0)
            for_each_brick([this](const Brick& brick) { mark_used(brick); });
    }

    /// Stores the links of a cell of a brick. May be called by many threads at once: they bring the same
    /// bits.
    void publish_links(const Brick& brick, int cell, const std::array<std::uint64_t, 3>& open) {
        auto& changed = const_cast<Brick&>(brick);
        for (std::size_t axis = 0; axis < 3; ++axis)
            or_relaxed(changed.links[axis], open[axis]);
        or_release(changed.links_known, static_cast<std::uint8_t>(1u << cell));
    }

    /// Keeps a flood of one of the brick's light points, and returns its index; if somebody else was first,
    /// theirs: it is the same. Throws what `Pool::allocate` throws.
    std::uint32_t publish_flood(const Brick& brick, int seed_bit, const FloodRecord& flood) {
        return keep_flood(brick, seed_bit, flood.size(), [&](std::uint64_t* record, std::uint32_t next) {
            flood.write(record, seed_bit, next);
        });
    }
    /// The same for a flood of another mesh, in a box with so many slots.
    std::uint32_t publish_flood(const Brick& brick, const FloodView& flood, std::size_t slots) {
        const std::size_t size = flood.size(slots);
        return keep_flood(brick, flood.seed_bit(), size, [&](std::uint64_t* record, std::uint32_t next) {
            std::copy_n(flood.words(), size, record);
            record[0] = static_cast<std::uint64_t>(flood.seed_bit()) << 32 | next;
        });
    }

    /// Calls visit(region) for all regions.
    template <class Visitor>
    void for_each_region(Visitor&& visit) const {
        const MeshView mesh = view();
        for (std::uint64_t i = 0; i < mesh.region_table.size; ++i)
            if (const std::uint32_t region = load_acquire(mesh.region_table.slots[i]); region != 0)
                visit(std::as_const(mesh.regions[region - 1]));
    }

    /// True if any brick is there.
    bool knows_anything() const { return bricks_.size() != 0; }
    /// True if nothing was ever added, not even in vain: a region can be there without bricks after memory
    /// ran out.
    bool is_untouched() const { return regions_.size() == 0 && !knows_anything(); }

    /// The number of entries of each kind, those that are no longer in use included.
    struct Counts {
        std::size_t regions, bricks, tile_indices, tiles, rows, words;
    };
    Counts counts() const {
        return {regions_.size(), bricks_.size(), tile_indices_.size(),
                tiles_.size(),   rows_.size(),   words_.size()};
    }

    /// Calls visit(const Brick&) for all bricks, region by region.
    template <class Visitor>
    void for_each_brick(Visitor&& visit) const {
        for_each_region([&](const Region& region) { for_each_brick(region, visit); });
    }
    /// The same for those of one region.
    template <class Visitor>
    void for_each_brick(const Region& region, Visitor&& visit) const {
        for (const std::uint32_t& entry : region.bricks)
            if (const std::uint32_t brick = load_acquire(entry))
                visit(std::as_const(bricks_[brick - 1]));
    }

    /// Without the lights.
    std::size_t bytes() const {
        const std::scoped_lock lock(growing_);
        std::size_t sum = sizeof *this;
        for (const auto& table : tables_)
            sum += sizeof(SlotTable) + table->slots.capacity() * sizeof(std::uint32_t);
        return sum + regions_.bytes() + bricks_.bytes() + tile_indices_.bytes() + tiles_.bytes() +
               rows_.bytes() + words_.bytes() + kept_.capacity() * sizeof(KeptLights) +
               superseded_bytes_.load(std::memory_order_relaxed);
    }

    /// Of the lights, for all meshes together that share them.
    std::size_t light_bytes() const { return lights_.bytes() + user_lights_->capacity() * sizeof(Light); }

    /// The bits that a cell holds of all lights; 0 for those of unknown groups.
    CellRow row_of(const BrickTile& tile, int cell) const {
        const CellIndex at{load_acquire(tile.cells[static_cast<std::size_t>(cell)])};
        if (at.is_nothing())
            return CellRow{};
        if (!at.is_words())
            return rows_[at.index()];
        const std::uint64_t* record = &words_[at.index()];
        CellRow row;
        int rank = 0;
        for (std::size_t l = 0; l < lights_per_tile; ++l) {
            if ((record[1] >> l & 1) != 0) {
                row.bytes[l] = static_cast<std::uint8_t>(record[2 + rank / 8] >> (8 * (rank % 8)));
                ++rank;
            } else {
                row.bytes[l] = (record[0] >> l & 1) != 0 ? 0xff : 0;
            }
        }
        return row;
    }

private:
    struct SlotTable {
        explicit SlotTable(std::size_t size) : slots(size) {}
        explicit SlotTable(std::span<const std::uint32_t> others) : slots(others.begin(), others.end()) {}
        RegionTable as_view() const { return {slots.data(), slots.size()}; }
        mutable std::vector<std::uint32_t> slots;
    };

    Region& find_or_make_region(std::uint64_t key) {
        if (const std::uint32_t region = tables_.back()->as_view().find(regions_.view(), key))
            return regions_[region - 1];
        if (2 * (region_count_ + 1) > tables_.back()->slots.size())
            grow_table();
        const std::uint32_t index = regions_.allocate();
        regions_[index].key = key;
        tables_.back()->as_view().insert(key, index + 1);
        ++region_count_;
        return regions_[index];
    }

    /// A table of twice the size. The old one is kept: a look-up may still be in it; it then misses what came
    /// later, and makes sure under the lock.
    void grow_table() {
        const std::size_t size = tables_.empty() ? 64 : 2 * tables_.back()->slots.size();
        auto table = std::make_unique<SlotTable>(size);
        if (!tables_.empty())
            for (const std::uint32_t region : tables_.back()->slots)
                if (region != 0)
                    table->as_view().insert(regions_[region - 1].key, region);
        tables_.push_back(std::move(table));
        table_.store(tables_.back().get(), std::memory_order_release);
    }

    BrickTile& find_or_make_tile(const Brick& brick, std::size_t t) {
        auto& entry = const_cast<std::uint32_t&>(view().tile_index(brick, t));
        if (entry == 0)
            store_release(entry, tiles_.allocate() + 1);
        return tiles_[entry - 1];
    }

    /// Null where nothing was ever forgotten, or known light by light. Who asks holds the brick's lock, or is
    /// alone.
    const KeptLights* kept_of(const Brick& brick, std::size_t t) const {
        const std::uint32_t tile = load_relaxed(view().tile_index(brick, t));
        return tile == 0 || tile > kept_.size() ? nullptr : &kept_[tile - 1];
    }
    KeptLights* kept_of(const Brick& brick, std::size_t t) {
        return const_cast<KeptLights*>(std::as_const(*this).kept_of(brick, t));
    }

    /// Remembers cells that are about to be replaced, for `reuse_superseded`. Throws std::bad_alloc.
    void note_superseded(const std::array<std::uint32_t, cells_per_brick>& before,
                         const std::array<std::uint32_t, cells_per_brick>& after) {
        const std::scoped_lock lock(superseding_);
        if (superseded_.capacity() - superseded_.size() < before.size())
            superseded_.reserve(2 * superseded_.size() + before.size());
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell)
            if (before[cell] != 0 && before[cell] != after[cell])
                superseded_.push_back(before[cell]);
        superseded_bytes_.store(superseded_.capacity() * sizeof(std::uint32_t), std::memory_order_relaxed);
    }

    template <class Write>
    std::uint32_t keep_flood(const Brick& brick, int seed_bit, std::size_t size, Write&& write) {
        auto& changed = const_cast<Brick&>(brick);
        const SpinLock lock(changed.lock);
        if (const std::uint32_t kept = find_flood(view(), brick, seed_bit); kept != 0)
            return kept - 1;
        const std::uint32_t index = words_.allocate(size);
        write(&words_[index], changed.floods);
        store_release(changed.floods, index + 1);
        return index;
    }

    /// The bits to be stored of a tile: lights of its cells, and which are uniform then, with those that are
    /// there already.
    struct CellsToStore {
        std::array<std::uint64_t, cells_per_brick> lights{};
        std::uint64_t uniform = 0;
        std::uint64_t lit = 0;
    };
    /// `BrickTile::cells` with some lights taken from `lit`, which may also be uniform.
    std::array<std::uint32_t, cells_per_brick> stored_cells(const BrickTile& tile, const CellsToStore& store,
                                                            const KeptLights& kept, const BrickWords& lit) {
        std::array<std::uint32_t, cells_per_brick> cells = tile.cells;
        // What cells hold of lights that were forgotten is in the way where those have become uniform.
        const bool is_outdated = store.lit != tile.lit || (kept.stale & store.uniform & ~tile.uniform) != 0;
        for (std::size_t cell = 0; cell < cells_per_brick; ++cell) {
            std::uint32_t& index = cells[cell];
            const std::uint64_t lights = store.lights[cell] & ~store.uniform;
            if (lights != 0 || (index != 0 && is_outdated))
                index = keep(merged_row(tile, static_cast<int>(cell), lights, lit), store.uniform, store.lit)
                            .value;
        }
        return cells;
    }

    /// The bits that a cell holds, with some lights taken from `lit`.
    CellRow merged_row(const BrickTile& tile, int cell, std::uint64_t lights, const BrickWords& lit) const {
        CellRow row = row_of(tile, cell);
        for (; lights != 0; lights &= lights - 1) {
            const auto l = static_cast<std::size_t>(std::countr_zero(lights));
            row.bytes[l] = static_cast<std::uint8_t>(lit[l] >> (8 * cell));
        }
        return row;
    }

    /// Stores a cell, if it holds more than what is uniform in its brick.
    CellIndex keep(CellRow row, std::uint64_t uniform, std::uint64_t uniformly_lit) {
        std::uint64_t lit = 0;
        std::uint64_t mixed = 0;
        for (std::size_t l = 0; l < lights_per_tile; ++l) {
            if ((uniform >> l & 1) != 0)
                row.bytes[l] = (uniformly_lit >> l & 1) != 0 ? 0xff : 0;
            lit |= static_cast<std::uint64_t>(row.bytes[l] == 0xff) << l;
            mixed |= static_cast<std::uint64_t>(row.bytes[l] != 0xff && row.bytes[l] != 0) << l;
        }
        if (((lit | mixed) & ~uniform) == 0)
            return {};
        if (std::popcount(mixed) > most_mixed_in_words) {
            const std::uint32_t index = rows_.allocate();
            rows_[index] = row;
            return CellIndex::row(index);
        }
        const std::uint32_t index = words_.allocate(mixed == 0 ? 2 : 3);
        std::uint64_t* record = &words_[index];
        record[0] = lit;
        record[1] = mixed;
        int shift = 0;
        for (std::uint64_t rest = mixed; rest != 0; rest &= rest - 1, shift += 8)
            record[2] |=
                static_cast<std::uint64_t>(row.bytes[static_cast<std::size_t>(std::countr_zero(rest))])
                << shift;
        return CellIndex::words(index);
    }

    Settings settings_;
    Grid grid_;
    LightTable lights_;
    std::shared_ptr<const std::vector<Light>> user_lights_;
    std::atomic<const SlotTable*> table_{nullptr};
    mutable std::mutex growing_;
    std::vector<std::unique_ptr<SlotTable>> tables_;
    Pool<Region> regions_;
    Pool<Brick> bricks_;
    Pool<std::uint32_t> tile_indices_;
    Pool<BrickTile> tiles_;
    Pool<CellRow> rows_;
    Pool<std::uint64_t> words_;
    std::size_t region_count_ = 0;
    std::uint16_t frame_ = 0;
    /// For each tile that was there at the last update, by its index.
    std::vector<KeptLights> kept_;
    std::mutex superseding_;
    std::vector<std::uint32_t> superseded_;  ///< `CellIndex` values
    std::atomic<std::size_t> superseded_bytes_{0};
};

}  // namespace lightmesh::detail
