// Turns the value of a vertex into a picture's linear Rec.709 colour. Both paths share it.
// player/draw/shader_source.cpp defines INTERPOLATION and CHANNEL.
INTERPOLATION in vec3 value;

#ifdef FADING
in vec2 place;
uniform vec4 rim;  // x and z of the middle, the distances where it begins to fade and has gone
#endif

uniform float error_max;  // the error that gets the brightest colour

layout(location = 0) out vec4 color;

// The colour map viridis (its lightness grows evenly, and it is safe for colour-blind eyes) as M. Zucker's polynomial
// of degree 6 (public domain), which is within 0.02 of the table. Its colours are sRGB.
vec3 viridis(float t) {
    const vec3 c0 = vec3(0.2777273272, 0.0054073445, 0.3340998053);
    const vec3 c1 = vec3(0.1050930431, 1.4046135299, 1.3845901626);
    const vec3 c2 = vec3(-0.3308618287, 0.2148475595, 0.0950951630);
    const vec3 c3 = vec3(-4.6342304990, -5.7991009734, -19.3324409563);
    const vec3 c4 = vec3(6.2282699363, 14.1799333668, 56.6905526007);
    const vec3 c5 = vec3(4.7763849977, -13.7451453777, -65.3530326334);
    const vec3 c6 = vec3(-5.4354558559, 4.6458526122, 26.3124352496);
    return clamp(c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * c6))))), 0.0, 1.0);
}

// The colour of a cluster or a part. Hues are a golden section apart, so that neighbouring numbers differ. Three
// lightnesses take turns.
vec3 numberColor(int number) {
    float hue = 6.0 * fract(0.08 + 0.6180339887 * float(number));
    vec3 pure = clamp(vec3(abs(hue - 3.0) - 1.0, 2.0 - abs(hue - 2.0), 2.0 - abs(hue - 4.0)), 0.0, 1.0);
    float lightness = 1.0 - 0.2 * float(number % 3);
    return lightness * mix(vec3(1.0), pure, 0.65);
}

void main() {
#if CHANNEL == CHANNEL_AO || CHANNEL == CHANNEL_BOUNCED_AO
    vec3 rgb = vec3(max(value.x, 0.0));
#elif CHANNEL == CHANNEL_ERROR
    vec3 rgb = linearFromSrgb(viridis(clamp(value.x / error_max, 0.0, 1.0)));
#elif CHANNEL == CHANNEL_CLUSTERS || CHANNEL == CHANNEL_PARTS
    vec3 rgb = linearFromSrgb(numberColor(int(value.x + 0.5)));
#elif CHANNEL == CHANNEL_NORMALS
    vec3 rgb = normalize(value) * 0.5 + 0.5;
#else
    vec3 rgb = value;
#ifdef TEXTURED
#ifdef BLENDED
    gl_SampleMask[0] = ~0;
#endif
    if (surface_plain == 0) {
        Surface s = surfaceHere();
        rgb = surfaceRadiance(s, value);
#ifdef SUNLIT
        rgb += sunlightOn(s);
#endif
        color = pictureColor(rgb);
        return;
    }
#endif
#ifdef SUNLIT
    rgb += sunlight();
#endif
#endif
    color = pictureColor(rgb);
#ifdef FADING
    color.a = 1.0 - smoothstep(rim.z, rim.w, distance(place, rim.xy));
    if (color.a == 0.0) discard;
#endif
}
