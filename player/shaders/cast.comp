// Writes what the casters of a scene leave visible at receivers: vertices of characters and of the ground.
// player/draw/shader_source.cpp puts a preamble before this text, with WORK_GROUP, CAP_LOG_TEXELS, and
// HAS_PARTS and HAS_SPHERES where some casters have them. Vertices of characters are cast on at anchors, by a program
// with CAST_ANCHORS and then one with AT_ANCHORS (cast_anchors.glsl).
layout(local_size_x = WORK_GROUP) in;

layout(std430, binding = 0) readonly buffer Fields { uint fields[]; };
// The table of penumbra_get_cap_logs(), then for each caster where its parts and its spheres begin and end.
layout(std430, binding = 1) readonly buffer Tables { vec4 tables[]; };
layout(std430, binding = 2) readonly buffer Posed { vec4 posed[]; };  // all parts, 7 rows each, then all spheres
// Position and the receiver's own caster, -1 for none; normal; tangent.
layout(std430, binding = 3) readonly buffer Receivers { vec4 receivers[]; };
// cast_quads a receiver: what is visible there, mirrored; its last number but two tells whether any caster counts.
layout(std430, binding = 4) writeonly buffer Casts { vec4 casts[]; };

uniform uint receiver_count;
uniform uint cast_quads;  // from one receiver to the next
uniform int part_count, sphere_count;

#ifdef HAS_PARTS
#define PENUMBRA_PART(part, row) posed[7 * (part) + (row)]
#define PENUMBRA_FIELD(word) fields[word]
#endif
#ifdef HAS_SPHERES
#define PENUMBRA_SPHERE(i) posed[7 * part_count + (i)]
#define PENUMBRA_CAP_LOG(texel) tables[texel]
#endif

GENERATED_BY_CAST_GLSL

// Where the parts and spheres of the receiver's own caster begin and end.
ivec4 ownOf(vec4 place) { return place.w < 0.0 ? ivec4(0) : ivec4(tables[CAP_LOG_TEXELS + int(place.w)]); }

#ifdef CAST_ANCHORS
void main() {  // y: characters
    uint anchor = gl_GlobalInvocationID.x, character = gl_GlobalInvocationID.y;
    if (anchor >= anchor_count) return;
    uint r = 3u * (character * vertex_count + cast_layout[2u * anchor]);
    castAnchor(receivers[r].xyz, receivers[r + 1u].xyz, uintBitsToFloat(cast_layout[2u * anchor + 1u]),
               ownOf(receivers[r]), ANCHOR_WORDS * (character * anchor_count + anchor));
}
#else
void main() {
    uint r = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * WORK_GROUP;
    if (r >= receiver_count) return;
    vec4 place = receivers[3u * r];
    vec3 normal = receivers[3u * r + 1u].xyz, tangent = receivers[3u * r + 2u].xyz;
    mat3 axes = mat3(tangent, cross(normal, tangent), normal), local_from_scene = transpose(axes);
    ivec4 own = ownOf(place);
#ifdef AT_ANCHORS
    CastWalk walk = castWalk(r / vertex_count, r % vertex_count);
#endif
    float mirrored[21];
    for (int i = 0; i < 21; ++i) mirrored[i] = 0.0;
    mirrored[0] = 3.5449077;  // free sight: sqrt(4 pi)
    bool by_parts = false, by_spheres = false;
#ifdef HAS_PARTS
#ifdef AT_ANCHORS
    by_parts = castParts(walk, own.xy, place.xyz, axes, mirrored);
#else
    by_parts = penumbra_cast_fields(part_count, own.xy, place.xyz, local_from_scene, mirrored);
#endif
#endif
#ifdef HAS_SPHERES
    float visibility[25], past_spheres[21];
#ifdef AT_ANCHORS
    by_spheres = castSpheres(walk, own.zw, place.xyz, axes, visibility);
#else
    by_spheres = penumbra_cast_visibility(sphere_count, own.zw, place.xyz, local_from_scene, visibility);
#endif
    penumbra_cast_mirror(visibility, past_spheres);
#ifdef HAS_PARTS
    if (by_spheres && by_parts) penumbra_cast_combine(mirrored, past_spheres);
    else if (by_spheres) mirrored = past_spheres;
#else
    mirrored = past_spheres;
#endif
#endif
    if (by_parts || by_spheres) penumbra_cast_clamp(mirrored);
    uint at = cast_quads * r;
    for (uint q = 0u; q < 5u; ++q)
        casts[at + q] = vec4(mirrored[4u * q], mirrored[4u * q + 1u], mirrored[4u * q + 2u], mirrored[4u * q + 3u]);
    casts[at + 5u] = vec4(mirrored[20], by_parts || by_spheres ? 1.0 : 0.0, 0.0, 0.0);
}
#endif
