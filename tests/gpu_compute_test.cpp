// SPDX-License-Identifier: MIT
#include "each_traversal.hpp"
#include "gpu/compute.hpp"
#include "watched_device.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace gpu_compute_test {

/// These tests need a Vulkan driver (Mesa's lavapipe will do) and the validation layers, and fail without
/// them.

namespace {

constexpr std::uint32_t multiply[] = {
#include "spirv/multiply.comp.inc"
};

std::string message_of(const auto& act) {
    try {
        act();
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return "nothing was thrown";
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("compute: kernels see the buffers, the push constants and what those before them wrote") {
    test::WatchedDevice watched;
    const demo::ComputeDevice& device = watched.device;
    std::vector<std::uint32_t> values(1000);
    for (std::uint32_t i = 0; i < values.size(); ++i)
        values[i] = i;
    const std::array<std::uint32_t, 4> factors{1, 2, 3, 5};
    const demo::ComputeBuffer seen(device, std::as_bytes(std::span(values)));
    const demo::ComputeBuffer uniform(device, std::as_bytes(std::span(factors)));
    const std::array bindings{
        demo::ComputeBinding{.set = 0, .binding = 1, .resource = seen},
        demo::ComputeBinding{.set = 1, .binding = 0, .resource = uniform, .is_uniform = true}};
    const demo::ComputeKernel kernel(device, multiply, bindings, 4);
    const std::array<std::uint32_t, 2> added{7, 11};
    const auto bytes = std::as_bytes(std::span(added));
    CHECK(device.run([&](const demo::ComputeCommands& commands) {
        commands.dispatch(kernel, 16, 1, 1, bytes.first(4));
        commands.dispatch(kernel, 16, 1, 1, bytes.last(4));
    }) >= 0.0);
    const auto expected = [&](std::uint32_t i, std::uint32_t value) {
        return factors[i % 4] * (factors[i % 4] * value + 7) + 11;
    };
    const auto found = seen.read_all<std::uint32_t>();
    for (std::uint32_t i = 0; i < values.size(); ++i)
        values[i] = expected(i, values[i]);
    CHECK(found == values);

    SUBCASE("a part is overwritten, and read") {
        seen.write(40, bytes);
        std::array<std::uint32_t, 4> part{};
        seen.read(36, std::as_writable_bytes(std::span(part)));
        CHECK(part == std::array<std::uint32_t, 4>{found[9], 7, 11, found[12]});
        CHECK_THROWS_AS(seen.write(3996, bytes), std::out_of_range);
        CHECK_THROWS_AS(seen.read(std::numeric_limits<std::size_t>::max(), std::span<std::byte>()),
                        std::out_of_range);
    }
    SUBCASE("many parts are overwritten, also more than is copied at a time; all or none") {
        std::vector<std::uint32_t> words(std::size_t{5} << 20);
        std::iota(words.begin(), words.end(), 0u);
        const auto all = std::as_bytes(std::span<const std::uint32_t>(words));
        const demo::ComputeBuffer large(device, all.size());
        std::vector<demo::ComputeWrite> parts{{0, all.first(all.size() - 4000)}};
        for (std::size_t at = all.size() - 4000; at < all.size(); at += 40)
            parts.push_back({at, all.subspan(at, 40)});
        large.write(parts);
        CHECK(large.read_all<std::uint32_t>() == words);
        parts = {{0, bytes}, {all.size() - 4, bytes}};
        CHECK_THROWS_AS(large.write(parts), std::out_of_range);
        CHECK(large.read_all<std::uint32_t>() == words);
    }
    SUBCASE("another buffer takes the place of one; it begins with zeros") {
        const demo::ComputeBuffer other(device, 12);
        kernel.bind({.set = 0, .binding = 1, .resource = other});
        device.run([&](const demo::ComputeCommands& commands) {
            commands.dispatch(kernel, 1, 1, 1, bytes.first(4));
        });
        CHECK(other.read_all<std::uint32_t>() == std::vector<std::uint32_t>{7, 7, 7});
        CHECK(seen.read_all<std::uint32_t>() == found);
        CHECK_THROWS_AS(kernel.bind({.set = 0, .binding = 5, .resource = other}), std::out_of_range);
    }
    SUBCASE("words are filled, and workgroups counted by the device") {
        const std::array<std::uint32_t, 3> counts{1, 1, 1};
        const demo::ComputeBuffer groups(device, std::as_bytes(std::span(counts)));
        device.run([&](const demo::ComputeCommands& commands) {
            commands.fill(seen, 8, 8, 100);
            commands.dispatch_indirect(kernel, groups, 0, bytes.first(4));
        });
        const auto after = seen.read_all<std::uint32_t>();
        CHECK(after[1] == 2 * found[1] + 7);
        CHECK(after[2] == 307);
        CHECK(after[3] == 507);
        CHECK(after[63] == 5 * found[63] + 7);
        CHECK(after[64] == found[64]);
    }
    CHECK(watched.messages.empty());
}

TEST_CASE("compute: what a device cannot do is said in one sentence that names it") {
    const demo::ComputeDevice device;
    CHECK(!device.name().empty());
    CHECK(!device.driver().empty());
    const auto names_device = [&](const std::string& text) {
        CAPTURE(text);
        return contains(text, "Vulkan: ") && contains(text, device.name());
    };
    const std::string too_large =
        message_of([&] { demo::ComputeBuffer(device, device.largest_buffer() + 4); });
    CHECK(names_device(too_large));
    CHECK(contains(too_large, std::to_string(device.largest_buffer() + 4)));

    const demo::ComputeBuffer buffer(device, 16);
    const std::array bindings{
        demo::ComputeBinding{.set = 0, .binding = 1, .resource = buffer},
        demo::ComputeBinding{.set = 1, .binding = 0, .resource = buffer, .is_uniform = true}};
    const demo::ComputeKernel kernel(device, multiply, bindings, 4);
    CHECK(names_device(message_of([&] {
        device.run([&](const demo::ComputeCommands& commands) { commands.dispatch(kernel, 1, 0xffffffffu); });
    })));
    CHECK(names_device(message_of([&] { demo::ComputeKernel(device, multiply, bindings, 1 << 20); })));
    const std::vector<demo::ComputeBinding> many(
        std::size_t{1} << 21, demo::ComputeBinding{.set = 0, .binding = 0, .resource = buffer});
    CHECK(names_device(message_of([&] { demo::ComputeKernel(device, multiply, many); })));
    const std::string no_device = message_of([] { demo::ComputeDevice({.device = "no such device"}); });
    CHECK(contains(no_device, "no such device"));
    CHECK(contains(no_device, device.name()));
}

TEST_CASE("compute: ray queries are there if they are wanted, or said to be lacking") {
    CHECK(!demo::ComputeDevice({.ray_queries = false}).has_ray_queries());
    const demo::ComputeDevice device;
    CHECK(device.has_ray_queries() == (!device.is_cpu() && test::there_are_ray_queries()));
    if (test::there_are_ray_queries())
        CHECK(demo::ComputeDevice({.ray_queries = true}).has_ray_queries());
    else
        CHECK(message_of([] { demo::ComputeDevice({.ray_queries = true}); }) ==
              "Vulkan: " + device.name() + " has no ray queries");

    const demo::ComputeDevice without({.ray_queries = false});
    const demo::ComputeBuffer vertices(without, 36);
    const std::array<std::uint32_t, 3> corners{0, 1, 2};
    CHECK(message_of([&] { demo::ComputeTriangles(without, vertices, 12, corners, {}); }) ==
          "Vulkan: " + without.name() + " was opened without ray queries");
}

}  // namespace gpu_compute_test
