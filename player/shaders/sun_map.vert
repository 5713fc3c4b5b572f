// Draws casters into the depth map of a sun. Rows and range are those of SunFrame (runtime/sun/sun_frame.h).
layout(location = 0) in vec3 position;

// 3 rows, then (range, tangent of the radius, texel, size) and (origin, border)
uniform vec4 sun_frame[5];

void main() {
    vec3 place, from_origin = position - sun_frame[4].xyz;
    for (int i = 0; i < 3; ++i) place[i] = dot(sun_frame[i].xyz, from_origin) / sun_frame[3].z + sun_frame[i].w;
    gl_Position = vec4(2.0 * place / vec3(sun_frame[3].ww, sun_frame[3].x) - 1.0, 1.0);
}
