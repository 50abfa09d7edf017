// SPDX-License-Identifier: MIT
#include "tune/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace demo {

namespace tune = lightmesh::tune;

namespace {

constexpr double width = 480.0;
constexpr double height = 400.0;
constexpr double left = 62.0;
constexpr double right = 468.0;
constexpr double top = 16.0;
constexpr double bottom = 344.0;

template <class... Values>
std::string format(const char* pattern, Values... values) {
    std::array<char, 512> text{};
    std::snprintf(text.data(), text.size(), pattern, values...);
    return text.data();
}

/// A logarithmic axis.
struct Axis {
    double low;
    double high;
    double from;
    double to;

    double at(double value) const {
        const double clamped = std::clamp(value, low, high);
        return from + (to - from) * std::log(clamped / low) / std::log(high / low);
    }

    /// 1, 2 and 5 times powers of ten, or the powers alone on a long axis.
    std::vector<double> ticks() const {
        std::vector<double> values;
        const bool is_long = high / low > 200.0;
        for (double power = std::pow(10.0, std::floor(std::log10(low))); power <= high; power *= 10.0)
            for (const double digit : {1.0, 2.0, 5.0})
                if ((digit == 1.0 || !is_long) && digit * power >= low && digit * power <= high)
                    values.push_back(digit * power);
        return values;
    }
};

double seconds_per_point(const Report& report, const tune::Measurement& m) {
    return 1e-9 * tune::ns_per_point(m, report.wishes.frame);
}

/// Around all values that are greater than 0, with some room.
Axis axis_around(const std::vector<double>& values, double from, double to) {
    double low = 1e30;
    double high = 0.0;
    for (const double value : values)
        if (value > 0.0 && std::isfinite(value)) {
            low = (std::min)(low, value);
            high = (std::max)(high, value);
        }
    if (high <= 0.0)
        return {0.5, 2.0, from, to};
    return {low / 1.35, high * 1.35, from, to};
}

struct Axes {
    Axis time;
    Axis error;
};

Axes axes_of(const Report& report) {
    std::vector<double> times{1e-9 * report.tuning.shadow_ray_ns_per_point};
    std::vector<double> errors;
    for (const tune::Measurement& m : report.tuning.measurements) {
        times.push_back(seconds_per_point(report, m));
        errors.push_back(m.mean_absolute_error);
    }
    return {axis_around(times, left, right), axis_around(errors, bottom, top)};
}

std::string grid_lines(const Axes& axes) {
    std::string svg;
    for (const double tick : axes.time.ticks()) {
        const double x = axes.time.at(tick);
        svg += format("<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", x, top, x,
                      bottom);
        svg += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>", x, bottom + 18.0,
                      seconds_text(tick).c_str());
    }
    for (const double tick : axes.error.ticks()) {
        const double y = axes.error.at(tick);
        svg += format("<line class=\"grid\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", left, y,
                      right, y);
        svg += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>", left - 6.0, y + 4.0,
                      percent_text(tick).c_str());
    }
    svg += format("<rect class=\"frame\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>", left, top,
                  right - left, bottom - top);
    return svg;
}

std::string axis_titles(const Report& report) {
    const char* frame = report.wishes.frame == tune::Frame::first ? "first frame" : "later frames";
    const double middle = 0.5 * (top + bottom);
    return format("<text class=\"title\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">time per point, one "
                  "thread, "
                  "%s</text>",
                  0.5 * (left + right), bottom + 42.0, frame) +
           format(
               "<text class=\"title\" x=\"14\" y=\"%.1f\" text-anchor=\"middle\" transform=\"rotate(-90 14 "
               "%.1f)\">mean absolute error</text>",
               middle, middle);
}

/// Long tests by colour.
const char* colour_class(tune::LongTest long_test) {
    switch (long_test) {
    case tune::LongTest::rays:
        return "rays";
    case tune::LongTest::shadow_maps:
        return "maps";
    case tune::LongTest::refined_shadow_maps:
        return "refined";
    case tune::LongTest::shadow_volumes:
        break;
    }
    return "volumes";
}

