#include "player/frame/shot.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/common/find_by_name.h"
#include "formats/common/slot_choice.h"
#include "player/frame/truth_frames.h"
#include "player/papers/transfer/transfer_model.h"
#include "runtime/shade/material_tables.h"
#include "sh/key_values.h"
#include "sh/light/light_rotation.h"

namespace penumbra {

namespace {

template <class T>
void checkSome(const AssetView& asset, const std::vector<T>& list, const std::string& what) {
    if (list.empty()) throw InvalidInput(asset.name + ": holds no " + what + "; penumbra-pack asset takes one");
}

const ClipView* findClip(const AnimationView& animation, std::string_view name) {
    for (const ClipView& clip : animation.clips)
        if (clip.name == name) return &clip;
    return nullptr;
}

// Returns the truth's frame of the same clip and number. Its time must be the same too.
std::size_t truthFrame(const AssetView& asset, const AssetView& truth, const ClipView& clip, std::size_t number) {
    const ClipView* baked = findClip(truth.animation, clip.name);
    if (!baked) throw InvalidInput(truth.name + ": has no clip \"" + std::string(clip.name) + "\"");
    if (number >= baked->frame_count)
        throw InvalidInput(truth.name + ": has " + std::to_string(baked->frame_count) + " frames of clip \"" +
                           std::string(clip.name) + "\", so none of number " + std::to_string(number));
    const std::size_t frame = baked->first_frame + number;
    const double expected = asset.animation.times[clip.first_frame + number], time = truth.animation.times[frame];
    if (std::abs(time - expected) > 1e-6)
        throw InvalidInput(truth.name + ": frame " + std::to_string(number) + " is at " + std::to_string(time) +
                           " s and the asset's at " + std::to_string(expected) + " s: they were sampled differently");
    return frame;
}

// Applies "SLOT=NAME".
void assignMaterial(const AssetView& asset, const std::string& text, Shot& shot) {
    const SlotChoice choice = parseSlotChoice(text);
    if (asset.mesh.slots.empty()) throw BadOption("slot", "the asset's mesh is one part without a name");
    for (const std::size_t slot : findSlots(asset.mesh.slots, choice.slot))
        shot.material_of_slot[slot] = findByName(asset.materials, choice.material, "slot");
}

// Applies "MATERIAL=VALUE". The name of a material may have a '=' itself.
void setParameter(const AssetView& asset, const std::string& text, Shot& shot) {
    const std::size_t at = text.rfind('=');
    if (at == text.npos || at == 0 || at + 1 == text.size())
        throw BadOption("parameter", "must be MATERIAL=VALUE, not \"" + text + "\"");
    const std::size_t material = findByName(asset.materials, text.substr(0, at), "parameter");
    const std::string name = "the asset's material \"" + std::string(asset.materials[material].name) + "\"";
    const std::optional<ChangingParameter> range = changingParameter(asset.materials[material]);
    if (!range)
        throw BadOption("parameter",
                        name + " has none that changes; penumbra-fit brdf makes live ones, and those over a range");
    if (std::ranges::find(shot.material_of_slot, material) == shot.material_of_slot.end())
        throw BadOption("parameter", name + " is not drawn");
    try {
        shot.parameters.emplace_back(material,
                                     parseNumber(range->name, text.substr(at + 1), range->least, range->most));
    } catch (const std::invalid_argument& error) {
        throw BadOption("parameter", name + ": " + error.what());
    }
}

bool wantsSuns(SunChoice choice, const AssetView& asset, const Shot& shot) {
    if (choice == SunChoice::kOff) return false;
    std::string lacking;
    const LightView& light = asset.lights[shot.light];
    if (light.suns.empty())
        lacking = "the light \"" + std::string(light.name) +
                  "\" has none; penumbra-fit light finds them where it factors the light";
    if (shot.shading.light_form != LightForm::kRotation) lacking = "they need the light form rotation";
    if (!hasVisibility(asset)) lacking = "linear transfer takes all of the light as SH";
    if (!lacking.empty() && choice == SunChoice::kOn) throw BadOption("suns", lacking);
    return lacking.empty();
}

void requireIndirect(const AssetView& asset, const std::string& option) {
    if (!asset.model.indirect)
        throw BadOption(option, asset.name + " has no light that bounces (penumbra-fit indirect)");
}

void resolveShading(const RenderOptions& options, const AssetView& asset, Shot& shot) {
    checkSome(asset, asset.materials, "brdf");
    checkSome(asset, asset.lights, "light");
    shot.shaded = true;
    shot.shading = options.shading;
    shot.material_of_slot.assign(asset.slot_material.begin(), asset.slot_material.end());
    shot.material_of_slot.resize(std::max<std::size_t>(1, asset.mesh.slots.size()));
    if (!options.brdf.empty())
        std::fill(shot.material_of_slot.begin(), shot.material_of_slot.end(),
                  findByName(asset.materials, options.brdf, "brdf"));
    shot.surface = options.textures && asset.surface && options.brdf.empty() &&
                   options.shading.reflectance == Reflectance::kSlices;
    for (const std::string& assignment : options.slots) assignMaterial(asset, assignment, shot);
    for (const std::string& assignment : options.parameters) setParameter(asset, assignment, shot);
    shot.light = findByName(asset.lights, options.light, "light");
    requireDiffuse(asset, shot.shading, shot.material_of_slot);
    for (const std::size_t material : shot.material_of_slot)
        if (!hasReflectance(asset.materials[material], shot.shading.reflectance))
            throw BadOption("reflectance", "the asset's material \"" + std::string(asset.materials[material].name) +
                                               "\" has no operators; penumbra-fit brdf makes them");
    if (!hasForm(asset.lights[shot.light], shot.shading.light_form))
        throw BadOption("light_form", "the asset's light \"" + std::string(asset.lights[shot.light].name) +
                                          "\" has no lobes; penumbra-fit light makes them");
    shot.bounces = options.bounces;
    if (shot.bounces == Bounces::kIndirect) requireIndirect(asset, "bounces");
    // The whole light bounces, so that pictures of indirect light alone have no suns as such.
    shot.suns = shot.bounces != Bounces::kIndirect && wantsSuns(options.suns, asset, shot);
    try {
        const Mat3d rotation = parseLightRotation(options.light_rotation);
        for (std::size_t i = 0; i < 9; ++i) shot.light_rotation.m[i] = float(rotation.m[i]);
    } catch (const std::invalid_argument& error) {
        throw BadOption("light_rotation", error.what());
    }
}

void checkComposed(const AssetView& asset, const std::string& option) {
    if (!asset.model.composition)
        throw BadOption(option, asset.name + " is not composed (penumbra-fit visibility makes composed models)");
}

void resolveOverlays(const RenderOptions& options, const AssetView& asset, Shot& shot) {
    shot.lobe = options.lobe;
    const std::size_t vertices = asset.mesh.positions.size();
    if (shot.lobe && *shot.lobe >= vertices)
        throw BadOption("lobe",
                        "must be a vertex, 0.." + std::to_string(vertices - 1) + ", not " + std::to_string(*shot.lobe));
    if (shot.lobe) shot.lobe_of = parseFactor(asset, options.lobe_of);
    if (shot.lobe_of != FactorChoice() && options.source == VisibilitySource::kTruth)
        throw BadOption("lobe_of", "the truth is known as a whole alone, without " + options.lobe_of);
    if (!options.boxes.empty()) checkComposed(asset, "boxes");
    for (const std::string& word : options.boxes)
        if (word == "all")
            for (std::size_t p = 0; p < asset.model.composition->parts.size(); ++p) shot.boxes.push_back(p);
        else
            shot.boxes.push_back(findPart(asset, word, "boxes"));
}

}  // namespace

void requireFrames(const AssetView& asset) {
    if (asset.model.deforming && asset.animation.frameCount() > 0 && asset.animation.playback.positions.empty())
        throw Unsupported(asset.name +
                          ": its frames were left out (penumbra-pack asset): nothing says where its vertices are");
}

Shot resolveLook(const RenderOptions& options, const AssetView& asset, const AssetView* truth) {
    if (!asset.has_mesh || !asset.hasCharacter())
        throw InvalidInput(asset.name + ": holds no model; make one with penumbra-pack asset");
    const bool needs_truth = needsTruth(options.channel) || options.source == VisibilitySource::kTruth;
    if (needs_truth && !truth)
        throw BadOption("truth",
                        "the channels error and transfer-error and the source truth need X.truth.pnb of "
                        "penumbra-pack truth");
    Shot shot;
    shot.asset = &asset;
    checkSome(asset, asset.animation.clips, "clip");
    requireFrames(asset);
    if (truth) checkTruth(asset, *truth);
    shot.truth = truth;
    if (options.channel == Channel::kShaded) resolveShading(options, asset, shot);
    if (options.channel == Channel::kParts) checkComposed(asset, "channel");
    if (options.channel == Channel::kBouncedAmbient) requireIndirect(asset, "channel");
    if (options.channel == Channel::kTransferError && transferErrorOrder(asset, *truth) < 1)
        throw InvalidInput(truth->name + ": SH order 1 is too low for E_transfer");
    refuseForTransfer(asset, {.clusters = options.channel == Channel::kClusters,
                              .lobe = options.lobe.has_value(),
                              .gpu = options.path == EvaluationPath::kGlsl});
    resolveOverlays(options, asset, shot);
    return shot;
}

Shot resolveShot(const RenderOptions& options, const AssetView& asset, const AssetView* truth) {
    Shot shot = resolveLook(options, asset, truth);
    const ClipView& clip = asset.animation.clips[findByName(asset.animation.clips, options.clip, "clip")];
    if (std::size_t(options.frame) >= clip.frame_count)
        throw BadOption("frame", "must be 0.." + std::to_string(clip.frame_count - 1) + " for clip \"" +
                                     std::string(clip.name) + "\", not " + std::to_string(options.frame));
    shot.frame = clip.first_frame + std::size_t(options.frame);
    if (truth) shot.truth_frame = truthFrame(asset, *truth, clip, std::size_t(options.frame));
    return shot;
}

ShadingSet shadingOf(const Shot& shot) {
    ShadingSet set(*shot.asset, shot.shading);
    for (std::size_t slot = 0; slot < shot.material_of_slot.size(); ++slot)
        set.setMaterial(slot, shot.material_of_slot[slot]);
    for (const auto& [material, value] : shot.parameters) set.setParameter(material, value);
    set.setLight(shot.light);
    set.setSuns(shot.suns);
    set.setBounces(shot.bounces);
    if (shot.surface) set.showSurface();
    set.setLightRotation(shot.light_rotation);
    return set;
}

}  // namespace penumbra
