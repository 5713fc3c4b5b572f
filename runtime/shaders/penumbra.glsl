// Penumbra in an engine's own shader (docs/c-api.md, "On the GPU"). The player's shader uses the same functions. It
// needs GLSL 4.30, or 4.20 without buffers. A shader has these parts, in this order:
//   #version 430
//   #define PENUMBRA_MATERIAL(texel), PENUMBRA_LIGHT(texel): the vec4 at `texel` of
//       penumbra_shading_get_gpu_materials() and penumbra_shading_get_gpu_light(), wherever the engine keeps them
//   the text of penumbra_shading_get_glsl(), which has the convention, PENUMBRA_STRIDE4 and
//       float penumbra_ambient(vec4 coefficients[PENUMBRA_STRIDE4]);             0 dark to 1 open
//       void penumbra_clamp_ambient(inout vec4 coefficients[PENUMBRA_STRIDE4]);  before anything else
//       vec3 penumbra_shade(vec4 coefficients[PENUMBRA_STRIDE4], vec3 to_eye, mat3 local_from_model, int material);
//       and, where light bounces, penumbra_shade_bounced(), which takes vec4 indirect[3] behind the coefficients
//   #define PENUMBRA_MEAN(texel), PENUMBRA_BASIS(texel), PENUMBRA_SCORE(k), where penumbra_coefficients() is wanted
//   this file
// Everything is in the model frame. For each vertex:
//   PenumbraSurface s = penumbra_surface(...);
//   vec4 coefficients[PENUMBRA_STRIDE4];
//   penumbra_coefficients(vertex - first_vertex, vertex_count, component_count, coefficients);
//   penumbra_clamp_ambient(coefficients);
//   mat3 local_from_model = penumbra_local_from_model(s);
//   vec3 to_eye = penumbra_to_eye(s, eye, local_from_model);
//   vec3 radiance = penumbra_shade(coefficients, to_eye, local_from_model, material);
// A vertex that follows points (penumbra_asset_get_followers) has no cluster. Compute surface and clamped
// coefficients of each of its three points as above, and add them to zeros:
//   penumbra_add_point(point_coefficients, penumbra_turn(point_surface, s), weight, coefficients);
// Its own surface takes the rotation of the cluster of the point with the greatest weight.

struct PenumbraSurface {
    vec3 position, normal, tangent;
};

// Skins by linear blending. row0..2 are the rows of the blended 3x4 skinning matrix, the sum over influences of
// weight * row. rotation0..2 are the rows of the rotation of the vertex' cluster. The cofactor of the blended linear
// part turns the normal.
PenumbraSurface penumbra_surface(vec4 row0, vec4 row1, vec4 row2, vec3 rest_position, vec3 rest_normal, vec3 rest_tangent,
                                 vec3 rotation0, vec3 rotation1, vec3 rotation2) {
    vec4 p = vec4(rest_position, 1.0);
    PenumbraSurface s;
    s.position = vec3(dot(row0, p), dot(row1, p), dot(row2, p));
    vec3 normal = vec3(dot(cross(row1.xyz, row2.xyz), rest_normal), dot(cross(row2.xyz, row0.xyz), rest_normal),
                       dot(cross(row0.xyz, row1.xyz), rest_normal));
    if (dot(row0.xyz, cross(row1.xyz, row2.xyz)) < 0.0) normal = -normal;  // the outside stays outside
    float size = length(normal);
    s.normal = size > 0.0 ? normal / size : normal;
    vec3 carried = vec3(dot(rotation0, rest_tangent), dot(rotation1, rest_tangent), dot(rotation2, rest_tangent));
    vec3 tangent = carried - s.normal * dot(s.normal, carried);
    if (dot(tangent, tangent) <= 1e-12) {  // the carried one is along the normal: the axis least along it instead
        vec3 a = abs(s.normal);
        vec3 axis = a.x <= a.y && a.x <= a.z ? vec3(1, 0, 0) : a.y <= a.z ? vec3(0, 1, 0) : vec3(0, 0, 1);
        tangent = axis - s.normal * dot(s.normal, axis);
    }
    s.tangent = normalize(tangent);
    return s;
}

// The rows are tangent, normal x tangent, normal.
mat3 penumbra_local_from_model(PenumbraSurface s) {
    return transpose(mat3(s.tangent, cross(s.normal, s.tangent), s.normal));
}

// Returns the unit vector to the eye in the local frame. Seen from behind it is mirrored at the tangent plane, as on
// the CPU.
vec3 penumbra_to_eye(PenumbraSurface s, vec3 eye, mat3 local_from_model) {
    vec3 to_eye = eye - s.position;
    float distance = length(to_eye);
    to_eye = local_from_model * (distance > 0.0 ? to_eye / distance : s.normal);
    to_eye.z = abs(to_eye.z);
    return to_eye;
}

// Returns cosine and sine of the angle at which the tangent of a point stands in the frame of a vertex that follows it.
// Numbers of the point follow the normal: the smallest rotation takes its tangent to the plane of the vertex.
vec2 penumbra_turn(PenumbraSurface point, PenumbraSurface follower) {
    vec3 carried = point.tangent;
    float cosine = dot(point.normal, follower.normal);
    if (cosine >= -0.999)
        carried -= (point.normal + follower.normal) * (dot(follower.normal, point.tangent) / (1.0 + cosine));
    vec2 turn = vec2(dot(carried, follower.tangent), dot(carried, cross(follower.normal, follower.tangent)));
    float size = length(turn);
    return size > 0.0 ? turn / size : vec2(1.0, 0.0);
}

// Unpack four numbers as the asset stores them: PENUMBRA_I8 (without their scale) in one word, PENUMBRA_F16 in two.
vec4 penumbra_unpack_i8(uint word) {
    int w = int(word);
    return vec4(bitfieldExtract(w, 0, 8), bitfieldExtract(w, 8, 8), bitfieldExtract(w, 16, 8), bitfieldExtract(w, 24, 8));
}
vec4 penumbra_unpack_f16(uvec2 words) { return vec4(unpackHalf2x16(words.x), unpackHalf2x16(words.y)); }

#ifdef PENUMBRA_BASIS
// Computes numbers = mean + sum over components k of score_k basis_k, for vertex `vertex` of a cluster's
// `vertex_count`. A texel is four numbers of the cluster's array. PENUMBRA_SCORE(k) is the score, times the
// component's scale for PENUMBRA_I8.
void penumbra_coefficients(int vertex, int vertex_count, int component_count, out vec4 coefficients[PENUMBRA_STRIDE4]) {
    for (int q = 0; q < PENUMBRA_STRIDE4; ++q) coefficients[q] = PENUMBRA_MEAN(vertex * PENUMBRA_STRIDE4 + q);
    for (int k = 0; k < component_count; ++k) {
        float score = PENUMBRA_SCORE(k);
        for (int q = 0; q < PENUMBRA_STRIDE4; ++q)
            coefficients[q] += score * PENUMBRA_BASIS((k * vertex_count + vertex) * PENUMBRA_STRIDE4 + q);
    }
}
#endif

// Joins the radiance of the three parts of a material (penumbra_slot_surface of penumbra.h) with its colours: base
// colour, metalness, and f0 and f90 of the dielectric. Radiance that the surface emits is added to this.
vec3 penumbra_join_terms(vec3 d, vec3 a, vec3 b, vec3 base, float metallic, vec3 f0, float f90) {
    return base * (1.0 - metallic) * d + mix(f0, base, metallic) * a + mix(f90, 1.0, metallic) * b;
}
