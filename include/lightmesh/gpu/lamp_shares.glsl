// SPDX-License-Identifier: MIT
// Shares of lamps that records of a visibility cache see, by rays of your own tracer in a shader:
// `VisibilityCache::fill_shares` hands out the work and stores what is found. It is what the cache itself would find
// with the same answers of the tracer.
//
//     layout(local_size_x = 64) in;              // so many, along x alone
//     #define LIGHTMESH_LAMP_SET 0
//     #define LIGHTMESH_LAMP_BINDING 0           // the storage buffer of the work; the next one is of what is found
//     #include <lightmesh/gpu/lamp_shares.glsl>
//     bool lightmesh_is_open(vec3 from, vec3 to) { return !...; }    // rays: yours
//     void main() { lightmesh_find_lamp_shares(0u); }
//
// The second buffer has a word for each share. A workgroup finds four of them, which 16 lanes each do together: their
// rays are near to each other. lightmesh_find_lamp_shares must be called in uniform control flow; it contains barriers.
// GLSL 4.5 for Vulkan 1.0: no 64-bit types, no subgroups.
#ifndef LIGHTMESH_LAMP_SHARES_GLSL
#define LIGHTMESH_LAMP_SHARES_GLSL

#include "lamp.glsl"

#ifndef LIGHTMESH_LAMP_SET
#define LIGHTMESH_LAMP_SET 0
#endif
#ifndef LIGHTMESH_LAMP_BINDING
#define LIGHTMESH_LAMP_BINDING 0
#endif

bool lightmesh_is_open(vec3 from, vec3 to);

// As `ShareWork` lays it out:
//     number of shares | where the lamps begin | where the shares begin | 0
//     the greatest length of a ray, a double | 0 | 0
//     64: points of the disc's pattern, a word each
//     1024: turns of it, see `lightmesh_lamp_turn`
//     lamps, four each: see `lightmesh_lamp_of_work`
//     rows, three each and two for each of their places, which have positions and parts, and normals: see
//     `lightmesh_find_lamp_shares`
//     shares, two words each: where the row is | the lamp's number
layout(std430, set = LIGHTMESH_LAMP_SET, binding = LIGHTMESH_LAMP_BINDING) readonly buffer LightMeshLampWork {
    uvec4 lightmesh_lamp_work[];
};
layout(std430, set = LIGHTMESH_LAMP_SET, binding = LIGHTMESH_LAMP_BINDING + 1) writeonly buffer LightMeshLampFound {
    uint lightmesh_lamp_found[];  // 0 to 255, or what a probe says; and, 256 times, the number of rays
};

const uint lightmesh_lamp_lanes = 16u;
const uint lightmesh_lamp_discs_at = 2u;
const uint lightmesh_lamp_turns_at = 66u;
const uint lightmesh_lamp_own_place = 256u;  // of a place: it is the record itself

// The number of rays, and 65536 times that of the open ones: of each share of the workgroup those from
// places around, those to the rim, and others. With the first lightmesh_lamp_hidden, once or more, if the record itself
// has nothing of the lamp above it.
shared uint lightmesh_lamp_counts[12];
const uint lightmesh_lamp_hidden = 0x01000000u;
shared uint lightmesh_lamp_left;  // shares that take more rays

LightMeshLamp lightmesh_lamp_of_work(uint number) {
    uint at = lightmesh_lamp_work[0].y + 4u * number;
    uvec4 a = lightmesh_lamp_work[at], b = lightmesh_lamp_work[at + 1u];
    uvec4 c = lightmesh_lamp_work[at + 2u], d = lightmesh_lamp_work[at + 3u];
    return LightMeshLamp(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), uintBitsToFloat(c.xyz), uvec2(b.w, c.w),
                         d.xy, d.zw);
}

uint lightmesh_lamp_share(uint open, uint sum) {
    return (510u * open + sum) / (2u * max(sum, 1u));
}

// As `shaft_byte`.
uint lightmesh_lamp_shaft_byte(uint value, bool misses) {
    if (misses)
        return value == 0u ? 1u : value == 255u ? 253u : clamp(value | 1u, 3u, 251u);
    return value == 0u || value == 255u ? value : max(value & 254u, 2u);
}

