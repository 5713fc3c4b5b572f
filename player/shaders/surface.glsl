// Joins the terms of the vertices with the pictures of a surface (docs/formulas.md, section 18). TERMS are those beside
// D: SLOPES vectors along the surface, one a colour, then A and B at each of STEPS roughnesses.
in vec4 surface_places;    // texture coordinates of two sets
flat in int surface_plain; // 1: the material has been replaced by one without pictures
#ifdef COLORED
in vec4 surface_color;     // colour of the vertices
#endif
#ifdef TURNED
in vec3 surface_turn;      // TangentTurn of formats/common/surface.h
#endif
#if TERMS > 0
INTERPOLATION in vec3 term[TERMS];
#endif
#if SLOPES > 0
in vec3 shape_position;                 // in the frame of the vertices, and of `term` [SLOPES]
INTERPOLATION in vec3 shape_normal;     // not unit
#endif

uniform vec3 surface_base, surface_emissive;
uniform vec4 surface_f0;        // f0 and f90 of the dielectric
uniform vec4 surface_numbers;   // metallic, roughness, scale of normals (0: level), strength of occlusion
uniform vec4 surface_alpha;     // alpha, cut-off (below 0: alphaMode BLEND), number of the slot
uniform int surface_steps;
uniform vec3 surface_step_roughness;
uniform int surface_uv_set[5];
uniform sampler2D base_picture, metal_picture, normal_picture, emissive_picture, occlusion_picture;

struct Surface {
    vec3 diffuse, f0, f90, emissive;  // weights of D, A and B, and what is added
    vec3 level, normal;               // normals of the vertices, and of the picture, in the frame of the vertices
    float roughness, occlusion;
};

#if SLOPES > 0
// The normal of the picture. Its x is along the unit direction in which u grows, across the vertices' normal, and its y
// at right angles to both, against v (glTF 2.0, section 3.7.2.1; MikkTSpace). It does not depend on the side that is
// seen: on the other one the turn of the corners changes its sign, and so does that of the places.
vec3 bentNormal(vec3 level, vec2 place, vec3 picture) {
    vec3 along_x = dFdx(shape_position), along_y = dFdy(shape_position);
    vec2 place_x = dFdx(place), place_y = dFdy(place);
    float turn = place_x.x * place_y.y - place_y.x * place_x.y;
    vec3 tangent = (along_x * place_y.y - along_y * place_x.y) * sign(turn);
    tangent -= level * dot(level, tangent);
    if (!(dot(tangent, tangent) > 0.0)) return level;
    tangent = normalize(tangent);
    vec3 bitangent = cross(level, tangent) * (dot(level, cross(along_x, along_y)) * turn > 0.0 ? -1.0 : 1.0);
    vec2 bend = surface_numbers.z * picture.xy;
#ifdef TURNED
    vec2 x = dot(surface_turn.xy, surface_turn.xy) > 0.0 ? normalize(surface_turn.xy) : vec2(1.0, 0.0);
    if (surface_turn.z < 0.0) bend.y = -bend.y;
    bend = bend.x * x + bend.y * vec2(-x.y, x.x);
#endif
    vec3 bent = tangent * bend.x + bitangent * bend.y + level * picture.z;
    return dot(bent, bent) > 0.0 ? normalize(bent) : level;
}
#endif

vec2 placeIn(int role) { return surface_uv_set[role] == 0 ? surface_places.xy : surface_places.zw; }

#ifdef BLENDED
// The finalizer of MurmurHash3 (public domain, A. Appleby).
uint hashOf(uint x) {
    x = (x ^ x >> 16) * 0x85ebca6bu;
    x = (x ^ x >> 13) * 0xc2b2ae35u;
    return x ^ x >> 16;
}

// Covers as many of the pixel's samples as alpha says, and ends fragments that cover none. So triangles may come in any
// order. A hash of pixel and triangle decides which samples they are, and whether what is left of alpha takes one more
// (Enderton et al. 2010, "Stochastic transparency").
void coverSamples(float alpha) {
    uint pixel = uint(gl_FragCoord.x) + (uint(gl_FragCoord.y) << 16);
    uint chance = hashOf(pixel ^ hashOf(uint(gl_PrimitiveID) ^ uint(surface_alpha.z) << 24));
    int samples = max(gl_NumSamples, 1);
    int covered = int(clamp(alpha, 0.0, 1.0) * float(samples) + float(chance >> 8) / 16777216.0);
    if (covered == 0) discard;
    uint all = (1u << samples) - 1u, bits = (1u << min(covered, samples)) - 1u;
    int turn = int((chance & 0xffu) % uint(samples));
    gl_SampleMask[0] = int((bits << turn | bits >> (samples - turn)) & all);
}
#endif

// Ends fragments that are not there.
Surface surfaceHere() {
    Surface s;
    vec4 base = vec4(surface_base, surface_alpha.x) * texture(base_picture, placeIn(0));
#ifdef COLORED
    base *= surface_color;
#endif
#ifdef BLENDED
    if (surface_alpha.y < 0.0) coverSamples(base.a);
#endif
    if (base.a < surface_alpha.y) discard;
    vec2 metal = surface_numbers.xy * texture(metal_picture, placeIn(1)).bg;
    s.roughness = metal.y;
    s.diffuse = base.rgb * (1.0 - metal.x);
    s.f0 = mix(surface_f0.rgb, base.rgb, metal.x);
    s.f90 = vec3(mix(surface_f0.a, 1.0, metal.x));
    s.emissive = surface_emissive * texture(emissive_picture, placeIn(3)).rgb;
    s.occlusion = mix(1.0, texture(occlusion_picture, placeIn(4)).r, surface_numbers.w);
    s.level = s.normal = vec3(0.0, 0.0, 1.0);
#if SLOPES > 0
    s.level = normalize(shape_normal);
    s.normal = s.level;
    if (surface_numbers.z != 0.0)
        s.normal = bentNormal(s.level, placeIn(2), 2.0 * texture(normal_picture, placeIn(2)).rgb - 1.0);
#endif
    return s;
}

// Returns the radiance of the surface under the surrounding light, without suns.
vec3 surfaceRadiance(Surface s, vec3 value) {
#if SLOPES > 0
    vec3 along = vec3(dot(term[0], s.normal), dot(term[1], s.normal), dot(term[2], s.normal));
    float cosine = clamp(dot(s.normal, s.level), -1.0, 1.0), angle = acos(cosine);
    // Light from above the vertex' horizon and below the picture's counts as 0 where the first two terms subtract it.
    vec3 below = max(value * (0.5 - 0.5 * cosine) - along * (angle / 3.14159265), 0.0);
    value = max(value * cosine + along + below, 0.0);
#endif
    vec3 sum = s.diffuse * value;
#if STEPS > 0
    if (surface_steps > 0) {
        int low = 0;
        while (low + 2 < surface_steps && s.roughness > surface_step_roughness[low + 1]) ++low;
        int high = min(low + 1, surface_steps - 1);
        float between = surface_step_roughness[high] - surface_step_roughness[low];
        float t = between > 0.0 ? clamp((s.roughness - surface_step_roughness[low]) / between, 0.0, 1.0) : 0.0;
        vec3 a = mix(term[SLOPES + 2 * low], term[SLOPES + 2 * high], t);
        vec3 b = mix(term[SLOPES + 2 * low + 1], term[SLOPES + 2 * high + 1], t);
        sum += s.f0 * a + s.f90 * b;
    }
#endif
    return sum * s.occlusion + s.emissive;
}
