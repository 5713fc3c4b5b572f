// The CPU path: position and value of every vertex come evaluated.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertex_value;

uniform mat4 clip_from_model;

// player/draw/shader_source.cpp defines INTERPOLATION: flat or centroid.
INTERPOLATION out vec3 value;

#ifdef SUNLIT
layout(location = 2) in vec3 normal;
layout(location = 3) in vec3 tangent;
layout(location = 4) in uint vertex_lobes;
layout(location = 5) in float vertex_sight;

uniform mat4 scene_from_model;

out vec3 surface_position;
INTERPOLATION out vec3 surface_normal, surface_tangent;
INTERPOLATION out float surface_sight;
flat out uint surface_lobes;
#endif

void main() {
    value = vertex_value;
#ifdef SUNLIT
    surface_position = (scene_from_model * vec4(position, 1.0)).xyz;
    surface_normal = mat3(scene_from_model) * normal;
    surface_tangent = mat3(scene_from_model) * tangent;
    surface_lobes = vertex_lobes;
    surface_sight = vertex_sight;
#endif
    gl_Position = clip_from_model * vec4(position, 1.0);
}
