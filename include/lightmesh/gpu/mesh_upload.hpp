// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/gpu/upload.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/flood.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/mesh_view.hpp>
#include <lightmesh/mesh/snapshot_reader.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/seeds.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/snapshot.hpp>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <vector>

namespace lightmesh {

/// A mesh as shaders read it (see lightmesh.glsl), with all of its levels: what to bind, and what to write
/// again when the mesh has been filled further, or has changed. Made from a `SnapshotView`, which has checked
/// all bytes.
///
///     MeshUpload upload(SnapshotView(bytes));
///     for (const UploadBuffer& buffer : upload.buffers())  ...                    // create and bind them
///     ... later: for (const UploadRange& range : upload.update(SnapshotView(newer)))  ...    // write these
///
/// Snapshots keep lights in the order of a new mesh, in groups of eight: after updates call `compact` before
/// `fill`, or what is missing here may be known there.
///
/// What a shader needs beside them is a request buffer, `requests_binding`, made by `empty_requests`.
class MeshUpload {
public:
    /// Number of buffers that `buffers` returns: bindings 0 to 4.
    static constexpr std::uint32_t buffer_count = 5;
    /// The binding of the request buffer, counted from LIGHTMESH_BINDING.
    static constexpr std::uint32_t requests_binding = 5;

    /// Throws std::invalid_argument if the view is of a cache; std::length_error if the mesh is too large for
    /// 32-bit indices.
    explicit MeshUpload(const SnapshotView& view) { update(view); }

    /// The buffers from LIGHTMESH_BINDING on, all of their bytes. Valid until the next `update`.
    std::array<UploadBuffer, buffer_count> buffers() const {
        std::array<UploadBuffer, buffer_count> all;
        for (std::uint32_t i = 0; i < buffer_count; ++i)
            all[i] = {i, words_[i].bytes()};
        return all;
    }

    /// Takes what the view has in the place of what there was. Returns what is to be written to the buffers,
    /// in multiples of 256 bytes; valid until the next `update`. A buffer may have become larger: then all of
    /// it is among them, and it is to be created anew. The cost is that of reading the snapshot. Throws what
    /// the constructor throws, and has then changed nothing if the view is of the wrong kind.
    std::vector<UploadRange> update(const SnapshotView& view) {
        const detail::SnapshotReader* reader = detail::SnapshotReaders::mesh(view);
        if (reader == nullptr)
            throw std::invalid_argument("lightmesh: this snapshot is of a cache, not of a mesh");
        const detail::MeshView& finest = reader->finest().view();
        if (!fits(finest))
            start_anew(*reader);
        set_header(*reader);
        set_lights(*finest.lights);
        ++round_;
        reader->for_each([&](int k, const detail::SnapshotLevel& level) {
            level.for_each_brick([&](const detail::Brick& brick) { set_brick(level.view(), k, brick); });
        });
        remove_others();
        std::vector<UploadRange> ranges;
        for (std::uint32_t i = 0; i < buffer_count; ++i)
            words_[i].take_changes(i, ranges);
        return ranges;
    }

    /// The least LIGHTMESH_MAX_QUALITY that serves the mesh.
    int max_quality() const { return static_cast<int>(std::ceil(quality_)); }

    /// True if only shaders with LIGHTMESH_EXACT serve the mesh.
    bool is_exact() const { return words_[header][3] == static_cast<std::uint32_t>(ShortTest::exact); }

private:
    enum Buffer : std::size_t { header, lights, directory, bricks, bits };

    // As in lightmesh.glsl.
    static constexpr std::size_t light_tile_words = 8;
    static constexpr std::size_t light_words = 16;
    static constexpr std::size_t slot_words = 4;
    static constexpr std::size_t region_words = 64;
    static constexpr std::size_t brick_head = 4;
    static constexpr std::size_t tile_words = 16;
    static constexpr std::size_t seed_bounds = 32;
    static constexpr std::size_t header_words = 14;
    static constexpr std::size_t level_words = 12 + seed_bounds + 10;
    static constexpr std::uint32_t cell_points = 8;
    static constexpr int region_bits = 27;                             ///< of their numbers; above: the level
    static constexpr std::size_t most_regions = std::size_t{1} << 25;  ///< words of more have no number

