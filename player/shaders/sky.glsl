// A light's lat-long picture (formats/image/image_file.h, latLongDirection()).
uniform samplerBuffer sky;  // row after row from the top; rgb
uniform ivec2 sky_size;     // width, height in texels

vec3 skyTexel(ivec2 at) {
    int x = (at.x + sky_size.x) % sky_size.x, y = clamp(at.y, 0, sky_size.y - 1);
    return texelFetch(sky, y * sky_size.x + x).rgb;
}

// The radiance from a unit direction in the light's own frame, linear between the centers of texels.
vec3 skyRadiance(vec3 direction) {
    const float pi = 3.14159265;
    vec2 coordinates = vec2(atan(direction.z, direction.x) / (2.0 * pi) + 0.5, acos(clamp(direction.y, -1.0, 1.0)) / pi);
    vec2 at = coordinates * vec2(sky_size) - 0.5, low = floor(at), part = at - low;
    ivec2 corner = ivec2(low);
    return mix(mix(skyTexel(corner), skyTexel(corner + ivec2(1, 0)), part.x),
               mix(skyTexel(corner + ivec2(0, 1)), skyTexel(corner + ivec2(1, 1)), part.x), part.y);
}
