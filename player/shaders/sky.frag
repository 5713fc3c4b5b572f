// Draws a light that is seen from far away: its picture, and the discs of its suns.
in vec3 ray;  // in the light's own frame

uniform int sun_count;
uniform vec4 sun_disc[SUN_MAX_SUNS];      // direction in the light's own frame, cosine of the radius
uniform vec3 sun_radiance[SUN_MAX_SUNS];  // radiance of the disc, in addition to the picture

layout(location = 0) out vec4 color;

void main() {
    vec3 direction = normalize(ray);
    vec3 radiance = skyRadiance(direction);
    for (int i = 0; i < sun_count; ++i)
        if (dot(direction, sun_disc[i].xyz) >= sun_disc[i].w) radiance += sun_radiance[i];
    color = pictureColor(radiance);
}