    detail::UploadWords& words(Buffer buffer) { return words_[buffer]; }

    /// True if what there is can hold the mesh: bricks of the same size on the same grid.
    bool fits(const detail::MeshView& mesh) const {
        return round_ != 0 && tile_count_ == mesh.lights->tile_count() && quality_ == mesh.grid->quality() &&
               step_ == mesh.grid->step() && origin_ == mesh.grid->origin();
    }

    void start_anew(const detail::SnapshotReader& reader) {
        const detail::MeshView& mesh = reader.finest().view();
        *this = MeshUpload();
        tile_count_ = mesh.lights->tile_count();
        quality_ = mesh.grid->quality();
        step_ = mesh.grid->step();
        origin_ = mesh.grid->origin();
        brick_words_ = brick_head + tile_words * tile_count_;
        flood_slots_ = detail::FloodBox::slots(quality_);
        const auto levels = static_cast<std::size_t>(reader.rule().coarsest()) + 1;
        words(header).grow(header_words + level_words * levels);
        for (std::size_t k = 0; k < levels; ++k)
            set_level(header_words + level_words * k, reader.grid_of(static_cast<int>(k)));
        words(bricks).grow(1);
        words(bits).grow(1);
        make_directory(4);
    }

    /// At `at` in the header what levels differ in.
    void set_level(std::size_t at, const Grid& grid) {
        detail::UploadWords& to = words(header);
        to.set(at, grid.step());
        to.set(at + 2, 1.0 / grid.step());
        for (int axis = 0; axis < 3; ++axis)
            to.set(at + 4 + 2 * static_cast<std::size_t>(axis), grid.origin()[axis]);
        to.set(at + 10, static_cast<float>(grid.step()));
        to.set(at + 11, static_cast<float>(grid.step() * Grid::max_index));
        for (std::size_t i = 0; i < seed_bounds; ++i)
            to.set(at + 12 + i, seed_bound(static_cast<int>(i) - 6, grid.step()));
        const auto low_of = [](double value) {
            return static_cast<float>(value - static_cast<double>(static_cast<float>(value)));
        };
        const std::size_t parts = at + 12 + seed_bounds;
        to.set(parts, low_of(grid.step()));
        to.set(parts + 1, static_cast<float>(1.0 / grid.step()));
        to.set(parts + 2, low_of(1.0 / grid.step()));
        for (int axis = 0; axis < 3; ++axis) {
            const double origin = grid.origin()[axis];
            to.set(parts + 3 + static_cast<std::size_t>(axis), static_cast<float>(origin));
            to.set(parts + 6 + static_cast<std::size_t>(axis), low_of(origin));
        }
    }

    void set_header(const detail::SnapshotReader& reader) {
        detail::UploadWords& to = words(header);
        to.set(0, reader.rule().steps_per_footprint());
        to.set(2, quality_);
        to.set(3, static_cast<std::uint32_t>(reader.settings().short_test));
        const detail::Hemisphere at_origin(reader.finest().grid(), glm::dvec3(0.0), glm::vec3(0.0f),
                                           glm::vec3(0.0f));
        to.set(4, static_cast<std::uint32_t>(at_origin.fraction_bits));
        to.set(5, static_cast<std::uint32_t>(at_origin.radius_squared));
        to.set(6, static_cast<std::uint32_t>(reader.lights().size()));
        to.set(9, static_cast<std::uint32_t>(brick_words_));
        to.set(10, static_cast<std::uint32_t>(detail::FloodBox::side_of(quality_)));
        to.set(11, flood_words());
        to.set(12, static_cast<std::uint32_t>(reader.rule().coarsest()));
    }

    /// The least magnitude of a point from which on seeds are sought 2^exponent steps in front of it, or
    /// more.
    static float seed_bound(int exponent, double step) {
        std::uint32_t below = 0;
        std::uint32_t from = std::bit_cast<std::uint32_t>((std::numeric_limits<float>::max)());
        while (from - below > 1) {
            const std::uint32_t middle = below + (from - below) / 2;
            const bool reaches =
                detail::SeedCandidates::exponent_in_front(std::bit_cast<float>(middle), step) >= exponent;
            (reaches ? from : below) = middle;
        }
        return std::bit_cast<float>(from);
    }

    // ---- lights

