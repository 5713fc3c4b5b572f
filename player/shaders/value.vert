// The CPU path: position and value of every vertex come evaluated.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertex_value;

uniform mat4 clip_from_model;

// player/draw/shader_source.cpp defines INTERPOLATION: flat or centroid.
INTERPOLATION out vec3 value;
#ifdef FADING
out vec2 place;
#endif

#ifdef HAS_NORMALS
layout(location = 2) in vec3 normal;
#endif
#ifdef SUNLIT
layout(location = 3) in vec3 tangent;
layout(location = 4) in uint vertex_lobes;
layout(location = 5) in float vertex_sight;

uniform mat4 scene_from_model;

out vec3 surface_position;
INTERPOLATION out vec3 surface_normal, surface_tangent;
INTERPOLATION out float surface_sight;
flat out uint surface_lobes;
#endif

#ifdef TEXTURED
layout(location = 6) in vec4 vertex_places;
uniform bool surface_replaced;
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
layout(location = 7) in vec3 vertex_term[TERMS];
INTERPOLATION out vec3 term[TERMS];
#endif
#endif

void main() {
    value = vertex_value;
#ifdef FADING
    place = position.xz;
#endif
#ifdef TEXTURED
    surface_places = vertex_places;
    surface_plain = surface_replaced ? 1 : 0;
#ifdef COLORED
    surface_color = texelFetch(surface_colors, gl_VertexID);
#endif
#ifdef TURNED
    surface_turn = vec3(texelFetch(surface_turns, gl_VertexID).xyz) / 127.0;
#endif
#if SLOPES > 0
    shape_position = position;
    shape_normal = normal;
#endif
#if TERMS > 0
    for (int i = 0; i < TERMS; ++i) term[i] = vertex_term[i];
#endif
#endif
#ifdef SUNLIT
    surface_position = (scene_from_model * vec4(position, 1.0)).xyz;
    surface_normal = mat3(scene_from_model) * normal;
    surface_tangent = mat3(scene_from_model) * tangent;
    surface_lobes = vertex_lobes;
    surface_sight = vertex_sight;
#endif
    gl_Position = clip_from_model * vec4(position, 1.0);
}
