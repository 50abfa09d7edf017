// SPDX-License-Identifier: MIT
#include "../examples/image/image.hpp"
#include "../examples/image/part_file.hpp"
#include "../examples/image/texture.hpp"
#include "../examples/render/files.hpp"
#include "../examples/render/terminal.hpp"
#include "temporary_folder.hpp"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace image_test {

namespace {

demo::Image gradient(int width, int height) {
    demo::Image image{width, height};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            image.at(x, y) = {static_cast<float>(x) / 7.0f, static_cast<float>(y) / 3.0f, 0.125f};
        }
    }
    return image;
}

/// The message of the exception that `call` throws, or nothing.
template <typename Call>
std::string message_of(const Call& call) {
    try {
        call();
    } catch (const std::exception& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("an image has at least one pixel") {
    CHECK_THROWS_WITH_AS(demo::Image(0, 3), "an image of 0 x 3 pixels", std::invalid_argument);
    CHECK(demo::Image(2, 3, glm::vec3{0.5f}).pixels.size() == 6);
}

TEST_CASE("the sRGB curve and its inverse") {
    CHECK(demo::to_srgb(0.5f) == doctest::Approx(0.735357f));
    CHECK(demo::to_srgb(0.002f) == doctest::Approx(0.02584f));
    CHECK(demo::to_srgb(-1.0f) == 0.0f);
    CHECK(demo::to_srgb(9.0f) == doctest::Approx(1.0f));
    CHECK(demo::to_srgb(std::numeric_limits<float>::quiet_NaN()) == 0.0f);
    for (int i = 0; i <= 100; ++i) {
        const float value = static_cast<float>(i) / 100.0f;
        CHECK(demo::from_srgb(demo::to_srgb(value)) == doctest::Approx(value).epsilon(1e-4));
    }
}

TEST_CASE("EXR keeps every bit, values above 1 and below 0 too") {
    const test::TemporaryFolder folder;
    demo::Image image = gradient(9, 5);
    image.at(3, 2) = {-4.0f, 1e20f, std::numeric_limits<float>::infinity()};
    demo::write_exr(image, folder / "a.exr");
    const demo::Image back = demo::read_exr(folder / "a.exr");
    CHECK(back.width == 9);
    CHECK(back.height == 5);
    CHECK(back.pixels == image.pixels);
}

TEST_CASE("PNG keeps 8 bits of the sRGB values") {
    const test::TemporaryFolder folder;
    const demo::Image image = gradient(8, 4);
    demo::write_png(image, folder / "a.png");
    const demo::Image back = demo::read_png(folder / "a.png");
    REQUIRE(back.width == 8);
    REQUIRE(back.height == 4);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            const float difference =
                demo::to_srgb(image.pixels[i][channel]) - demo::to_srgb(back.pixels[i][channel]);
            CHECK(std::abs(difference) <= 0.5001f / 255.0f);
        }
    }
}

TEST_CASE("the extension chooses the format") {
    const test::TemporaryFolder folder;
    const demo::Image image = gradient(4, 4);
    demo::write_image(image, folder / "a.png");
    demo::write_image(image, folder / "a.exr");
    CHECK(demo::read_png(folder / "a.png").width == 4);
    CHECK(demo::read_exr(folder / "a.exr").pixels == image.pixels);
    CHECK(message_of([&] { demo::write_image(image, folder / "a.jpg"); }).find("a.jpg") != std::string::npos);
    CHECK(folder.file_count() == 2);
}

TEST_CASE("writers name the path that fails and leave nothing half-written") {
    const test::TemporaryFolder folder;
    const demo::Image image = gradient(4, 4);
    for (const auto write : {demo::write_png, demo::write_exr}) {
        const auto nowhere = folder / "no such folder" / "a.img";
        CHECK(message_of([&] { write(image, nowhere); }).find(nowhere.string()) != std::string::npos);

        std::filesystem::create_directories(folder / "taken");
        CHECK(message_of([&] { write(image, folder / "taken"); }).find("taken: it is a folder") !=
              std::string::npos);
        CHECK(folder.file_count() == 1);
    }
}

