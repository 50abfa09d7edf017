// SPDX-License-Identifier: MIT

// `Random` of scene/random.hpp: PCG32, with its state of 64 bits in two words, the lower one first.

uvec2 random_step(uvec2 state) {
    const uvec2 factor = uvec2(0x4c957f2du, 0x5851f42du);
    const uvec2 more = uvec2(0xf767814fu, 0x14057b7eu);
    uint high;
    uint low;
    umulExtended(state.x, factor.x, high, low);
    high += state.x * factor.y + state.y * factor.x;
    uint carry;
    low = uaddCarry(low, more.x, carry);
    return uvec2(low, high + more.y + carry);
}

uint random_next(inout uvec2 state) {
    uvec2 old = state;
    state = random_step(old);
    uvec2 mixed = uvec2(old.x >> 18 | old.y << 14, old.y >> 18) ^ old;
    uint shifted = mixed.x >> 27 | mixed.y << 5;
    uint turn = old.y >> 27;
    return shifted >> turn | shifted << (32u - turn & 31u);
}

uvec2 random_of(uvec2 seed) {
    uvec2 state = random_step(uvec2(0u));
    uint carry;
    state.x = uaddCarry(state.x, seed.x, carry);
    state.y += seed.y + carry;
    return random_step(state);
}

float random_uniform(inout uvec2 state) {
    return float(random_next(state) >> 8) * (1.0 / 16777216.0);
}

// The point of a circle at an angle given in turns.
vec2 circle_point(float turns) {
    float quarters = 4.0 * fract(turns);
    float quarter = floor(quarters + 0.5);
    float a = (quarters - quarter) * 1.5707963267948966;
    float b = a * a;
    float s = a * (1.0 - b / 6.0 * (1.0 - b / 20.0 * (1.0 - b / 42.0 * (1.0 - b / 72.0))));
    float c = 1.0 - b / 2.0 * (1.0 - b / 12.0 * (1.0 - b / 30.0 * (1.0 - b / 56.0 * (1.0 - b / 90.0))));
    int side = int(quarter) & 3;
    return side == 0 ? vec2(c, s) : side == 1 ? vec2(-s, c) : side == 2 ? vec2(-c, -s) : vec2(s, -c);
}
