// The light of suns on a surface, for the fragment shaders of surfaces that it falls on (SUNLIT; SUN_MIRRORS where some
// of it is a mirror, SUN_MEMBRANES where some is a membrane, SUN_LAMBERT where all lobes are Lambertian). sun_count is
// not 0, and every surface has lobes. brdf_glsl.h writes penumbra_brdf_lobe(), and sun.glsl has sunVisibility().
in vec3 surface_position;  // in the scene. sunFacing() needs its derivatives, which are wrong between centroids
INTERPOLATION in vec3 surface_normal, surface_tangent;  // in the scene; not unit
INTERPOLATION in float surface_sight;                   // V at the mirrored direction, for mirrors
flat in uint surface_lobes;                             // LobeTable::add()

uniform samplerBuffer lobes;  // 2 texels a lobe: its parameters; its colour and its model
uniform vec3 scene_eye;
uniform int sun_count;
uniform vec3 sun_direction[SUN_MAX_SUNS], sun_irradiance[SUN_MAX_SUNS];  // unit, towards the sun; at normal incidence
uniform float sun_cosine[SUN_MAX_SUNS];  // cosine of the radius; 1: a point, which no mirror shows
uniform mat3 light_from_scene;                     // for sky.glsl

// Where the maps are asked: at the centroid, because at an edge the middle of the pixel may lie beyond the triangle and
// below the next one. Software GL takes 1 / w of the pixel's middle there, which leaves the plane of the triangle by
// some centimetres; `face`, the unit normal of the triangle, leads back to it.
vec3 sunPoint(vec3 face) {
    vec3 aside = interpolateAtCentroid(surface_position) - surface_position;
    return surface_position + aside - face * dot(aside, face);
}

int lobeCount() { return int(surface_lobes >> 24 & 0x7fu); }

#ifdef SUN_LAMBERT
vec3 paintOfSurface() {
    int i = int(surface_lobes & 0xffffffu), end = i + lobeCount();
    vec3 sum = vec3(0.0);
    do sum += texelFetch(lobes, 2 * i + 1).rgb;
    while (++i < end);
    return sum;
}
#endif

vec3 brdfOfSurface(vec3 wi, vec3 wo) {
    int i = int(surface_lobes & 0xffffffu), end = i + lobeCount();
    vec3 sum = vec3(0.0);
    do {
        vec4 color = texelFetch(lobes, 2 * i + 1);
        sum += penumbra_brdf_lobe(int(color.w), texelFetch(lobes, 2 * i), color.rgb, wi, wo);
    } while (++i < end);
    return sum;
}

vec3 mirrorOfSurface(vec3 wo) {
    int i = int(surface_lobes & 0xffffffu), end = i + lobeCount();
    vec3 sum = vec3(0.0);
    do {
        vec4 color = texelFetch(lobes, 2 * i + 1);
        sum += penumbra_mirror_reflectance(int(color.w), texelFetch(lobes, 2 * i), color.rgb, wo);
    } while (++i < end);
    return sum;
}

// Returns the radiance that a mirror reflects from a direction of the scene: the sky as far as the body leaves it
// visible (Nowrouzezahrai 2011 eq. 21), and discs of suns, which the shadow maps hide.
vec3 mirrored(vec3 direction, vec3 face) {
    vec3 seen = clamp(surface_sight, 0.0, 1.0) * skyRadiance(light_from_scene * direction);
    int i = 0;
    do {
        if (sun_cosine[i] < 1.0 && dot(direction, sun_direction[i]) >= sun_cosine[i])
            seen += sunVisibility(i, sunPoint(face), face) * sun_irradiance[i] /
                    (3.14159265 * (1.0 - sun_cosine[i] * sun_cosine[i]));
    } while (++i < sun_count);
    return seen;
}

