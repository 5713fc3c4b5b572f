// One triangle covers the whole picture. It lies at the far plane, so that everything else is in front of it.
uniform vec3 ahead, across, up;  // rays through the middle of the picture, and how they change towards x = 1 and y = 1

out vec3 ray;

void main() {
    vec2 at = vec2(float((gl_VertexID & 1) << 2), float((gl_VertexID & 2) << 1)) - 1.0;
    ray = ahead + across * at.x + up * at.y;
    gl_Position = vec4(at, 1.0, 1.0);
}
