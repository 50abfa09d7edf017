// SPDX-License-Identifier: MIT
#include "render/render_together.hpp"

#include "render/share_out.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// In each round for each rank: enough for ranks to end at about the same time, few enough for a group to
/// keep all cores of a rank busy.
constexpr std::size_t groups_per_rank = 4;

struct TileGrid {
    int columns;
    int rows;

    explicit TileGrid(const RenderOptions& options)
        : columns((options.width + tile_size - 1) / tile_size),
          rows((options.height + tile_size - 1) / tile_size) {}
};

/// The bits of two numbers in turns.
std::uint64_t interleaved(std::uint32_t x, std::uint32_t y) {
    std::uint64_t bits = 0;
    for (int i = 0; i < 32; ++i)
        bits |= (std::uint64_t{x} >> i & 1) << (2 * i) | (std::uint64_t{y} >> i & 1) << (2 * i + 1);
    return bits;
}

/// All tiles in Morton's order: those that follow each other lie beside each other, and see the same.
std::vector<int> ordered_tiles(const TileGrid& grid) {
    std::vector<int> tiles(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
    std::iota(tiles.begin(), tiles.end(), 0);
    std::ranges::sort(tiles, {}, [&](int tile) {
        return interleaved(static_cast<std::uint32_t>(tile % grid.columns),
                           static_cast<std::uint32_t>(tile / grid.columns));
    });
    return tiles;
}

/// Calls visit(pixels of a row, how many of them) for the rows of tiles, tile by tile.
template <class Picture, class Visit>
void for_each_row(Picture& image, const TileGrid& grid, const std::vector<int>& tiles, const Visit& visit) {
    for (const int tile : tiles) {
        const int left = tile % grid.columns * tile_size;
        const int top = tile / grid.columns * tile_size;
        const int width = (std::min)(tile_size, image.width - left);
        for (int y = top; y < (std::min)(top + tile_size, image.height); ++y)
            visit(&image.at(left, y), static_cast<std::size_t>(width));
    }
}

Bytes pixels_of(const Image& image, const TileGrid& grid, const std::vector<int>& tiles) {
    Bytes bytes;
    for_each_row(image, grid, tiles, [&](const glm::vec3* row, std::size_t count) {
        const auto* begin = reinterpret_cast<const std::byte*>(row);
        bytes.insert(bytes.end(), begin, begin + count * sizeof *row);
    });
    return bytes;
}

void put_pixels(const Bytes& bytes, const TileGrid& grid, const std::vector<int>& tiles, Image& image) {
    std::size_t place = 0;
    for_each_row(image, grid, tiles, [&](glm::vec3* row, std::size_t count) {
        const std::size_t size = count * sizeof *row;
        if (place + size > bytes.size())
            throw std::runtime_error("another rank has sent too few pixels");
        std::memcpy(row, bytes.data() + place, size);
        place += size;
    });
}

}  // namespace

Image render_together(Ranks& ranks, const EmbreeScene& scene, const Visibility& visibility,
                      const RenderOptions& options, RenderStatistics& statistics, const Progress& progress,
                      const std::function<void()>& after_round) {
    const auto start = std::chrono::steady_clock::now();
    const TileGrid grid(options);
    const std::vector<int> order = ordered_tiles(grid);
    const std::size_t groups = groups_per_rank * static_cast<std::size_t>(ranks.size());
    int round = 0;
    // A rank goes on in a later round where it was in the one before.
    const auto tiles_of = [&](std::size_t group) {
        constexpr auto rounds = static_cast<std::size_t>(together_rounds);
        const std::size_t run = group / groups_per_rank;
        const std::size_t place =
            (run * rounds + static_cast<std::size_t>(round)) * groups_per_rank + group % groups_per_rank;
        const auto at = [&](std::size_t i) {
            return order.begin() + static_cast<std::ptrdiff_t>(i * order.size() / (rounds * groups));
        };
        return std::vector<int>(at(place), at(place + 1));
    };
    statistics = {};
    const auto work = [&](std::size_t group, WorkWatch& watch) {
        RenderOptions part = options;
        part.tiles = tiles_of(group);
        if (part.tiles.empty())
            return Bytes{};
        RenderStatistics spent;
        const Image image = render(
            scene, visibility, part, spent, [&](double) { watch.look(); }, &watch.is_in_vain());
        statistics += spent;
        return pixels_of(image, grid, part.tiles);
    };
    Image picture = ranks.is_first() ? Image(options.width, options.height) : Image();
    std::size_t done = 0;
    const auto take = [&](std::size_t group, int, const Bytes& pixels) {
        put_pixels(pixels, grid, tiles_of(group), picture);
        done += tiles_of(group).size();
        if (progress)
            progress(static_cast<double>(done) / static_cast<double>(order.size()));
    };
    for (; round < together_rounds; ++round) {
        share_out(ranks, groups, work, take);
        after_round();
    }
    statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return picture;
}

}  // namespace demo
