// The GLSL path draws what evaluate.comp wrote for every vertex of every character.
uniform samplerBuffer evaluated;  // 2 texels a vertex: position in the scene, value
uniform int vertex_count;         // of one character
uniform mat4 clip_from_model;     // of the scene

// player/draw/shader_source.cpp defines INTERPOLATION: flat or centroid.
INTERPOLATION out vec3 value;

void main() {
    int at = 2 * (gl_InstanceID * vertex_count + gl_VertexID);
    value = texelFetch(evaluated, at + 1).xyz;
    gl_Position = clip_from_model * vec4(texelFetch(evaluated, at).xyz, 1.0);
}
