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
/// As many as measurements are held against, unless there are so many lamps that the picture would take
/// hours.
constexpr int lamp_rays = 256;
constexpr double most_lamp_rays = 2e9;

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

/// A picture with the name of its file.
struct Shot {
    std::string name;
    Image image;
};

class Photographer {
public:
    Photographer(const EmbreeScene& scene, const TuneOptions& options, const std::filesystem::path& folder)
        : scene_(scene), visibility_(lamp_options(scene, options)), render_(options.render), folder_(folder) {
        const RenderOptions& frame = options.render;
        render_.width = options.picture_width;
        render_.height = (std::max)(1, options.picture_width * frame.height / frame.width);
    }

    const RenderOptions& options() const { return render_; }

    Shot render(const tune::Candidate& candidate) const {
        return {file_name_of(candidate), render(*shadows_of(candidate), tune::describe(candidate))};
    }

    /// With the lamps themselves.
    Image render_lamps(int rays) const {
        VisibilityOptions visibility = visibility_;
        visibility.area_samples = rays;
        return render(*make_area_shadows(scene_, visibility), lamps_text(rays));
    }

    /// The rays to each lamp that `render_lamps` is given.
    int rays_to_lamps() const {
        const double pairs = static_cast<double>(render_.width) * static_cast<double>(render_.height) *
                             static_cast<double>(render_.samples) *
                             static_cast<double>((std::max<std::size_t>)(1, scene_.scene().lights.size()));
        return std::clamp(static_cast<int>(most_lamp_rays / pairs), 1, lamp_rays);
    }

    static std::string lamps_text(int rays) { return "lamps of " + std::to_string(rays) + " rays"; }

    /// The bytes of the PNG file that it becomes.
    std::string keep(const Image& image, const std::string& name) const {
        const std::filesystem::path file = folder_ / (name + ".png");
        write_png(image, file);
        return read_file(file);
    }

    /// Beside what it is compared with, whose name ends that of the difference's file.
    CandidatePicture keep_beside(const tune::Measurement& measurement, const Image& reference,
                                 const std::string& reference_name) const {
        const Shot shot = render(measurement.candidate);
        return {measurement, keep(shot.image, shot.name),
                keep(difference_picture(shot.image, reference, amplification),
                     shot.name + "-to-" + reference_name),
                mean_absolute_difference(shot.image, reference)};
    }

private:
    Image render(const Visibility& shadows, const std::string& what) const {
        RenderStatistics statistics;
        ProgressBar bar("picture of " + what);
        Image image = demo::render(
            scene_, shadows, render_, statistics, [&](double done) { bar.show(done); }, &interrupted());
        if (!statistics.finished)
            throw std::runtime_error("interrupted");
        return image;
    }

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

/// The frontier of a radius, or of caches: both ends of it, what is recommended, and the rest evenly.
std::vector<tune::Measurement> chosen_frontier(const Report& report, float radius, std::size_t& size) {
    std::vector<tune::Measurement> all;
    for (const std::size_t i : report.frontier)
        if (tune::radius_of(report.tuning.measurements[i].candidate) == radius)
            all.push_back(report.tuning.measurements[i]);
    size = all.size();
    if (size <= most_pictures)
        return all;
    std::vector<tune::Measurement> chosen;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t next = chosen.size() * (size - 1) / (most_pictures - 1);
        const bool is_recommended = std::ranges::any_of(report.by_radius, [&](const auto& recommendation) {
            return recommendation.choice && all[i].candidate == recommendation.choice->candidate;
        });
        // The last place is for the last one.
        const bool has_room = chosen.size() + 1 < most_pictures;
        if (i + 1 == size || (has_room && (i == next || is_recommended)))
            chosen.push_back(all[i]);
    }
    return chosen;
}

/// As exact as meshes are measured against, but for the limit of pictures.
tune::Candidate exact_mesh(const Report& report) {
    float best = picture_reference_quality;
    for (const tune::Measurement& m : report.tuning.measurements)
        if (!tune::is_cache(m.candidate))
            best = (std::min)(best, m.reference.quality);
    return {report.tuning.middle_radius, best, lightmesh::ShortTest::exact, tune::LongTest::rays, 0};
}

void add_lamp_pictures(const Report& report, const Photographer& photographer, ReportPictures& pictures) {
    const std::vector<tune::Measurement> caches = chosen_frontier(report, 0.0f, pictures.caches.candidates);
    if (report.by_radius.size() < 2 && caches.empty())
        return;
    const int rays = photographer.rays_to_lamps();
    const Image lamps = photographer.render_lamps(rays);
    const std::string name = "lamps";
    for (PictureStrip* strip : {&pictures.kinds, &pictures.caches}) {
        strip->reference_name = Photographer::lamps_text(rays);
        strip->reference = photographer.keep(lamps, name);
    }
    for (const tune::Measurement& m : caches)
        pictures.caches.pictures.push_back(photographer.keep_beside(m, lamps, name));
    if (report.by_radius.size() < 2)
        return;
    for (const tune::Recommendation& recommendation : report.by_radius) {
        if (!recommendation.choice)
            continue;
        ++pictures.kinds.candidates;
        const tune::Candidate& candidate = recommendation.choice->candidate;
        const auto there = std::ranges::find_if(pictures.caches.pictures, [&](const auto& picture) {
            return picture.measurement.candidate == candidate;
        });
        pictures.kinds.pictures.push_back(
            there != pictures.caches.pictures.end()
                ? *there
                : photographer.keep_beside(*recommendation.choice, lamps, name));
    }
    std::stable_partition(
        pictures.kinds.pictures.begin(), pictures.kinds.pictures.end(),
        [](const CandidatePicture& picture) { return tune::is_cache(picture.measurement.candidate); });
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
    const tune::Candidate exact = exact_mesh(report);
    const Image reference = photographer.render(exact).image;
    pictures.meshes.reference_name = tune::describe(exact);
    pictures.meshes.reference = photographer.keep(reference, "exact-mesh");
    for (const tune::Measurement& m :
         chosen_frontier(report, report.tuning.middle_radius, pictures.meshes.candidates))
        pictures.meshes.pictures.push_back(photographer.keep_beside(m, reference, "exact-mesh"));
    add_lamp_pictures(report, photographer, pictures);
    return pictures;
}

}  // namespace demo
