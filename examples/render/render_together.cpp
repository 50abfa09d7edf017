// SPDX-License-Identifier: MIT
#include "render/render_together.hpp"

#include "render/share_out.hpp"
#include "render/stopwatch.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// The share of a picture that is done when a round begins. The first rounds find what is coarse and seen
/// from everywhere: they are short.
constexpr std::array<std::size_t, together_rounds + 1> parts_before{0, 1, 3, 6, 12, 24, 36, 48};

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
    const Stopwatch stopwatch;
    const TileGrid grid(options);
    const std::vector<int> order = ordered_tiles(grid);
    const auto pieces = static_cast<std::size_t>(ranks.size());
    int round = 0;
    // In each round one for each rank, which goes on where it was: smaller ones would keep the ranks busy to
    // the end of a round, but beside each other, where all find the same.
    const auto tiles_of = [&](std::size_t piece) {
        const auto at = [&](int begun) {
            const std::size_t parts =
                piece * parts_before.back() + parts_before[static_cast<std::size_t>(begun)];
            return order.begin() +
                   static_cast<std::ptrdiff_t>(parts * order.size() / (pieces * parts_before.back()));
        };
        return std::vector<int>(at(round), at(round + 1));
    };
    statistics = {};
    const auto work = [&](std::size_t piece, WorkWatch& watch) {
        RenderOptions part = options;
        part.tiles = tiles_of(piece);
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
    const auto take = [&](std::size_t piece, int, const Bytes& pixels) {
        put_pixels(pixels, grid, tiles_of(piece), picture);
        done += tiles_of(piece).size();
        if (progress)
            progress(static_cast<double>(done) / static_cast<double>(order.size()));
    };
    for (; round < together_rounds; ++round) {
        share_out(ranks, pieces, work, take);
        after_round();
    }
    statistics.seconds = stopwatch.seconds();
    return picture;
}

}  // namespace demo