TEST_CASE("a full disk is an error, and no file stays") {
    // /dev/full takes no byte; the temporary file would be beside it, so the test goes through a link in its
    // place.
    const std::filesystem::path full = "/dev/full";
    if (!std::filesystem::exists(full)) {
        return;
    }
    const test::TemporaryFolder folder;
    const auto path = folder / "a.png";
    const auto part = folder / ("a.png.part" + std::to_string(::getpid()));
    std::filesystem::create_symlink(full, part);
    CHECK(message_of([&] { demo::write_png(gradient(300, 300), path); }).find(path.string()) !=
          std::string::npos);
    CHECK(folder.file_count() == 0);
}

TEST_CASE("an older picture is replaced") {
    const test::TemporaryFolder folder;
    demo::write_png(demo::Image{2, 2, glm::vec3{1.0f}}, folder / "a.png");
    demo::write_png(demo::Image{3, 3, glm::vec3{0.0f}}, folder / "a.png");
    CHECK(demo::read_png(folder / "a.png").width == 3);
    CHECK(folder.file_count() == 1);
}

TEST_CASE("a filmic picture keeps mid grey and tells highlights apart") {
    demo::Image image{5, 1};
    const float values[] = {0.18f, 1.0f, 4.0f, 12.0f, 1e30f};
    for (int x = 0; x < 5; ++x)
        image.at(x, 0) = glm::vec3{values[x]};
    CHECK(demo::toned(image, demo::Tone::linear).pixels == image.pixels);
    const demo::Image filmic = demo::toned(image, demo::Tone::filmic);
    CHECK(filmic.at(0, 0).g == doctest::Approx(0.18f).epsilon(0.15));
    CHECK(filmic.at(1, 0).g == doctest::Approx(0.67f).epsilon(0.01));
    for (int x = 1; x < 4; ++x)
        CHECK(filmic.at(x, 0).g > filmic.at(x - 1, 0).g + 0.02f);
    CHECK(filmic.at(3, 0).g < 1.0f);
    CHECK(filmic.at(4, 0).g == 1.0f);
    image.at(0, 0) = glm::vec3{std::numeric_limits<float>::quiet_NaN()};
    CHECK(demo::toned(image, demo::Tone::filmic).at(0, 0) == glm::vec3{0.0f});
}

TEST_CASE("a JPEG without the tables that it needs is the same each time") {
    const auto decoded = [] {
        const std::string file =
            demo::read_file(std::filesystem::path(LIGHTMESH_FIELD) / "hostile/no-tables.jpg");
        try {
            return demo::decode_texture(
                       std::span(reinterpret_cast<const std::uint8_t*>(file.data()), file.size()))
                .rgba;
        } catch (const std::runtime_error&) {
            return std::vector<std::uint8_t>();
        }
    };
    const std::vector<std::uint8_t> first = decoded();
    for (int fill = 1; fill < 256; fill += 50) {
        // What the decoder finds in memory that it takes.
        for (const std::size_t size : {18000, 20000, 64})
            CHECK(std::vector<char>(size, static_cast<char>(fill)).back() == static_cast<char>(fill));
        CHECK(decoded() == first);
    }
}

TEST_CASE("a second Ctrl-C leaves no unfinished file") {
    const test::TemporaryFolder folder;
    const auto target = folder.write("a.png", "older");
    const pid_t child = fork();
    if (child == 0) {
        static_cast<void>(demo::interrupted());
        const demo::PartFile part(target);
        std::ofstream{part.path()} << "half of it";
        std::raise(SIGINT);
        const bool goes_on = demo::interrupted();
        std::raise(goes_on ? SIGTERM : SIGKILL);
        _exit(0);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == SIGTERM);
    CHECK(folder.file_count() == 1);
}

