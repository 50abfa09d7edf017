// SPDX-License-Identifier: MIT

// examples/one_feature_each/, run as its readers would.

#include "run_command.hpp"

#include <doctest/doctest.h>

#include <string>

namespace one_feature_each_test {

namespace {

/// The program ends well, and one of its lines has `part` in it.
void check_prints(const std::string& program, const std::string& part) {
    CAPTURE(program);
    const test::TemporaryFolder folder;
    const test::Finished ran =
        test::run(folder, "cd " + (folder / "").string() + " && " LIGHTMESH_ONE_FEATURE_EACH "/" + program);
    CHECK(ran.status == 0);
    CHECK(ran.errors.empty());
    CHECK_MESSAGE(ran.output.find(part) != std::string::npos, ran.output);
}

}  // namespace

TEST_CASE("the examples of one feature each do what they say") {
    check_prints("batch_queries", "the same values: yes");
    check_prints("shadow_maps", "long rays: 0 with maps");
    check_prints("shadow_maps", "mean difference below 1 %: yes");
    check_prints("shadow_volumes", "long rays: 0 with volumes");
    check_prints("shadow_volumes", "the same within 1 %: yes");
    check_prints("standalone_shadow_map", " 0 wrong");
    check_prints("moving_scene", "the same values");
    check_prints("snapshots", "a second start: 0 long rays, the same values");
    check_prints("snapshots", "not in the snapshot: 2 values");
    check_prints("snapshots", "its checksum is wrong");
    check_prints("shaders", "missing: 0 of 130");
    check_prints("shaders", "the CPU's values: yes");
    check_prints("tuning", "Take a cache rather than a mesh: the best mesh (r 0.8, ");
    check_prints("tuning", "paste: lightmesh::CacheSettings{.spacing = 0.");
    check_prints("visibility_cache", "softer with distance: yes");
}

}  // namespace one_feature_each_test