    void set_lights(const detail::LightTable& table) {
        detail::UploadWords& to = words(lights);
        to.grow((std::max)(tile_count_ * (light_tile_words + detail::lights_per_tile * light_words),
                           std::size_t{1}));
        for (std::size_t t = 0; t < tile_count_; ++t) {
            const detail::LightColumns& tile = table.tile(t);
            const std::size_t head = light_tile_words * t;
            for (int axis = 0; axis < 3; ++axis) {
                to.set(head + static_cast<std::size_t>(axis), tile.box.low[axis]);
                to.set(head + 3 + static_cast<std::size_t>(axis), tile.box.high[axis]);
            }
            to.set(head + 6, tile.largest_at);
            for (std::size_t l = 0; l < static_cast<std::size_t>(table.tile_size(t)); ++l)
                set_light(light_tile_words * tile_count_ + light_words * (detail::lights_per_tile * t + l),
                          tile, l, table.order().light_at(detail::lights_per_tile * t + l));
        }
    }

    void set_light(std::size_t at, const detail::LightColumns& tile, std::size_t l, std::size_t number) {
        enum : std::uint32_t { directional = 1, range = 2, cone = 4, wide = 8, nothing = 16, odd_range = 32 };
        const detail::LightCone of = tile.cones.empty() ? detail::LightCone{} : tile.cones[l];
        std::uint32_t kind = 0;
        kind |= tile.w[l] == 0.0f ? directional : 0u;
        kind |= std::isinf(tile.range_squared[l]) ? 0u : range;
        kind |= of.is_everything ? 0u : cone;
        kind |= of.is_wide ? wide : 0u;
        kind |= tile.range_squared[l] < 0.0 ? nothing : 0u;
        const bool is_odd = std::isnan(tile.coarse_range_squared[l]);
        kind |= is_odd ? odd_range : 0u;
        detail::UploadWords& to = words(lights);
        to.set(at, tile.at_x[l]);
        to.set(at + 1, tile.at_y[l]);
        to.set(at + 2, tile.at_z[l]);
        to.set(at + 3, kind);
        to.set(at + 4, tile.range_squared[l]);
        to.set(at + 6, is_odd ? 0.0f : tile.coarse_range_squared[l]);
        for (int axis = 0; axis < 3; ++axis)
            to.set(at + 7 + 2 * static_cast<std::size_t>(axis), of.axis[axis]);
        to.set(at + 13, of.tangent_squared);
        to.set(at + 15, static_cast<std::uint32_t>(number));
    }

    // ---- the directory: slots {x, y, z, number plus one and the level} of regions, then regions of 4x4x4
    // bricks. The fourth coordinate of bricks and of regions is their level.

    struct RegionHash {
        std::size_t operator()(const glm::ivec4& region) const {
            const auto x = static_cast<std::uint32_t>(region.x);
            const auto y = static_cast<std::uint32_t>(region.y);
            const auto z = static_cast<std::uint32_t>(region.z);
            const auto level = static_cast<std::uint32_t>(region.w);
            const std::uint32_t hash =
                x * 0x9e3779b1u ^ y * 0x85ebca77u ^ z * 0xc2b2ae3du ^ level * 0x27d4eb2fu;
            return hash ^ hash >> 15;
        }
    };

    static glm::ivec4 region_of(const glm::ivec4& coord) {
        return {coord.x >> 2, coord.y >> 2, coord.z >> 2, coord.w};
    }

    static std::size_t slot_in_region(const glm::ivec4& coord) {
        return static_cast<std::size_t>((coord.x & 3) + 4 * (coord.y & 3) + 16 * (coord.z & 3));
    }

    std::size_t first_region() const { return slot_words * slot_count_; }

    void make_directory(std::size_t slot_count) {
        const std::size_t old_first = first_region();
        std::vector<std::uint32_t> old(regions_.size() * region_words);
        for (std::size_t i = 0; i < old.size(); ++i)
            old[i] = words(directory)[old_first + i];
        slot_count_ = slot_count;
        words(directory).grow(first_region() + (slot_count / 2) * region_words);
        for (std::size_t i = 0; i < first_region(); ++i)
            words(directory).set(i, 0u);
        for (std::size_t i = 0; i < old.size(); ++i)
            words(directory).set(first_region() + i, old[i]);
        for (std::uint32_t region = 0; region < regions_.size(); ++region)
            insert(regions_[region], region);
        words(header).set(7, static_cast<std::uint32_t>(slot_count - 1));
        words(header).set(8, static_cast<std::uint32_t>(first_region()));
    }

