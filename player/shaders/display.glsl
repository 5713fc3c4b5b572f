// How linear Rec.709 colours become what is written: exposed and tone mapped where they are radiance, then sRGB
// encoded. player/draw/shader_source.cpp puts it before the fragment shaders and defines CHANNEL.
uniform float exposure;
uniform int tone_map;  // ToneMap (view_display.h); -1: linear values times exposure

vec3 linearFromSrgb(vec3 c) {
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}

vec3 srgbFromLinear(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}

vec3 displayed(vec3 c) {
#if CHANNEL == CHANNEL_NORMALS
    return c;  // numbers
#elif CHANNEL == CHANNEL_SHADED
    c *= exposure;
    if (tone_map == 1) c = c / (1.0 + c);
    if (tone_map == 2) c = c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14);
#endif
    return srgbFromLinear(clamp(c, 0.0, 1.0));
}

vec4 pictureColor(vec3 rgb) { return vec4(tone_map < 0 ? rgb * exposure : displayed(rgb), 1.0); }
