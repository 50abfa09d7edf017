// SPDX-License-Identifier: MIT
// Arithmetic of IEEE doubles by 32-bit integers, for devices without 64-bit types, rounded to nearest even: the
// same bits as a processor has. A double is a uvec2 of its low and its high word. Only zeros and normal numbers
// that stay such: no denormal ones, infinities, NaN. And what a device may round its own way: quotients and
// square roots of floats.
#ifndef LIGHTMESH_DOUBLES_GLSL
#define LIGHTMESH_DOUBLES_GLSL

// A number by sign, exponent and 64 bits of which the highest but one is set, low word first; the lowest stands
// for all that lie below.
uvec2 lightmesh_double_round(uint sign, int exponent, uvec2 bits) {
    uint half_way = 511u + ((bits.x >> 10) & 1u);
    uint low = bits.x + half_way;
    uint high = bits.y + (low < bits.x ? 1u : 0u);
    // The leading bit adds one to the exponent.
    return uvec2(low >> 10 | high << 22, sign + (uint(exponent + 1022) << 20) + (high >> 10));
}

// The same for any bits.
uvec2 lightmesh_double_normalize(uint sign, int exponent, uvec2 bits) {
    if ((bits.x | bits.y) == 0u)
        return uvec2(0u);
    if ((bits.y & 0x80000000u) != 0u)
        return lightmesh_double_round(sign, exponent + 1, uvec2(bits.x >> 1 | (bits.x & 1u) | bits.y << 31, bits.y >> 1));
    int shift = bits.y != 0u ? 30 - findMSB(bits.y) : 62 - findMSB(bits.x);
    if (shift >= 32)
        bits = uvec2(0u, bits.x << (shift - 32));
    else if (shift > 0)
        bits = uvec2(bits.x << shift, bits.y << shift | bits.x >> (32 - shift));
    return lightmesh_double_round(sign, exponent - shift, bits);
}

uvec2 lightmesh_double_of(int value) {
    return lightmesh_double_normalize(value < 0 ? 0x80000000u : 0u, 30, uvec2(0u, value < 0 ? uint(-value) : uint(value)));
}

uvec2 lightmesh_double_of(float value) {
    uint bits = floatBitsToUint(value);
    uint sign = bits & 0x80000000u, magnitude = bits & 0x7fffffffu;
    if (magnitude >= 0x00800000u)
        return uvec2(magnitude << 29, sign | ((magnitude >> 3) + (896u << 20)));
    if (magnitude == 0u)
        return uvec2(0u, sign);
    return lightmesh_double_normalize(sign, -149 + 30, uvec2(0u, magnitude));
}

uvec2 lightmesh_double_negate(uvec2 a) {
    return uvec2(a.x, a.y ^ 0x80000000u);
}

uvec2 lightmesh_double_abs(uvec2 a) {
    return uvec2(a.x, a.y & 0x7fffffffu);
}

// a * 2^power
uvec2 lightmesh_double_scale(uvec2 a, int power) {
    return (a.x | (a.y & 0x7fffffffu)) == 0u ? a : uvec2(a.x, a.y + (uint(power) << 20));
}

bool lightmesh_double_is_zero(uvec2 a) {
    return (a.x | (a.y & 0x7fffffffu)) == 0u;
}

bool lightmesh_double_less(uvec2 a, uvec2 b) {
    bool is_negative = (a.y & 0x80000000u) != 0u;
    if (is_negative != ((b.y & 0x80000000u) != 0u))
        return is_negative && !(lightmesh_double_is_zero(a) && lightmesh_double_is_zero(b));
    bool is_below = a.y < b.y || (a.y == b.y && a.x < b.x);
    bool is_same = a.x == b.x && a.y == b.y;
    return !is_same && is_below != is_negative;
}