#ifdef SUN_MEMBRANES
// Returns the light of suns that falls on the other side of a membrane and comes through. kLetsThrough of
// player/frame/lobe_table.h marks a membrane, and an entry behind its lobes has tau.
vec3 sunlightThrough() {
    vec3 normal = -normalize(surface_normal), face = sunFacing(surface_position, normal), sum = vec3(0.0);
    if (surface_lobes >> 31 == 0u) return sum;
    int entry = int(surface_lobes & 0xffffffu) + lobeCount(), i = 0;
    bool open_back = texelFetch(lobes, 2 * entry).x > 0.0;
    do {
        float cosine = dot(normal, sun_direction[i]);
        if (cosine > 0.0)
            sum += (open_back ? 1.0 : sunVisibility(i, sunPoint(face), face)) * cosine * sun_irradiance[i];
    } while (++i < sun_count);
    return sum * texelFetch(lobes, 2 * entry + 1).rgb / 3.14159265;
}
#else
vec3 sunlightThrough() { return vec3(0.0); }
#endif

#ifdef SUN_LAMBERT
// All lobes are Lambertian.
vec3 sunlight() {
    vec3 normal = normalize(surface_normal), face = sunFacing(surface_position, normal), sum = vec3(0.0);
    int i = 0;
    do {
        float cosine = dot(normal, sun_direction[i]);
        if (cosine > 0.0) sum += sunVisibility(i, sunPoint(face), face) * cosine * sun_irradiance[i];
    } while (++i < sun_count);
    return sum * paintOfSurface() / 3.14159265 + sunlightThrough();
}
#else
// A surface that is seen from behind its normal sends back what it sends to the mirrored eye, as in penumbra_to_eye().
vec3 sunlight() {
    vec3 normal = normalize(surface_normal), to_eye = normalize(scene_eye - surface_position);
    vec3 face = sunFacing(surface_position, normal);
    vec3 tangent = normalize(surface_tangent - normal * dot(normal, surface_tangent));
    mat3 local_from_scene = transpose(mat3(tangent, cross(normal, tangent), normal));
    vec3 wo = local_from_scene * to_eye;
    wo.z = abs(wo.z);
    vec3 sum = sunlightThrough();
    int i = 0;
    do {
        vec3 wi = local_from_scene * sun_direction[i];
        float share = wi.z > 0.0 ? sunVisibility(i, sunPoint(face), face) : 0.0;
        if (share > 0.0) sum += share * wi.z * sun_irradiance[i] * brdfOfSurface(wi, wo);
    } while (++i < sun_count);
#ifdef SUN_MIRRORS
    vec3 share = mirrorOfSurface(wo);
    if (share != vec3(0.0)) sum += share * mirrored(transpose(local_from_scene) * vec3(-wo.xy, wo.z), face);
#endif
    return sum;
}
#endif

#ifdef TEXTURED
uniform mat4 scene_from_model;

// Returns the radiance of a surface with pictures under suns: the sum of D, A and B at the pixel's own normal and
// roughness.
vec3 sunlightOn(Surface s) {
    vec3 level = normalize(surface_normal), to_eye = normalize(scene_eye - surface_position);
    vec3 face = sunFacing(surface_position, level), normal = level;
#if SLOPES > 0
    normal = normalize(mat3(scene_from_model) * s.normal);
#endif
    vec3 tangent = normalize(surface_tangent - normal * dot(normal, surface_tangent));
    mat3 local_from_scene = transpose(mat3(tangent, cross(normal, tangent), normal));
    vec3 wo = local_from_scene * to_eye, sum = vec3(0.0);
    wo.z = max(abs(wo.z), 1e-3);
    vec4 dielectric = vec4(max(surface_f0.r, max(surface_f0.g, surface_f0.b)), surface_f0.a, 0.0, 0.0);
    int i = 0;
    do {
        vec3 wi = local_from_scene * sun_direction[i];
        bool lit = wi.z > 0.0 && dot(level, sun_direction[i]) > 0.0;
        float share = lit ? sunVisibility(i, sunPoint(face), face) : 0.0;
        if (share <= 0.0) continue;
        vec3 f = penumbra_brdf_lobe(PENUMBRA_PRINCIPLED_DIFFUSE, dielectric, s.diffuse, wi, wo);
        if (surface_steps > 0) {
            vec4 roughness = vec4(max(s.roughness, MIN_ROUGHNESS), 0.0, 0.0, 0.0);
            f += penumbra_brdf_lobe(PENUMBRA_GGX_F0, roughness, s.f0, wi, wo) +
                 penumbra_brdf_lobe(PENUMBRA_GGX_F90, roughness, s.f90, wi, wo);
        }
        sum += share * wi.z * sun_irradiance[i] * f;
    } while (++i < sun_count);
    return sum;
}
#endif
