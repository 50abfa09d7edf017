// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/self_test/finding.hpp>
#include <lightmesh/adapters/self_test/known_scenes.hpp>
#include <lightmesh/adapters/self_test/scene_test.hpp>
#include <lightmesh/adapters/self_test/segments.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/segment.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// Tests tracers over scenes of which the right answers are known. A fault that was named is not looked for
/// in the scenes that follow.
template <class Factory>
class KnownTest {
public:
    explicit KnownTest(Factory& make_tracer) : make_tracer_(make_tracer) {}

    std::vector<std::string> run() {
        const bool lengths_are_right = test_sheets();
        const bool sheets_are_right = sentences_.empty();
        if (lengths_are_right)
            test_ends();
        if (sheets_are_right) {
            test_boxes();
            test_slivers();
        }
        if (sentences_.empty())
            test_scales();
        test_soup();
        return std::move(sentences_);
    }

private:
    /// Calls use(tracer) for the scene, put down.
    template <class Use>
    void with_tracer(std::vector<TestTriangle> scene, const Placement& placement, Use&& use) {
        for (TestTriangle& triangle : scene)
            for (glm::vec3& corner : triangle)
                corner = placement(corner);
        const auto tracer = make_tracer_(std::span<const TestTriangle>(scene));
        use(tracer);
    }

    void ask(const std::vector<TestTriangle>& scene, const Placement& placement,
             const std::vector<Question>& questions, Finding& finding) {
        with_tracer(scene, placement, [&](const auto& tracer) {
            for (const Question& question : questions) {
                const Segment segment = placement(question.segment);
                finding.add(tracer.occluded(segment) != question.is_blocked, segment);
            }
        });
    }

    /// The ways to go wrong at a sheet.
    struct Sheet {
        Finding missed;   ///< open both ways where it blocks
        Finding front;    ///< open one way
        Finding back;     ///< open the other way
        Finding beyond;   ///< blocked where the sheet lies beyond an end
        Finding normals;  ///< of closest_hit
    };

    static constexpr int questions_per_sheet = 200;  ///< and axis

    Sheet ask_sheet(float slope, bool is_straight) {
        Sheet sheet;
        for (int axis = 0; axis < 3; ++axis) {
            const Placement placement{1.0f, axis};
            with_tracer(test_sheet(slope), placement, [&](const auto& tracer) {
                for (int i = 0; i < questions_per_sheet; ++i)
                    ask_sheet_once(tracer, placement, slope, is_straight, sheet);
            });
        }
        return sheet;
    }

    template <class Tracer>
    void ask_sheet_once(const Tracer& tracer, const Placement& placement, float slope, bool is_straight,
                        Sheet& sheet) {
        const glm::vec3 point = point_on_sheet(numbers_, slope);
        const glm::vec3 step = step_through_sheet(numbers_, is_straight);
        const float above = numbers_.dyadic(2, 5);
        const float below = numbers_.dyadic(2, 5);
        const Segment down = placement(Segment{point + above * step, point - below * step});
        const Segment up = reversed(down);
        const bool is_down_blocked = tracer.occluded(down);
        const bool is_up_blocked = tracer.occluded(up);
        sheet.missed.add(!is_down_blocked && !is_up_blocked, down);
        if (is_down_blocked || is_up_blocked) {
            sheet.front.add(!is_down_blocked, down);
            sheet.back.add(!is_up_blocked, up);
        }
        for (const float side : {-1.0f, 1.0f}) {
            const Segment before =
                placement(Segment{point + 0.75f * side * step, point + 0.25f * side * step});
            sheet.beyond.add(tracer.occluded(before), before);
        }
        if constexpr (ClosestHitIntersector<Tracer>) {
            const glm::vec3 normal = glm::normalize(placement(glm::vec3{-2.0f * slope, -slope, 1.0f}));
            for (const Segment& segment : {down, up})
                if (const std::optional<Hit> hit = tracer.closest_hit(segment))
                    sheet.normals.add(!(std::abs(glm::dot(hit->normal, normal)) > 0.999f &&
                                        std::abs(glm::dot(hit->normal, hit->normal) - 1.0f) < 1e-2f),
                                      segment);
        }
    }

