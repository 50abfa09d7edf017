// SPDX-License-Identifier: MIT
#pragma once

#include "contestant.hpp"

#include <lightmesh/lightmesh.hpp>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// What the programs share that hold a light mesh against bars.

namespace bench {

using Mesh = lightmesh::LightMesh<demo::EmbreeIntersector>;

double seconds(const std::function<void()>& work);
/// Of this program's one thread: a busy machine makes others wait.
double processor_seconds(const std::function<void()>& work);
double least_seconds(int passes, const std::function<void()>& work);

/// The head of a table, after a warning if times mean nothing, and one of its rows: whether the bar is
/// reached stands in it, if there is one.
void print_head();
void print_row(const std::string& what, double measured, std::optional<double> to_reach, bool at_least,
               const std::string& beside);

std::vector<lightmesh::Light> lights_of(const Workload& workload);

/// q = 4 and the workload's radius.
lightmesh::Settings settings_of(const Workload& workload, lightmesh::ShortTest short_test);
Mesh make_mesh(const Workload& workload, lightmesh::ShortTest short_test);

/// Asks for all lights at all points, tile by tile.
void ask(const Mesh& mesh, const ShadingPoints& points);

/// Mean absolute difference of S between two meshes with the same lights, at points and lights that face each
/// other. `tiles`: how many of the points' tiles are taken.
double difference(const Mesh& mesh, const Mesh& other, const Workload& workload, const ShadingPoints& points,
                  std::size_t tiles);
/// The same to exact short tests.
double error_of(const Mesh& mesh, const Workload& workload);
/// An error as text, in per cent.
std::string error_text(double error);

/// ns a point of hard shadows by single rays.
double hard_ns(const Workload& workload, const ShadingPoints& points);

}  // namespace bench
