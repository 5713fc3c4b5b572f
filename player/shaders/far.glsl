// The far parts of a composed asset on the GPU, as sh/far/far_lanes.h has them for 8 receivers at a time. Before this
// stand farGlsl() (player/runtime/far_glsl.h, which also has the layout of the tables) and the shader's own surfaces
// and buffers.
//
// An anchor (main() with FAR_ANCHORS) sums the parts that block little, and tells how near each part is. A vertex takes
// that from its anchors, multiplies the near parts in one by one at 64 directions above its horizon, and brings the sum
// in by an exponential.

float farFloat(uint table, uint i) { return uintBitsToFloat(asset[table + i]); }
vec3 farVector(uint at) { return uintBitsToFloat(uvec3(asset[at], asset[at + 1u], asset[at + 2u])); }

const float kRootOfSphere = 3.5449077;  // sqrt(4 pi), the coefficient of the function 1
const uint kBoxWords = 16u;

// A part as one vertex sees it.
struct FarSight {
    float height, sine;  // of its sphere over the horizon; height 1: all of it is above
    float share;         // of the sphere that it blocks
    float weight;        // by which it counts
    float inside;        // how dark it is inside of it
    bool counts;
};

uint farPart(uint part) { return FAR_PARTS + part * FAR_PART_WORDS; }
vec4 posedRow(uint part, uint row) { return pose[pose_begin + POSE_PARTS + 7u * part + row]; }

// Tells how high the part stands, and returns whether it is large enough to count.
bool farHeight(uint part, PenumbraSurface s, out FarSight sight) {
    vec4 sphere = posedRow(part, 6u);
    vec3 way = sphere.xyz - s.position;
    float along = dot(way, s.normal), square = dot(way, way), radius2 = sphere.w * sphere.w;
    sight.height = clamp(along / sphere.w, -1.0, 1.0);
    sight.sine = along / sqrt(square + 1e-20);
    return radius2 >= 4.0 * kLeastBlocked * (square - radius2);
}

// Eight points of a level around the vertex.
struct FarLevel {
    float share;
    int first;
    ivec3 stride;
    vec3 part;
};

FarLevel farBox(uint box, vec3 point) {
    vec3 low = farVector(box), high = farVector(box + 3u), cells = farVector(box + 9u);
    vec3 above = point - low, below = high - point;
    float depth = min(min(min(above.x, below.x), min(above.y, below.y)), min(above.z, below.z));
    vec3 t = clamp(above * farVector(box + 6u), vec3(0.0), cells);
    ivec3 cell = ivec3(min(t, cells - 1.0));
    FarLevel level;
    level.share = clamp(depth * farFloat(box, 12u), 0.0, 1.0);
    level.stride = ivec3(1, int(asset[box + 13u]), int(asset[box + 14u]));
    level.first = int(asset[box + 15u]) + cell.x + cell.y * level.stride.y + cell.z * level.stride.z;
    level.part = t - vec3(cell);
    return level;
}

// Four points on each of two spheres, which are linear in u = r / d. The octahedral map unfolds a sphere to a square.
FarLevel farSpheres(uint at, vec3 offset, float distance, float radius) {
    float u = clamp(distance > 0.0 ? radius / distance : 1.0, kSphereScales[0], kSphereScales[3]);
    int sphere = u > kSphereScales[2] ? 2 : u > kSphereScales[1] ? 1 : 0;
    float low = sphere == 2 ? kSphereScales[2] : sphere == 1 ? kSphereScales[1] : kSphereScales[0];
    float high = sphere == 2 ? kSphereScales[3] : sphere == 1 ? kSphereScales[2] : kSphereScales[1];
    vec3 size = abs(offset);
    float sum = size.x + size.y + size.z;
    vec2 side = vec2(offset.x >= 0.0 ? 1.0 : -1.0, offset.y >= 0.0 ? 1.0 : -1.0);
    vec2 map = sum > 0.0 ? (offset.z >= 0.0 ? offset.xy / sum : (1.0 - size.yx / sum) * side) : vec2(0.0);
    vec2 t = clamp((map + 1.0) * 6.0, vec2(0.0), vec2(12.0));
    ivec2 cell = ivec2(min(t, vec2(11.0)));
    FarLevel level;
    level.stride = ivec3(13, 1, 169);
    level.first = int(asset[at + 37u]) + sphere * 169 + cell.x * 13 + cell.y;
    level.part = vec3(t - vec2(cell), (u - low) / (high - low));
    return level;
}

