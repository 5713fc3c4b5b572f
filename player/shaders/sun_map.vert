// Draws casters into the depth map of a sun. Rows and range are those of SunFrame (player/runtime/sun_frame.h).
layout(location = 0) in vec3 position;

uniform vec4 sun_frame[4];  // 3 rows, then (range, tangent of the radius, texel, size)

void main() {
    vec3 place;
    for (int i = 0; i < 3; ++i) place[i] = dot(sun_frame[i].xyz, position) / sun_frame[3].z + sun_frame[i].w;
    gl_Position = vec4(2.0 * place / vec3(sun_frame[3].ww, sun_frame[3].x) - 1.0, 1.0);
}
