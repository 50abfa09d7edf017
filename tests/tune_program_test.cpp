// SPDX-License-Identifier: MIT

// The program lightmesh-tune as its users run it, and its report in a browser.

#include "image/image.hpp"
#include "render/files.hpp"
#include "run_command.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tune_program_test {

namespace {

using Json = nlohmann::json;

using test::Finished;
using test::run;

/// Takes a second or so.
std::string tune_command(const std::filesystem::path& output, const std::string& more = "--quality 2,3") {
    return LIGHTMESH_TUNE " spheres --points 256 --reference-points 16 --radius 5 --short-test none,linked "
                          "--long-test rays --spacing 1 --detail 2 --lamp-rays 16 --shaft-rows on "
                          "--width 160 --height 120 --picture-width 48 --threads 2 -o " +
           output.string() + " " + more;
}

Json report_in(const std::filesystem::path& folder) {
    return Json::parse(demo::read_file(folder / "report.json"));
}

/// Loads a page in a browser. The output is what became of it; the errors have a line for each message of the
/// page's console, with CONSOLE in it.
Finished browse(const test::TemporaryFolder& folder, const std::filesystem::path& page) {
    return run(folder, LIGHTMESH_CHROMIUM " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage "
                                          "--disable-background-networking --no-first-run "
                                          "--enable-logging=stderr --virtual-time-budget=2000 --dump-dom "
                                          "--user-data-dir=" +
                           (folder / "profile").string() + " file://" + page.string());
}

/// What stands between `before` and the next quote.
std::string attribute(const std::string& html, const std::string& before) {
    const std::size_t at = html.find(before);
    if (at == std::string::npos)
        return "missing";
    const std::size_t start = at + before.size();
    return html.substr(start, html.find('"', start) - start);
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size()))
        ++found;
    return found;
}

/// Sorts the table by the errors, twice, and tells the page around what came of it.
constexpr const char* probe = R"(<script>
const header = document.querySelectorAll("th")[5];
const column = () => Array.from(document.querySelectorAll("tbody tr"), (row) => Number(row.cells[5].dataset.value));
const rises = (values) => values.every((value, i) => i === 0 || values[i - 1] <= value);
const sort = () => {
    header.querySelector("button").click();
    return header.getAttribute("aria-sort") + " ";
};
parent.postMessage({
    up: sort() + rises(column()) + " " + column().length,
    down: sort() + rises(column().reverse()),
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    images: Array.from(document.images).every((image) => image.complete && image.naturalWidth > 0),
}, "*");
</script></body>)";

/// A page around, since a browser's own window may not be as narrow as a phone.
std::string frame_around(const std::string& page, int width) {
    return "<!DOCTYPE html><title>-</title><body><script>addEventListener('message', (event) => "
           "Object.assign(document.body.dataset, event.data));</script><iframe src='" +
           page + "' style='height: 800px; width: " + std::to_string(width) + "px'></iframe></body>";
}

}  // namespace

TEST_CASE("lightmesh-tune: predicts, measures, recommends, and says so as text and as JSON") {
    const test::TemporaryFolder folder;
    const Finished ran = run(folder, tune_command(folder / "out"));
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    CHECK(ran.errors.empty());
    CHECK(ran.output.find("lamp radius: 1.5\n") != std::string::npos);
    CHECK(ran.output.find("5 candidates to measure") < ran.output.find("predicted time: about "));
    const Json report = report_in(folder / "out");
    CHECK(report.at("finished") == true);
    CHECK(report.at("context").at("scene") == "spheres");
    CHECK(ran.output.find(report.at("recommended").at("settings")) != std::string::npos);
    CHECK(ran.output.find(report.at("recommended").at("reason")) != std::string::npos);
    REQUIRE(report.at("measurements").size() == 5);
    for (std::size_t i = 0; i < 5; ++i) {
        const Json& measurement = report.at("measurements")[i];
        CHECK(measurement.at("candidate").at("radius") == (i < 4 ? 5.0 : 0.0));
        CHECK(measurement.at("candidate").at("spacing") == (i < 4 ? 0.0 : 1.0));
        CHECK(measurement.at("candidate").at("shaft_rows") == true);
        CHECK((measurement.at("short_rays_per_point") > 0.0) ==
              (i == 4 || measurement.at("candidate").at("short_test") == "linked"));
        CHECK(measurement.at("lamp_error") > 0.0);
        CHECK(measurement.at("warm_ns_per_point") > 0.0);
        CHECK(measurement.at("mean_absolute_error") > 0.0);
        CHECK(measurement.at("frame").at("cold_seconds") >= measurement.at("frame").at("warm_seconds"));
    }
    // The kind that lost is told as well.
    const Json& recommended = report.at("recommended");
    CHECK((recommended.at("held_against").at("spacing") == 0.0) ==
          (recommended.at("candidate").at("spacing") == 1.0));
    for (const char* name :
         {"exact-mesh", "lamps", "cache-g1-detail2-16lamprays", "cache-g1-detail2-16lamprays-to-lamps"})
        CHECK_MESSAGE(std::filesystem::exists(folder / "out/pictures" / (std::string(name) + ".png")), name);
    CHECK_FALSE(folder.has_part_files());
}