/// Short tests by shape: circle, square, triangle.
std::string shape(lightmesh::ShortTest short_test, const char* colour, double x, double y,
                  const std::string& title) {
    const std::string end = " class=\"mark " + std::string(colour) + "\"><title>" + title + "</title></";
    switch (short_test) {
    case lightmesh::ShortTest::none:
        return format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5\"", x, y) + end + "circle>";
    case lightmesh::ShortTest::linked:
        return format("<rect x=\"%.1f\" y=\"%.1f\" width=\"9\" height=\"9\"", x - 4.5, y - 4.5) + end +
               "rect>";
    case lightmesh::ShortTest::exact:
        break;
    }
    return format("<path d=\"M%.1f %.1fl6 10.5h-12z\"", x, y - 7.0) + end + "path>";
}

/// A diamond.
std::string cache_shape(double x, double y, const std::string& title) {
    return format("<path d=\"M%.1f %.1fl6 6-6 6-6-6z\"", x, y - 6.0) + " class=\"mark cache\"><title>" +
           title + "</title></path>";
}

std::string hard_shadow_line(const Report& report, const Axes& axes) {
    const double x = axes.time.at(1e-9 * report.tuning.shadow_ray_ns_per_point);
    const bool near_right = x > 0.5 * (left + right);
    return format("<line class=\"hard\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", x, top, x,
                  bottom) +
           format(
               "<text class=\"hard-text\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">hard shadow rays</text>",
               x + (near_right ? -5.0 : 5.0), bottom - 8.0, near_right ? "end" : "start");
}

bool is_recommended(const Report& report, const tune::Candidate& candidate) {
    return std::ranges::any_of(report.by_radius, [&](const tune::Recommendation& recommendation) {
        return recommendation.choice && recommendation.choice->candidate == candidate;
    });
}

/// Texts of a plot, each only where it covers none before it.
class Labels {
public:
    /// Below a mark and to the left of it; to the right where it would leave the plot.
    void add(const std::string& text, double x, double y, double distance) {
        const double long_as = 8.0 * static_cast<double>(text.size());
        const bool fits_left = x - distance - long_as > left;
        const double text_x = fits_left ? x - distance - long_as : x + distance;
        const double text_y = y + distance + 5.0;
        for (const auto& [other_x, other_y, other_length] : placed_)
            if (std::abs(text_y - other_y) < 13.0 && text_x < other_x + other_length &&
                other_x < text_x + long_as)
                return;
        placed_.push_back({text_x, text_y, long_as});
        svg_ +=
            format("<text class=\"label\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">%s</text>",
                   fits_left ? text_x + long_as : text_x, text_y, fits_left ? "end" : "start", text.c_str());
    }
    const std::string& svg() const { return svg_; }

private:
    struct Box {
        double x;
        double y;
        double length;
    };
    std::vector<Box> placed_;
    std::string svg_;
};

/// A staircase would claim candidates that nobody has measured; straight lines only guide the eye.
std::string frontier_line(const Report& report, const Axes& axes, float radius) {
    std::string points;
    Labels labels;
    for (const std::size_t i : report.frontier) {
        const tune::Measurement& m = report.tuning.measurements[i];
        if (tune::radius_of(m.candidate) != radius)
            continue;
        const double x = axes.time.at(seconds_per_point(report, m));
        const double y = axes.error.at(m.mean_absolute_error);
        points += format("%.1f,%.1f ", x, y);
        const double distance = is_recommended(report, m.candidate) ? 12.0 : 7.0;
        labels.add(tune::is_cache(m.candidate) ? "g " + tune::shortest_text(m.candidate.spacing)
                                               : "q " + tune::shortest_text(m.candidate.quality),
                   x, y, distance);
    }
    return "<polyline class=\"frontier\" points=\"" + points + "\"/>" + labels.svg();
}