    void insert(const glm::ivec4& region, std::uint32_t number) {
        std::size_t slot = RegionHash{}(region) & (slot_count_ - 1);
        detail::UploadWords& to = words(directory);
        while (to[slot_words * slot + 3] != 0)
            slot = (slot + 1) & (slot_count_ - 1);
        for (int axis = 0; axis < 3; ++axis)
            to.set(slot_words * slot + static_cast<std::size_t>(axis),
                   static_cast<std::uint32_t>(region[axis]));
        to.set(slot_words * slot + 3, (number + 1) | static_cast<std::uint32_t>(region.w) << region_bits);
    }

    /// The word of the directory that names a brick.
    std::size_t directory_word(const glm::ivec4& coord) {
        const auto [found, is_new] =
            region_numbers_.try_emplace(region_of(coord), static_cast<std::uint32_t>(regions_.size()));
        const std::uint32_t number = found->second;
        if (is_new) {
            if (regions_.size() == most_regions)
                throw std::length_error("lightmesh: the mesh is too large for a shader");
            if (2 * (regions_.size() + 1) > slot_count_)
                make_directory(2 * slot_count_);
            regions_.push_back(region_of(coord));
            insert(region_of(coord), number);
        }
        return first_region() + region_words * number + slot_in_region(coord);
    }

    // ---- bricks

    void set_brick(const detail::MeshView& mesh, int level, const detail::Brick& brick) {
        const glm::ivec4 coord(brick.position(), level);
        const std::size_t named_at = directory_word(coord);
        std::uint32_t number = words(directory)[named_at];
        if (number == 0) {
            if (free_bricks_.empty()) {
                rounds_.push_back(0);
                coords_.push_back(coord);
                number = static_cast<std::uint32_t>(rounds_.size());
                words(bricks).grow(number * brick_words_);
            } else {
                number = free_bricks_.back();
                free_bricks_.pop_back();
                coords_[number - 1] = coord;
            }
            words(directory).set(named_at, number);
        }
        rounds_[number - 1] = round_;
        const std::size_t record = (number - 1) * brick_words_;
        for (std::size_t t = 0; t < tile_count_; ++t)
            set_tile(mesh, mesh.find_tile(brick, t), record + brick_head + tile_words * t);
        set_floods(mesh, brick, record);
    }

    void set_tile(const detail::MeshView& mesh, const detail::BrickTile* tile, std::size_t record) {
        detail::UploadWords& to = words(bricks);
        to.set(record, tile != nullptr ? tile->known : std::uint64_t{0});
        to.set(record + 2, tile != nullptr ? tile->uniform : std::uint64_t{0});
        to.set(record + 4, tile != nullptr ? tile->lit : std::uint64_t{0});
        std::uint64_t with_words = 0;  // 8 bits a cell, as masks of light points have
        for (std::size_t cell = 0; cell < detail::cells_per_brick; ++cell) {
            set_cell(mesh, detail::CellIndex{tile != nullptr ? tile->cells[cell] : 0u}, record + 8 + cell);
            if (to[record + 8 + cell] != 0)
                with_words |= std::uint64_t{0xff} << 8 * cell;
        }
        to.set(record + 6, with_words);
    }

