// Casts on the vertices of characters at anchors, as runtime/cast/cast_anchors.cpp has them. An anchor (main() with
// CAST_ANCHORS) sums what is far and hides little, and lists what is near. A vertex takes the sum from its four
// anchors, and multiplies in one by one what is in any of their lists.
//
// Words of an anchor: the sum over parts [36], that over spheres [25], how many are near, and each of these: its index
// in the lower 17 bits, spheres after parts, and its weight in the upper ones. The lists are in the order of the
// indices. Where an anchor finds more than it has room for, the vertices around look everything up themselves.
//
// The layout has a vertex and the spacing for each anchor, then for each vertex its 4 anchors and their weights.
layout(std430, binding = 5) readonly buffer CastLayout { uint cast_layout[]; };

const uint kSpheresAt = 36u, kCountAt = 61u, kNearAt = 62u, kMaxNear = ANCHOR_WORDS - kNearAt, kTooMany = 0xffffffffu;
const uint kIndexBits = 17u, kIndexMask = (1u << kIndexBits) - 1u;
const float kMaxWeight = 32767.0;

uniform uint vertex_count, anchor_count;

#ifdef CAST_ANCHORS
layout(std430, binding = 6) writeonly buffer CastAnchors { uint cast_anchors[]; };

// Returns how near a caster is for anchors at this spacing: 1 near, 0 far.
float castNearness(vec4 sphere, vec3 position, float spacing) {
    float distance = length(sphere.xyz - position) - sphere.w;
    return clamp((FAR_SPACINGS - distance / spacing) / (FAR_SPACINGS - NEAR_SPACINGS), 0.0, 1.0);
}

void castList(uint at, int index, float near, inout uint found) {
    if (near <= 0.0) return;
    if (found < kMaxNear) cast_anchors[at + kNearAt + found] = uint(index) | uint(near * kMaxWeight + 0.5) << kIndexBits;
    ++found;
}

void castAnchor(vec3 position, vec3 normal, float spacing, ivec4 own, uint at) {
    uint found = 0u;
#ifdef HAS_PARTS
    float rest[36];
    for (int i = 0; i < 36; ++i) rest[i] = 0.0;
    for (int i = 0; i < part_count; ++i) {
        PenumbraSight sight;
        if (i >= own.x && i < own.y || !penumbra_field_height(i, position, normal, sight)) continue;
        penumbra_field_blocked(i, position, sight);
        float near = clamp((sight.share - penumbra_near_from) / (penumbra_near_full - penumbra_near_from), 0.0, 1.0);
        near = max(near, castNearness(PENUMBRA_PART(i, 6), position, spacing));
        castList(at, i, near, found);
        float scale = sight.weight * (1.0 - near) * (1.0 + penumbra_depth * clamp(36.0 * sight.share, 0.0, 1.0));
        if (scale <= 0.0) continue;
        mat3 turn = penumbra_into_part(i);
        penumbra_far_turn(turn[0], turn[1], turn[2]);
        for (int j = 0; j < 36; ++j) rest[j] += scale * penumbra_f[j];
    }
    for (uint j = 0u; j < 36u; ++j) cast_anchors[at + j] = floatBitsToUint(rest[j]);
#endif
#ifdef HAS_SPHERES
    float logarithm[25];
    for (int i = 0; i < 25; ++i) logarithm[i] = 0.0;
    for (int i = 0; i < sphere_count; ++i) {
        if (i >= own.z && i < own.w) continue;
        float near = castNearness(PENUMBRA_SPHERE(i), position, spacing);
        castList(at, part_count + i, near, found);
        if (near < 1.0) penumbra_cast_sphere(i, 1.0 - near, position, mat3(1.0), logarithm);
    }
    for (uint j = 0u; j < 25u; ++j) cast_anchors[at + kSpheresAt + j] = floatBitsToUint(logarithm[j]);
#endif
    cast_anchors[at + kCountAt] = found > kMaxNear ? kTooMany : found;
}
#else
layout(std430, binding = 6) readonly buffer CastAnchors { uint cast_anchors[]; };

// Walks through what a vertex multiplies in one by one, in the order of the indices.
struct CastWalk {
    bool by_anchors;  // else everything, with a share of 1
    uvec4 from;       // where the words of the anchors begin
    vec4 weight;
    uvec4 at, end;  // rest of the anchors' lists
    int next;
};