TEST_CASE("lightmesh-tune: its report shows caches and meshes beside the lamps themselves") {
    const test::TemporaryFolder folder;
    const auto with = [](std::string command, const std::string& option, const std::string& other) {
        return command.replace(command.find(option), option.size(), other);
    };
    const Finished ran = run(
        folder, with(tune_command(folder / "out", "--quality 4"), "--shaft-rows on", "--shaft-rows on,off"));
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    CHECK(ran.output.find("4 candidates to measure") != std::string::npos);
    const std::string html = demo::read_file(folder / "out/report.html");
    const auto section = [&](const std::string& title) {
        const std::size_t start = html.find("<h2>" + title + "</h2>");
        REQUIRE_MESSAGE(start != std::string::npos, title);
        return html.substr(start, html.find("</section>", start) - start);
    };
    const auto check_strip = [](const std::string& text, std::size_t pictures, const std::string& reference) {
        CHECK(text.find("alt=\"The reference: " + reference) != std::string::npos);
        CHECK(count(text, "<figure") == pictures + 1);
        CHECK(count(text, "<img ") == 2 * pictures + 1);
        CHECK(count(text, "Its difference to the reference") == pictures);
    };
    const Json report = report_in(folder / "out");
    const auto on_frontier = [&](bool of_caches) {
        return std::ranges::count_if(report.at("measurements"), [&](const Json& measurement) {
            return measurement.at("on_frontier") == true &&
                   (measurement.at("candidate").at("spacing") != 0.0) == of_caches;
        });
    };
    const std::string kinds = section("Cache or mesh?");
    check_strip(kinds, 2, "lamps of 256 rays");
    const bool takes_cache = report.at("recommended").at("candidate").at("spacing") != 0.0;
    CHECK(kinds.find(takes_cache ? "<b>Take the cache.</b>" : "<b>Take the mesh.</b>") != std::string::npos);
    CHECK(kinds.find("The view with cache, g 1") < kinds.find("The view with r 5"));
    check_strip(section("Caches: faster, or more exact"), static_cast<std::size_t>(on_frontier(true)),
                "lamps of 256 rays");
    check_strip(section("Meshes: faster, or more exact"), static_cast<std::size_t>(on_frontier(false)),
                "r 5, q ");

    // The reference is what the others come near to: the lamps as rays show them.
    const demo::Image lamps = demo::read_png(folder / "out/pictures/lamps.png");
    const demo::Image cache = demo::read_png(folder / "out/pictures/cache-g1-detail2-16lamprays.png");
    const demo::Image mesh = demo::read_png(folder / "out/pictures/exact-mesh.png");
    CHECK(demo::mean_absolute_difference(cache, lamps) < 0.6 * demo::mean_absolute_difference(mesh, lamps));

    const Finished without = run(folder, with(tune_command(folder / "meshes", "--quality 2 --caches off"),
                                              "--radius 5", "--radius 4,5"));
    REQUIRE_MESSAGE(without.status == 0, without.errors);
    const std::string meshes = demo::read_file(folder / "meshes/report.html");
    CHECK(meshes.find("<h2>Which radius?</h2>") != std::string::npos);
    CHECK(meshes.find("<h2>Caches") == std::string::npos);
}

TEST_CASE("lightmesh-tune: warns where a view shows no shadow, from which a radius could come") {
    const test::TemporaryFolder folder;
    const auto floor = folder.write("floor.obj", "v -4 0 -4\nv 4 0 -4\nv 4 0 4\nv -4 0 4\nf 4 3 2 1\n");
    const Finished ran = run(folder, LIGHTMESH_TUNE " " + floor.string() +
                                         " --points 64 --reference-points 4 --quality 2 --short-test none "
                                         "--long-test rays --caches off --width 64 --height 48 "
                                         "--picture-width 0 --threads 2 -o " +
                                         (folder / "out").string());
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    CHECK(ran.output.find("radius: at ") != std::string::npos);
    CHECK(ran.output.find(" points 0 of ") != std::string::npos);
    CHECK(ran.output.find("warning: nothing that this view shows was found in shadow") != std::string::npos);
}