    /// A cell takes nothing, two equal pairs of words where its light points see the same lights, or one for
    /// each of them: bit l of point p's is V(L_l, x_p).
    void set_cell(const detail::MeshView& mesh, detail::CellIndex from, std::size_t at) {
        std::array<std::uint64_t, cell_points> points{};
        std::uint32_t size = 0;
        if (from.is_words()) {
            const std::uint64_t* record = &mesh.words[from.index()];
            points.fill(record[0]);
            size = record[1] == 0 ? 2 : cell_points;
            int rank = 0;
            for (std::uint64_t rest = record[1]; rest != 0; rest &= rest - 1, ++rank)
                for (std::size_t p = 0; p < cell_points; ++p)
                    if ((record[2] >> (8 * static_cast<std::size_t>(rank) + p) & 1) != 0)
                        points[p] |= rest & (~rest + 1);
        } else if (!from.is_nothing()) {
            size = cell_points;
            const detail::CellRow& row = mesh.rows[from.index()];
            for (std::size_t l = 0; l < detail::lights_per_tile; ++l)
                for (std::size_t p = 0; p < cell_points; ++p)
                    points[p] |= static_cast<std::uint64_t>(row.bytes[l] >> p & 1) << l;
        }
        const std::uint32_t old = words(bricks)[at];
        const std::uint32_t old_size = size_of_cell(old);
        std::uint32_t index = old / 2 - 1;
        if (size != old_size) {
            if (old_size != 0)
                pool_.give_back(index, old_size);
            if (size != 0)
                index = pool_.take(size, words(bits));
        }
        for (std::uint32_t p = 0; p < size; ++p)
            words(bits).set(2 * (std::size_t{index} + p), points[p]);
        words(bricks).set(at, size == 0 ? 0u : 2 * (index + 1) + (size == 2 ? 1u : 0u));
    }

    /// Shaders read two pairs at a time: all that the pool gives begins at an even one.
    static std::uint32_t even(std::uint32_t size) { return (size + 1) / 2 * 2; }

    static std::uint32_t size_of_cell(std::uint32_t cell) {
        return cell == 0 ? 0u : (cell & 1) != 0 ? 2u : cell_points;
    }

    // ---- floods: {first brick of the box, 0}, {full, partial} for each 32 bricks of it, for each of these
    // the number of partial bricks before it, a mask for each partial brick. A brick has a table of their
    // places plus one, in the order of the light points.

    std::uint32_t flood_words() const { return static_cast<std::uint32_t>((flood_slots_ + 31) / 32); }
    std::uint32_t flood_head() const { return 2 + flood_words() + (flood_words() + 1) / 2; }

    void set_floods(const detail::MeshView& mesh, const detail::Brick& brick, std::size_t record) {
        std::array<const std::uint64_t*, 64> found{};
        std::uint64_t seeds = 0;
        for (std::uint32_t flood = brick.floods; flood != 0;) {
            const detail::FloodView view(&mesh.words[flood - 1]);
            const auto bit = static_cast<std::size_t>(view.seed_bit());
            // The one that was added last counts.
            if ((seeds >> bit & 1) == 0)
                found[bit] = view.words();
            seeds |= std::uint64_t{1} << bit;
            flood = view.next();
        }
        std::array<std::uint32_t, 64> floods = old_floods(record);
        const auto had = (std::uint64_t{words(bricks)[record + 3]} << 32) | words(bricks)[record + 2];
        for (std::uint64_t rest = had | seeds; rest != 0; rest &= rest - 1) {
            const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
            floods[bit] = set_flood(brick, static_cast<int>(bit), found[bit], floods[bit]);
        }
        const auto old_size = even(static_cast<std::uint32_t>((std::popcount(had) + 1) / 2));
        const auto size = even(static_cast<std::uint32_t>((std::popcount(seeds) + 1) / 2));
        std::uint32_t table = words(bricks)[record];
        if (size != old_size) {
            if (old_size != 0)
                pool_.give_back(table - 1, old_size);
            table = size != 0 ? pool_.take(size, words(bits)) + 1 : 0;
        }
        words(bricks).set(record, table);
        words(bricks).set(record + 2, seeds);
        std::size_t word = 2 * (std::size_t{table} - 1);
        for (std::uint64_t rest = seeds; rest != 0; rest &= rest - 1)
            words(bits).set(word++, floods[static_cast<std::size_t>(std::countr_zero(rest))]);
    }

    /// Places plus one of a brick's floods by the numbers of their seeds.
    std::array<std::uint32_t, 64> old_floods(std::size_t record) {
        std::array<std::uint32_t, 64> floods{};
        const auto had = (std::uint64_t{words(bricks)[record + 3]} << 32) | words(bricks)[record + 2];
        std::size_t word = 2 * (std::size_t{words(bricks)[record]} - 1);
        for (std::uint64_t rest = had; rest != 0; rest &= rest - 1)
            floods[static_cast<std::size_t>(std::countr_zero(rest))] = words(bits)[word++];
        return floods;
    }

