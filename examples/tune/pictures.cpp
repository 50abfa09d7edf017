// SPDX-License-Identifier: MIT
#include "tune/pictures.hpp"

#include "image/image.hpp"
#include "render/files.hpp"
#include "render/run.hpp"
#include "render/terminal.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace demo {

namespace tune = lightmesh::tune;

namespace {

constexpr float amplification = 4.0f;
/// Of the frontier, so that the report stays small.
constexpr std::size_t most_pictures = 7;
/// Exact pictures of a higher quality take minutes.
constexpr float picture_reference_quality = 8.0f;

/// "r3-q4-linked-rays"
std::string file_name_of(const tune::Candidate& candidate) {
    std::string name;
    for (const char c : tune::describe(candidate))
        if (c == ',')
            name += '-';
        else if (c != ' ')
            name += c;
    return name;
}

class Photographer {
public:
    Photographer(const EmbreeScene& scene, const TuneOptions& options, const std::filesystem::path& folder)
        : scene_(scene), visibility_(lamp_options(scene, options)), render_(options.render), folder_(folder) {
        const RenderOptions& frame = options.render;
        render_.width = options.picture_width;
        render_.height = (std::max)(1, options.picture_width * frame.height / frame.width);
    }

    const RenderOptions& options() const { return render_; }

    Image render(const tune::Candidate& candidate) const {
        const auto shadows = shadows_of(candidate);
        RenderStatistics statistics;
        ProgressBar bar("picture of " + tune::describe(candidate));
        Image image = demo::render(
            scene_, *shadows, render_, statistics, [&](double done) { bar.show(done); }, &interrupted());
        if (!statistics.finished)
            throw std::runtime_error("interrupted");
        return image;
    }

    /// The bytes of the PNG file that it becomes.
    std::string keep(const Image& image, const std::string& name) const {
        const std::filesystem::path file = folder_ / (name + ".png");
        write_png(image, file);
        return read_file(file);
    }

private:
    std::unique_ptr<Visibility> shadows_of(const tune::Candidate& candidate) const {
        VisibilityOptions visibility = visibility_;
        if (tune::is_cache(candidate)) {
            visibility.cache = tune::cache_settings_of(candidate);
            return make_cache(scene_, visibility);
        }
        visibility.settings = tune::settings_of(candidate);
        visibility.settings.footprint_scale = 0.0f;  // as measured
        return make_light_mesh(scene_, visibility, candidate.long_test);
    }

    const EmbreeScene& scene_;
    VisibilityOptions visibility_;
    RenderOptions render_;
    std::filesystem::path folder_;
};

/// The frontier of the middle radius: both ends of it, what is recommended, and the rest evenly.
std::vector<tune::Measurement> chosen_frontier(const Report& report, std::size_t& size) {
    std::vector<tune::Measurement> all;
    for (const std::size_t i : report.frontier)
        if (tune::radius_of(report.tuning.measurements[i].candidate) == report.tuning.middle_radius)
            all.push_back(report.tuning.measurements[i]);
    size = all.size();
    if (size <= most_pictures)
        return all;
    std::vector<tune::Measurement> chosen;
    const auto& recommended = report.recommended.choice;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t next = chosen.size() * (size - 1) / (most_pictures - 1);
        if (i == next || (recommended && all[i].candidate == recommended->candidate))
            chosen.push_back(all[i]);
    }
    return chosen;
}

}  // namespace

ReportPictures render_pictures(const EmbreeScene& scene, const TuneOptions& options, const Report& report,
                               const std::filesystem::path& folder) {
    prepare_folder(folder);
    const Photographer photographer(scene, options, folder);
    ReportPictures pictures;
    pictures.width = photographer.options().width;
    pictures.height = photographer.options().height;
    pictures.amplification = amplification;
    float best = picture_reference_quality;
    for (const tune::Measurement& m : report.tuning.measurements)
        if (!tune::is_cache(m.candidate))
            best = (std::min)(best, m.reference.quality);
    tune::Candidate& exact = pictures.reference.measurement.candidate;
    exact = {report.tuning.middle_radius, best, lightmesh::ShortTest::exact, tune::LongTest::rays, 0};
    const Image reference = photographer.render(exact);
    pictures.reference.picture = photographer.keep(reference, "reference");
    for (const tune::Measurement& m : chosen_frontier(report, pictures.frontier_size)) {
        const Image image = photographer.render(m.candidate);
        const std::string name = file_name_of(m.candidate);
        pictures.frontier.push_back(
            {m, photographer.keep(image, name),
             photographer.keep(difference_picture(image, reference, amplification), name + "-difference"),
             mean_absolute_difference(image, reference)});
    }
    if (report.by_radius.size() > 1)
        for (const tune::Recommendation& recommendation : report.by_radius)
            if (recommendation.choice) {
                const tune::Candidate& candidate = recommendation.choice->candidate;
                const Image image = photographer.render(candidate);
                pictures.radii.push_back(
                    {*recommendation.choice, photographer.keep(image, file_name_of(candidate)), {}, 0.0});
            }
    return pictures;
}

}  // namespace demo
