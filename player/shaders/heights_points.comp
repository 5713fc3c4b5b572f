// What the points of a height field show. heights_seen.glsl and a preamble with WORK_GROUP, CHANNEL, PENUMBRA_STRIDE4,
// NUMBERS and EVALUATED_QUADS stand before this text; RECEIVERS where it writes the points that casters cast on instead,
// CAST where they have cast on them.
layout(local_size_x = WORK_GROUP) in;

#ifdef RECEIVERS
layout(std430, binding = 3) writeonly buffer Receivers { vec4 receivers[]; };  // as cast.comp reads them
#else
layout(std430, binding = 3) readonly buffer Light { vec4 light[]; };
layout(std430, binding = 4) writeonly buffer Evaluated { vec4 evaluated[]; };  // as evaluated.vert reads it
#endif
#ifdef CAST
layout(std430, binding = 5) readonly buffer Casts { vec4 casts[]; };  // as cast.comp writes them
#endif
#if CHANNEL == CHANNEL_SHADED
uniform samplerBuffer materials;
#endif

#define PENUMBRA_MATERIAL(texel) texelFetch(materials, texel)
#define PENUMBRA_LIGHT(texel) light[texel]

uniform vec3 eye;  // in the scene
#ifdef SUNLIT
uniform vec3 lobes;  // of all points: the first, and their number; 1: the first is a mirror
#endif

GENERATED_BY_SHADING_GLSL

#ifndef RECEIVERS
// The two receivers of an axis around a point, and how far it is from the first.
void aroundPoint(int at, int count, int line_count, out int low, out int high, out float share) {
    low = at / SPACING;
    int first = min(low * SPACING, count - 1);
    if (low + 1 == line_count) {
#ifdef WRAPS
        high = 0;
#else
        high = low;
#endif
        share = float(at - first) / float(max(count - first, 1));
        return;
    }
    high = low + 1;
    share = float(at - first) / float(min(high * SPACING, count - 1) - first);
}

// V at a point, between four receivers. One whose normal is another one has less weight.
void visibilityBetween(ivec2 at, vec3 normal, out float v[ORDER * ORDER]) {
    ivec2 low, high;
    vec2 share;
    aroundPoint(at.x, side.x, lines.x, low.x, high.x, share.x);
    aroundPoint(at.y, side.y, lines.y, low.y, high.y, share.y);
    vec4 sum[ROW_QUADS];
    float weights = 0.0;
    for (int q = 0; q < ROW_QUADS; ++q) sum[q] = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        bool down = k > 1, right = k % 2 == 1;
        int first = ROW_QUADS * ((down ? high.x : low.x) * lines.y + (right ? high.y : low.y));
        vec3 there;
        for (int c = 0; c < 3; ++c) there[c] = rows[first + (ORDER * ORDER + c) / 4][(ORDER * ORDER + c) % 4];
        vec3 way = there - normal;
        float weight = (down ? share.x : 1.0 - share.x) * (right ? share.y : 1.0 - share.y) /
                       (1.0 + NORMALS_MATTER * dot(way, way));
        weights += weight;
        for (int q = 0; q < ROW_QUADS; ++q) sum[q] += weight * rows[first + q];
    }
    for (int i = 0; i < ORDER * ORDER; ++i) v[i] = sum[i / 4][i % 4] / weights;
#ifdef REFINED
    mixFiner(at, normal, v);
#endif
}

#ifdef SUNLIT
float surface_sight = 0.0;  // V at the mirrored direction, of mirrors
#endif

vec3 valueOf(uint point, PenumbraSurface s, float own[NUMBERS]) {
    vec4 coefficients[PENUMBRA_STRIDE4];
    for (int i = 0; i < 4 * PENUMBRA_STRIDE4; ++i) coefficients[i / 4][i % 4] = i < NUMBERS ? own[min(i, NUMBERS - 1)] : 0.0;
#ifdef CAST
    uint first = CAST_QUADS * point;
    if (casts[first + 5u].y != 0.0) {
        float mirrored[21];
        for (uint i = 0u; i < 21u; ++i) mirrored[i] = casts[first + i / 4u][i % 4u];
        penumbra_cast_coefficients(coefficients, mirrored);
    }
#endif
#if CHANNEL == CHANNEL_SHADED
    mat3 local_from_scene = penumbra_local_from_model(s);
    vec3 to_eye = penumbra_to_eye(s, eye, local_from_scene);
#ifdef SUNLIT
    // Fragments reflect the light's picture in mirrors, which SH blur.
    if (lobes.z > 0.0) {
        surface_sight = clamp(penumbra_sight(coefficients, vec3(-to_eye.xy, to_eye.z)), 0.0, 1.0);
        return vec3(0.0);
    }
#endif
    return max(penumbra_shade(coefficients, to_eye, local_from_scene, 0), 0.0);
#else
    return vec3(penumbra_ambient(coefficients), 0.0, 0.0);
#endif
}
#endif

void main() {
    uint point = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * WORK_GROUP;
    if (point >= uint(side.x * side.y)) return;
    ivec2 at = ivec2(point / uint(side.y), point % uint(side.y));
    vec3 normal = heightNormal(at), tangent = heightTangent(normal);
    PenumbraSurface s = PenumbraSurface(
        corner + vec3(float(at.y) * cell.y, heights[point], float(at.x) * cell.x),
        sceneFromField(normal), sceneFromField(tangent));
#ifdef RECEIVERS
    receivers[3u * point] = vec4(s.position, -1.0);
    receivers[3u * point + 1u] = vec4(s.normal, 0.0);
    receivers[3u * point + 2u] = vec4(s.tangent, 0.0);
#else
    float v[ORDER * ORDER], own[NUMBERS];
    visibilityBetween(at, normal, v);
    heightsMirror(v, normal, tangent, own);
    vec4 value = vec4(valueOf(point, s, own), 0.0);
#ifdef SUNLIT
    value.w = surface_sight;
    evaluated[EVALUATED_QUADS * point + 2u] = vec4(s.normal, lobes.x);
    evaluated[EVALUATED_QUADS * point + 3u] = vec4(s.tangent, lobes.y);
#endif
    evaluated[EVALUATED_QUADS * point] = vec4(s.position, 1.0);
    evaluated[EVALUATED_QUADS * point + 1u] = value;
#endif
}
