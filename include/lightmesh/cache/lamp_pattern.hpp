// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/rounded.hpp>

#include <glm/vec2.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

/// The places where rays meet a lamp. Fixed patterns, turned or shifted by 32 bits that belong to a record
/// and a lamp.

namespace lightmesh::detail {

/// The most points of a pattern.
inline constexpr std::size_t most_pattern_points = 256;

/// Points of the unit disc, times 1024. The first 16, the first 32, 64 and 128, and all 256 each split by
/// straight edges as the disc's area does, within .034, .022, .014, .0075 and .0045 (root mean square, over
/// edges at all distances from the centre; 16 random points: .095).
inline constexpr std::array<std::array<std::int16_t, 2>, most_pattern_points> disc_points{{
    {{45, 26}},     {{-268, 277}},  {{2, -402}},    {{397, 231}},   {{-537, -121}}, {{481, -301}},
    {{-24, 693}},   {{-514, -672}}, {{783, 402}},   {{-797, 359}},  {{516, -688}},  {{327, 770}},
    {{-784, -326}}, {{847, -117}},  {{-476, 672}},  {{-50, -843}},  {{213, 34}},    {{-462, 83}},
    {{180, -398}},  {{212, 436}},   {{-289, -310}}, {{560, -57}},   {{-287, 570}},  {{-210, -694}},
    {{550, 633}},   {{-871, -1}},   {{695, -442}},  {{-22, 940}},   {{-675, -515}}, {{943, 115}},
    {{-671, 497}},  {{220, -914}},  {{-100, 27}},   {{-257, 4}},    {{204, -217}},  {{33, 315}},
    {{-166, -265}}, {{435, 82}},    {{-169, 252}},  {{18, -579}},   {{342, 371}},   {{-598, -249}},
    {{624, -197}},  {{-411, 581}},  {{-346, -493}}, {{730, 264}},   {{-552, 317}},  {{267, -512}},
    {{31, 587}},    {{-604, -742}}, {{727, -10}},   {{-590, 786}},  {{35, -832}},   {{434, 565}},
    {{-686, 92}},   {{720, -591}},  {{-156, 892}},  {{-374, -874}}, {{744, 605}},   {{-907, 205}},
    {{338, -760}},  {{286, 911}},   {{-939, -248}}, {{926, -324}},  {{-38, 450}},   {{485, -501}},
    {{-641, -384}}, {{625, 186}},   {{-801, 143}},  {{57, -294}},   {{196, 665}},   {{-201, -946}},
    {{123, 164}},   {{-308, 918}},  {{456, -865}},  {{-716, -101}}, {{839, 91}},    {{-404, -252}},
    {{446, -161}},  {{-732, 620}},  {{-156, -546}}, {{458, 821}},   {{160, -607}},  {{-367, 378}},
    {{771, -248}},  {{-852, -521}}, {{498, 344}},   {{-461, 222}},  {{-332, -691}}, {{81, 802}},
    {{355, -332}},  {{-45, -141}},  {{918, 337}},   {{-988, -11}},  {{192, -755}},  {{-191, 447}},
    {{-266, 752}},  {{841, -475}},  {{-585, -560}}, {{263, 182}},   {{-336, 113}},  {{320, -75}},
    {{-875, 463}},  {{-69, -684}},  {{610, 779}},   {{120, -129}},  {{-153, 673}},  {{-458, -811}},
    {{966, -76}},   {{-521, -20}},  {{301, 594}},   {{376, -598}},  {{-546, 476}},  {{614, 66}},
    {{-471, -417}}, {{614, 395}},   {{-170, -415}}, {{138, 936}},   {{62, -977}},   {{-674, 267}},
    {{580, -394}},  {{-55, 145}},   {{-825, -198}}, {{663, 504}},   {{-271, -124}}, {{-436, 821}},
    {{636, -741}},  {{125, 421}},   {{-160, -188}}, {{345, 494}},   {{-405, -603}}, {{696, -310}},
    {{-739, 421}},  {{401, -44}},   {{-77, 559}},   {{123, -800}},  {{-678, -4}},   {{827, 297}},
    {{-172, -78}},  {{368, -473}},  {{-131, 1002}}, {{-743, -663}}, {{543, 532}},   {{-76, -438}},
    {{-501, 396}},  {{605, -506}},  {{-552, 84}},   {{96, 698}},    {{-54, -957}},  {{730, 117}},
    {{-803, 552}},  {{254, -340}},  {{145, 255}},   {{-558, -457}}, {{525, 733}},   {{533, -774}},
    {{-607, -119}}, {{-91, 375}},   {{778, -139}},  {{-432, -163}}, {{-348, 840}},  {{97, -683}},
    {{502, 258}},   {{-988, 169}},  {{267, -148}},  {{206, 920}},   {{-298, -900}}, {{554, -159}},
    {{-351, 184}},  {{-261, -440}}, {{794, 550}},   {{-692, -255}}, {{677, -665}},  {{-327, 665}},
    {{36, 199}},    {{59, 522}},    {{303, -839}},  {{-755, 217}},  {{820, 185}},   {{-281, -598}},
    {{-93, 745}},   {{-66, -284}},  {{804, -403}},  {{-746, -386}}, {{396, 896}},   {{-319, 34}},
    {{181, -464}},  {{-669, 701}},  {{503, -3}},    {{-356, -760}}, {{304, 286}},   {{-868, 86}},
    {{982, -195}},  {{-298, 459}},  {{-149, -883}}, {{437, 430}},   {{-402, -70}},  {{355, -216}},
    {{-77, 837}},   {{-757, -506}}, {{788, -559}},  {{-407, 479}},  {{49, -98}},    {{681, 435}},
    {{-463, -508}}, {{-74, 247}},   {{400, -686}},  {{-899, 324}},  {{597, 292}},   {{-355, -366}},
    {{231, 791}},   {{73, -495}},   {{-952, -101}}, {{988, 168}},   {{213, 110}},   {{-573, 572}},
    {{152, -963}},  {{185, 563}},   {{-305, -190}}, {{584, -308}},  {{-595, 171}},  {{672, 702}},
    {{-520, -853}}, {{-188, 568}},  {{519, -581}},  {{-518, -301}}, {{341, 117}},   {{-494, 835}},
    {{262, -637}},  {{-29, -37}},   {{869, 450}},   {{-871, -222}}, {{193, 368}},   {{-73, -557}},
    {{698, -70}},   {{-416, 276}},  {{41, 919}},    {{370, -899}},  {{-614, -666}}, {{425, 669}},
    {{132, -263}},  {{-654, 357}},  {{864, -272}},  {{-166, 117}},  {{-195, -783}}, {{-228, 840}},
    {{531, 135}},   {{-892, -371}}, {{430, -385}},  {{323, 678}},   {{-14, -720}},  {{-554, 653}},
    {{886, 2}},     {{-809, -53}},  {{161, -24}},   {{-219, 336}},
}};

/// A rotation by one of 4096 angles, in numbers that are the same on every machine: the cosine and the sine
/// as (1 - t^2) / (1 + t^2) and 2t / (1 + t^2), and a quarter turn or none, or half a turn.
inline glm::dvec2 turn_of(std::uint32_t bits) {
    const double t = (static_cast<double>(bits & 1023u) + 0.5) / 1024.0 * 0.82842712 - 0.41421356;
    const float rounded = static_cast<float>(t);
    const double square = static_cast<double>(rounded) * static_cast<double>(rounded);
    const double c = (1.0 - square) / (1.0 + square);
    const double s = 2.0 * static_cast<double>(rounded) / (1.0 + square);
    switch (bits >> 10 & 3u) {
    case 0:
        return {c, s};
    case 1:
        return {-s, c};
    case 2:
        return {-c, -s};
    default:
        return {s, -c};
    }
}

/// The i-th point of the unit disc, turned.
inline glm::dvec2 disc_point(std::size_t i, const glm::dvec2& turn) {
    const double x = disc_points[i][0] / 1024.0;
    const double y = disc_points[i][1] / 1024.0;
    return {rounded(x * turn.x) - rounded(y * turn.y), rounded(x * turn.y) + rounded(y * turn.x)};
}

/// A point of the square [-1, 1]^2: the (0, 2)-sequence of Sobol (1967) in base 2, shifted digit by digit
/// (Kollig and Keller 2002). The first 16 lie one in each cell of 4 x 4.
inline glm::dvec2 square_point(std::uint32_t i, std::uint32_t bits) {
    std::uint32_t x = 0;
    std::uint32_t y = 0;
    std::uint32_t direction = 0x8000u;
    for (int digit = 0; digit < 8; ++digit) {
        if ((i >> digit & 1u) != 0) {
            x ^= 0x8000u >> digit;
            y ^= direction;
        }
        direction ^= direction >> 1;
    }
    x ^= bits & 0xffffu;
    y ^= bits >> 16;
    return {(x + 0.5) / 32768.0 - 1.0, (y + 0.5) / 32768.0 - 1.0};
}

/// Eight points around the square [-1, 1]^2: centres of its sides, and corners between them. Rims lie a
/// little within.
inline constexpr std::array<std::array<int, 2>, 8> around_square{
    {{{1, 0}}, {{1, 1}}, {{0, 1}}, {{-1, 1}}, {{-1, 0}}, {{-1, -1}}, {{0, -1}}, {{1, -1}}}};
inline constexpr double rim = 0.97;

/// The i-th of eight points near the rim of the square.
inline glm::dvec2 square_rim(std::size_t i) {
    return {rim * around_square[i][0], rim * around_square[i][1]};
}

/// The i-th of eight points near the rim of the unit disc, turned.
inline glm::dvec2 disc_rim(std::size_t i, const glm::dvec2& turn) {
    const double radius = i % 2 == 0 ? rim : 0.70710678118654752440 * rim;
    const double x = radius * around_square[i][0];
    const double y = radius * around_square[i][1];
    return {rounded(x * turn.x) - rounded(y * turn.y), rounded(x * turn.y) + rounded(y * turn.x)};
}

}  // namespace lightmesh::detail
