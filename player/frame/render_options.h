#pragma once
// RenderOptions tells what a picture shows and how large it is; the defaults stand here. player/look_flags.h and
// player/picture_flags.h define the flags that set these values.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/image/tone_map.h"
#include "player/frame/channel.h"
#include "player/gl/gl_context.h"
#include "runtime/shade/indirect_light.h"
#include "runtime/shade/shading.h"
#include "runtime/sun/sun_frame.h"
#include "sh/vec3.h"

namespace penumbra {

enum class VisibilitySource {
    kModel,
    kTruth,  // baked moments, shaded in the same way, so that only the regression differs
};

// Tells whether the suns of the light shine as such, with shadow maps, beside a soft remainder (docs/formulas.md,
// section 11). Otherwise all of the light is SH.
enum class SunChoice {
    kAuto,  // where the light has suns and all materials have lobes
    kOn,
    kOff,
};

enum class EvaluationPath {
    kCpu,   // runtime evaluates, GL draws vertex colours: the faster one in software
    kGlsl,  // a compute shader evaluates from the asset's arrays
};

struct RenderOptions {
    std::string clip;  // "" = the first one
    int frame = 0;     // index in the clip, 0 = its first sampled frame
    // Names in the asset, or beginnings of one name. brdf: of every part, or "" for what the asset gives each part.
    // slots: SLOT=NAME (formats/common/slot_choice.h), applied after brdf. light: "" is the first one.
    std::string brdf, light;
    std::vector<std::string> slots;
    std::vector<std::string> parameters;  // MATERIAL=VALUE of live and stepped materials
    ShadingChoice shading;
    bool textures = false;  // pictures of an asset that has them are drawn, where `brdf` names no other material
    SunChoice suns = SunChoice::kAuto;
    Bounces bounces = Bounces::kBoth;  // for an asset that has light that bounces
    int sun_map = kSunMapSize;         // texels a side of a sun's shadow map
    std::string light_rotation;        // sh/light/light_rotation.h
    int width = 512, height = 512;     // pixels, 1..16384
    std::string camera;                // sh/camera.h
    Channel channel = Channel::kShaded;
    VisibilitySource source = VisibilitySource::kModel;
    std::optional<EvaluationPath> path;  // unset: cpu on software GL, glsl on a GPU
    GlBackend backend = GlBackend::kAuto;
    std::optional<float> exposure;    // factor on the colours of a shaded PNG, > 0; unset: automaticExposure()
    ToneMap tone = ToneMap::kOff;     // for a shaded PNG
    std::optional<Vec3> background;   // linear; unset: transparent
    bool light_background = false;    // shows the light as background instead; only for shaded pictures
    int samples = 4;                  // a pixel, 1, 2, 4 or 8
    float error_max = 0.25f;          // the error that gets the brightest colour, > 0
    std::optional<std::size_t> lobe;  // a vertex of the asset whose visibility is drawn as a lobe
    std::string lobe_of = "whole";    // parseFactor()
    // The parts of a composed asset whose boxes of fields are drawn: joints, or beginnings of their names, or "all".
    std::vector<std::string> boxes;
};

inline constexpr Word<VisibilitySource> kSourceWords[] = {{"model", VisibilitySource::kModel},
                                                          {"truth", VisibilitySource::kTruth}};
inline constexpr Word<std::optional<EvaluationPath>> kPathWords[] = {
    {"auto", {}}, {"cpu", EvaluationPath::kCpu}, {"glsl", EvaluationPath::kGlsl}};
inline constexpr Word<int> kSampleWords[] = {{"1", 1}, {"2", 2}, {"4", 4}, {"8", 8}};
inline constexpr Word<bool> kTextureWords[] = {{"on", true}, {"off", false}};
inline constexpr Word<SunChoice> kSunWords[] = {
    {"auto", SunChoice::kAuto}, {"on", SunChoice::kOn}, {"off", SunChoice::kOff}};
inline constexpr Word<Bounces> kBounceWords[] = {
    {"both", Bounces::kBoth}, {"direct", Bounces::kDirect}, {"indirect", Bounces::kIndirect}};
inline constexpr Word<Reflectance> kReflectanceWords[] = {{"slices", Reflectance::kSlices},
                                                          {"operators", Reflectance::kOperators}};
inline constexpr Word<LightForm> kLightFormWords[] = {{"lobes", LightForm::kLobes},
                                                      {"fixed", LightForm::kFixed},
                                                      {"rotation", LightForm::kRotation},
                                                      {"auto", ShadingChoice().light_form}};
constexpr std::string_view nameOf(Reflectance reflectance) { return wordOf(kReflectanceWords, reflectance); }
constexpr std::string_view nameOf(LightForm form) { return wordOf(kLightFormWords, form); }

}  // namespace penumbra