    std::uint32_t flood_size(std::uint32_t index) {
        std::uint32_t size = flood_head();
        for (std::uint32_t w = 0; w < flood_words(); ++w)
            size +=
                static_cast<std::uint32_t>(std::popcount(words(bits)[2 * (std::size_t{index} + 2 + w) + 1]));
        return size;
    }

    /// Writes a flood, or null for none, over an old one (its index plus one, or 0). Returns its index plus
    /// one.
    std::uint32_t set_flood(const detail::Brick& brick, int seed_bit, const std::uint64_t* from,
                            std::uint32_t old) {
        const std::uint32_t old_size = old != 0 ? even(flood_size(old - 1)) : 0;
        std::uint32_t size = 0;
        const std::size_t full_words = detail::FloodView::bit_words(flood_slots_);
        if (from != nullptr)
            size = even(flood_head() + static_cast<std::uint32_t>(detail::FloodView(from).size(flood_slots_) -
                                                                  1 - 2 * full_words));
        if (size != old_size) {
            if (old_size != 0)
                pool_.give_back(old - 1, old_size);
            old = size != 0 ? pool_.take(size, words(bits)) + 1 : 0;
        }
        if (size == 0)
            return 0;
        detail::UploadWords& to = words(bits);
        const std::size_t at = 2 * (std::size_t{old} - 1);
        const detail::FloodBox box(detail::grid_pos_of(brick.position(), seed_bit), quality_);
        for (int axis = 0; axis < 3; ++axis)
            to.set(at + static_cast<std::size_t>(axis), static_cast<std::uint32_t>(box.first[axis]));
        to.set(at + 3, 0u);
        const std::size_t ranks = at + 4 + 2 * std::size_t{flood_words()};
        std::uint32_t rank = 0;
        for (std::uint32_t w = 0; w < flood_words(); ++w) {
            const auto full = static_cast<std::uint32_t>(from[1 + w / 2] >> (32 * (w % 2)));
            const auto partial = static_cast<std::uint32_t>(from[1 + full_words + w / 2] >> (32 * (w % 2)));
            to.set(at + 4 + 2 * std::size_t{w}, full);
            to.set(at + 5 + 2 * std::size_t{w}, partial);
            to.set(ranks + w, rank);
            rank += static_cast<std::uint32_t>(std::popcount(partial));
        }
        if (flood_words() % 2 != 0)
            to.set(ranks + flood_words(), 0u);
        for (std::uint32_t i = 0; i < rank; ++i)
            to.set(at + 2 * (std::size_t{flood_head()} + i), from[1 + 2 * full_words + i]);
        return old;
    }

    /// Forgets bricks that the view does not have.
    void remove_others() {
        for (std::uint32_t number = 1; number <= rounds_.size(); ++number) {
            if (rounds_[number - 1] == round_ || rounds_[number - 1] == 0)
                continue;
            rounds_[number - 1] = 0;
            words(directory).set(directory_word(coords_[number - 1]), 0u);
            const std::size_t record = (number - 1) * brick_words_;
            const detail::MeshView nothing;
            for (std::size_t t = 0; t < tile_count_; ++t)
                set_tile(nothing, nullptr, record + brick_head + tile_words * t);
            detail::Brick without_floods{};
            set_floods(nothing, without_floods, record);
            free_bricks_.push_back(number);
        }
    }

    MeshUpload() = default;

    std::array<detail::UploadWords, buffer_count> words_;
    detail::UploadPool pool_;  ///< of pairs in `bits`
    std::uint64_t round_ = 0;  ///< number of updates
    std::size_t tile_count_ = 0;
    float quality_ = 0.0f;
    double step_ = 0.0;
    glm::dvec3 origin_{0.0};
    std::size_t brick_words_ = 0;
    std::size_t flood_slots_ = 0;
    std::size_t slot_count_ = 0;
    std::vector<glm::ivec4> regions_;  ///< their coordinates
    std::unordered_map<glm::ivec4, std::uint32_t, RegionHash> region_numbers_;
    std::vector<std::uint64_t> rounds_;  ///< of each brick the last update that had it; 0: it is free
    std::vector<glm::ivec4> coords_;     ///< of each brick
    std::vector<std::uint32_t> free_bricks_;
};

}  // namespace lightmesh
