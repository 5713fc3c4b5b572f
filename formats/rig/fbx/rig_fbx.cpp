// Reads FBX files through FBX2glTF, or through assimp where that one is not there or gets a file wrong and assimp does
// not. Which it gets wrong is told by a scan of the file (fbx_faults.h). A file that neither reads as it is, is refused
// with both reasons.
#include <algorithm>
#include <fstream>
#include <set>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/common/sha256.h"
#include "formats/common/temporary_folder.h"
#include "formats/rig/fbx/fbx_convert.h"
#include "formats/rig/fbx/fbx_faults.h"
#include "formats/rig/fbx/fbx_takes.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_import.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

std::string joinedFaults(const std::vector<std::string>& faults) {
    const std::string more = faults.size() == 1 ? "" : " (and " + std::to_string(faults.size() - 1) + " more)";
    return faults.front() + more;
}

void addNotes(std::vector<RigNote> notes, RigSource& source) {
    source.notes.insert(source.notes.end(), std::make_move_iterator(notes.begin()),
                        std::make_move_iterator(notes.end()));
}

// Returns the vertices of triangles that no bone moves.
std::vector<std::size_t> unweightedOf(const SourcePart& part) {
    std::vector<bool> used(part.positions.size());
    for (const Triangle& triangle : part.triangles)
        for (const std::uint32_t v : triangle) used[v] = true;
    const std::size_t k = std::size_t(part.influences);
    std::vector<std::size_t> list;
    for (std::size_t v = 0; v < used.size(); ++v) {
        double sum = 0;
        for (std::size_t i = v * k; i < (v + 1) * k; ++i) sum += part.weights[i];
        if (used[v] && !(sum > 1e-6)) list.push_back(v);
    }
    return list;
}

// In FBX files, what no bone moves stays with the node of its mesh, which becomes a joint for it.
void bindUnweighted(RigSource& source) {
    for (SourcePart& part : source.parts) {
        if (part.skin < 0 || part.influences == 0) continue;
        const std::vector<std::size_t> vertices = unweightedOf(part);
        if (vertices.empty()) continue;
        SourceSkin& skin = source.skins[std::size_t(part.skin)];
        const auto joint = std::uint32_t(skin.nodes.size());
        skin.nodes.push_back(part.node);
        skin.inverse_bind.push_back(kIdentityMatrix);
        for (const std::size_t v : vertices) {
            part.joints[v * std::size_t(part.influences)] = joint;
            part.weights[v * std::size_t(part.influences)] = 1;
        }
        source.notes.push_back({source.file.string(), source.nodes[std::size_t(part.node)].name,
                                std::to_string(vertices.size()) + " vertices without a bone", "move with the node"});
    }
}

// --- FBX2glTF -------------------------------------------------------------------------------------------------------

// Returns the take of each clip that the converter printed: of several with one name the first, the second, ...
std::vector<int> takesOf(const FbxScan& scan, const std::vector<FbxConvertedClip>& clips) {
    std::set<int> used;
    std::vector<int> takes;
    for (const FbxConvertedClip& clip : clips) {
        int found = -1;
        for (int take = 0; take < int(scan.takes.size()) && found < 0; ++take)
            if (scan.takes[std::size_t(take)].name == clip.name && used.insert(take).second) found = take;
        takes.push_back(found);
    }
    return takes;
}

// Cuts the clips to what their takes show. The converter leaves out clips in which nothing moves.
void cutToTakes(const FbxScan& scan, const FbxConversion& conversion, RigSource& source) {
    const std::vector<int> takes = takesOf(scan, conversion.clips);
    std::size_t printed = 0;
    for (std::size_t c = 0; c < source.clips.size(); ++c) {
        const auto isThis = [&](const FbxConvertedClip& clip) { return clip.name == source.clips[c].name; };
        const auto found =
            std::find_if(conversion.clips.begin() + std::ptrdiff_t(printed), conversion.clips.end(), isThis);
        if (found == conversion.clips.end()) continue;
        printed = std::size_t(found - conversion.clips.begin());
        const int take = takes[printed++];
        const std::optional<FbxSpan> span = take < 0 ? std::nullopt : spanOfClip(scan, take);
        if (!span) continue;
        const double first = std::max(span->first - found->first, 0.0),
                     last = std::min(span->last, found->last) - found->first;
        constexpr double kSameTime = 1e-4;  // seconds
        if (last <= first || (first < kSameTime && last > source.clips[c].duration - kSameTime)) continue;
        cutClip(source, c, first, last);
    }
}

// Reads the converter's .glb as if it were the file.
RigSource readConverted(const FbxScan& scan, const FbxConversion& conversion) {
    const TemporaryFolder folder;
    const fs::path glb = folder.path() / "converted.glb";
    std::ofstream out(glb, std::ios::binary);
    out.write(reinterpret_cast<const char*>(conversion.glb.data()), std::streamsize(conversion.glb.size()));
    out.close();
    if (!out) throw IoError(glb.string() + ": cannot be written");
    const auto named = [&](std::string text) {
        const std::size_t at = text.find(glb.string());
        return at == std::string::npos ? text : text.replace(at, glb.string().size(), scan.file.string());
    };
    RigSource source = readGltf(glb);
    source.file = scan.file;
    for (RigNote& note : source.notes) note.file = named(note.file);
    for (SourcePart& part : source.parts) part.color.material.problem = named(part.color.material.problem);
    return source;
}

