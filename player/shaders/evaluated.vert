// The GLSL path draws what evaluate.comp wrote for every vertex of every character.
// EVALUATED_QUADS texels a vertex: position in the scene; value, and the sight of mirrors. Where suns shine, these,
// too: normal, and the first of the lobes; tangent, and their number. Where pictures are drawn, the fourth number of
// the position is 1 if they are seen, and the terms beside the first stand at TERM_QUAD; with SLOPES the normal is
// there.
uniform samplerBuffer evaluated;
uniform int vertex_count;      // vertices of one character
uniform mat4 clip_from_model;  // for points in the scene

// player/draw/shader_source.cpp defines INTERPOLATION: flat or centroid.
INTERPOLATION out vec3 value;

#ifdef SUNLIT
out vec3 surface_position;
INTERPOLATION out vec3 surface_normal, surface_tangent;
INTERPOLATION out float surface_sight;
flat out uint surface_lobes;
#endif

#ifdef TEXTURED
layout(location = 0) in uint drawn_vertex;  // index in the mesh; at seams several drawn vertices have the same
layout(location = 6) in vec4 vertex_places;
out vec4 surface_places;
flat out int surface_plain;
#ifdef COLORED
uniform samplerBuffer surface_colors;  // a texel a vertex that is drawn
out vec4 surface_color;
#endif
#ifdef TURNED
uniform isamplerBuffer surface_turns;  // a texel a vertex that is drawn
out vec3 surface_turn;
#endif
#if SLOPES > 0
out vec3 shape_position;
INTERPOLATION out vec3 shape_normal;
#endif
#if TERMS > 0
INTERPOLATION out vec3 term[TERMS];
#endif
#define VERTEX int(drawn_vertex)
#else
#define VERTEX gl_VertexID
#endif

void main() {
    int at = EVALUATED_QUADS * (gl_InstanceID * vertex_count + VERTEX);
    vec4 place = texelFetch(evaluated, at);
    vec3 position = place.xyz;
    vec4 shown = texelFetch(evaluated, at + 1);
    value = shown.xyz;
#ifdef TEXTURED
    surface_places = vertex_places;
    surface_plain = place.w > 0.0 ? 0 : 1;
#ifdef COLORED
    surface_color = texelFetch(surface_colors, gl_VertexID);
#endif
#ifdef TURNED
    surface_turn = vec3(texelFetch(surface_turns, gl_VertexID).xyz) / 127.0;
#endif
#if SLOPES > 0
    shape_position = position;
    shape_normal = texelFetch(evaluated, at + 2).xyz;
#endif
#if TERMS > 0
    for (int i = 0; i < TERMS; ++i) term[i] = texelFetch(evaluated, at + TERM_QUAD + i).xyz;
#endif
#endif
#ifdef SUNLIT
    vec4 normal = texelFetch(evaluated, at + 2), tangent = texelFetch(evaluated, at + 3);
    surface_position = position;
    surface_normal = normal.xyz;
    surface_tangent = tangent.xyz;
    surface_sight = shown.w;
    surface_lobes = uint(normal.w) | uint(tangent.w) << 24;
#endif
    gl_Position = clip_from_model * vec4(position, 1.0);
}
