// The CPU path: position and value of every vertex come evaluated.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertex_value;

uniform mat4 clip_from_model;

// player/draw/shader_source.cpp defines INTERPOLATION: flat or centroid.
INTERPOLATION out vec3 value;

void main() {
    value = vertex_value;
    gl_Position = clip_from_model * vec4(position, 1.0);
}