CastWalk castWalk(uint character, uint vertex) {
    CastWalk walk;
    uint row = 2u * anchor_count + 8u * vertex;
    walk.next = 0;
    walk.by_anchors = cast_layout[row] != NO_ANCHOR;
    if (!walk.by_anchors) return walk;
    for (uint k = 0u; k < 4u; ++k) {
        walk.from[k] = ANCHOR_WORDS * (character * anchor_count + cast_layout[row + k]);
        walk.weight[k] = uintBitsToFloat(cast_layout[row + 4u + k]);
        uint count = cast_anchors[walk.from[k] + kCountAt];
        walk.by_anchors = walk.by_anchors && count != kTooMany;
        walk.at[k] = walk.from[k] + kNearAt;
        walk.end[k] = walk.at[k] + count;
    }
    return walk;
}

// Goes on to the next index below `end`. `own` are left out.
bool castNext(inout CastWalk walk, ivec2 own, int end, out int index, out float share) {
    index = walk.next;
    share = 1.0;
    if (!walk.by_anchors) {
        if (index >= own.x && index < own.y) index = own.y;
        walk.next = min(index + 1, end);
        return index < end;
    }
    uint first = uint(end);
    for (int k = 0; k < 4; ++k)
        if (walk.at[k] < walk.end[k]) first = min(first, cast_anchors[walk.at[k]] & kIndexMask);
    index = int(first);
    if (index == end) return false;
    share = 0.0;
    for (int k = 0; k < 4; ++k) {
        if (walk.at[k] >= walk.end[k]) continue;
        uint word = cast_anchors[walk.at[k]];
        if ((word & kIndexMask) != first) continue;
        share += walk.weight[k] * float(word >> kIndexBits) / kMaxWeight;
        ++walk.at[k];
    }
    share = clamp(share, 0.0, 1.0);
    return true;
}

float castInterpolated(CastWalk walk, uint i) {
    uvec4 at = walk.from + i;
    return walk.weight.x * uintBitsToFloat(cast_anchors[at.x]) + walk.weight.y * uintBitsToFloat(cast_anchors[at.y]) +
           walk.weight.z * uintBitsToFloat(cast_anchors[at.z]) + walk.weight.w * uintBitsToFloat(cast_anchors[at.w]);
}

#ifdef HAS_PARTS
bool castParts(inout CastWalk walk, ivec2 own, vec3 position, mat3 axes, out float mirrored[21]) {
    bool seen = false;
    int i;
    float share;
    penumbra_cast_begin();
    while (castNext(walk, own, part_count, i, share))
        if (share > 0.0 && penumbra_cast_part(i, share, position, axes)) seen = true;
    if (walk.by_anchors && castInterpolated(walk, 0u) < 0.0) {  // a sum of V - 1
        float factor[64];
        for (uint j = 0u; j < 36u; ++j) penumbra_f[j] = castInterpolated(walk, j);
        penumbra_far_turn(axes[0], axes[1], axes[2]);
        penumbra_far_mirror(1.0, 0.0);
        penumbra_far_values(factor);
        for (int d = 0; d < 64; ++d) penumbra_product[d] *= penumbra_far_exponential(factor[d]);
        seen = true;
    }
    penumbra_cast_end(seen, mirrored);
    return seen;
}
#endif

#ifdef HAS_SPHERES
bool castSpheres(inout CastWalk walk, ivec2 own, vec3 position, mat3 axes, out float visibility[25]) {
    bool seen = false;
    int i;
    float share;
    for (int j = 0; j < 25; ++j) visibility[j] = 0.0;
    if (walk.by_anchors && castInterpolated(walk, kSpheresAt) < 0.0) {
        for (int j = 0; j < 36; ++j) penumbra_f[j] = j < 25 ? castInterpolated(walk, kSpheresAt + uint(j)) : 0.0;
        penumbra_far_turn(axes[0], axes[1], axes[2]);
        for (int j = 0; j < 25; ++j) visibility[j] = penumbra_f[j];
        seen = true;
    }
    walk.next = part_count;
    while (castNext(walk, part_count + own, part_count + sphere_count, i, share))
        if (share > 0.0 && penumbra_cast_sphere(i - part_count, share, position, transpose(axes), visibility))
            seen = true;
    if (seen) penumbra_cast_exponential(visibility);
    else visibility[0] = 3.5449077;
    return seen;
}
#endif
#endif