TEST_CASE("lightmesh-tune: its report works in a browser, needs no network and fits a phone") {
    const test::TemporaryFolder folder;
    const Finished ran = run(folder, tune_command(folder / "out"));
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    const std::string html = demo::read_file(folder / "out/report.html");
    const Finished plain = browse(folder, folder / "out/report.html");
    REQUIRE_MESSAGE(plain.status == 0, plain.errors);
    CHECK_MESSAGE(plain.errors.find("CONSOLE") == std::string::npos, plain.errors);

    const std::size_t end = html.rfind("</body>");
    REQUIRE(end != std::string::npos);
    folder.write("probed.html", html.substr(0, end) + probe + html.substr(end + 7));
    for (const int width : {1200, 390}) {
        CAPTURE(width);
        const Finished shown = browse(folder, folder.write("frame.html", frame_around("probed.html", width)));
        CHECK_MESSAGE(shown.errors.find("CONSOLE") == std::string::npos, shown.errors);
        CHECK(attribute(shown.output, "data-up=\"") == "ascending true 5");
        CHECK(attribute(shown.output, "data-down=\"") == "descending true");
        CHECK(attribute(shown.output, "data-overflow=\"") == "0");
        CHECK(attribute(shown.output, "data-images=\"") == "true");
    }

    CHECK(html.find("http") == std::string::npos);
    CHECK(html.find("url(") == std::string::npos);
    CHECK(count(html, " src=\"") == count(html, " src=\"data:image/png;base64,"));
    CHECK(count(html, " href=\"") == count(html, " href=\"data:"));
    CHECK(count(html, "class=\"frontier\"") == 3);  // of two plots and of their legend
    CHECK(html.find("mean absolute error</text>") != std::string::npos);
    CHECK(html.find("time per point, one thread, first frame</text>") != std::string::npos);
}

TEST_CASE("lightmesh-tune: the test of the report would see an error of its script") {
    const test::TemporaryFolder folder;
    const auto page =
        folder.write("page.html", "<!DOCTYPE html><title>-</title><script>not_there();</script>");
    const Finished shown = browse(folder, page);
    CHECK(shown.status == 0);
    CHECK_MESSAGE(shown.errors.find("CONSOLE") != std::string::npos, shown.errors);
}

TEST_CASE("lightmesh-tune: resumes what was measured, and measures the rest") {
    const test::TemporaryFolder folder;
    REQUIRE(run(folder, tune_command(folder / "out", "--quality 2 --caches off")).status == 0);
    const Json before = report_in(folder / "out");
    const Finished ran = run(folder, tune_command(folder / "out", "--quality 2,3 --resume"));
    REQUIRE_MESSAGE(ran.status == 0, ran.errors);
    CHECK(ran.output.find("2 candidates measured before\n3 candidates to measure") != std::string::npos);
    const Json after = report_in(folder / "out");
    REQUIRE(before.at("measurements").size() == 2);
    REQUIRE(after.at("measurements").size() == 5);
    for (std::size_t i = 0; i < 2; ++i)
        CHECK(after.at("measurements")[i].at("warm_ns_per_point") ==
              before.at("measurements")[i].at("warm_ns_per_point"));
}

TEST_CASE("lightmesh-tune: after Ctrl-C the report has what was measured") {
    const test::TemporaryFolder folder;
    const std::string out = (folder / "out").string();
    const std::string all = "--quality 2,3,4,5,6,7,8 --short-test none,linked,exact --caches off";
    const Finished ran = run(folder, tune_command(out, all) + " & p=$!; while kill -0 $p && [ ! -s " + out +
                                         "/report.json ]; do sleep 0.01; done; kill -INT $p; wait $p");
    CHECK(ran.status == 130);
    CHECK(ran.errors.find("--resume takes them up") != std::string::npos);
    const Json report = report_in(out);
    CHECK(report.at("finished") == false);
    CHECK(report.at("measurements").size() >= 1);
    CHECK(report.at("measurements").size() < 21);
}

TEST_CASE("lightmesh-tune: limits that nothing keeps to are status 3, and the report is written") {
    const test::TemporaryFolder folder;
    const Finished ran = run(folder, tune_command(folder / "out", "--quality 2 --budget 1ns"));
    CHECK(ran.status == 3);
    CHECK(ran.output.find("No candidate is fast enough; the nearest is r 5, q 2, ") != std::string::npos);
    CHECK_FALSE(report_in(folder / "out").at("recommended").contains("candidate"));
    CHECK(std::filesystem::exists(folder / "out/report.html"));
}

