// SPDX-License-Identifier: MIT
#include "render/run.hpp"

#include "render/lamps.hpp"
#include "render/merge_ranks.hpp"
#include "render/render_together.hpp"
#include "render/stopwatch.hpp"
#include "render/terminal.hpp"
#include "render/text_table.hpp"

#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace demo {

namespace {

/// The work that a rank has done.
struct RankPart {
    RenderStatistics statistics;
    lightmesh::MeshStatistics mesh;
    lightmesh::CacheStatistics cache;
};

void add(Run& sum, const RankPart& part) {
    sum.statistics += part.statistics;
    if (sum.mesh)
        sum.mesh->add_work(part.mesh);
    if (sum.cache)
        sum.cache->add_work(part.cache);
}

using MakeImage = std::function<Image(Visibility&, RenderStatistics&, ProgressBar&)>;

Run run_by(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
           ProgressBar::Elsewhere progress_elsewhere, const MakeImage& make_image) {
    Run made = run_begun(algorithm, scene, visibility);
    const Stopwatch stopwatch;
    const std::unique_ptr<Visibility> shadows = make_visibility(algorithm, scene, visibility);
    made.seconds_preparing = stopwatch.seconds();
    {
        ProgressBar bar(algorithm, progress_elsewhere);
        made.image = make_image(*shadows, made.statistics, bar);
    }
    made.mesh = shadows->mesh();
    made.cache = shadows->cache();
    made.bytes = made.mesh ? made.mesh->bytes : made.cache ? made.cache->bytes : shadows->bytes();
    if (visibility.keep_snapshot)
        made.snapshot = shadows->snapshot();
    return made;
}

}  // namespace

void add_other_ranks(Run& made, Ranks& ranks) {
    const std::vector<Bytes> parts =
        ranks.gather(bytes_of(RankPart{made.statistics, made.mesh.value_or(lightmesh::MeshStatistics{}),
                                       made.cache.value_or(lightmesh::CacheStatistics{})}));
    for (std::size_t rank = 1; rank < parts.size(); ++rank)
        add(made, value_in<RankPart>(parts[rank]));
    made.ranks = ranks.size();
}

Run run_begun(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility) {
    Run begun;
    begun.algorithm = algorithm;
    begun.settings = visibility.settings;
    begun.spacing = cache_settings_of(visibility).spacing;
    begun.shaft_rows = cache_settings_of(visibility).shaft_rows;
    begun.exact_edges = cache_settings_of(visibility).exact_edges;
    begun.lamp_sizes = lamp_size_text(lamps_of(scene, visibility));
    return begun;
}

Run run(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
        const RenderOptions& options) {
    return run_by(algorithm, scene, visibility, ProgressBar::Elsewhere::nothing,
                  [&](const Visibility& shadows, RenderStatistics& statistics, ProgressBar& bar) {
                      return render(
                          scene, shadows, options, statistics, [&](double done) { bar.show(done); },
                          &interrupted());
                  });
}

Run run(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
        const RenderOptions& options, Ranks& ranks) {
    if (ranks.size() == 1)
        return run(algorithm, scene, visibility, options);
    Run made = run_by(algorithm, scene, visibility, progress_elsewhere(ranks),
                      [&](Visibility& shadows, RenderStatistics& statistics, ProgressBar& bar) {
                          static_cast<void>(interrupted());
                          RankMerge merge;
                          int rounds = 0;
                          const auto after_round = [&] {
                              if (++rounds < together_rounds || visibility.keep_snapshot)
                                  merge.run(ranks, shadows);
                          };
                          return render_together(
                              ranks, scene, shadows, options, statistics,
                              [&](double done) { bar.show(done); }, after_round);
                      });
    add_other_ranks(made, ranks);
    return made;
}

