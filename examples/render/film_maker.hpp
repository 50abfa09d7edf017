// SPDX-License-Identifier: MIT
#pragma once

#include "image/image.hpp"
#include "render/embree_scene.hpp"
#include "render/merge_ranks.hpp"
#include "render/on_gpu.hpp"
#include "render/ranks.hpp"
#include "render/renderer.hpp"
#include "render/share_out.hpp"
#include "render/text_table.hpp"
#include "render/visibility.hpp"
#include "scene/film.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace demo {

/// Renders frames of a film one after another, alone or together with other ranks, and keeps count.
class FilmMaker {
public:
    /// `gpu`: what renders, of the same algorithm and options, which has no scene yet; null: the CPU. Throws
    /// what `GpuFrames::follow` throws.
    FilmMaker(Ranks& ranks, std::string algorithm, const RenderOptions& options, Film film,
              const VisibilityOptions& visibility, std::unique_ptr<GpuFrames> gpu = nullptr);

    struct Made {
        Image linear;
        Image toned;  ///< by `RenderOptions::tone`, if a GPU did that; else empty
    };
    /// The frame at a time, by this rank alone; not whole if `watch` says that it is in vain. With `may_wait`
    /// nothing, if in its first half it turns out that more than a tenth has to be found that this rank does
    /// not know; what was found by then is kept.
    std::optional<Made> frame(double time, WorkWatch& watch, bool may_wait, const Progress& progress);

    struct TogetherMade {
        Image image;   ///< on rank 0
        bool is_cold;  ///< on all: whether more than a tenth had to be found that nobody knew
    };
    /// The frame at a time, by all ranks on the CPU, which must call this together. What they find there is
    /// made known to all, unless it is little.
    TogetherMade frame_together(double time, const Progress& progress);

    bool is_on_gpu() const { return gpu_ != nullptr; }

    /// Goes to a time and lets all ranks know what each has found. All must call this together.
    void merge_at(double time);

    /// Says what it took, line by line, on rank 0. All must call this together if `is_whole`; else it says
    /// nothing of other ranks.
    std::string report(bool is_whole);

private:
    std::uint64_t rays_of_all_since(std::uint64_t before);
    std::uint64_t rays_for_shadows() const;
    void add_memory_rows(TextTable& table) const;
    bool rank_0_says(bool is_so);
    void go_to(double time);
    void begin_frame(double time);
    void count_frame(double seconds);

    Ranks& ranks_;
    std::string algorithm_;
    RenderOptions options_;
    Film film_;
    VisibilityOptions visibility_;
    EmbreeScene embree_;
    std::unique_ptr<GpuFrames> gpu_;
    std::unique_ptr<Visibility> shadows_;  ///< on the CPU, from the first frame on
    RankMerge merge_;
    RenderStatistics spent_;
    int made_ = 0;
    int made_together_ = 0;
    std::uint64_t most_rays_ = 0;  // that all have traced together for one frame; the same on all ranks
    double first_seconds_ = 0.0;
    double later_seconds_ = 0.0;
    double seconds_between_ = 0.0;
};

}  // namespace demo