// Of the shares from `first` on: that of the first workgroup.
void lightmesh_find_lamp_shares(uint first) {
    uint of_group = gl_LocalInvocationID.x / lightmesh_lamp_lanes, lane = gl_LocalInvocationID.x % lightmesh_lamp_lanes;
    uint first_of_group = first + 4u * gl_WorkGroupID.x, share_count = lightmesh_lamp_work[0].x;
    uint share = first_of_group + of_group;
    bool is_left = share < share_count;
    uvec4 shares = lightmesh_lamp_work[lightmesh_lamp_work[0].z + (is_left ? share >> 1 : 0u)];
    uint row = (share & 1u) == 0u ? shares.x : shares.z;
    LightMeshLamp lamp = lightmesh_lamp_of_work((share & 1u) == 0u ? shares.y : shares.w);
    // Position and turn; normal and how far short of lamps rays end at least; what the rays are.
    uvec4 head = lightmesh_lamp_work[row], second = lightmesh_lamp_work[row + 1u];
    uvec4 plan = lightmesh_lamp_work[row + 2u];
    uvec2 reach = lightmesh_lamp_work[1].xy;
    float least_end = uintBitsToFloat(second.w);
    // As in `RowLook` and `RayPlan`.
    bool is_probe = (plan.x & 3u) == 1u, is_around = (plan.x & 3u) != 0u, has_rim = (plan.x & 4u) != 0u;
    uint place_count = plan.w & 255u, rays_of_place = (plan.w >> 8) & 255u, parts_apart = plan.w >> 16;
    bool is_point = lightmesh_lamp_is_point(lamp), is_square = lamp.kind == lightmesh_lamp_rectangle;
    if (is_point)
        rays_of_place = 1u;
    uint begin = 0u, end = plan.y;
    bool is_unsettled = false, is_doubted = false, misses = false;
    uint value = 0u;
    // The place that `view` and `is_hidden` are of; that of the record itself follows all others.
    uint at_place = ~0u;
    bool is_hidden = false;
    LightMeshLampView view;
    bool has_turn = false;
    LightMeshLampTurn turn;
    if (lane < 3u)
        lightmesh_lamp_counts[3u * of_group + lane] = 0u;
    if (gl_LocalInvocationID.x == 0u)
        lightmesh_lamp_left = first_of_group < share_count ? min(4u, share_count - first_of_group) : 0u;
    barrier();
    // From places around, the first rays, and the others: rays that disagree go on to do so, however many there are.
    do {
        uint rims = begin == 0u && has_rim && !is_point ? 8u : 0u;
        uint count = is_around ? place_count * rays_of_place
                     : is_point ? (begin == 0u ? 1u : 0u)
                                : rims + end - begin;
        uvec2 counts = uvec2(0u);  // rim, others
        for (uint n = is_left ? lane : count; n < count; n += lightmesh_lamp_lanes) {
            uint place = is_around ? n / rays_of_place : place_count;
            uint part = begin + n - rims;
            uvec4 origin = is_around ? lightmesh_lamp_work[row + 3u + 2u * place] : head;
            if (place != at_place) {
                at_place = place;
                uvec4 normal = is_around ? lightmesh_lamp_work[row + 4u + 2u * place] : second;
                is_hidden = lightmesh_lamp_is_below(lamp, uintBitsToFloat(origin.xyz), uintBitsToFloat(normal.xyz));
                if (!is_hidden)
                    view = lightmesh_lamp_view(lamp, uintBitsToFloat(origin.xyz), least_end, reach);
                else if (is_around && (origin.w & lightmesh_lamp_own_place) != 0u)
                    counts.y += lightmesh_lamp_hidden;
            }
            if (is_hidden)
                continue;
            if (is_around)
                part = (origin.w & 255u) + n % rays_of_place * parts_apart;
            bool is_rim = !is_around && n < rims;
            LightMeshLampPlace to = lightmesh_lamp_middle();
            if (!is_point) {
                if (is_rim)
                    to = lightmesh_lamp_rim_point(n, is_square);
                else if (is_square)
                    to = lightmesh_lamp_square_point(part, head.w);
                else
                    to = lightmesh_lamp_disc_point(
                        lightmesh_lamp_work[lightmesh_lamp_discs_at + (part >> 2)][part & 3u]);
                if (!is_square) {
                    if (!has_turn) {
                        has_turn = true;
                        turn = lightmesh_lamp_turn(lightmesh_lamp_work[lightmesh_lamp_turns_at + (head.w & 1023u)],
                                                   head.w, lamp.radius);
                    }
                    to = lightmesh_lamp_turned(to, turn);
                }
            }
            bool is_open = lightmesh_is_open(view.origin, lightmesh_lamp_target(view, to));
            counts[is_rim ? 0 : 1] += is_open ? 65537u : 1u;
        }
        if (counts.x != 0u)
            atomicAdd(lightmesh_lamp_counts[3u * of_group + 1u], counts.x);
        if (counts.y != 0u)
            atomicAdd(lightmesh_lamp_counts[3u * of_group + (is_around ? 0u : 2u)], counts.y);
        barrier();
        uvec3 all = uvec3(lightmesh_lamp_counts[3u * of_group], lightmesh_lamp_counts[3u * of_group + 1u],
                          lightmesh_lamp_counts[3u * of_group + 2u]);
        uvec3 sums = all & 0xffffu, open = all >> 16;
        // As `LampTally` ends a round.
        bool is_done = false;
        if (is_left && is_around) {
            bool is_below = open.x >= lightmesh_lamp_hidden >> 16;
            open.x &= (lightmesh_lamp_hidden >> 16) - 1u;
            bool sees_both = open.x != 0u && open.x != sums.x;
            bool is_enough = sums.x >= parts_apart * rays_of_place / 2u;
            value = lightmesh_lamp_share(open.x, sums.x);
            if (is_probe)
                value = sees_both ? 127u : sums.x == 0u ? 128u : value;
            is_unsettled = !is_probe && (sees_both || !is_enough || (open.x != 0u && is_below));
            is_doubted = sees_both;
            is_around = false;
            is_done = !is_unsettled;
        } else if (is_left) {
            uint around = value;
            bool sees_open = open.y + open.z != 0u, sees_closed = open.y + open.z != sums.y + sums.z;
            value = plan.z == 2u && sums.y != 0u ? (255u * (4u * open.z + open.y) + 8u) / 16u
                                                : lightmesh_lamp_share(open.z, sums.z);
            if (begin == 0u && is_unsettled && is_doubted)
                misses = !sees_open || !sees_closed || abs(int(value) - int(around)) > 16;
            is_done = !sees_open || !sees_closed || misses || end == plan.z;
            if (is_done && is_unsettled)
                value = lightmesh_lamp_shaft_byte(value, misses);
            begin = end;
            end = plan.z;
        }
        if (is_done && lane == 0u) {
            lightmesh_lamp_found[share] = value | (sums.x + sums.y + sums.z) << 8;
            atomicAdd(lightmesh_lamp_left, ~0u);
        }
        is_left = is_left && !is_done;
        barrier();
    } while (lightmesh_lamp_left != 0u);
}

#endif