TEST_CASE("lightmesh-tune: what is wrong with the command line is told in one line") {
    const test::TemporaryFolder folder;
    folder.write("file", "");
    struct Wrong {
        std::string arguments;
        std::string message;
        int status;
    };
    const std::vector<Wrong> all{
        {"", "scene is required", 2},
        {"nosuch", "nosuch: no such file, and no built-in scene of that name", 1},
        {"spheres --budget soon", "'soon' is no budget: write 200ns", 2},
        {"spheres --budget -3ns", "'-3ns' is no budget", 2},
        {"spheres --error 150%", "'150%' is no error: write 0.01 or 1%", 2},
        {"spheres --memory much", "--memory: much", 2},
        {"spheres --memory 0", "--memory: 0 leaves no room", 2},
        {"spheres --quality 0.5", "0.5 is not a number from 1 to 16", 2},
        {"spheres --quality 2,x", "x is not a number from 1 to 16", 2},
        {"spheres --radius nan", "--radius: nan is not a finite number above 0", 2},
        {"spheres --radius 0", "--radius: 0 is not", 2},
        {"spheres --points 0", "--points: Value 0 not in range", 2},
        {"spheres --lamp-angle 1e9", "--lamp-angle: Value 1e9 not in range", 2},
        {"spheres --long-test magic", "--long-test: magic not in", 2},
        {"spheres --spacing 0", "--spacing: 0 is not a finite number above 0", 2},
        {"spheres --detail 7", "--detail: Value 7 not in range", 2},
        {"spheres --caches maybe", "--caches: maybe not in", 2},
        {"spheres --shaft-rows maybe", "--shaft-rows: maybe not in", 2},
        {"spheres --resume", "there is nothing to resume: no file ", 1},
    };
    for (const Wrong& wrong : all) {
        CAPTURE(wrong.arguments);
        const Finished ran =
            run(folder, LIGHTMESH_TUNE " -o " + (folder / "out").string() + " " + wrong.arguments);
        CHECK(ran.status == wrong.status);
        CHECK(ran.errors.starts_with("lightmesh-tune: "));
        CHECK_MESSAGE(ran.errors.find(wrong.message) != std::string::npos, ran.errors);
        CHECK(count(ran.errors, "\n") == 1);
        CHECK_FALSE(std::filesystem::exists(folder / "out"));
    }
    const Finished ran = run(folder, tune_command(folder / "file/out"));
    CHECK(ran.status == 1);
    CHECK(ran.errors.find("cannot make the folder " + (folder / "file/out").string()) != std::string::npos);
}

TEST_CASE("lightmesh-tune: it does not resume from damaged reports, or from others") {
    const test::TemporaryFolder folder;
    REQUIRE(run(folder, tune_command(folder / "out", "--quality 2")).status == 0);
    const auto file = folder / "out/report.json";
    const std::string good = demo::read_file(file);
    const auto with = [&](const std::string& path, const Json& value) {
        Json changed = Json::parse(good);
        changed.at(Json::json_pointer(path)) = value;
        return changed.dump();
    };
    struct Damaged {
        std::string content;
        std::string message;
    };
    const std::vector<Damaged> all{
        {"", "parse error"},
        {good.substr(0, good.size() / 2), "parse error"},
        {"null", "cannot resume"},
        {"{}", "key 'format' not found"},
        {with("/format", 99), "it has format 99, not 3"},
        {with("/context/scene", "park"), "its scene was \"park\" and is \"spheres\" now"},
        {with("/context/points measured", "17"), "its points measured was \"17\" and is \"256\" now"},
        {with("/measurements/0/warm_ns_per_point", "fast"), "must be number, but is string"},
        {with("/measurements/0/frame/warm_seconds", -1.0), "warm_seconds is -1.0; it must not be negative"},
        {with("/measurements/0/candidate/short_test", "magic"), "unknown name \"magic\""},
    };
    for (const Damaged& damaged : all) {
        CAPTURE(damaged.message);
        demo::write_file(file, damaged.content);
        const Finished ran = run(folder, tune_command(folder / "out", "--quality 2 --resume"));
        CHECK(ran.status == 1);
        CHECK(ran.errors.starts_with("lightmesh-tune: cannot resume from " + file.string() + ": "));
        CHECK_MESSAGE(ran.errors.find(damaged.message) != std::string::npos, ran.errors);
        CHECK(count(ran.errors, "\n") == 1);
        CHECK(demo::read_file(file) == damaged.content);
    }
}

}  // namespace tune_program_test
