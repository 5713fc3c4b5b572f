// Computes the visibility that height fields leave: the twin of sh/height/height_lanes.cpp, one point at a time.
// heights_glsl.cpp puts a preamble before this text, with SIDE, CORNER, CELL, AZIMUTHS, TAPS (per azimuth), ORDER and
// LEAST (the tangent of the least horizon). WRAPS or OPEN is defined if the border is of that kind.
layout(std430, binding = 0) readonly buffer Heights { float heights[]; };  // heights of all levels
// Three a tap (HeightTap): row, column, 1 / metres, scale; offset, last row, last column; columns, first. Then
// cos m phi and sin m phi times 2 pi / AZIMUTHS of each azimuth and m, and the norms.
layout(std430, binding = 1) readonly buffer Taps { uvec4 taps[]; };

const ivec2 side = SIDE;     // rows and columns
const vec3 corner = CORNER;  // where height 0 of row 0 and column 0 stands in the scene
const vec2 cell = CELL;      // metres from row to row, from column to column

vec3 sceneFromField(vec3 v) { return v.yzx; }
vec3 fieldFromScene(vec3 v) { return v.zxy; }

// The two numbers around a place of one axis of a level, and how far it is from the first.
void aroundTap(float x, int last, out int low, out int high, out float share) {
#ifdef WRAPS
    low = int(x + 1.0) - 1;  // x >= -1/2
    share = x - float(low);
    high = low + 1;
    if (low < 0) low += last + 1;
    if (high > last) high = 0;
#else
    low = int(x);
    share = x - float(low);
    high = min(low + 1, last);
#endif
}

float sampleTap(vec2 place, uvec4 a, uvec4 b, uvec4 c) {
    vec2 last = uintBitsToFloat(b.yz);
#ifdef WRAPS
    vec2 count = vec2(side);
    place = clamp(place - count * floor(place * (1.0 / count)), vec2(0.0), count);
#endif
    place = place * uintBitsToFloat(a.w) + uintBitsToFloat(b.x);
#ifndef WRAPS
    place = clamp(place, vec2(0.0), last);
#endif
    int r0, r1, c0, c1;
    vec2 share;
    aroundTap(place.x, int(last.x), r0, r1, share.x);
    aroundTap(place.y, int(last.y), c0, c1, share.y);
    int upper_row = int(c.y) + r0 * int(c.x), lower_row = int(c.y) + r1 * int(c.x);
    float upper = heights[upper_row + c0], lower = heights[lower_row + c0];
    upper += share.y * (heights[upper_row + c1] - upper);
    lower += share.y * (heights[lower_row + c1] - lower);
    return upper + share.x * (lower - upper);
}

// The tangent of the horizon along an azimuth. `at` has row, column and height.
float horizonOf(uint azimuth, vec3 at) {
    float tangent = LEAST;
    for (uint k = 0u; k < TAPS; ++k) {
        uint tap = 3u * (azimuth * TAPS + k);
        uvec4 a = taps[tap];
        vec2 place = at.xy + uintBitsToFloat(a.xy);
#ifdef OPEN
        if (any(lessThan(place, vec2(-0.5))) || any(greaterThan(place, vec2(side) - 0.5))) continue;
#endif
        float height = sampleTap(place, a, taps[tap + 1u], taps[tap + 2u]);
        tangent = max(tangent, (height - at.z) * uintBitsToFloat(a.z));
    }
    return tangent;
}

float tableNumber(uint i) { return uintBitsToFloat(taps[3u * AZIMUTHS * TAPS + i / 4u][i % 4u]); }

// The integrals of horizonThetas(), without the norms.
void thetasOf(float tangent, out float theta[ORDER * (ORDER + 1) / 2]) {
    float c = 1.0 / sqrt(1.0 + tangent * tangent), s = tangent * c, s2 = s * s, c2 = c * c, c3 = c2 * c;
    float b = 2.0 * atan(c / (1.0 + s)), j0 = (b - s * c) * 0.5, j2 = (b + s * c * (1.0 - 2.0 * s2)) * 0.125;
    theta[0] = 1.0 - s;
    theta[1] = c2 * 0.5;
    theta[2] = -j0;
    theta[3] = s * c2 * 0.5;
    theta[4] = -c3;
    theta[5] = 2.0 - 3.0 * s + s2 * s;
    theta[6] = c2 * (5.0 * s2 - 1.0) * 0.125;
    theta[7] = -1.5 * (5.0 * j2 - j0);
    theta[8] = 3.75 * c2 * c2;
    theta[9] = -1.875 * (3.0 * b - s * c * (5.0 - 2.0 * s2));
#if ORDER > 4
    float c5 = c3 * c2;
    theta[10] = s * c2 * (7.0 * s2 - 3.0) * 0.125;
    theta[11] = -10.0 / 3.0 * c3 + 3.5 * c5;
    theta[12] = 2.0 + s * (7.5 + s2 * (-20.0 + 10.5 * s2));
    theta[13] = -21.0 * c5;
    theta[14] = 56.0 + s * (-105.0 + s2 * (70.0 - 21.0 * s2));
#endif
}

