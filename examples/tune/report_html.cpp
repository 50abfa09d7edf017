// SPDX-License-Identifier: MIT
#include "tune/report_html.hpp"

#include "render/text_table.hpp"
#include "tune/html.hpp"
#include "tune/plot.hpp"
#include "tune/report_assets.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace demo {

namespace tune = lightmesh::tune;

namespace {

using tune::shortest_text;

bool is_chosen(const Report& report, const tune::Candidate& candidate) {
    return report.recommended.choice && report.recommended.choice->candidate == candidate;
}

/// Wall-clock seconds of a frame.
double frame_seconds(const Report& report, const tune::Measurement& m, tune::Frame frame) {
    return tune::frame_seconds(m, frame) / report.threads;
}

std::string wishes_text(const tune::Wishes& wishes) {
    std::string text;
    const auto add = [&](bool is_limited, const std::string& wish) {
        if (is_limited)
            text += (text.empty() ? "" : ", ") + wish;
    };
    add(std::isfinite(wishes.ns_per_point),
        "at most " + seconds_text(1e-9 * wishes.ns_per_point) + " a point");
    add(std::isfinite(wishes.seconds_per_frame),
        "at most " + seconds_text(wishes.seconds_per_frame) + " a frame");
    add(std::isfinite(wishes.mean_absolute_error),
        "at most " + percent_text(wishes.mean_absolute_error) + " mean absolute error");
    add(std::isfinite(wishes.bytes), "at most " + megabytes_text(wishes.bytes));
    return text.empty() ? "nothing in particular, so the best balance of time and error" : text;
}

/// Settings with a member to a line.
std::string in_lines(std::string source) {
    const auto replace_all = [&](const std::string& from, const std::string& to) {
        for (std::size_t at = 0; (at = source.find(from, at)) != std::string::npos; at += to.size())
            source.replace(at, from.size(), to);
    };
    replace_all("{.", "{\n    .");
    replace_all(", .", ",\n    .");
    replace_all("}", ",\n}");
    return source;
}

std::string figures(const Report& report, const tune::Measurement& m) {
    std::string html;
    const auto add = [&](const std::string& value, const std::string& what) {
        html += "<div><dt>" + what + "</dt><dd>" + value + "</dd></div>";
    };
    const std::string threads =
        report.threads == 1 ? "1 thread" : std::to_string(report.threads) + " threads";
    add(percent_text(m.mean_absolute_error), "mean absolute error");
    if (!tune::is_cache(m.candidate))
        add(percent_text(m.lamp_error), "the same to lamps");
    add(seconds_text(frame_seconds(report, m, tune::Frame::first)), "first frame, " + threads);
    add(seconds_text(frame_seconds(report, m, tune::Frame::later)), "later frames, " + threads);
    add(seconds_text(1e-9 * m.warm_ns_per_point), "per point and thread, later frames");
    add(seconds_text(1e-9 * report.tuning.shadow_ray_ns_per_point), "the same by hard shadow rays");
    add(megabytes_text(m.frame.bytes), "memory for a frame");
    return "<dl class=\"figures\">" + html + "</dl>";
}

std::string advice_section(const Report& report) {
    const tune::Recommendation& recommended = report.recommended;
    std::string html = "<section class=\"advice\"><h2>Recommended</h2>";
    if (recommended.choice) {
        html += "<pre id=\"settings\">" + escaped(in_lines(tune::to_source(recommended.choice->candidate))) +
                "</pre><button class=\"copy\" type=\"button\" data-source=\"settings\">Copy</button>";
        if (tune::uses_shadow_maps(recommended.choice->candidate.long_test))
            html += "<p>With a <code>DepthRenderer</code> as the mesh's second argument.</p>";
        if (recommended.choice->candidate.long_test == tune::LongTest::shadow_volumes)
            html += "<p>With <code>Occluders</code> as the mesh's second argument.</p>";
        if (tune::is_cache(recommended.choice->candidate))
            html += "<p>For a <code>VisibilityCache</code>, with lamps of their sizes.</p>";
        html += figures(report, *recommended.choice);
    }
    html +=
        "<p>" + escaped(recommended.reason) +
        "</p><p class=\"soft\">Asked for: " + wishes_text(report.wishes) + "; " +
        (report.wishes.frame == tune::Frame::first ? "for a first frame, which fills mesh or cache."
                                                   : "for later frames, which find mesh or cache filled.") +
        " Times are of shadows alone; those of frames are estimated from the samples.</p></section>";
    return html;
}

std::string picture_element(const std::string& png, const ReportPictures& pictures, const std::string& text) {
    return "<img width=\"" + std::to_string(pictures.width) + "\" height=\"" +
           std::to_string(pictures.height) + "\" alt=\"" + escaped(text) + "\" src=\"" + png_address(png) +
           "\">";
}

std::string picture_figure(const Report& report, const ReportPictures& pictures,
                           const CandidatePicture& shown, bool beside_lamps) {
    const tune::Measurement& m = shown.measurement;
    const std::string name = tune::describe(m.candidate);
    const bool chosen = is_chosen(report, m.candidate);
    std::string html = chosen ? "<figure class=\"chosen\">" : "<figure>";
    html +=
        picture_element(shown.picture, pictures, "The view with " + name) +
        picture_element(shown.difference, pictures, "Its difference to the reference, amplified and negated");
    html += "<figcaption><b>" + escaped(name) + (chosen ? " <span class=\"badge\">recommended</span>" : "") +
            "</b>" + seconds_text(frame_seconds(report, m, report.wishes.frame)) + " a frame, error " +
            (beside_lamps ? "to lamps " + percent_text(m.lamp_error) : percent_text(m.mean_absolute_error)) +
            ", of the picture " + percent_text(shown.mean_difference) + ", " + megabytes_text(m.frame.bytes) +
            "</figcaption></figure>";
    return html;
}

/// The reference, and the pictures that are compared with it.
std::string picture_strip(const Report& report, const ReportPictures& pictures, const PictureStrip& strip,
                          bool beside_lamps) {
    const std::string name = escaped(strip.reference_name);
    std::string html = "<div class=\"strip\"><figure>" +
                       picture_element(strip.reference, pictures, "The reference: " + strip.reference_name) +
                       "<figcaption><b>Reference of the pictures</b>" + name + "</figcaption></figure>";
    for (const CandidatePicture& shown : strip.pictures)
        html += picture_figure(report, pictures, shown, beside_lamps);
    return html + "</div>";
}

std::string differences_text(const ReportPictures& pictures) {
    std::ostringstream text;
    text << "with each picture its difference to the reference, " << pictures.amplification
         << " times amplified and negated: white where they are equal.";
    return text.str();
}

/// Which of the two kinds wins, where both were tried.
std::string verdict_text(const Report& report) {
    const tune::Recommendation& recommended = report.recommended;
    if (!recommended.choice || !recommended.other)
        return {};
    const auto name_of_kind = [](const tune::Measurement& m) {
        return std::string(tune::is_cache(m.candidate) ? "cache" : "mesh");
    };
    const auto figures_text = [&](const tune::Measurement& m) {
        return " is off by " + percent_text(m.lamp_error) + " of full light and takes " +
               seconds_text(frame_seconds(report, m, report.wishes.frame)) + " a frame";
    };
    const tune::Measurement& other = *recommended.other;
    return "<p><b>Take the " + name_of_kind(*recommended.choice) + ".</b> Held against the lamps, it" +
           figures_text(*recommended.choice) + "; the best " + name_of_kind(other) + figures_text(other) +
           ". What weighs is error times time, or the error alone where only time is limited.</p>";
}

std::string kinds_section(const Report& report, const ReportPictures& pictures) {
    if (pictures.kinds.pictures.empty())
        return {};
    return "<section><h2>" +
           std::string(pictures.caches.pictures.empty() ? "Which radius?" : "Cache or mesh?") + "</h2>" +
           verdict_text(report) +
           "<p>A visibility cache shows the penumbrae of the lamps, sharp where things touch. A light mesh "
           "blurs all shadows by its radius: the greater, the softer, and the cheaper to fill. Each with the "
           "settings that are recommended for it, beside the lamps themselves; " +
           differences_text(pictures) + "</p>" + picture_strip(report, pictures, pictures.kinds, true) +
           "</section>";
}

/// "3 of 12", or nothing where all of them are shown.
std::string shown_text(const PictureStrip& strip) {
    if (strip.pictures.size() == strip.candidates)
        return {};
    return " (" + std::to_string(strip.pictures.size()) + " of " + std::to_string(strip.candidates) + ")";
}

std::string frontier_sections(const Report& report, const ReportPictures& pictures) {
    std::string html;
    const auto add = [&](const std::string& title, const std::string& which, const PictureStrip& strip,
                         bool beside_lamps) {
        if (!strip.pictures.empty())
            html += "<section><h2>" + title + "</h2><p>" + which +
                    " that nothing beats in both time and error" + shown_text(strip) +
                    ", the fastest first; " + differences_text(pictures) + "</p>" +
                    picture_strip(report, pictures, strip, beside_lamps) + "</section>\n";
    };
    add("Caches: faster, or more exact", "The caches", pictures.caches, true);
    add("Meshes: faster, or more exact", "The meshes of radius " + shortest_text(report.tuning.middle_radius),
        pictures.meshes, false);
    return html;
}

std::string plot_section(const Report& report) {
    std::string html =
        "<section><h2>Time and error</h2><p>Every candidate: meshes held against a converged one of their "
        "own radius, caches against lamps of 256 rays. Down is more exact, left is faster; both axes are "
        "logarithmic. Texts give q or g along the frontier.</p>" +
        plot_legend(report) + "<div class=\"plots\">";
    for (const float radius : radii_of(report))
        html += "<section><h3>" + (radius == 0.0f ? "Caches" : "Radius " + shortest_text(radius)) + "</h3>" +
                time_error_plot(report, radius) + "</section>";
    return html + "</div></section>";
}

/// A table cell: what is shown, and what it is sorted by.
std::string cell(const std::string& text, double value) {
    std::ostringstream html;
    html << "<td data-value=\"" << value << "\">" << text << "</td>";
    return html.str();
}

std::string text_cell(const std::string& text) {
    return "<td class=\"text\" data-value=\"" + escaped(text) + "\">" + escaped(text) + "</td>";
}

/// Sorted by rank: what is recommended comes first.
std::string verdict_cell(bool is_recommended, bool on_frontier) {
    if (is_recommended)
        return "<td class=\"text\" data-value=\"0\">recommended</td>";
    return on_frontier ? "<td class=\"text\" data-value=\"1\">frontier</td>"
                       : "<td class=\"text\" data-value=\"2\"></td>";
}

std::string header_cell(const std::string& text, const std::string& unit, bool is_number) {
    return std::string("<th scope=\"col\" data-column=\"") +
           (is_number ? "number\">" : "text\" class=\"text\">") + "<button type=\"button\">" + text +
           (unit.empty() ? "" : "<small>" + unit + "</small>") + "</button></th>";
}

std::string table_head(const Report& report) {
    const std::string wall =
        "s, " + std::to_string(report.threads) + (report.threads == 1 ? " thread" : " threads");
    return "<thead><tr>" + header_cell("Verdict", "", false) + header_cell("r", "", true) +
           header_cell("q", "", true) + header_cell("Short test", "", false) +
           header_cell("Long test", "", false) + header_cell("Error", "mean abs., %", true) +
           header_cell("Error", "RMS, %", true) + header_cell("To lamps", "mean abs., %", true) +
           header_cell("First frame", wall, true) + header_cell("Later frame", wall, true) +
           header_cell("First", "ns a point", true) + header_cell("Later", "ns a point", true) +
           header_cell("Rays", "a point", true) + header_cell("Light points, records", "thousands", true) +
           header_cell("Memory", "MB", true) + "</tr></thead>";
}

/// Three digits, so that a column can be compared at a glance; all of those before the point.
std::string digits(double value) {
    if (value >= 999.5)
        return grouped(static_cast<unsigned long long>(std::llround(value)));
    const double magnitude = value > 0.0 ? std::floor(std::log10(value)) : 2.0;
    return fixed(value, static_cast<int>(std::clamp(2.0 - magnitude, 0.0, 9.0)));
}

std::string table_row(const Report& report, std::size_t i) {
    const tune::Measurement& m = report.tuning.measurements[i];
    const bool chosen = is_chosen(report, m.candidate);
    const bool on_frontier = std::ranges::find(report.frontier, i) != report.frontier.end();
    const auto number = [](double value) {
        return cell(digits(value), value);
    };
    const auto setting = [](float value) {
        return value == 0.0f ? cell("", 0.0) : cell(shortest_text(value), static_cast<double>(value));
    };
    const bool is_cache = tune::is_cache(m.candidate);
    std::string short_test = tune::name_of(m.candidate.short_test);
    std::string long_test = tune::name_of(m.candidate.long_test);
    if (is_cache) {
        const std::string name = tune::describe(m.candidate);
        short_test = "cache";
        long_test = name.substr(name.find(", ") + 2);
    } else if (tune::uses_shadow_maps(m.candidate.long_test))
        long_test += " " + std::to_string(m.candidate.shadow_map_size);
    return std::string(chosen        ? "<tr class=\"chosen\">"
                       : on_frontier ? "<tr class=\"on-frontier\">"
                                     : "<tr>") +
           verdict_cell(chosen, on_frontier) + setting(tune::radius_of(m.candidate)) +
           setting(is_cache ? 0.0f : m.candidate.quality) + text_cell(short_test) + text_cell(long_test) +
           number(100.0 * m.mean_absolute_error) + number(100.0 * m.rms_error) +
           number(100.0 * m.lamp_error) + number(frame_seconds(report, m, tune::Frame::first)) +
           number(frame_seconds(report, m, tune::Frame::later)) +
           number(tune::ns_per_point(m, tune::Frame::first)) +
           number(tune::ns_per_point(m, tune::Frame::later)) + number(m.short_rays_per_point) +
           number(1e-3 * m.frame.light_points) + number(1e-6 * m.frame.bytes) + "</tr>\n";
}

std::string table_section(const Report& report) {
    std::string html =
        "<section><h2>All candidates</h2><p>Press a heading to sort by it. Blue rows are the frontier of "
        "their radius; light points, records and memory are those of a frame.</p><div class=\"scroll\" "
        "tabindex=\"0\" "
        "role=\"region\" "
        "aria-label=\"All candidates\"><table>" +
        table_head(report) + "<tbody>\n";
    for (std::size_t i = 0; i < report.tuning.measurements.size(); ++i)
        html += table_row(report, i);
    return html + "</tbody></table></div></section>";
}

std::string reference_text(const Report& report) {
    std::string text;
    for (const float radius : radii_of(report)) {
        const auto m = std::ranges::find_if(report.tuning.measurements, [&](const tune::Measurement& one) {
            return tune::radius_of(one.candidate) == radius;
        });
        const tune::Convergence& reference = m->reference;
        if (radius == 0.0f) {
            text += "<li>Caches: lamps of 256 rays; half of them differ by " +
                    percent_text(reference.change) + ".</li>";
            continue;
        }
        text += "<li>Radius " + shortest_text(radius) + ": q " + shortest_text(reference.quality) + ", " +
                (reference.converged ? "converged: " : "not converged before the limit of q: ") +
                "half of it differs by " + percent_text(reference.change) + ".</li>";
    }
    return "<ul>" + text + "</ul>";
}

std::string facts_section(const Report& report) {
    std::string html =
        "<section><h2>How this was measured</h2><p>With runs of neighbouring shading points of the "
        "view, each candidate in a mesh or cache of its own on one thread: once empty, then filled until the "
        "time is steady. Errors are those of S, from 0 to 1: of caches to lamps of 256 rays, of meshes to an "
        "exact mesh of the same radius with so high a q that half of it differs by less than 0.1 %:</p>" +
        reference_text(report);
    if (const auto& advice = report.tuning.advice)
        html +=
            "<p>The radius comes from the scene: at " + grouped(advice->points) +
            " points, spread over the view, " + grouped(advice->shadowed) + " of " + grouped(advice->pairs) +
            " pairs of a point and a light are in shadow, and lamps of middling size would throw penumbrae " +
            escaped(fixed(advice->penumbra_width, 2)) + " wide (median).</p>";
    html += "<dl class=\"facts\">";
    for (const auto& [name, value] : report.context)
        html += "<dt>" + escaped(name) + "</dt><dd>" + escaped(value) + "</dd>";
    return html + "</dl></section>";
}

}  // namespace

std::string to_html(const Report& report, const std::optional<ReportPictures>& pictures) {
    const std::string title = "Shadow settings for " + report.scene;
    std::string html = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
                       "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
                       // Keeps browsers from asking for a file that is not there.
                       "<link rel=\"icon\" href=\"data:,\"><title>" +
                       escaped(title) + "</title><style>" + report_css + "</style></head>\n<body><main><h1>" +
                       escaped(title) + "</h1>\n";
    html += "<p class=\"soft\">" + grouped(report.tuning.measurements.size()) +
            " candidates, measured on this machine with " + grouped(report.light_count) +
            (report.light_count == 1 ? " light" : " lights") + " and " + grouped(report.triangle_count) +
            " triangles.</p>\n";
    if (!report.tuning.finished)
        html += "<p><b>The run was interrupted: some candidates are missing.</b></p>";
    html += advice_section(report) + "\n";
    if (pictures)
        html += kinds_section(report, *pictures) + "\n" + frontier_sections(report, *pictures);
    html += plot_section(report) + "\n" + table_section(report) + "\n" + facts_section(report) +
            "</main>\n<script>" + report_js + "</script></body></html>\n";
    return html;
}

}  // namespace demo
