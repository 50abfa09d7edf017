// SPDX-License-Identifier: MIT
#include "row.hpp"

#include "pass.hpp"
#include "workloads.hpp"

#include <array>
#include <map>
#include <sstream>

namespace bench {

namespace {

const char* name_of(Algorithm algorithm) {
    constexpr std::array names{"hard", "area", "pcf", "exact", "linked", "express"};
    return names[static_cast<std::size_t>(algorithm)];
}

lightmesh::ShortTest short_test_of(Algorithm algorithm) {
    switch (algorithm) {
    case Algorithm::exact:
        return lightmesh::ShortTest::exact;
    case Algorithm::linked:
        return lightmesh::ShortTest::linked;
    default:
        return lightmesh::ShortTest::none;
    }
}

std::unique_ptr<Contestant> make_empty(const Row& row) {
    const Workload& work = workload(row.scene, row.lights);
    switch (row.algorithm) {
    case Algorithm::hard:
        return make_hard_shadows(work, row.form);
    case Algorithm::area:
        return make_area_shadows(work, row.form);
    case Algorithm::pcf:
        return make_shadow_maps(work);
    default:
        return make_light_mesh(work, row.quality, short_test_of(row.algorithm), row.query);
    }
}

std::shared_ptr<const Contestant> make_full(const Row& row) {
    std::shared_ptr<const Contestant> made = make_empty(row);
    Pass(points_of(row.scene, row.most_points), row.lights, 0).run(*made);
    return made;
}

/// Shadow maps of many lights take a gigabyte: only those of one row at a time are kept.
std::shared_ptr<const Contestant> shadow_maps(const Row& row) {
    static std::string whose;
    static std::shared_ptr<const Contestant> kept;
    if (whose != row.name()) {
        kept.reset();
        kept = make_full(row);
        whose = row.name();
    }
    return kept;
}

std::shared_ptr<const Contestant> full_mesh(const Row& row) {
    static std::map<std::string, std::shared_ptr<const Contestant>> kept;
    Row by_tiles = row;
    by_tiles.query = Query::tile;
    std::shared_ptr<const Contestant>& mesh = kept[by_tiles.name()];
    if (!mesh)
        mesh = make_full(by_tiles);
    return share_light_mesh(*mesh, row.query);
}

}  // namespace

std::string Row::name() const {
    std::ostringstream text;
    text << scene << '/' << name_of(algorithm);
    if (!form.empty())
        text << '/' << form;
    if (is_mesh())
        text << (cold ? "/cold" : "/warm") << (query == Query::tile ? "/tile" : "/point");
    text << "/lights:" << lights;
    if (is_mesh())
        text << "/q:" << quality << "/threads:" << threads;
    return text.str();
}

std::shared_ptr<const Contestant> contestant(const Row& row) {
    if (row.algorithm == Algorithm::pcf)
        return shadow_maps(row);
    if (!row.is_mesh() || row.cold)
        return make_empty(row);
    return full_mesh(warm(row));
}

Row warm(Row row) {
    row.cold = false;
    row.threads = 1;
    return row;
}

}  // namespace bench
