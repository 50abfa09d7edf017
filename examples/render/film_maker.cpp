// SPDX-License-Identifier: MIT
#include "render/film_maker.hpp"

#include "render/lamps.hpp"
#include "render/render_together.hpp"
#include "render/run.hpp"
#include "render/stopwatch.hpp"
#include "render/terminal.hpp"
#include "render/text_table.hpp"

#include <algorithm>
#include <atomic>
#include <span>
#include <utility>
#include <vector>

namespace demo {

namespace {

/// The share of a frame after which its rays are counted again: that is a walk over all that is known.
constexpr double count_step = 1.0 / 16.0;

/// The work that a rank has done.
struct RankCount {
    std::uint64_t frames;
    std::uint64_t rays;
};

}  // namespace

FilmMaker::FilmMaker(Ranks& ranks, std::string algorithm, const RenderOptions& options, Film film,
                     const VisibilityOptions& visibility, std::unique_ptr<GpuFrames> gpu)
    : ranks_(ranks), algorithm_(std::move(algorithm)), options_(options), film_(std::move(film)),
      visibility_(visibility),
      // Trees are built at 0 s, so that they are the same wherever a film begins: what several surfaces let
      // through is rounded in the order in which a ray finds them.
      embree_(film_.scene(), film_.moving().objects ? EmbreeScene::For::films : EmbreeScene::For::stills),
      gpu_(std::move(gpu)) {
    if (gpu_)
        gpu_->follow(embree_, {});
}

std::optional<FilmMaker::Made> FilmMaker::frame(double time, WorkWatch& watch, bool may_wait,
                                                const Progress& progress) {
    const Stopwatch stopwatch;
    begin_frame(time);
    RenderStatistics spent;
    const std::uint64_t before = may_wait ? kept_rays(*shadows_) : 0;
    double next_count = count_step;
    bool waits = false;
    std::atomic<bool> is_in_vain{false};
    const auto show = [&](double done) {
        watch.look();
        if (may_wait && !waits && done >= next_count && done < 0.5) {
            waits = 10 * (kept_rays(*shadows_) - before) > most_rays_;
            next_count = done + count_step;
        }
        is_in_vain = waits || watch.is_in_vain();
        progress(done);
    };
    Made made;
    if (gpu_) {
        watch.look_during([&] {
            GpuFrames::Frame frame = gpu_->render(spent, progress, watch.is_in_vain());
            made = {std::move(frame.linear), std::move(frame.toned)};
        });
    } else {
        made.linear = render(embree_, *shadows_, options_, spent, show, &is_in_vain);
    }
    spent_ += spent;
    if (waits) {
        later_seconds_ += stopwatch.seconds();
        return std::nullopt;
    }
    count_frame(stopwatch.seconds());
    return made;
}

FilmMaker::TogetherMade FilmMaker::frame_together(double time, const Progress& progress) {
    const Stopwatch stopwatch;
    begin_frame(time);
    RenderStatistics spent;
    std::uint64_t before = kept_rays(*shadows_);
    std::uint64_t rays = 0;
    const auto after_round = [&] {
        const std::uint64_t of_round = rays_of_all_since(before);
        before = kept_rays(*shadows_);
        rays += of_round;
        if (rank_0_says(of_round > 0 && 10 * together_rounds * of_round > most_rays_))
            merge_.run(ranks_, *shadows_);
    };
    TogetherMade made{render_together(ranks_, embree_, *shadows_, options_, spent, progress, after_round),
                      false};
    spent_ += spent;
    most_rays_ = value_in<std::uint64_t>(ranks_.broadcast(bytes_of((std::max)(most_rays_, rays))));
    made.is_cold = rank_0_says(10 * rays > most_rays_);
    count_frame(stopwatch.seconds());
    ++made_together_;
    return made;
}

void FilmMaker::merge_at(double time) {
    go_to(time);
    if (gpu_)
        merge_.run(ranks_, *gpu_);
    else
        merge_.run(ranks_, *shadows_);
}

std::string FilmMaker::report(bool is_whole) {
    const Scene& scene = film_.scene();
    TextTable table;
    table.add_row({"algorithm", algorithm_});
    table.add_row({"triangles", grouped(scene.triangles.size())});
    table.add_row({"lights", grouped(scene.lights.size())});
    table.add_row({"radius r", number(visibility_.settings.radius)});
    table.add_row({"quality q", number(visibility_.settings.quality)});
    table.add_row({"spacing g", number(cache_settings_of(visibility_).spacing)});
    if (!visibility_.cache.shaft_rows)
        table.add_row({"shaft rows", "none"});
    if (visibility_.cache.exact_edges)
        table.add_row({"edges", "exact"});
    table.add_row({"lamp radius", lamp_size_text(lamps_of(embree_, visibility_))});
    if (gpu_)
        table.add_row({"device", gpu_->device()});
    std::vector<RankCount> counts;
    if (is_whole) {
        const RankCount mine{static_cast<std::uint64_t>(made_ - made_together_), rays_for_shadows()};
        for (const Bytes& of_rank : ranks_.gather(bytes_of(mine)))
            counts.push_back(value_in<RankCount>(of_rank));
    }
    RankCount all{static_cast<std::uint64_t>(made_together_), 0};
    for (const RankCount& count : counts) {
        all.frames += count.frames;
        all.rays += count.rays;
    }
    if (is_whole) {
        table.add_row({"frames rendered", grouped(all.frames)});
        table.add_row({"rays for shadows", grouped(all.rays)});
    } else {
        table.add_row({ranks_.size() == 1 ? "frames rendered" : "frames rendered by rank 0",
                       grouped(static_cast<std::uint64_t>(made_))});
    }
    add_memory_rows(table);
    if (made_ > 0) {
        table.add_rule();
        table.add_row({"seconds: BVH", fixed(embree_.seconds_building(), 3)});
        table.add_row({"seconds: first frame", fixed(first_seconds_, 3)});
        table.add_row(
            {"seconds: each frame after it", made_ > 1 ? fixed(later_seconds_ / (made_ - 1), 3) : "-"});
        table.add_row({"seconds: poses and updates, each frame", fixed(seconds_between_ / made_, 3)});
        if (gpu_) {
            table.add_row({"seconds: in shaders, each frame", fixed(gpu_->seconds_device() / made_, 3)});
        } else {
            table.add_row({"  of all threads: rays to surfaces", fixed(spent_.seconds_tracing, 3)});
            table.add_row({"  of all threads: shadows", fixed(spent_.visibility.seconds, 3)});
            table.add_row({"  of all threads: shading", fixed(spent_.seconds_shading, 3)});
        }
    }
    if (counts.size() > 1) {
        table.add_rule();
        table.add_row({"ranks; the seconds above are of rank 0", grouped(counts.size())});
        table.add_row({"frames by all ranks together", grouped(static_cast<std::uint64_t>(made_together_))});
        for (std::size_t rank = 0; rank < counts.size(); ++rank)
            table.add_row({"rank " + std::to_string(rank) + ": frames, and rays for shadows",
                           grouped(counts[rank].frames) + ", " + grouped(counts[rank].rays)});
        table.add_row({"merges", grouped(static_cast<std::uint64_t>(merge_.count()))});
        if (merge_.count() > 0) {
            const auto merges = static_cast<std::size_t>(merge_.count());
            table.add_row({"bytes that all know, each merge", bytes_text(merge_.bytes() / merges)});
            table.add_row({"seconds: each merge", fixed(merge_.seconds() / merge_.count(), 3)});
        }
    }
    return table.text();
}

/// Prints what the mesh and the cache of this rank hold, and what they have forgotten for want of memory.
void FilmMaker::add_memory_rows(TextTable& table) const {
    const std::string of_rank = ranks_.size() > 1 ? " of rank 0" : "";
    const auto mesh = gpu_ ? gpu_->mesh() : shadows_ ? shadows_->mesh() : std::nullopt;
    const auto cache = gpu_ ? gpu_->cache() : shadows_ ? shadows_->cache() : std::nullopt;
    if (mesh)
        table.add_row({"memory of the mesh" + of_rank, bytes_text(mesh->bytes)});
    if (cache)
        table.add_row({"memory of the cache" + of_rank, bytes_text(cache->bytes)});
    if (visibility_.cache.memory_budget == lightmesh::CacheSettings{}.memory_budget)
        return;
    if (mesh)
        table.add_row({"bricks forgotten for memory" + of_rank, grouped(mesh->evicted_bricks)});
    if (cache)
        table.add_row({"records forgotten for memory" + of_rank, grouped(cache->evicted_records)});
}

/// By this rank, in all frames.
std::uint64_t FilmMaker::rays_for_shadows() const {
    const std::uint64_t kept = gpu_ ? kept_rays(*gpu_) : shadows_ ? kept_rays(*shadows_) : 0;
    const auto cache = shadows_ ? shadows_->cache() : std::nullopt;
    return kept + (cache ? cache->point_rays : 0) + spent_.visibility.shadow_rays +
           spent_.visibility.short_rays;
}

/// On rank 0.
std::uint64_t FilmMaker::rays_of_all_since(std::uint64_t before) {
    std::uint64_t rays = 0;
    for (const Bytes& of_rank : ranks_.gather(bytes_of(kept_rays(*shadows_) - before)))
        rays += value_in<std::uint64_t>(of_rank);
    return rays;
}

bool FilmMaker::rank_0_says(bool is_so) {
    return value_in<bool>(ranks_.broadcast(bytes_of(is_so)));
}

void FilmMaker::go_to(double time) {
    const Stopwatch stopwatch;
    const SceneChange change = film_.go_to(time);
    embree_.update(change);
    if (gpu_)
        gpu_->follow(embree_, change);
    else if (shadows_)
        shadows_->update(embree_, change);
    else
        shadows_ = make_visibility(algorithm_, embree_, visibility_);
    seconds_between_ += stopwatch.seconds();
}

/// Goes to the time of a frame that is about to be rendered.
void FilmMaker::begin_frame(double time) {
    go_to(time);
    const Stopwatch stopwatch;
    if (gpu_)
        gpu_->begin_frame();
    else if (shadows_)
        shadows_->begin_frame();
    seconds_between_ += stopwatch.seconds();
}

void FilmMaker::count_frame(double seconds) {
    (made_ == 0 ? first_seconds_ : later_seconds_) += seconds;
    ++made_;
}

}  // namespace demo
