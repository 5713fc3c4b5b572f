#include "formats/rig/fbx/fbx_convert.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "formats/common/child_process.h"
#include "formats/common/errors.h"
#include "formats/common/find_program.h"
#include "formats/common/json_depth.h"
#include "formats/common/temporary_folder.h"
#include "formats/rig/fbx/fbx_faults.h"
#include "formats/rig/fbx/fbx_takes.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_import.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

constexpr const char* kProgram = "FBX2glTF";

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

}  // namespace

std::optional<fs::path> findConverter() {
    if (const std::string named = environment("PENUMBRA_FBX2GLTF"); !named.empty()) {
        if (named == "off") return std::nullopt;
        if (!isProgram(named)) throw IoError("PENUMBRA_FBX2GLTF: '" + named + "' is not a program");
        return fs::absolute(named);
    }
    std::vector<fs::path> folders = foldersOfPath();
    if (const std::string data = environment("XDG_DATA_HOME"); !data.empty())
        folders.push_back(fs::path(data) / "penumbra");
    else if (const std::string home = environment("HOME"); !home.empty())
        folders.push_back(fs::path(home) / ".local/share/penumbra");
    return findProgram(kProgram, folders);
}

namespace {

// --- What the converter prints --------------------------------------------------------------------------------------

// Reads the lines "Animation NAME: [FIRST - LAST]", which count frames.
std::vector<FbxConvertedClip> clipsOf(const std::string& output, int frames_a_second) {
    constexpr std::string_view kBegin = "Animation ";
    std::vector<FbxConvertedClip> clips;
    for (std::size_t at = 0; at < output.size();) {
        const std::size_t end = std::min(output.find('\n', at), output.size());
        const std::string line = output.substr(at, end - at);
        at = end + 1;
        const std::size_t bracket = line.rfind(": [");
        unsigned long long first = 0, last = 0;
        if (!line.starts_with(kBegin) || bracket == std::string::npos ||
            std::sscanf(line.c_str() + bracket, ": [%llu - %llu]", &first, &last) != 2 || bracket < kBegin.size())
            continue;
        // a clip without keys on x has frames -1 to -1; keys before 0 s count as that, too
        const auto seconds = [&](unsigned long long frame) { return double((long long)(frame)) / frames_a_second; };
        clips.push_back(
            {cleanText(line.substr(kBegin.size(), bracket - kBegin.size())), seconds(first), seconds(last)});
    }
    return clips;
}

// Reads the lines "Warning: could not find a image file for texture: NAME."
std::vector<std::string> missingPictures(const std::string& output) {
    constexpr std::string_view kBegin = "Warning: could not find a image file for texture: ";
    std::vector<std::string> names;
    for (std::size_t at = output.find(kBegin); at != std::string::npos; at = output.find(kBegin, at)) {
        at += kBegin.size();
        const std::size_t end = std::min(output.find('\n', at), output.size());
        names.push_back(cleanText(output.substr(at, end > at ? end - at - 1 : 0)));
    }
    return names;
}

// Returns the last line that the converter printed, for messages.
std::string lastLine(const std::string& output) {
    const std::size_t end = output.find_last_not_of(" \r\n");
    if (end == std::string::npos) return "";
    const std::size_t first = output.rfind('\n', end);
    return ": " +
           cleanText(output.substr(first == std::string::npos ? 0 : first + 1, end - (first + 1) + 1).substr(0, 160));
}

// --- What it writes -------------------------------------------------------------------------------------------------

std::uint32_t wordAt(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    return word;
}

struct FbxGlb {
    nlohmann::json document;
    std::span<std::byte> binary;
};

// Takes a .glb apart. Returns what is wrong with it, "" if nothing is.
std::string openResult(std::span<std::byte> glb, FbxGlb& out) {
    constexpr std::size_t kHeader = 12, kChunkHeader = 8;
    if (glb.size() < kHeader + kChunkHeader || std::memcmp(glb.data(), "glTF", 4) != 0 || wordAt(glb, 8) != glb.size())
        return "its .glb is not whole";
    const std::size_t json_size = wordAt(glb, kHeader), json_at = kHeader + kChunkHeader;
    if (json_size > glb.size() - json_at) return "its .glb is not whole";
    const std::string_view text(reinterpret_cast<const char*>(glb.data()) + json_at, json_size);
    if (nestedTooDeep(text)) return "its .glb has JSON that is nested too deeply";
    out.document = nlohmann::json::parse(text, nullptr, false);
    if (!out.document.is_object()) return "its .glb has damaged JSON";
    const std::size_t binary_at = json_at + json_size;
    if (glb.size() - binary_at < kChunkHeader) return "";
    const std::size_t binary_size = wordAt(glb, binary_at);
    if (binary_size > glb.size() - binary_at - kChunkHeader) return "its .glb is not whole";
    out.binary = glb.subspan(binary_at + kChunkHeader, binary_size);
    return "";
}

std::size_t numberIn(const nlohmann::json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_number_unsigned() ? found->get<std::size_t>() : 0;
}

// Returns entry `index` of a list of the document, or null.
const nlohmann::json* entryOf(const nlohmann::json& document, const char* list, std::size_t index) {
    const auto found = document.find(list);
    return found != document.end() && found->is_array() && index < found->size() && (*found)[index].is_object()
               ? &(*found)[index]
               : nullptr;
}

// Writes 0 over the weights of vertices that no bone moves, which the converter divides by 0.
void mendWeights(FbxGlb& glb, std::size_t accessor_index) {
    const nlohmann::json* accessor = entryOf(glb.document, "accessors", accessor_index);
    const nlohmann::json* view =
        accessor ? entryOf(glb.document, "bufferViews", numberIn(*accessor, "bufferView")) : nullptr;
    if (!view || numberIn(*view, "byteStride") != 0) return;
    const std::size_t first = numberIn(*view, "byteOffset"), size = numberIn(*view, "byteLength");
    if (first > glb.binary.size() || size > glb.binary.size() - first) return;
    for (std::size_t at = first; at + sizeof(float) <= first + size; at += sizeof(float)) {
        float weight = 0;
        std::memcpy(&weight, glb.binary.data() + at, sizeof weight);
        if (!std::isnan(weight)) continue;
        weight = 0;
        std::memcpy(glb.binary.data() + at, &weight, sizeof weight);
    }
}

// Goes through the meshes, mends their weights and tells whether there is one.
bool mendMeshes(FbxGlb& glb) {
    bool any = false;
    for (std::size_t m = 0; const nlohmann::json* mesh = entryOf(glb.document, "meshes", m); ++m)
        for (std::size_t p = 0; const nlohmann::json* primitive = entryOf(*mesh, "primitives", p); ++p) {
            any = true;
            const auto attributes = primitive->find("attributes");
            if (attributes != primitive->end() && attributes->is_object() && attributes->contains("WEIGHTS_0"))
                mendWeights(glb, numberIn(*attributes, "WEIGHTS_0"));
        }
    return any;
}

bool hasClip(const FbxGlb& glb, const std::string& name) {
    for (std::size_t a = 0; const nlohmann::json* clip = entryOf(glb.document, "animations", a); ++a) {
        const auto found = clip->find("name");
        if (found != clip->end() && found->is_string() && cleanText(found->get<std::string>()) == name) return true;
    }
    return false;
}

std::string checkResult(const FbxScan& scan, FbxConversion& conversion) {
    FbxGlb glb;
    if (std::string problem = openResult(conversion.glb, glb); !problem.empty()) return problem;
    conversion.lost_old_clips = scan.old_clips && entryOf(glb.document, "animations", 0) == nullptr;
    if (!mendMeshes(glb) && hasVisibleMesh(scan)) return "its .glb has no mesh, and the file has one that is shown";
    if (hasVisibleSkin(scan) && entryOf(glb.document, "skins", 0) == nullptr)
        return "its .glb has no skin, and the file has one";
    for (int take = 0; take < int(scan.takes.size()); ++take)
        if (hasKeys(scan, take) && !hasClip(glb, scan.takes[std::size_t(take)].name))
            return "its .glb lacks the clip '" + scan.takes[std::size_t(take)].name + "'";
    return "";
}

std::vector<std::byte> bytesOfFile(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto* first = reinterpret_cast<const std::byte*>(text.data());
    return {first, first + text.size()};
}

ChildLimits limitsFor(const fs::path& file) {
    std::error_code unknown;
    const std::uintmax_t size = fs::file_size(file, unknown);
    ChildLimits limits = importLimits(unknown ? 0 : size);
    limits.seconds = 30 + 5e-7 * double(unknown ? 0 : size);
    return limits;
}

}  // namespace

FbxConversion convertFbx(const fs::path& converter, const FbxScan& scan) {
    const TemporaryFolder folder;
    const std::string rate = "bake" + std::to_string(framesASecond(scan));
    FbxConversion conversion;
    try {
        const fs::path input = fs::absolute(scan.file);  // beside which it looks for pictures
        const ProgramResult result =
            runProgram({{converter.string(), "-b", "--anim-framerate", rate, "--fbx-temp-dir", folder.path().string(),
                         "-i", input.string(), "-o", (folder.path() / "out").string()},
                        folder.path(),
                        limitsFor(input),
                        input.parent_path()});
        conversion.confinement = result.confinement;
        conversion.clips = clipsOf(result.output, framesASecond(scan));
        conversion.missing_pictures = missingPictures(result.output);
        if (result.status != 0)
            conversion.problem = "it ended with status " + std::to_string(result.status) + lastLine(result.output);
    } catch (const ChildFailed& how) {
        conversion.problem = std::string("it crashed: ") + how.what();
    }
    if (!conversion.problem.empty()) return conversion;
    conversion.glb = bytesOfFile(folder.path() / "out.glb");
    conversion.problem = checkResult(scan, conversion);
    return conversion;
}

}  // namespace penumbra