uvec2 lightmesh_double_add(uvec2 a, uvec2 b) {
    uvec2 x = lightmesh_double_abs(a), y = lightmesh_double_abs(b);
    if (x.y < y.y || (x.y == y.y && x.x < y.x)) {
        uvec2 t = a;
        a = b;
        b = t;
        x = lightmesh_double_abs(a);
        y = lightmesh_double_abs(b);
    }
    int apart = int(x.y >> 20) - int(y.y >> 20);
    if ((y.x | y.y) == 0u || apart > 54)
        return a;
    // 53 bits with ten below.
    uvec2 p = uvec2(x.x << 10, ((x.y & 0xfffffu) | 0x100000u) << 10 | x.x >> 22);
    uvec2 q = uvec2(y.x << 10, ((y.y & 0xfffffu) | 0x100000u) << 10 | y.x >> 22);
    if (apart >= 32) {
        uint lost = q.x | (apart > 32 ? q.y << (64 - apart) : 0u);
        q = uvec2(q.y >> (apart - 32) | (lost != 0u ? 1u : 0u), 0u);
    } else if (apart > 0) {
        uint lost = q.x << (32 - apart);
        q = uvec2(q.x >> apart | q.y << (32 - apart) | (lost != 0u ? 1u : 0u), q.y >> apart);
    }
    uvec2 sum;
    if (((a.y ^ b.y) & 0x80000000u) == 0u) {
        sum.x = p.x + q.x;
        sum.y = p.y + q.y + (sum.x < p.x ? 1u : 0u);
    } else {
        sum.x = p.x - q.x;
        sum.y = p.y - q.y - (p.x < q.x ? 1u : 0u);
    }
    return lightmesh_double_normalize(a.y & 0x80000000u, int(x.y >> 20) - 1023, sum);
}

uvec2 lightmesh_double_subtract(uvec2 a, uvec2 b) {
    return lightmesh_double_add(a, lightmesh_double_negate(b));
}

uvec2 lightmesh_double_multiply(uvec2 a, uvec2 b) {
    uint sign = (a.y ^ b.y) & 0x80000000u;
    if (lightmesh_double_is_zero(a) || lightmesh_double_is_zero(b))
        return uvec2(0u, sign);
    // 53 bits with eleven below, and the upper half of their product.
    uvec2 p = uvec2(a.x << 11, ((a.y & 0xfffffu) | 0x100000u) << 11 | a.x >> 21);
    uvec2 q = uvec2(b.x << 11, ((b.y & 0xfffffu) | 0x100000u) << 11 | b.x >> 21);
    uint low_high, low_low, one_high, one_low, two_high, two_low, high_high, high_low;
    umulExtended(p.x, q.x, low_high, low_low);
    umulExtended(p.x, q.y, one_high, one_low);
    umulExtended(p.y, q.x, two_high, two_low);
    umulExtended(p.y, q.y, high_high, high_low);
    uint middle = low_high + one_low;
    uint carries = middle < one_low ? 1u : 0u;
    middle += two_low;
    carries += middle < two_low ? 1u : 0u;
    uint sum = high_low + one_high;
    high_high += sum < one_high ? 1u : 0u;
    high_low = sum + two_high;
    high_high += high_low < two_high ? 1u : 0u;
    sum = high_low + carries;
    high_high += sum < carries ? 1u : 0u;
    return lightmesh_double_normalize(sign, int((a.y >> 20) & 0x7ffu) + int((b.y >> 20) & 0x7ffu) - 2046,
                                      uvec2(sum | ((middle | low_low) != 0u ? 1u : 0u), high_high));
}

