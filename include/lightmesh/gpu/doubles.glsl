// SPDX-License-Identifier: MIT
// Arithmetic of IEEE doubles by 32-bit integers, for devices without 64-bit types, rounded to nearest even: the
// same bits as a processor has. A double is a uvec2 of its low and its high word. Only positive zero and normal
// numbers that stay such: no infinities, no NaN; denormal floats are taken for 0. And what a device may round its
// own way: quotients and square roots of floats; and products of floats with all their bits.
#ifndef LIGHTMESH_DOUBLES_GLSL
#define LIGHTMESH_DOUBLES_GLSL

// A number by its sign, the exponent of the highest of 64 bits, and those, low word first; the lowest stands for all
// that lie below.
uvec2 lightmesh_double_round(uint sign, int exponent, uvec2 bits) {
    int zeros = bits.y != 0u ? 31 - findMSB(bits.y) : 63 - findMSB(bits.x);
    int shift = zeros & 31;
    uint high = bits.y << shift | (bits.x >> 1) >> (31 - shift);
    uint low = bits.x << shift;
    high = zeros >= 32 ? low : high;
    low = zeros >= 32 ? 0u : low;
    // Of 53 bits the lowest is bit 11.
    uint rounded_low = low + 1023u + ((low >> 11) & 1u);
    uint carry = rounded_low < low ? 1u : 0u;
    uint rounded = high + carry;
    // The leading bit adds one to the exponent; two, if all bits were ones.
    uint top = (rounded >> 11) + (rounded < carry ? 0x200000u : 0u);
    bool is_zero = (bits.x | bits.y) == 0u;
    return is_zero ? uvec2(0u)
                   : uvec2(rounded_low >> 11 | rounded << 21, sign + (uint(exponent - zeros + 1022) << 20) + top);
}

// The upper and the lower word of 53 bits with eleven below them; of zero none is set.
uvec2 lightmesh_double_bits(uvec2 a) {
    uint lead = (a.y & 0x7ff00000u) != 0u ? 0x80000000u : 0u;
    return uvec2(a.x << 11, lead | ((a.y << 11) & 0x7fffffffu) | a.x >> 21);
}

int lightmesh_double_exponent(uvec2 a) {
    return int((a.y >> 20) & 0x7ffu) - 1023;
}

uvec2 lightmesh_double_of(int value) {
    return lightmesh_double_round(value < 0 ? 0x80000000u : 0u, 31, uvec2(0u, uint(abs(value))));
}

uvec2 lightmesh_double_of(float value) {
    uint bits = floatBitsToUint(value), magnitude = bits & 0x7fffffffu;
    return magnitude < 0x00800000u ? uvec2(0u)
                                   : uvec2(magnitude << 29, (bits & 0x80000000u) | ((magnitude >> 3) + 0x38000000u));
}

uvec2 lightmesh_double_negate(uvec2 a) {
    return uvec2(a.x, a.y == 0u ? 0u : a.y ^ 0x80000000u);
}

uvec2 lightmesh_double_abs(uvec2 a) {
    return uvec2(a.x, a.y & 0x7fffffffu);
}

// a * 2^power
uvec2 lightmesh_double_scale(uvec2 a, int power) {
    return uvec2(a.x, a.y == 0u ? 0u : a.y + (uint(power) << 20));
}

bool lightmesh_double_is_negative(uvec2 a) {
    return (a.y & 0x80000000u) != 0u;
}

bool lightmesh_double_less(uvec2 a, uvec2 b) {
    bool is_negative = lightmesh_double_is_negative(a);
    uvec2 low = is_negative ? b : a, high = is_negative ? a : b;
    return is_negative != lightmesh_double_is_negative(b) ? is_negative
                                                         : low.y < high.y || (low.y == high.y && low.x < high.x);
}