// Adds the share of a level to penumbra_f. Returns its share of the signed distance, which only the fine box has.
float farAddLevel(uint at, uint level_index, FarLevel level) {
    vec4 sum[9];
    for (int i = 0; i < 9; ++i) sum[i] = vec4(0.0);
    float distance = 0.0;
    for (int c = 0; c < 8; ++c) {
        ivec3 corner = ivec3(c & 1, (c >> 1) & 1, c >> 2);
        vec3 weights = mix(1.0 - level.part, level.part, vec3(corner));
        float weight = weights.x * weights.y * weights.z;
        uint point = uint(level.first + corner.x * level.stride.x + corner.y * level.stride.y + corner.z * level.stride.z);
        uint word = asset[at + 38u] + 9u * point;
        for (uint i = 0u; i < 9u; ++i) sum[i] += weight * penumbra_unpack_i8(asset[word + i]);
        if (level_index == 0u)
            distance += weight * float(bitfieldExtract(int(asset[asset[at + 39u] + point / 4u]), int(8u * (point % 4u)), 8));
    }
    float scales[6];
    for (uint l = 0u; l < 6u; ++l) scales[l] = level.share * farFloat(at, 41u + 6u * level_index + l);
    for (int l = 0; l < 6; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) penumbra_f[i] += scales[l] * sum[i / 4][i % 4];
    return level_index == 0u ? level.share * farFloat(at, 40u) * distance : 0.0;
}

// Writes V - 1 of a part in its rest frame to penumbra_f, and tells by what it counts.
void farBlocked(uint part, PenumbraSurface s, inout FarSight sight) {
    uint at = farPart(part);
    vec4 p = vec4(s.position, 1.0);
    vec3 point = vec3(dot(posedRow(part, 0u), p), dot(posedRow(part, 1u), p), dot(posedRow(part, 2u), p));
    vec3 offset = point - farVector(at + 32u);
    float square = dot(offset, offset), radius = farFloat(at, 35u);
    for (int i = 0; i < 36; ++i) penumbra_f[i] = 0.0;
    float fine_share = 0.0, left = 1.0, distance = 0.0;
    for (uint l = 0u; l < 3u && left > 0.0; ++l) {
        FarLevel level;
        if (l < 2u) {
            level = farBox(at + kBoxWords * l, point);
            if (l == 0u) fine_share = level.share;
            level.share *= left;
        } else {
            level = farSpheres(at, offset, sqrt(square), radius);
            level.share = left;
        }
        left -= level.share;
        if (level.share > 0.0) distance += farAddLevel(at, l, level);
    }
    float scale = 1.0 / (square + 0.25 * radius * radius);
    for (int i = 0; i < 36; ++i) penumbra_f[i] *= scale;
    sight.inside = clamp(-distance * farFloat(at, 36u), 0.0, fine_share);
    sight.share = -penumbra_f[0] / kRootOfSphere;
    sight.weight = clamp((sight.share - kLeastBlocked) / (kFullBlocked - kLeastBlocked), 0.0, 1.0);
    sight.counts = sight.weight > 0.0 || sight.inside > 0.0;
}

mat3 modelFromPart(uint part) {  // columns of the transpose: its columns are the rows of the rotation
    return mat3(posedRow(part, 3u).xyz, posedRow(part, 4u).xyz, posedRow(part, 5u).xyz);
}

uint farListBegin(uint part) { return asset[FAR_LISTS + part]; }
uint farListEnd(uint part) { return asset[FAR_LISTS + part + 1u]; }
uint farListPart(uint i) { return asset[FAR_LISTS + PART_COUNT + 1u + i]; }

#ifdef FAR_ANCHORS
void farAnchor(PenumbraSurface s, uint own_part, uint out_at) {
    float rest[36];
    for (int i = 0; i < 36; ++i) rest[i] = 0.0;
    uint begin = farListBegin(own_part), end = farListEnd(own_part);
    for (uint i = begin; i < end; ++i) {
        uint part = farListPart(i);
        FarSight sight;
        float near = 0.0;
        if (farHeight(part, s, sight)) {
            farBlocked(part, s, sight);
            if (sight.counts) {
                near = clamp((sight.share - kNearFrom) / (kNearFull - kNearFrom), 0.0, 1.0);
                // Few bands are darker in the middle than V - 1, and leak below the horizon: addToRest().
                float dark = clamp(36.0 * sight.share, 0.0, 1.0), above = clamp(1.0 + sight.sine, 0.0, 1.0);
                float scale = sight.weight * (1.0 - near) * above * (1.0 + kDepth * dark);
                if (scale > 0.0) {
                    mat3 turn = modelFromPart(part);
                    penumbra_far_turn(turn[0], turn[1], turn[2]);
                    for (int j = 0; j < 36; ++j) rest[j] += scale * penumbra_f[j];
                }
            }
        }
        anchor_values[out_at + 9u + (i - begin) / 4u][(i - begin) % 4u] = near;
    }
    for (uint i = 0u; i < 9u; ++i)
        anchor_values[out_at + i] = vec4(rest[4u * i], rest[4u * i + 1u], rest[4u * i + 2u], rest[4u * i + 3u]);
}
#else
// exp(x) = exp(x / 8)^8, for x in [-6, 2].
float farExponential(float x) {
    x = 0.125 * clamp(x, -6.0, 2.0);
    x = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0))));
    x *= x;
    x *= x;
    return x * x;
}