std::string marks(const Report& report, const Axes& axes, float radius) {
    std::string svg;
    for (const tune::Measurement& m : report.tuning.measurements) {
        if (tune::radius_of(m.candidate) != radius)
            continue;
        const double seconds = seconds_per_point(report, m);
        const std::string title = tune::describe(m.candidate) + ": " + seconds_text(seconds) + " a point, " +
                                  percent_text(m.mean_absolute_error);
        const double x = axes.time.at(seconds);
        const double y = axes.error.at(m.mean_absolute_error);
        svg += tune::is_cache(m.candidate)
                   ? cache_shape(x, y, title)
                   : shape(m.candidate.short_test, colour_class(m.candidate.long_test), x, y, title);
    }
    return svg;
}

std::string recommended_ring(const Report& report, const Axes& axes, float radius) {
    for (const tune::Recommendation& recommendation : report.by_radius) {
        if (!recommendation.choice || tune::radius_of(recommendation.choice->candidate) != radius)
            continue;
        const tune::Measurement& m = *recommendation.choice;
        return format("<circle class=\"ring\" cx=\"%.1f\" cy=\"%.1f\" r=\"11\"/>",
                      axes.time.at(seconds_per_point(report, m)), axes.error.at(m.mean_absolute_error));
    }
    return {};
}

}  // namespace

std::string seconds_text(double seconds) {
    if (seconds < 0.9995e-6)
        return format("%.3g ns", 1e9 * seconds);
    if (seconds < 0.9995e-3)
        return format("%.3g \u00b5s", 1e6 * seconds);
    if (seconds < 0.9995)
        return format("%.3g ms", 1e3 * seconds);
    return seconds < 999.5 ? format("%.3g s", seconds) : format("%.0f s", seconds);
}

std::string percent_text(double share) {
    return format("%.2g %%", 100.0 * share);
}

std::string megabytes_text(double bytes) {
    return bytes < 999.5e6 ? format("%.3g MB", 1e-6 * bytes) : format("%.3g GB", 1e-9 * bytes);
}

std::string time_error_plot(const Report& report, float radius) {
    const Axes axes = axes_of(report);
    const std::string name =
        radius == 0.0f ? "Time and error of the caches"
                       : "Time and error of the candidates with radius " + tune::shortest_text(radius);
    return format("<svg class=\"plot\" viewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"%s\">", width,
                  height, name.c_str()) +
           grid_lines(axes) + axis_titles(report) + hard_shadow_line(report, axes) +
           frontier_line(report, axes, radius) + marks(report, axes, radius) +
           recommended_ring(report, axes, radius) + "</svg>";
}

std::string plot_legend(const Report& report) {
    std::string html;
    const auto add = [&](const std::string& mark, const std::string& text) {
        html += "<li><svg viewBox=\"0 0 24 24\" aria-hidden=\"true\">" + mark + "</svg>" + text + "</li>";
    };
    for (const lightmesh::ShortTest short_test :
         {lightmesh::ShortTest::none, lightmesh::ShortTest::linked, lightmesh::ShortTest::exact})
        add(shape(short_test, "plain", 12.0, 12.0, ""),
            "short test " + std::string(tune::name_of(short_test)));
    for (const tune::LongTest long_test :
         {tune::LongTest::rays, tune::LongTest::shadow_maps, tune::LongTest::refined_shadow_maps,
          tune::LongTest::shadow_volumes})
        if (std::ranges::any_of(report.tuning.measurements, [&](const tune::Measurement& m) {
                return !tune::is_cache(m.candidate) && m.candidate.long_test == long_test;
            }))
            add(shape(lightmesh::ShortTest::linked, colour_class(long_test), 12.0, 12.0, ""),
                "long test " + std::string(tune::name_of(long_test)));
    if (std::ranges::any_of(report.tuning.measurements,
                            [](const tune::Measurement& m) { return tune::is_cache(m.candidate); }))
        add(cache_shape(12.0, 12.0, ""), "visibility cache");
    add("<polyline class=\"frontier\" points=\"2,6 12,16 22,19\"/>",
        "frontier: nothing beats both time and error");
    add("<circle class=\"ring\" cx=\"12\" cy=\"12\" r=\"9\"/>", "recommended");
    return "<ul class=\"legend\">" + html + "</ul>";
}

}  // namespace demo