uvec2 lightmesh_double_add(uvec2 a, uvec2 b) {
    uvec2 x = lightmesh_double_abs(a), y = lightmesh_double_abs(b);
    bool is_greater = x.y > y.y || (x.y == y.y && x.x >= y.x);
    uvec2 greater = is_greater ? a : b, lesser = is_greater ? b : a;
    // With a bit above, for the sum's carry.
    uvec2 p = lightmesh_double_bits(greater), q = lightmesh_double_bits(lesser);
    p = uvec2(p.x >> 1 | p.y << 31, p.y >> 1);
    q = uvec2(q.x >> 1 | q.y << 31, q.y >> 1);
    int apart = min(lightmesh_double_exponent(greater) - lightmesh_double_exponent(lesser), 63);
    int shift = apart & 31;
    uint lost = (q.x << 1) << (31 - shift);
    q = uvec2(q.x >> shift | (q.y << 1) << (31 - shift), q.y >> shift);
    lost |= apart >= 32 ? q.x : 0u;
    q = apart >= 32 ? uvec2(q.y, 0u) : q;
    q.x |= lost != 0u ? 1u : 0u;
    if (((a.y ^ b.y) & 0x80000000u) != 0u)
        q = uvec2(0u - q.x, ~q.y + (q.x == 0u ? 1u : 0u));
    uint low = p.x + q.x;
    return lightmesh_double_round(greater.y & 0x80000000u, lightmesh_double_exponent(greater) + 1,
                                  uvec2(low, p.y + q.y + (low < p.x ? 1u : 0u)));
}

uvec2 lightmesh_double_subtract(uvec2 a, uvec2 b) {
    return lightmesh_double_add(a, lightmesh_double_negate(b));
}

uvec2 lightmesh_double_multiply(uvec2 a, uvec2 b) {
    uvec2 p = lightmesh_double_bits(a), q = lightmesh_double_bits(b);
    uint low_high, low_low, one_high, one_low, two_high, two_low, high_high, high_low;
    umulExtended(p.x, q.x, low_high, low_low);
    umulExtended(p.x, q.y, one_high, one_low);
    umulExtended(p.y, q.x, two_high, two_low);
    umulExtended(p.y, q.y, high_high, high_low);
    // The sum of what is worth 2^32, and then of what is worth 2^64.
    uint middle = low_high + one_low;
    uint carries = middle < one_low ? 1u : 0u;
    middle += two_low;
    carries += middle < two_low ? 1u : 0u;
    uint low = high_low + one_high;
    high_high += low < one_high ? 1u : 0u;
    low += two_high;
    high_high += low < two_high ? 1u : 0u;
    low += carries;
    high_high += low < carries ? 1u : 0u;
    return lightmesh_double_round((a.y ^ b.y) & 0x80000000u,
                                  lightmesh_double_exponent(a) + lightmesh_double_exponent(b) + 1,
                                  uvec2(low | ((middle | low_low) != 0u ? 1u : 0u), high_high));
}

// `b` is not 0.
uvec2 lightmesh_double_divide(uvec2 a, uvec2 b) {
    uvec2 rest = lightmesh_double_bits(a), by = lightmesh_double_bits(b), quotient = uvec2(0u);
    rest = uvec2(rest.x >> 1 | rest.y << 31, rest.y >> 1);
    by = uvec2(by.x >> 1 | by.y << 31, by.y >> 1);
    // 53 bits, and two or three below.
    for (int i = 0; i < 56; ++i) {
        bool is_there = rest.y > by.y || (rest.y == by.y && rest.x >= by.x);
        quotient = uvec2(quotient.x << 1 | (is_there ? 1u : 0u), quotient.y << 1 | quotient.x >> 31);
        rest -= is_there ? uvec2(by.x, by.y + (rest.x < by.x ? 1u : 0u)) : uvec2(0u);
        rest = uvec2(rest.x << 1, rest.y << 1 | rest.x >> 31);
    }
    quotient.x |= (rest.x | rest.y) != 0u ? 1u : 0u;
    return lightmesh_double_round((a.y ^ b.y) & 0x80000000u,
                                  lightmesh_double_exponent(a) - lightmesh_double_exponent(b) + 8, quotient);
}

// The square root; `a` is not negative.
uvec2 lightmesh_double_sqrt(uvec2 a) {
    uvec2 square = lightmesh_double_bits(a), rest = uvec2(0u), root = uvec2(0u);
    int exponent = lightmesh_double_exponent(a);
    if ((exponent & 1) == 0)
        square = uvec2(square.x >> 1 | square.y << 31, square.y >> 1);
    // Two bits of the square for each of the root's: 53, and two below.
    for (int i = 0; i < 55; ++i) {
        rest = uvec2(rest.x << 2 | square.y >> 30, rest.y << 2 | rest.x >> 30);
        square = uvec2(square.x << 2, square.y << 2 | square.x >> 30);
        uvec2 more = uvec2(root.x << 2 | 1u, root.y << 2 | root.x >> 30);
        bool is_there = rest.y > more.y || (rest.y == more.y && rest.x >= more.x);
        root = uvec2(root.x << 1 | (is_there ? 1u : 0u), root.y << 1 | root.x >> 31);
        rest -= is_there ? uvec2(more.x, more.y + (rest.x < more.x ? 1u : 0u)) : uvec2(0u);
    }
    root.x |= (rest.x | rest.y) != 0u ? 1u : 0u;
    return lightmesh_double_round(0u, (exponent >> 1) + 9, root);
}