    /// Sheets across the axes and flat ones, by segments along axes and others: where it fails tells why.
    /// Returns whether the tracer gets lengths right.
    bool test_sheets() {
        const Sheet slanted = ask_sheet(0.125f, false);
        if (slanted.beyond.is_more_than(0.05) ||
            (slanted.missed.wrong > 0 && !slanted.missed.is_more_than(0.99))) {
            const bool is_beyond = slanted.beyond.wrong > 0;
            const Finding& finding = is_beyond ? slanted.beyond : slanted.missed;
            say(finding,
                is_beyond ? "segments that end before a sheet are blocked"
                          : "segments through a sheet are not blocked",
                "the tracer gets the segment's length wrong: direction = target - origin is not "
                "normalised, and blockers count at 0 < t < 1");
            return false;
        }
        if (say(slanted.missed, "segments through a sheet are not blocked",
                "a sheet of two triangles, 8 by 8, must block; if the tracer normalises the direction, "
                "t must reach to the segment's length"))
            return false;
        for (const Finding& side : {slanted.front, slanted.back})
            say(side, "segments through a sheet are not blocked from one of its sides",
                "surfaces must block from both sides; is back-face culling on?");
        say(slanted.normals, "normals of closest_hit are not the sheet's",
            "they must be unit geometric normals, to either side");
        const Sheet straight = ask_sheet(0.125f, true);
        const bool zeros_are_right =
            !say(straight.missed,
                 "axis-parallel segments through a slanting sheet are not blocked, though others are",
                 "the tracer's box test fails for directions with zeros (0 * infinity)");
        const Sheet flat = ask_sheet(0.0f, false);
        const bool flat_is_right =
            !say(flat.missed,
                 "segments through an axis-parallel sheet are not blocked, though a slanting one blocks",
                 "the tracer's box test loses boxes of thickness 0");
        if (zeros_are_right && flat_is_right)
            say(ask_sheet(0.0f, true).missed,
                "axis-parallel segments through an axis-parallel sheet are not blocked",
                "the tracer's box test fails for directions with zeros at boxes of thickness 0");
        return true;
    }

    /// Sheets exactly at an end and close to it. Lengths are powers of two: t is exactly 0 or 1, so most
    /// tracers do not round it.
    void test_ends() {
        Finding at_origin;
        Finding at_target;
        Finding close_by;
        for (int axis = 0; axis < 3; ++axis) {
            const Placement placement{1.0f, axis};
            with_tracer(test_sheet(0.0f), placement, [&](const auto& tracer) {
                for (int i = 0; i < questions_per_sheet; ++i) {
                    const glm::vec3 point = point_on_sheet(numbers_, 0.0f);
                    const glm::vec3 step{
                        0.0f, 0.0f, std::exp2(static_cast<float>(i % 4 - 1)) * (i % 8 < 4 ? 1.0f : -1.0f)};
                    const Segment leaving = placement(Segment{point, point + step});
                    at_origin.add(tracer.occluded(leaving), leaving);
                    at_target.add(tracer.occluded(reversed(leaving)), reversed(leaving));
                    const Segment through = placement(Segment{point - 0x1p-12f * step, point + step});
                    const bool is_through = tracer.occluded(placement(Segment{point - step, point + step}));
                    if (is_through) {
                        close_by.add(!tracer.occluded(through), through);
                        close_by.add(!tracer.occluded(reversed(through)), reversed(through));
                    }
                }
            });
        }
        if (at_origin.is_more_than(0.5))
            say(at_origin, "segments are blocked by a sheet exactly at their origin",
                "both ends are exclusive: blockers count at t > 0; if the tracer includes its bounds, begin "
                "some roundings later");
        if (at_target.is_more_than(0.5))
            say(at_target, "segments are blocked by a sheet exactly at their target",
                "both ends are exclusive: blockers count at t < 1; if the tracer includes its bounds, end "
                "some "
                "roundings earlier");
        // One side of a one-sided sheet is another fault.
        if (close_by.is_more_than(0.6) || (sentences_.empty() && close_by.wrong > 0))
            say(close_by, "segments are not blocked by a sheet close to an end, at 2^-12 of their length",
                "ends are off all surfaces already: the tracer must add no epsilon");
    }