// Puts the pictures that the converter did not find, most of them named by a path of another system, back where the
// file says. The converter also did not see what is transparent in them.
void restorePictures(const FbxScan& scan, const FbxConversion& conversion, RigSource& source) {
    for (const std::string& name : conversion.missing_pictures) {
        source.notes.push_back({scan.file.string(), "", "picture of texture '" + name + "'",
                                "was not found by FBX2glTF, what is transparent in it is solid"});
        const auto isThis = [&](const FbxTexture& texture) { return texture.name == name; };
        const auto found = std::find_if(scan.textures.begin(), scan.textures.end(), isThis);
        for (SourcePart& part : source.parts) {
            MaterialColor& color = part.color.material;
            constexpr std::size_t kOnePixel = 100;  // bytes
            if (found == scan.textures.end() || !color.texture || color.texture->bytes.size() > kOnePixel ||
                !color.texture->name.ends_with("'" + name + "'"))
                continue;
            color.texture = std::make_shared<const Texture>(
                Texture{"texture '" + name + "': picture '" + cleanText(found->file) + "'",
                        findPicture(scan.file, found->file),
                        {}});
        }
    }
}

// Returns nothing and why where the converter does not come through.
std::optional<RigSource> readWithConverter(const fs::path& converter, const FbxScan& scan, std::string& problem) {
    FbxConversion conversion = convertFbx(converter, scan);
    problem = conversion.problem;
    if (!problem.empty()) return std::nullopt;
    RigSource source;
    try {
        source = readConverted(scan, conversion);
    } catch (const InvalidInput& error) {
        problem = std::string("its .glb is refused: ") + error.what();
        return std::nullopt;
    }
    if (source.parts.empty() && hasVisibleMesh(scan)) {
        problem = "its .glb draws no mesh, and the file has one that is shown";
        return std::nullopt;
    }
    cutToTakes(scan, conversion, source);
    restorePictures(scan, conversion, source);
    addNotes(converterNotes(scan), source);
    if (conversion.lost_old_clips)
        source.notes.push_back({scan.file.string(), "", "keys", "of which FBX2glTF made no clip"});
    source.files_read = {scan.file, converter};
    source.log = {scan.file.string() + ": read by " + converter.string() + " (" +
                  sha256OfFile(converter).substr(0, 12) + "), " + textOf(conversion.confinement)};
    source.converted = std::make_shared<const std::vector<std::byte>>(std::move(conversion.glb));
    return source;
}

// --- assimp ---------------------------------------------------------------------------------------------------------

// assimp shows hidden nodes. Their names are no other node's (assimpFaults()).
void dropHidden(const FbxScan& scan, RigSource& source) {
    std::set<std::string> hidden;
    for (const FbxModel& model : scan.models)
        if (model.hidden) hidden.insert(model.name);
    std::erase_if(source.parts,
                  [&](const SourcePart& part) { return hidden.contains(source.nodes[std::size_t(part.node)].name); });
}

// assimp counts all times in ticks of FBX 2019 and before.
void mendTimes(const FbxScan& scan, RigSource& source) {
    if (!scan.other_ticks) return;
    const double factor = scan.seconds_a_tick * 46186158000.0;
    for (Clip& clip : source.clips) {
        clip.duration *= factor;
        for (Channel& channel : clip.channels)
            for (double& time : channel.times) time *= factor;
    }
}

RigSource readScannedWithAssimp(const FbxScan& scan) {
    RigSource source = readWithAssimp(scan.file);
    dropHidden(scan, source);
    mendTimes(scan, source);
    return source;
}

[[noreturn]] void refuse(const FbxScan& scan, const std::string& converter_problem, const std::string& assimp_fault) {
    if (converter_problem.empty())
        throw Unsupported(
            scan.file.string() + ": assimp reads it wrong (" + assimp_fault +
            "), and FBX2glTF is not there: `scripts/setup --fbx` installs it, or PENUMBRA_FBX2GLTF names it");
    throw Unsupported(scan.file.string() + ": FBX2glTF: " + converter_problem + "; assimp: " + assimp_fault);
}

}  // namespace

RigSource readFbx(const fs::path& path) {
    checkReadable(path);
    std::error_code unknown;
    if (fs::file_size(path, unknown) == 0 && !unknown) failAtFile(path, "is empty");
    const FbxScan scan = scanFbx(path);
    const std::vector<std::string> of_assimp = assimpFaults(scan), of_converter = converterFaults(scan);
    const std::optional<fs::path> converter = findConverter();
    std::string problem;
    if (!of_converter.empty()) problem = joinedFaults(of_converter);
    std::optional<RigSource> source;
    const bool assimp_is_better = of_assimp.empty() && (!cutWeights(scan).empty() || hasOtherRate(scan));
    if (converter && problem.empty() && !assimp_is_better) source = readWithConverter(*converter, scan, problem);
    if (!source) {
        if (!of_assimp.empty()) refuse(scan, problem, joinedFaults(of_assimp));
        try {
            source = readScannedWithAssimp(scan);
        } catch (const InvalidInput& error) {
            if (problem.empty()) throw;
            refuse(scan, problem, error.what());
        }
    }
    addNotes(fbxNotes(scan), *source);
    bindUnweighted(*source);
    return std::move(*source);
}

}  // namespace penumbra