// The greatest integer that is not greater; of magnitude below 2^31.
int lightmesh_double_floor(uvec2 a) {
    uvec2 bits = lightmesh_double_bits(a);
    int exponent = lightmesh_double_exponent(a), whole_bits = clamp(exponent, 0, 30);
    uint whole = exponent < 0 ? 0u : bits.y >> (31 - whole_bits);
    uint rest = bits.x | (exponent < 0 ? bits.y : bits.y << (whole_bits + 1));
    return lightmesh_double_is_negative(a) ? -int(whole) - (rest != 0u ? 1 : 0) : int(whole);
}

// The nearest float; 0 where that would be a denormal one.
float lightmesh_double_to_float(uvec2 a) {
    uint magnitude = ((a.y & 0x7fffffffu) << 3 | a.x >> 29) - 0x40000000u * 7u;
    uint rest = a.x & 0x1fffffffu;
    magnitude += rest + (magnitude & 1u) > 0x10000000u ? 1u : 0u;
    return uintBitsToFloat(lightmesh_double_exponent(a) < -126 ? 0u : (a.y & 0x80000000u) | magnitude);
}

// a + b as the sum of two floats. Knuth 1969, "The Art of Computer Programming", volume 2.
vec2 lightmesh_sum(float a, float b) {
    precise float sum = a + b;
    precise float b_in_it = sum - a;
    precise float lost = (a - (sum - b_in_it)) + (b - b_in_it);
    return vec2(sum, lost);
}

// a * b as the sum of two floats. Dekker 1971, "A Floating-Point Technique for Extending the Available
// Precision".
vec2 lightmesh_product(float a, float b) {
    precise float ca = 4097.0f * a;
    precise float ah = ca - (ca - a);
    precise float al = a - ah;
    precise float cb = 4097.0f * b;
    precise float bh = cb - (cb - b);
    precise float bl = b - bh;
    precise float p = a * b;
    precise float e = ((ah * bh - p) + ah * bl + al * bh) + al * bl;
    return vec2(p, e);
}

// a / b as the nearest float: the quotient of the device, put right. 0 where that would be a denormal one. `b` is not 0.
float lightmesh_float_divide(float a, float b) {
    uint x = floatBitsToUint(a), y = floatBitsToUint(b);
    uint dividend = (x & 0x7fffffu) | 0x800000u, by = (y & 0x7fffffu) | 0x800000u;
    uint quotient = uint(float(dividend) / float(by) * 33554432.0);
    int rest = int((dividend << 25) - quotient * by);
    int more = int(floor(float(rest) / float(by)));
    quotient += uint(more);
    rest -= more * int(by);
    if (rest < 0) {
        --quotient;
        rest += int(by);
    } else if (rest >= int(by)) {
        ++quotient;
        rest -= int(by);
    }
    // 24 bits, and one or two below.
    int below = (quotient >> 25) != 0u ? 2 : 1;
    uint whole = quotient >> below, part = quotient & ((1u << below) - 1u), half_way = 1u << (below - 1);
    bool is_up = part > half_way || (part == half_way && (rest != 0 || (whole & 1u) != 0u));
    int exponent = int((x >> 23) & 255u) - int((y >> 23) & 255u) + 124 + below;
    uint magnitude = (uint(exponent) << 23) + whole + (is_up ? 1u : 0u);
    bool is_zero = (x & 0x7f800000u) == 0u || exponent < 0;
    return uintBitsToFloat(is_zero ? 0u : ((x ^ y) & 0x80000000u) | magnitude);
}

// The square root of a number from 1 to 3 as the nearest float: that of the device, put right.
float lightmesh_float_sqrt(float a) {
    uint square = uint(a * 8388608.0), root = uint(sqrt(a) * 8388608.0);
    int rest = int((square << 23) - root * root);
    root += uint(int(floor(float(rest) / float(2u * root) + 0.5)));
    rest = int((square << 23) - root * root);
    root = rest > int(root) ? root + 1u : rest <= -int(root) ? root - 1u : root;
    return float(root) * uintBitsToFloat(0x34000000u);  // 2^-23
}

#endif