std::string report(const Run& run, const EmbreeScene& scene) {
    const RenderStatistics& spent = run.statistics;
    const std::size_t lights = scene.scene().lights.size();
    TextTable table;
    table.add_row({"algorithm", run.algorithm});
    table.add_row({"triangles", grouped(scene.scene().triangles.size())});
    table.add_row({"lights", grouped(lights)});
    // Also where this algorithm knows no such thing: they are what another one would take of this view.
    table.add_row({"radius r", number(run.settings.radius)});
    table.add_row({"quality q", number(run.settings.quality)});
    table.add_row({"spacing g", number(run.spacing)});
    if (!run.shaft_rows)
        table.add_row({"shaft rows", "none"});
    if (run.exact_edges)
        table.add_row({"edges", "exact"});
    table.add_row({"lamp radius", run.lamp_sizes});
    if (!run.device.empty())
        table.add_row({"device", run.device});
    if (run.ranks > 1)
        table.add_row({"ranks, whose points and rays are summed", std::to_string(run.ranks)});
    table.add_row({"surface points", grouped(spent.shading_points)});
    table.add_rule();
    table.add_row({"seconds: BVH", fixed(scene.seconds_building(), 3)});
    table.add_row({"seconds: preparing shadows", fixed(run.seconds_preparing, 3)});
    table.add_row({"seconds: rendering", fixed(spent.seconds, 3)});
    if (run.device.empty()) {
        table.add_row({"  of all threads: rays to surfaces", fixed(spent.seconds_tracing, 3)});
        table.add_row({run.mesh ? "  of all threads: light mesh" : "  of all threads: shadows",
                       fixed(spent.visibility.seconds, 3)});
        table.add_row({"  of all threads: shading", fixed(spent.seconds_shading, 3)});
    } else {
        table.add_row(
            {run.ranks > 1 ? "  in shaders of rank 0" : "  in shaders", fixed(run.seconds_device, 3)});
    }
    table.add_rule();
    table.add_row({"primary rays", grouped(spent.primary_rays)});
    table.add_row({"mirrored and refracted rays", grouped(spent.secondary_rays)});
    // Shaders count their own.
    const bool is_counted_by_cache = run.cache && run.device.empty();
    table.add_row({is_counted_by_cache ? "rays from points" : "shadow rays",
                   grouped(is_counted_by_cache ? run.cache->point_rays : spent.visibility.shadow_rays)});
    if (run.mesh) {
        table.add_row({"short rays", grouped(spent.visibility.short_rays)});
        table.add_row({"long rays", grouped(run.mesh->long_rays + run.mesh->listed_rays)});
        if (!run.device.empty())
            table.add_row({"  by shaders", grouped(run.mesh->listed_rays)});
        table.add_row({"link rays", grouped(run.mesh->link_rays + run.mesh->listed_link_rays)});
        if (run.mesh->listed_link_rays > 0)
            table.add_row({"  by shaders", grouped(run.mesh->listed_link_rays)});
        table.add_row({"long tests", grouped(run.mesh->long_tests)});
        table.add_row({"light points", grouped(run.mesh->light_points)});
    }
    if (run.cache) {
        table.add_row({"rays to lamps", grouped(run.cache->lamp_rays + run.cache->listed_rays)});
        if (!run.device.empty())
            table.add_row({"  by shaders", grouped(run.cache->listed_rays)});
        table.add_row({"rays to surfaces and links", grouped(run.cache->drop_rays + run.cache->link_rays)});
        table.add_row({"records", grouped(run.cache->records)});
    }
    table.add_row({run.mesh    ? "memory of the mesh"
                   : run.cache ? "memory of the cache"
                               : "memory of maps and volumes",
                   bytes_text(run.bytes)});
    const double pairs = static_cast<double>(spent.shading_points) * static_cast<double>(lights);
    table.add_row({"ns per point and light", pairs > 0.0 && run.device.empty()
                                                 ? fixed(1e9 * spent.visibility.seconds / pairs, 2)
                                                 : "-"});
    return table.text();
}

void prepare_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        throw std::runtime_error("cannot make the folder " + folder.string() + ": " + error.message());
    std::string name = (folder / ".lightmesh-XXXXXX").string();
    const int file = mkstemp(name.data());
    if (file < 0) {
        const std::error_code reason(errno, std::generic_category());
        throw std::runtime_error("cannot write into the folder " + folder.string() + ": " + reason.message());
    }
    close(file);
    unlink(name.c_str());
}

void prepare_file(const std::filesystem::path& file) {
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored))
        throw std::runtime_error("cannot write " + file.string() +
                                 ": there is something that is no regular file");
    prepare_folder(file.has_parent_path() ? file.parent_path() : std::filesystem::path("."));
}

void prepare_picture(const std::filesystem::path& file) {
    if (file.extension() != ".png" && file.extension() != ".exr")
        throw std::runtime_error("cannot write " + file.string() + ": its name must end in .png or .exr");
    prepare_file(file);
}

}  // namespace demo