    void test_boxes() {
        std::vector<Question> through;
        std::vector<Question> out;
        std::vector<Question> open;
        for (int i = 0; i < questions_per_sheet; ++i) {
            // Off the diagonals of the faces, in the plane z = 0 as well as above it.
            const glm::vec3 point{0.25f + 0.5f * (numbers_.dyadic(0, 1)),
                                  -1.0f - 0.25f * numbers_.dyadic(0, 1), 0.125f * numbers_.dyadic(0, 1)};
            const glm::vec3 step = step_through_sheet(numbers_, i % 2 == 0) * glm::vec3(0.25f, 0.25f, 1.0f);
            const float above = numbers_.dyadic(4, 6);
            const glm::vec3 beside{16.0f, 0.0f, 0.0f};
            through.push_back({{point + above * step, point - above * step}, true});
            out.push_back({{point, point + above * step}, true});
            out.push_back({{point + above * step, point}, true});
            open.push_back({{point, point + 0.5f * step}, false});
            open.push_back({{point + beside + above * step, point + beside - above * step}, false});
        }
        const std::vector<TestTriangle> box = test_box(glm::vec3(-2.0f), glm::vec3(2.0f));
        const std::vector<TestTriangle> flat = test_box({-2.0f, -2.0f, -0.5f}, {2.0f, 2.0f, -0.5f});
        Finding through_box;
        Finding out_of_box;
        Finding beside_box;
        Finding through_flat;
        for (int axis = 0; axis < 3; ++axis) {
            const Placement placement{1.0f, axis};
            ask(box, placement, through, through_box);
            ask(box, placement, out, out_of_box);
            ask(box, placement, open, beside_box);
            ask(flat, placement, through, through_flat);
        }
        say(through_box, "segments through a closed box are not blocked",
            "its faces are 12 triangles, 4 by 4");
        say(out_of_box, "segments between the inside of a closed box and its outside are not blocked",
            "a segment that leads out of a solid is blocked as well as one that leads into it");
        say(beside_box, "segments within a closed box or beside it are blocked", "nothing is in their way");
        say(through_flat,
            "segments through a flat box, of 12 triangles of which 8 are empty, are not blocked",
            "triangles without area must not hide others, nor boxes of thickness 0 be lost");
    }

    /// A lone triangle, long and narrow, across all axes.
    void test_slivers() {
        const std::vector<TestTriangle> scene{{glm::vec3{-4.0f, -0x1p-8f, -1.0f},
                                               glm::vec3{-4.0f, 0x1p-8f, -1.0f},
                                               glm::vec3{4.0f, 0.0f, 1.0f}}};
        std::vector<Question> questions;
        for (int i = 0; i < questions_per_sheet; ++i) {
            const float x = numbers_.dyadic(-3, 1);
            const glm::vec3 point{x, 0.0f, 0.25f * x};
            const glm::vec3 step = step_through_sheet(numbers_, i % 2 == 0);
            questions.push_back({{point + step, point - step}, true});
            questions.push_back({{point - step, point + step}, true});
            const glm::vec3 aside{0.0f, 0x1p-4f, 0.0f};
            questions.push_back({{point + aside + step, point + aside - step}, false});
        }
        Finding finding;
        for (int axis = 0; axis < 3; ++axis)
            ask(scene, {1.0f, axis}, questions, finding);
        say(finding, "answers about a lone sliver, 8 long and 1/128 wide, are wrong",
            "small and narrow triangles block as well as others");
    }

    /// All the same, small and large.
    void test_scales() {
        for (const int power : {-10, 10}) {
            const float scale = std::exp2(static_cast<float>(power));
            std::vector<Question> questions;
            for (int i = 0; i < questions_per_sheet; ++i) {
                const glm::vec3 point = point_on_sheet(numbers_, 0.125f);
                const glm::vec3 step = step_through_sheet(numbers_, i % 2 == 0);
                questions.push_back({{point + step, point - step}, true});
                questions.push_back({{point - step, point + step}, true});
                questions.push_back({{point + step, point + 0.25f * step}, false});
            }
            Finding finding;
            for (int axis = 0; axis < 3; ++axis)
                ask(test_sheet(0.125f), {scale, axis}, questions, finding);
            say(finding,
                std::string("answers about a scene that is right at its own size are wrong at ") +
                    (power < 0 ? "1/1024" : "1024 times") + " its size",
                "the tracer has an epsilon or a bound in world units");
        }
    }

    /// Loose triangles: right answers, and all that is tested without knowing them.
    void test_soup() {
        const std::vector<TestTriangle> scene = detail::test_soup(numbers_);
        const Bounds bounds{glm::vec3(-5.0f), glm::vec3(5.0f)};
        with_tracer(scene, {}, [&](const auto& tracer) {
            if (sentences_.empty()) {
                Finding finding;
                std::vector<Segment> segments = slanted_segments(numbers_, bounds);
                const std::vector<Segment> straight = straight_segments(numbers_, bounds);
                segments.insert(segments.end(), straight.begin(), straight.end());
                for (const Segment& segment : segments)
                    if (const std::optional<bool> is_blocked = blocks(scene, segment))
                        finding.add(tracer.occluded(segment) != *is_blocked, segment);
                say(finding, "answers about 32 loose triangles are wrong, none of them near to an edge",
                    "each triangle blocks what crosses it, and nothing else");
            }
            for (std::string& sentence : SceneTest(tracer, bounds).run())
                sentences_.push_back(std::move(sentence));
        });
    }

    /// Returns whether there was something to say.
    bool say(const Finding& finding, const std::string& what, const std::string& why) {
        if (finding.wrong == 0)
            return false;
        sentences_.push_back(finding.sentence(what, why));
        return true;
    }

    Factory& make_tracer_;
    TestNumbers numbers_;
    std::vector<std::string> sentences_;
};

}  // namespace lightmesh::detail