// V at a point that lies on the field or above it, in the frame of the field.
void heightVisibility(vec3 at, out float v[ORDER * ORDER]) {
    for (int i = 0; i < ORDER * ORDER; ++i) v[i] = 0.0;
    for (uint a = 0u; a < AZIMUTHS; ++a) {
        float theta[ORDER * (ORDER + 1) / 2];
        thetasOf(horizonOf(a, at), theta);
        for (int l = 0, i = 0; l < ORDER; ++l)
            for (int m = 0; m <= l; ++m, ++i) {
                float scaled = theta[i] * tableNumber(2u * AZIMUTHS * ORDER + uint(i));
                uint turn = 2u * (a * ORDER + uint(m));
                v[l * (l + 1) + m] += tableNumber(turn) * scaled;
                if (m > 0) v[l * (l + 1) - m] += tableNumber(turn + 1u) * scaled;
            }
    }
}

// Cosines and sines of the turns that bring a normal to z and a tangent to x: about z by -phi, about y by -beta, about
// z by psi.
void turnsOf(vec3 normal, vec3 tangent, out vec2 phi, out vec2 beta, out vec2 psi) {
    vec3 b = cross(normal, tangent);
    float across = sqrt(normal.x * normal.x + normal.y * normal.y);
    bool up = normal.z >= 0.0;
    phi = across > 1e-7 ? normal.xy / across : vec2(1.0, 0.0);
    beta = vec2(normal.z, across);
    vec2 both = normalize(up ? vec2(tangent.x + b.y, b.x - tangent.y) : vec2(b.y - tangent.x, -b.x - tangent.y));
    float sin_phi = up ? phi.y : -phi.y;
    psi = vec2(both.x * phi.x - both.y * sin_phi, both.y * phi.x + both.x * sin_phi);
}

void turn(inout float plus, inout float minus, vec2 by) {
    float turned = by.x * plus - by.y * minus;
    minus = by.y * plus + by.x * minus;
    plus = turned;
}
vec2 turnedTwice(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.y * b.x + a.x * b.y); }

// The height of row r and column c, which may lie one beyond the border.
int neighbour(int at, int by, int count) {
#ifdef WRAPS
    return (at + by + count) % count;
#else
    return clamp(at + by, 0, count - 1);
#endif
}

// The normal at a point of the grid, by central differences.
vec3 heightNormal(ivec2 at) {
    int r0 = neighbour(at.x, -1, side.x), r1 = neighbour(at.x, 1, side.x);
    int c0 = neighbour(at.y, -1, side.y), c1 = neighbour(at.y, 1, side.y);
#ifdef WRAPS
    vec2 steps = vec2(2.0);
#else
    vec2 steps = vec2(max(r1 - r0, 1), max(c1 - c0, 1));  // one-sided where an edge cuts the difference short
#endif
    vec2 rise = vec2(heights[r1 * side.y + at.y] - heights[r0 * side.y + at.y],
                     heights[at.x * side.y + c1] - heights[at.x * side.y + c0]) / (steps * cell);
    return vec3(-rise, 1.0) / sqrt(1.0 + dot(rise, rise));
}

// tangentOf(normal, x), sh/tangent.h.
vec3 heightTangent(vec3 n) {
    float across = 1.0 - n.x * n.x;
    if (across > 1e-4) return vec3(across, -n.x * n.y, -n.x * n.z) / sqrt(across);
    vec3 axis = abs(n.y) <= abs(n.z) ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
    return normalize(axis - n * dot(n, axis));
}

// The height at a place of the grid, bilinear.
float heightAt(vec2 place) {
#ifdef WRAPS
    vec2 count = vec2(side);
    place = clamp(place - count * floor(place / count), vec2(0.0), count);
    ivec2 low = min(ivec2(place), side - 1), high = (low + 1) % side;
#else
    place = clamp(place, vec2(0.0), vec2(side - 1));
    ivec2 low = ivec2(place), high = min(low + 1, side - 1);
#endif
    vec2 share = place - vec2(low);
    float upper = heights[low.x * side.y + low.y], lower = heights[high.x * side.y + low.y];
    upper += share.y * (heights[low.x * side.y + high.y] - upper);
    lower += share.y * (heights[high.x * side.y + high.y] - lower);
    return upper + share.x * (lower - upper);
}

GENERATED_BY_HEIGHTS_GLSL