// What a vertex takes from its anchors.
struct FarOwed {
    bool has_anchors;
    uvec4 from;  // where their values begin
    vec4 weight;
};

vec4 farInterpolated(FarOwed owed, uint i) {
    uvec4 at = owed.from + i;
    return owed.weight.x * anchor_values[at.x] + owed.weight.y * anchor_values[at.y] +
           owed.weight.z * anchor_values[at.z] + owed.weight.w * anchor_values[at.w];
}

// Multiplies the numbers by what the far parts leave visible at the vertex. `anchors`: where the values of this
// character's anchors begin.
void farCompose(PenumbraSurface s, uint own_part, uint anchors, inout vec4 numbers[PENUMBRA_STRIDE4]) {
    vec3 bitangent = cross(s.normal, s.tangent);
    float values[64], factor[64], light = 1.0;
    for (int d = 0; d < 64; ++d) values[d] = 1.0;
    uint row = FAR_RECEIVERS + 8u * vertex;
    FarOwed owed;
    owed.has_anchors = asset[row] != NO_ANCHOR;
    owed.from = uvec4(asset[row], asset[row + 1u], asset[row + 2u], asset[row + 3u]) + anchors;
    owed.weight = uintBitsToFloat(uvec4(asset[row + 4u], asset[row + 5u], asset[row + 6u], asset[row + 7u]));
    // 1. The near parts, or without anchors all parts, one by one. The last round brings in the sum that the anchors
    // have of the others. Compilers take long for this code, so that it stands here once for both.
    uint begin = farListBegin(own_part), end = farListEnd(own_part);
    for (uint i = begin; i <= end; ++i) {
        bool is_sum = i == end;
        vec3 row0 = s.tangent, row1 = bitangent, row2 = s.normal;
        float by_bands = 1.0, by_height = 0.0;
        if (is_sum) {
            if (!owed.has_anchors) continue;
            for (uint j = 0u; j < 9u; ++j) {
                vec4 four = farInterpolated(owed, j);
                for (uint k = 0u; k < 4u; ++k) penumbra_f[4u * j + k] = four[k];
            }
            if (penumbra_f[0] >= 0.0) continue;
        } else {
            float share = owed.has_anchors ? clamp(farInterpolated(owed, 9u + (i - begin) / 4u)[(i - begin) % 4u], 0.0, 1.0) : 1.0;
            if (share <= 0.0) continue;
            uint part = farListPart(i);
            FarSight sight;
            if (!farHeight(part, s, sight) || sight.height <= -1.0) continue;
            farBlocked(part, s, sight);
            light *= 1.0 - sight.inside * share;
            if (sight.weight == 0.0) continue;
            mat3 into_part = modelFromPart(part);
            row0 = into_part * row0;
            row1 = into_part * row1;
            row2 = into_part * row2;
            float sure = sight.height * sight.height, counted = share * sight.weight;
            by_bands = counted * (1.0 - sure);
            by_height = sight.height > 0.0 ? 2.0 * counted * sure : 0.0;
        }
        penumbra_far_turn(row0, row1, row2);
        penumbra_far_mirror(by_bands, by_height);
        if (!is_sum) penumbra_even[0] += kRootOfSphere;
        penumbra_far_values(factor);
        if (is_sum)
            for (int d = 0; d < 64; ++d) values[d] *= farExponential(factor[d]);
        else
            for (int d = 0; d < 64; ++d) values[d] *= factor[d];
    }
    // 2. Back from the directions, which leaves the bands of a far factor.
    penumbra_far_from_values(values);
    for (int i = 0; i < 21; ++i) penumbra_even[i] *= light;
    // 3. The product of that and the numbers, at the same directions.
    penumbra_far_values(values);
    for (int i = 0; i < 21; ++i) penumbra_even[i] = i < NUMBERS ? numbers[i / 4][i % 4] : 0.0;
    penumbra_far_values(factor);
    for (int d = 0; d < 64; ++d) values[d] *= factor[d];
    penumbra_far_from_values(values);
    for (int i = 0; i < NUMBERS; ++i) numbers[i / 4][i % 4] = penumbra_even[i];
}
#endif