uvec2 lightmesh_double_divide(uvec2 a, uvec2 b) {
    uint sign = (a.y ^ b.y) & 0x80000000u;
    if (lightmesh_double_is_zero(a))
        return uvec2(0u, sign);
    uvec2 rest = uvec2(a.x, (a.y & 0xfffffu) | 0x100000u);
    uvec2 by = uvec2(b.x, (b.y & 0xfffffu) | 0x100000u);
    uvec2 quotient = uvec2(0u);
    for (int i = 0; i < 63; ++i) {
        quotient = uvec2(quotient.x << 1, quotient.y << 1 | quotient.x >> 31);
        if (rest.y > by.y || (rest.y == by.y && rest.x >= by.x)) {
            rest = uvec2(rest.x - by.x, rest.y - by.y - (rest.x < by.x ? 1u : 0u));
            quotient.x |= 1u;
        }
        rest = uvec2(rest.x << 1, rest.y << 1 | rest.x >> 31);
    }
    quotient.x |= (rest.x | rest.y) != 0u ? 1u : 0u;
    return lightmesh_double_normalize(sign, int((a.y >> 20) & 0x7ffu) - int((b.y >> 20) & 0x7ffu), quotient);
}

// The greatest integer that is not greater; of magnitude below 2^31.
int lightmesh_double_floor(uvec2 a) {
    bool is_negative = (a.y & 0x80000000u) != 0u;
    int exponent = int((a.y >> 20) & 0x7ffu) - 1023;
    if (exponent < 0)
        return is_negative && !lightmesh_double_is_zero(a) ? -1 : 0;
    uint high = (a.y & 0xfffffu) | 0x100000u;
    uint whole, rest;
    if (exponent <= 20) {
        whole = high >> (20 - exponent);
        rest = (high & ((1u << (20 - exponent)) - 1u)) | a.x;
    } else {
        whole = high << (exponent - 20) | a.x >> (52 - exponent);
        rest = a.x << (exponent - 20);
    }
    return is_negative ? -int(whole) - (rest != 0u ? 1 : 0) : int(whole);
}

// The nearest float; 0 where that would be a denormal one.
float lightmesh_double_to_float(uvec2 a) {
    int exponent = int((a.y >> 20) & 0x7ffu) - 1023;
    if (exponent < -126)
        return 0.0;
    uint magnitude = (uint(exponent + 127) << 23) + ((a.y & 0xfffffu) << 3) + (a.x >> 29);
    uint rest = a.x & 0x1fffffffu;
    if (rest > 0x10000000u || (rest == 0x10000000u && (magnitude & 1u) != 0u))
        ++magnitude;
    return uintBitsToFloat((a.y & 0x80000000u) | magnitude);
}

// a / b as the nearest float. Neither is denormal.
float lightmesh_float_divide(float a, float b) {
    uint x = floatBitsToUint(a), y = floatBitsToUint(b);
    uint sign = (x ^ y) & 0x80000000u;
    if ((x & 0x7fffffffu) == 0u)
        return uintBitsToFloat(sign);
    uint rest = (x & 0x7fffffu) | 0x800000u, by = (y & 0x7fffffu) | 0x800000u, quotient = 0u;
    for (int i = 0; i < 26; ++i) {
        quotient <<= 1;
        if (rest >= by) {
            rest -= by;
            quotient |= 1u;
        }
        rest <<= 1;
    }
    int exponent = int((x >> 23) & 255u) - int((y >> 23) & 255u);
    return lightmesh_double_to_float(
        lightmesh_double_normalize(sign, exponent + 5, uvec2(rest != 0u ? 1u : 0u, quotient)));
}

// The square root of a number from 1 to 4 as the nearest float.
float lightmesh_float_sqrt(float a) {
    uvec2 wanted = lightmesh_double_of(a);
    uint guess = floatBitsToUint(sqrt(a)) - 4u;
    for (int i = 0; i < 8; ++i) {
        // Whether the root is beyond the middle between this float and the next; it is never that.
        uvec2 middle = lightmesh_double_of(uintBitsToFloat(guess));
        middle.x |= 0x10000000u;
        if (!lightmesh_double_less(lightmesh_double_multiply(middle, middle), wanted))
            break;
        ++guess;
    }
    return uintBitsToFloat(guess);
}

#endif
