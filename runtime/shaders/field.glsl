// Computes the visibility past a part of a character by its field, like sh/far/far_lookup.h. The player's far.glsl uses
// these functions, and so does cast_fields.glsl. The text of fieldGlsl() (runtime/glsl/far_glsl.h) and two macros stand
// before this:
//   #define PENUMBRA_FIELD(word): the uint at `word` (a uint) of the buffer with the tables and bytes of fields
//   #define PENUMBRA_PART(part, row): the vec4 `row` (0 to 6) of a posed part, writePosedPart() (far_glsl.h)

float penumbra_field_float(uint table, uint i) { return uintBitsToFloat(PENUMBRA_FIELD(table + i)); }
vec3 penumbra_field_vector(uint at) {
    return uintBitsToFloat(uvec3(PENUMBRA_FIELD(at), PENUMBRA_FIELD(at + 1u), PENUMBRA_FIELD(at + 2u)));
}
vec4 penumbra_field_bytes(uint word) {
    int w = int(word);
    return vec4(bitfieldExtract(w, 0, 8), bitfieldExtract(w, 8, 8), bitfieldExtract(w, 16, 8), bitfieldExtract(w, 24, 8));
}

// A part as one point sees it.
struct PenumbraSight {
    float height, sine;  // height and sine of its sphere over the horizon; height 1: all of it is above
    float share;         // share of the sphere that it blocks
    float weight;        // weight with which it counts
    float inside;        // how dark it is inside of it
    bool counts;
};

// Where the words of a part begin.
uint penumbra_field_words(int part) { return 4u * uint(PENUMBRA_PART(part, 3).w); }

// Tells how high the part stands, and returns whether it is large enough to count.
bool penumbra_field_height(int part, vec3 position, vec3 normal, out PenumbraSight sight) {
    vec4 sphere = PENUMBRA_PART(part, 6);
    vec3 way = sphere.xyz - position;
    float along = dot(way, normal), square = dot(way, way), radius2 = sphere.w * sphere.w;
    sight.height = clamp(along / sphere.w, -1.0, 1.0);
    sight.sine = along / sqrt(square + 1e-20);
    return radius2 >= 4.0 * penumbra_blocked_from * (square - radius2);
}

// Eight points of a level around the point.
struct PenumbraLevel {
    float share;
    int first;
    ivec3 stride;
    vec3 part;
};

PenumbraLevel penumbra_field_box(uint box, vec3 point) {
    vec3 low = penumbra_field_vector(box), high = penumbra_field_vector(box + 3u), cells = penumbra_field_vector(box + 9u);
    vec3 above = point - low, below = high - point;
    float depth = min(min(min(above.x, below.x), min(above.y, below.y)), min(above.z, below.z));
    vec3 t = clamp(above * penumbra_field_vector(box + 6u), vec3(0.0), cells);
    ivec3 cell = ivec3(min(t, cells - 1.0));
    PenumbraLevel level;
    level.share = clamp(depth * penumbra_field_float(box, 12u), 0.0, 1.0);
    level.stride = ivec3(1, int(PENUMBRA_FIELD(box + 13u)), int(PENUMBRA_FIELD(box + 14u)));
    level.first = int(PENUMBRA_FIELD(box + 15u)) + cell.x + cell.y * level.stride.y + cell.z * level.stride.z;
    level.part = t - vec3(cell);
    return level;
}

// Four points on each of two spheres, which are linear in u = r / d. The octahedral map unfolds a sphere to a square.
PenumbraLevel penumbra_field_spheres(uint at, vec3 offset, float distance, float radius) {
    float u = clamp(distance > 0.0 ? radius / distance : 1.0, penumbra_sphere_scales[0], penumbra_sphere_scales[3]);
    int sphere = u > penumbra_sphere_scales[2] ? 2 : u > penumbra_sphere_scales[1] ? 1 : 0;
    float low = penumbra_sphere_scales[sphere], high = penumbra_sphere_scales[sphere + 1];
    vec3 size = abs(offset);
    float sum = size.x + size.y + size.z;
    vec2 side = vec2(offset.x >= 0.0 ? 1.0 : -1.0, offset.y >= 0.0 ? 1.0 : -1.0);
    vec2 map = sum > 0.0 ? (offset.z >= 0.0 ? offset.xy / sum : (1.0 - size.yx / sum) * side) : vec2(0.0);
    vec2 t = clamp((map + 1.0) * 6.0, vec2(0.0), vec2(12.0));
    ivec2 cell = ivec2(min(t, vec2(11.0)));
    PenumbraLevel level;
    level.stride = ivec3(13, 1, 169);
    level.first = int(PENUMBRA_FIELD(at + 37u)) + sphere * 169 + cell.x * 13 + cell.y;
    level.part = vec3(t - vec2(cell), (u - low) / (high - low));
    return level;
}

