// The GLSL path draws what evaluate.comp wrote for every vertex of every character.
// EVALUATED_QUADS texels a vertex: position in the scene; value, and the sight of mirrors. Where suns shine, these, too:
// normal, and the first of the lobes; tangent, and their number.
uniform samplerBuffer evaluated;
uniform int vertex_count;      // of one character
uniform mat4 clip_from_model;  // of the scene

// player/draw/shader_source.cpp defines INTERPOLATION: flat or centroid.
INTERPOLATION out vec3 value;

#ifdef SUNLIT
out vec3 surface_position;
INTERPOLATION out vec3 surface_normal, surface_tangent;
INTERPOLATION out float surface_sight;
flat out uint surface_lobes;
#endif

void main() {
    int at = EVALUATED_QUADS * (gl_InstanceID * vertex_count + gl_VertexID);
    vec3 position = texelFetch(evaluated, at).xyz;
    vec4 shown = texelFetch(evaluated, at + 1);
    value = shown.xyz;
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
