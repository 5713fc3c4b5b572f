#pragma once
// The flags of materials and lights.
#include "formats/common/options.h"
#include "player/frame/render_options.h"
#include "sh/light/light_rotation.h"

namespace penumbra {

constexpr const char* kLookGroup = "Materials and light";

// How materials and lights are evaluated: render, bench and view have these.
inline void addShadingFlags(CLI::App& app, ShadingChoice& shading) {
    addChoice(app, "--light-form", shading.light_form, kLightFormWords,
              "how the light is turned into each vertex' frame: lobes (as fitted), fixed or rotation (both exact)")
        ->group(kLookGroup);
    addChoice(app, "--reflectance", shading.reflectance, kReflectanceWords,
              "what a material is evaluated from: slices, or the papers' operators")
        ->group(kLookGroup);
}

// Whether pictures are drawn: render, bench, composite and view have this.
inline void addTextureFlag(CLI::App& app, bool& textures) {
    textures = true;
    addChoice(app, "--textures", textures, kTextureWords,
              "whether pictures are drawn where the asset has them and no other material is chosen")
        ->group(kLookGroup);
}

// Which materials and which light of an asset: render and bench have these.
inline void addMaterialFlags(CLI::App& app, RenderOptions& options) {
    addTextureFlag(app, options.textures);
    app.add_option("--brdf", options.brdf,
                   "name of one material for all parts, or a beginning of it that no other has (default: what the "
                   "asset gives each)")
        ->group(kLookGroup);
    app.add_option("--slot", options.slots,
                   "SLOT=NAME: the material of a part of the mesh (penumbra-bake info lists the slots); any number")
        ->allow_extra_args(false)
        ->group(kLookGroup);
    app.add_option("--light", options.light,
                   "name of the light, or a beginning of it that no other has (default: the first)")
        ->group(kLookGroup);
}

// Whether suns shine past shadow maps: render and probe have these.
inline void addSunFlags(CLI::App& app, SunChoice& suns, int& sun_map) {
    addChoice(app, "--suns", suns, kSunWords,
              "whether the suns of a factored light cast shadows with edges (penumbra-fit light --factor)")
        ->group(kLookGroup);
    app.add_option("--sun-map", sun_map, "texels a side of a sun's shadow map")
        ->check(within(kSmallestSunMap, kLargestSunMap))
        ->group(kLookGroup);
}

inline void addLookFlags(CLI::App& app, RenderOptions& options) {
    addMaterialFlags(app, options);
    app.add_option("--parameter", options.parameters,
                   "MATERIAL=VALUE: the exponent or width of a live material, or of one over a range; any number")
        ->allow_extra_args(false)
        ->group(kLookGroup);
    app.add_option("--light-rotation", options.light_rotation,
                   "yaw=,pitch=,roll= or axis=X/Y/Z,angle= (degrees) that the light is turned by")
        ->check(readableBy(parseLightRotation))
        ->group(kLookGroup);
    addShadingFlags(app, options.shading);
    addSunFlags(app, options.suns, options.sun_map);
    addChoice(app, "--bounces", options.bounces, kBounceWords,
              "for an asset with light that bounces (penumbra-fit indirect): direct light, indirect light or both")
        ->group(kLookGroup);
    app.add_option("--exposure", options.exposure,
                   "factor on the colours of a shaded PNG (default: automatic and printed, one for the whole run: the "
                   "90th percentile of the luminance of the clips' first frame, in the truth if there is one, is "
                   "shown as 0.6)")
        ->check(aboveZero())
        ->group(kLookGroup);
}

}  // namespace penumbra