TEST_CASE("readers name the file they can't read") {
    const test::TemporaryFolder folder;
    const auto junk = folder.write("junk", "this is no picture");
    for (const auto read : {demo::read_png, demo::read_exr}) {
        CHECK(message_of([&] { read(folder / "none"); }).find((folder / "none").string()) !=
              std::string::npos);
        CHECK(message_of([&] { read(junk); }).find(junk.string()) != std::string::npos);
    }
}

TEST_CASE("differences of linear values") {
    demo::Image a{2, 1, glm::vec3{0.5f}};
    demo::Image b = a;
    b.at(1, 0) = {0.5f, 0.8f, 0.1f};
    CHECK(demo::mean_absolute_difference(a, b) == doctest::Approx((0.3 + 0.4) / 6.0));
    CHECK(demo::rms_difference(a, b) == doctest::Approx(std::sqrt((0.09 + 0.16) / 6.0)));
    CHECK(demo::mean_absolute_difference(a, a) == 0.0);
    CHECK(demo::share_beyond_one_step(a, a) == 0.0);
    CHECK(demo::share_beyond_one_step(a, b) == 0.5);
    CHECK_THROWS_WITH_AS(demo::rms_difference(a, demo::Image(1, 2)), "images of different size: 2x1 and 1x2",
                         std::invalid_argument);
}

TEST_CASE("the difference picture is white where the images are equal, and darker by the amplification") {
    demo::Image a{2, 1, glm::vec3{demo::from_srgb(0.5f)}};
    demo::Image b = a;
    b.at(1, 0).g = demo::from_srgb(0.54f);
    const demo::Image difference = demo::difference_picture(a, b, 10.0f);
    CHECK(difference.at(0, 0) == glm::vec3{1.0f});
    CHECK(difference.at(1, 0).r == 1.0f);
    CHECK(demo::to_srgb(difference.at(1, 0).g) == doctest::Approx(0.6f).epsilon(1e-3));
    CHECK(demo::difference_picture(a, b, 100.0f).at(1, 0).g == 0.0f);
}

TEST_CASE("sheets hold every picture and its caption") {
    const demo::Image red{40, 20, {1, 0, 0}};
    const demo::Image green{40, 20, {0, 1, 0}};
    const demo::Image sheet = demo::side_by_side({{red, "one"}, {green, "two\nlines"}});
    CHECK(sheet.width > 80);
    CHECK(sheet.height > 20 + 2 * 12);
    const auto count = [&sheet](auto matches) {
        return std::count_if(sheet.pixels.begin(), sheet.pixels.end(), matches);
    };
    CHECK(count([](glm::vec3 p) { return p == glm::vec3{1, 0, 0}; }) == 800);
    CHECK(count([](glm::vec3 p) { return p == glm::vec3{0, 1, 0}; }) == 800);
    CHECK(count([](glm::vec3 p) { return p == glm::vec3{0.75f}; }) > 40);  // the letters

    const demo::Image four = demo::contact_sheet({{red, "1"}, {red, "2"}, {red, "3"}, {red, "4"}}, 2);
    CHECK(four.height > 2 * 20);
    CHECK(four.width < 3 * 40);
    CHECK_THROWS_AS(demo::side_by_side({}), std::invalid_argument);
    CHECK_THROWS_AS(demo::contact_sheet({{red, "1"}}, 0), std::invalid_argument);
}

TEST_CASE("text is cut off at the edges, and what the font lacks is left out") {
    demo::Image image{10, 10};
    demo::draw_text(image, -5, -5, 3, "edge \xC3\xA4 \x01", glm::vec3{1.0f});
    demo::draw_text(image, 8, 8, 2, "", glm::vec3{1.0f});
    demo::draw_text(image, 0, 0, 1, std::string(500, '@'), glm::vec3{1.0f});
    CHECK(image.pixels.size() == 100);
}

}  // namespace image_test
