// penumbra-pack embed X.pnb RIG.glb -o Y.glb: the asset inside of the character's file, for a loader that knows it.
// Other programs read Y.glb as they read RIG.glb.
#include <algorithm>
#include <cstdio>
#include <set>

#include "formats/asset/asset_file.h"
#include "formats/asset/mapped_file.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"
#include "formats/rig/growing_glb.h"
#include "formats/rig/rig_build.h"
#include "pack/pack_verbs.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = "PENUMBRA_visibility";

struct EmbedCommand {
    fs::path asset, rig, output;

    std::vector<fs::path> inputs() const { return {asset, rig}; }
};

// Throws InvalidInput where the file has no node for a joint that the page must pose.
void checkJoints(const AssetView& asset, const GrowingGlb& glb) {
    if (!asset.has_model || asset.model.deforming) return;
    std::set<std::string> names;
    if (const auto nodes = glb.document.find("nodes"); nodes != glb.document.end())
        for (const auto& node : *nodes) names.insert(node.value("name", ""));
    std::set<std::int32_t> inputs;
    for (const InputJointView& input : asset.model.input_joints) inputs.insert(input.joint);
    for (std::size_t j = 0; j < asset.animation.joint_names.size(); ++j)
        if (!inputs.contains(std::int32_t(j)) && !names.contains(std::string(asset.animation.joint_names[j])))
            throw InvalidInput(glb.path.string() + ": has no node '" + std::string(asset.animation.joint_names[j]) +
                               "', which is a joint of the asset: it is another character");
}

void addExtension(GrowingGlb& glb, std::span<const std::byte> bytes) {
    auto& extensions = glb.document["extensions"];
    if (extensions.contains(kExtension))
        throw InvalidInput(glb.path.string() + ": has an asset inside already; give the file as it was before");
    extensions[kExtension] = {{"bufferView", addBytes(glb, bytes)}};
    glb.document["extensionsUsed"].push_back(kExtension);
}

void runEmbed(EmbedCommand& command, const CommonOptions& common, Report& report) {
    if (!isExtension(command.output, ".glb"))
        throw UsageError("--output must end in .glb, not " + command.output.string());
    const MappedFile file(command.asset);
    const AssetView asset = openAsset(file.bytes(), command.asset.string());
    GrowingGlb glb = openGrowingGlb(command.rig);
    for (const std::string& note : glb.notes) reportWarning("penumbra-pack", note);
    checkJoints(asset, glb);
    try {
        addExtension(glb, file.bytes());
    } catch (const nlohmann::json::exception& error) {
        throw InvalidInput(command.rig.string() + ": is not valid glTF: " + error.what());
    }
    const std::vector<std::byte> bytes = bytesOf(glb);
    report.figures["asset_bytes"] = file.bytes().size();
    report.figures["bytes"] = bytes.size();
    if (!common.quiet)
        std::printf("%s: %.1f kB, of which %.1f kB are the asset\n", command.output.c_str(),
                    double(bytes.size()) * 1e-3, double(file.bytes().size()) * 1e-3);
    if (!common.dry_run) writeWholeFile(command.output, bytes);
}

void defineEmbed(CLI::App& app, EmbedCommand& command) {
    app.add_option("asset", command.asset, "X.pnb")->required();
    app.add_option("rig", command.rig, "RIG.glb of the character")->required();
    app.add_option("-o,--output", command.output, "Y.glb")->required();
}

}  // namespace

Verb embedVerb() {
    return verbOf<EmbedCommand>("embed", "Put an asset into the .glb of its character, for pages.", defineEmbed,
                                runEmbed);
}

}  // namespace penumbra
