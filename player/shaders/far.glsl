// The far parts of a composed asset on the GPU, as sh/far/far_lanes.cpp has them for 8 receivers at a time. Before this
// stand farGlsl() (runtime/glsl/far_glsl.h, which also has the layout of the tables), field.glsl, and the shader's own
// surfaces and buffers.
//
// An anchor (main() with FAR_ANCHORS) sums the parts that block little, and tells how near each part is. A vertex takes
// that from its anchors, multiplies the near parts in one by one at 64 directions above its horizon, and brings the sum
// in by an exponential.

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
        PenumbraSight sight;
        float near = 0.0;
        if (penumbra_field_height(int(part), s.position, s.normal, sight)) {
            penumbra_field_blocked(int(part), s.position, sight);
            if (sight.counts) {
                near = clamp((sight.share - penumbra_near_from) / (penumbra_near_full - penumbra_near_from), 0.0, 1.0);
                // Few bands are darker in the middle than V - 1, and leak below the horizon: addToRest().
                float dark = clamp(36.0 * sight.share, 0.0, 1.0), above = clamp(1.0 + sight.sine, 0.0, 1.0);
                float scale = sight.weight * (1.0 - near) * above * (1.0 + penumbra_depth * dark);
                if (scale > 0.0) {
                    mat3 turn = penumbra_into_part(int(part));
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
#if NEAR_COUNT > 0
// Near parts of a part, and the gains of this vertex for them. 65535: no part.
uint nearPart(uint own_part, uint n) {
    uint i = NEAR_COUNT * own_part + n;
    return bitfieldExtract(asset[NEAR_PARTS + i / 2u], int(16u * (i % 2u)), 16);
}
float nearGain(uint n) {
    uint i = NEAR_COUNT * vertex + n;
    return float(bitfieldExtract(asset[NEAR_GAINS + i / 4u], int(8u * (i % 4u)), 8)) / 128.0;
}
#endif

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

// Multiplies the numbers by what the far and near parts leave visible at the vertex. `anchors`: where the values of
// this character's anchors begin.
void farCompose(PenumbraSurface s, uint own_part, uint anchors, inout vec4 coefficients[PENUMBRA_STRIDE4]) {
    vec3 bitangent = cross(s.normal, s.tangent);
    float values[64], factor[64], light = 1.0;
    for (int d = 0; d < 64; ++d) values[d] = 1.0;
    uint row = FAR_RECEIVERS + 8u * vertex;
    FarOwed owed;
    owed.has_anchors = asset[row] != NO_ANCHOR;
    owed.from = uvec4(asset[row], asset[row + 1u], asset[row + 2u], asset[row + 3u]) + anchors;
    owed.weight = uintBitsToFloat(uvec4(asset[row + 4u], asset[row + 5u], asset[row + 6u], asset[row + 7u]));
    // 1. What blocks much, or without anchors all far parts, one by one. The next round brings in the sum that the
    // anchors have of the others, and the last ones are near parts. Compilers take long for this code, so that it
    // stands here once for all.
    uint begin = farListBegin(own_part), end = farListEnd(own_part);
    for (uint i = begin; i <= end + NEAR_COUNT; ++i) {
        bool is_sum = i == end;
        vec3 row0 = s.tangent, row1 = bitangent, row2 = s.normal;
        float by_bands = 1.0, by_height = 0.0, whole = 1.0;
        if (is_sum) {
            if (!owed.has_anchors) continue;
            for (uint j = 0u; j < 9u; ++j) {
                vec4 four = farInterpolated(owed, j);
                for (uint k = 0u; k < 4u; ++k) penumbra_f[4u * j + k] = four[k];
            }
            if (penumbra_f[0] >= 0.0) continue;
        } else {
            uint part;
            float share;
#if NEAR_COUNT > 0
            if (i > end) {
                part = nearPart(own_part, i - end - 1u);
                if (part == 65535u) continue;
                share = nearGain(i - end - 1u);
            } else
#endif
            {
                part = farListPart(i);
                share = owed.has_anchors ? clamp(farInterpolated(owed, 9u + (i - begin) / 4u)[(i - begin) % 4u], 0.0, 1.0) : 1.0;
            }
            if (share <= 0.0) continue;
            PenumbraSight sight;
            if (!penumbra_field_height(int(part), s.position, s.normal, sight) || sight.height <= -1.0) continue;
            penumbra_field_blocked(int(part), s.position, sight);
            float outside = 1.0 - sight.inside * share, counted = share * sight.weight;
            if (i > end && sight.weight > 0.0) {
                // 1 - a (1 - (1 + w g) (1 - inside)) = 1 - a inside + a (1 - inside) w g
                whole = outside;
                counted *= 1.0 - sight.inside;
            } else {
                light *= outside;
            }
            if (sight.weight == 0.0) continue;
            mat3 into_part = penumbra_into_part(int(part));
            row0 = into_part * row0;
            row1 = into_part * row1;
            row2 = into_part * row2;
            float sure = sight.height * sight.height;
            by_bands = counted * (1.0 - sure);
            by_height = sight.height > 0.0 ? 2.0 * counted * sure : 0.0;
        }
        penumbra_far_turn(row0, row1, row2);
        penumbra_far_mirror(by_bands, by_height);
        if (!is_sum) penumbra_even[0] += penumbra_root_of_sphere * whole;
        penumbra_far_values(factor);
        if (is_sum)
            for (int d = 0; d < 64; ++d) values[d] *= penumbra_far_exponential(factor[d]);
        else
            for (int d = 0; d < 64; ++d) values[d] *= factor[d];
    }
    // 2. Back from the directions, which leaves the bands of a far factor.
    penumbra_far_from_values(values);
    for (int i = 0; i < 21; ++i) penumbra_even[i] *= light;
    // 3. The product of that and the numbers, at the same directions.
    penumbra_far_values(values);
    for (int i = 0; i < 21; ++i) penumbra_even[i] = i < NUMBERS ? coefficients[i / 4][i % 4] : 0.0;
    penumbra_far_values(factor);
    for (int d = 0; d < 64; ++d) values[d] *= factor[d];
    penumbra_far_from_values(values);
    for (int i = 0; i < NUMBERS; ++i) coefficients[i / 4][i % 4] = penumbra_even[i];
}
#endif
