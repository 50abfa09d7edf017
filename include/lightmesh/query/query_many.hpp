// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/trace.hpp>
#include <lightmesh/query/hemisphere.hpp>
#include <lightmesh/query/neighbours.hpp>
#include <lightmesh/query/query.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>

namespace lightmesh::detail {

/// Finds the seeds of the linked short test for the queries whose numbers are in `waiting`, with rays in
/// batches, and does the test.
template <class Store, class Kernel>
void find_seeds(const Store& store, std::span<std::optional<Query<Store, Kernel>>> queries,
                std::span<std::size_t> waiting) {
    while (!waiting.empty()) {
        std::array<Segment, most_segments> segments;
        std::array<std::uint8_t, most_segments> hit;
        std::size_t size = 0;
        for (const std::size_t i : waiting)
            if (queries[i]->next_seed(segments[size]))
                waiting[size++] = i;
        trace(store.tracer(), std::span<const Segment>(segments).first(size), std::span(hit).first(size));
        std::size_t still = 0;
        for (std::size_t k = 0; k < size; ++k) {
            if (hit[k] != 0)
                waiting[still++] = waiting[k];
            else
                queries[waiting[k]]->link_to_seed();
        }
        waiting = waiting.first(still);
    }
}

/// S of all lights for many points, row by row.
template <class Kernel, class Store>
void query_many(const Store& store, std::span<const glm::vec3> points, std::span<const glm::vec3> normals,
                std::span<float> all, QueryStatistics* spent) {
    using OneQuery = Query<Store, Kernel>;
    const std::size_t light_count = store.lights().size();
    BrickPoints memory[2 * Hemisphere::max_entries];
    if (store.settings().short_test != ShortTest::linked) {
        for (std::size_t i = 0; i < points.size(); ++i)
            OneQuery(store, points[i], normals[i], spent)
                .all(all.subspan(i * light_count, light_count), memory);
        return;
    }
    // As many points at once as there are places for segments and for neighbours.
    std::array<std::optional<OneQuery>, most_segments> queries;
    for (std::size_t done = 0; done < points.size();) {
        std::array<std::size_t, most_segments> waiting;
        std::size_t waiting_count = 0;
        std::size_t taken = 0;
        std::size_t count = 0;
        for (; count < queries.size() && done + count < points.size(); ++count) {
            if (taken + Hemisphere::max_entries > std::size(memory))
                break;
            OneQuery& query =
                queries[count].emplace(store, points[done + count], normals[done + count], spent);
            const auto values = all.subspan((done + count) * light_count, light_count);
            if (query.answers_without_neighbours(values)) {
                queries[count].reset();
                continue;
            }
            taken += query.find_neighbours(memory + taken);
            waiting[waiting_count++] = count;
        }
        find_seeds<Store, Kernel>(store, queries, std::span(waiting).first(waiting_count));
        for (std::size_t i = 0; i < count; ++i)
            if (queries[i])
                queries[i]->average(all.subspan((done + i) * light_count, light_count));
        done += count;
    }
}

}  // namespace lightmesh::detail
