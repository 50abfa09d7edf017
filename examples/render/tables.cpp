// SPDX-License-Identifier: MIT
#include "render/commands.hpp"
#include "render/options.hpp"
#include "render/run.hpp"
#include "render/text_table.hpp"

#include <algorithm>
#include <array>
#include <iostream>
#include <map>
#include <memory>
#include <utility>

namespace demo {

namespace {

/// Seconds as published in 2013, in the order of `PaperTable::columns`; 0: not published.
struct PaperRow {
    std::string title;
    std::string algorithm;
    std::array<double, 4> seconds;
};

struct Column {
    float radius;
    int map_size;
};

struct PaperTable {
    std::string scene;
    float quality;
    std::array<Column, 4> columns;
    std::vector<PaperRow> rows;
};

/// The rows that the paper has, then those that are beside it here.
std::vector<PaperRow> rows_with(std::array<double, 4> lmm, std::array<double, 4> maps,
                                std::array<double, 4> express, std::array<double, 4> express_maps) {
    return {{"LMM", "lmm", lmm},
            {"LMM+ATK", "lmm+map", maps},
            {"Express LMM", "express", express},
            {"Express LMM+ATK", "express+map", express_maps},
            {"LMM+ATO", "lmm+volume", {}},
            {"Linked LMM", "linked", {}},
            {"Linked LMM+ATK", "linked+map", {}},
            {"Whitted (hard)", "whitted", {}},
            {"area lights", "area", {}},
            {"visibility cache", "cache", {}}};
}

std::vector<PaperTable> paper_tables() {
    return {{"spheres",
             6.0f,
             {{{4.5f, 1024}, {4.5f, 512}, {5.5f, 1024}, {5.5f, 512}}},
             rows_with({42.6, 42.6, 77.6, 77.6}, {41.5, 42.2, 76.8, 76.3}, {6.52, 6.2, 12.8, 12.8},
                       {6.4, 6.33, 9.53, 9.52})},
            {"park",
             4.0f,
             {{{3.0f, 1024}, {3.0f, 512}, {4.0f, 1024}, {4.0f, 512}}},
             rows_with({65.1, 65.1, 146.1, 146.1}, {62.7, 59.5, 142.8, 141.1}, {12.65, 12.65, 13.3, 13.3},
                       {4.0, 3.98, 5.2, 5.1})}};
}

bool uses_maps(const std::string& algorithm) {
    return algorithm.ends_with("+map");
}

/// Renders what the cells need, nothing twice.
class Cells {
public:
    Cells(const PaperTable& table, const EmbreeScene& scene, const CommonOptions& options)
        : table_(table), scene_(scene), options_(options) {}

    const Run& at(const std::string& algorithm, const Column& column) {
        const bool has_radius = algorithm != "whitted";
        const std::pair key(algorithm +
                                (has_radius ? " r=" + fixed(static_cast<double>(column.radius), 1) : ""),
                            uses_maps(algorithm) ? column.map_size : 0);
        auto found = runs_.find(key);
        if (found == runs_.end())
            found = runs_.emplace(key, render_cell(algorithm, column)).first;
        return found->second;
    }

    VisibilityOptions options_at(const Column& column) const {
        VisibilityOptions visibility = visibility_options(options_, scene_.scene());
        visibility.settings.radius = column.radius;
        visibility.settings.quality = table_.quality;
        visibility.settings.shadow_map_size = column.map_size;
        visibility.settings.footprint_scale = 0.0f;  // the paper has no levels
        return visibility;
    }

private:
    Run render_cell(const std::string& algorithm, const Column& column) const {
        return run(algorithm, scene_, options_at(column), options_.render);
    }

    const PaperTable& table_;
    const EmbreeScene& scene_;
    const CommonOptions& options_;
    std::map<std::pair<std::string, int>, Run> runs_;
};

std::string cell_text(const Run& made, const Run& lmm, double published) {
    return fixed(made.seconds(), 2) + (published > 0.0 ? " (" + fixed(published, 1) + ")" : " (-)") + "  " +
           fixed(100.0 * mean_absolute_difference(made.image, lmm.image), 3) + " %";
}

/// False if the user has stopped it.
bool print_table(const PaperTable& table, CommonOptions options) {
    options.scene = table.scene;
    const Scene scene = show_scene(options);
    const EmbreeScene embree(scene);
    Cells cells(table, embree, options);
    TextTable text;
    std::vector<std::string> header{scene.name + ", q=" + fixed(static_cast<double>(table.quality), 0)};
    for (const Column& column : table.columns)
        header.push_back("r=" + fixed(static_cast<double>(column.radius), 1) + ", map " +
                         std::to_string(column.map_size) + ", g " +
                         number(cache_settings_of(cells.options_at(column)).spacing));
    text.add_row(header);
    text.add_rule();
    for (const PaperRow& row : table.rows) {
        std::vector<std::string> line{row.title};
        for (std::size_t c = 0; c < table.columns.size(); ++c) {
            const Run& lmm = cells.at("lmm", table.columns[c]);
            const Run& made = cells.at(row.algorithm, table.columns[c]);
            if (!lmm.statistics.finished || !made.statistics.finished)
                return false;
            line.push_back(cell_text(made, lmm, row.seconds[c]));
        }
        text.add_row(line);
    }
    std::cout << '\n'
              << grouped(scene.triangles.size()) << " triangles, " << scene.lights.size() << " lights, "
              << options.render.width << " x " << options.render.height << " pixels\n"
              << text.text() << std::flush;
    return true;
}

struct TablesOptions : CommonOptions {
    std::vector<std::string> scenes{"spheres", "park"};
};

int print_tables(const TablesOptions& options) {
    std::cout << "Seconds for a frame here, from an empty mesh (in the paper, on its machine of 2013); mean "
                 "absolute\n"
                 "difference of the picture's linear values to LMM's.\n";
    for (const PaperTable& table : paper_tables()) {
        if (std::ranges::find(options.scenes, table.scene) == options.scenes.end())
            continue;
        if (!print_table(table, options)) {
            std::cerr << "interrupted: the tables are not finished\n";
            return exit_interrupted;
        }
    }
    return 0;
}

}  // namespace

void add_tables_command(CLI::App& program, int& status) {
    const auto options = std::make_shared<TablesOptions>();
    CLI::App* command = program.add_subcommand("tables", "the two tables of the paper, on this machine");
    command->add_option("scenes", options->scenes, "whose table")
        ->check(CLI::IsMember({"spheres", "park"}))
        ->capture_default_str();
    add_render_options(*command, *options);
    command->callback([options, &status] { status = print_tables(*options); });
}

}  // namespace demo