// Adds the share of a level to penumbra_f. Returns its share of the signed distance, which only the fine box has.
float penumbra_field_add(uint at, uint level_index, PenumbraLevel level) {
    vec4 sum[9];
    for (int i = 0; i < 9; ++i) sum[i] = vec4(0.0);
    float distance = 0.0;
    for (int c = 0; c < 8; ++c) {
        ivec3 corner = ivec3(c & 1, (c >> 1) & 1, c >> 2);
        vec3 weights = mix(1.0 - level.part, level.part, vec3(corner));
        float weight = weights.x * weights.y * weights.z;
        ivec3 steps = corner * level.stride;
        uint point = uint(level.first + steps.x + steps.y + steps.z);
        uint word = PENUMBRA_FIELD(at + 38u) + 9u * point;
        for (uint i = 0u; i < 9u; ++i) sum[i] += weight * penumbra_field_bytes(PENUMBRA_FIELD(word + i));
        if (level_index > 0u) continue;
        int four = int(PENUMBRA_FIELD(PENUMBRA_FIELD(at + 39u) + point / 4u));
        distance += weight * float(bitfieldExtract(four, int(8u * (point % 4u)), 8));
    }
    float scales[6];
    for (uint l = 0u; l < 6u; ++l) scales[l] = level.share * penumbra_field_float(at, 41u + 6u * level_index + l);
    for (int l = 0; l < 6; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) penumbra_f[i] += scales[l] * sum[i / 4][i % 4];
    return level_index == 0u ? level.share * penumbra_field_float(at, 40u) * distance : 0.0;
}

// Writes V - 1 of a part in its rest frame to penumbra_f, and tells by what it counts.
void penumbra_field_blocked(int part, vec3 position, inout PenumbraSight sight) {
    uint at = penumbra_field_words(part);
    vec4 p = vec4(position, 1.0);
    vec3 point = vec3(dot(PENUMBRA_PART(part, 0), p), dot(PENUMBRA_PART(part, 1), p), dot(PENUMBRA_PART(part, 2), p));
    vec3 offset = point - penumbra_field_vector(at + 32u);
    float square = dot(offset, offset), radius = penumbra_field_float(at, 35u);
    for (int i = 0; i < 36; ++i) penumbra_f[i] = 0.0;
    float fine_share = 0.0, left = 1.0, distance = 0.0;
    for (uint l = 0u; l < 3u && left > 0.0; ++l) {
        PenumbraLevel level;
        if (l < 2u) {
            level = penumbra_field_box(at + 16u * l, point);
            if (l == 0u) fine_share = level.share;
            level.share *= left;
        } else {
            level = penumbra_field_spheres(at, offset, sqrt(square), radius);
            level.share = left;
        }
        left -= level.share;
        if (level.share > 0.0) distance += penumbra_field_add(at, l, level);
    }
    float scale = 1.0 / (square + 0.25 * radius * radius);
    for (int i = 0; i < 36; ++i) penumbra_f[i] *= scale;
    sight.inside = clamp(-distance * penumbra_field_float(at, 36u) * penumbra_dark, 0.0, fine_share);
    sight.share = -penumbra_f[0] / penumbra_root_of_sphere;
    float solid = clamp(sight.share / penumbra_solid, 0.0, 1.0);
    sight.weight = clamp((sight.share - penumbra_blocked_from) / (penumbra_blocked_full - penumbra_blocked_from), 0.0, 1.0);
    sight.weight *= penumbra_overlap + (1.0 - penumbra_overlap) * solid;
    sight.counts = sight.weight > 0.0 || sight.inside > 0.0;
}

// Returns the rotation from the frame of the parts into the rest frame of this one. Its columns are the rows of the
// rotation back.
mat3 penumbra_into_part(int part) {
    return mat3(PENUMBRA_PART(part, 3).xyz, PENUMBRA_PART(part, 4).xyz, PENUMBRA_PART(part, 5).xyz);
}

// exp(x) = exp(x / 8)^8, for x in [-6, 2].
float penumbra_far_exponential(float x) {
    x = 0.125 * clamp(x, -6.0, 2.0);
    x = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0))));
    x *= x;
    x *= x;
    return x * x;
}
