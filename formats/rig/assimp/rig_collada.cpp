// Reads Collada through assimp, once for each clip that the file names.
#include <cmath>
#include <fstream>
#include <iterator>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/rig/assimp/collada_text.h"
#include "formats/rig/fbx/fbx_takes.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_import.h"

namespace penumbra {

namespace {

// Makes one clip of what assimp made of the animations of one.
Clip joinedClip(RigSource& source, const ColladaClip& said) {
    if (source.clips.empty()) failAtFile(source.file, "animation clip '" + said.name + "': has no keys");
    Clip joined = std::move(source.clips.front());
    for (std::size_t c = 1; c < source.clips.size(); ++c) {
        joined.duration = std::max(joined.duration, source.clips[c].duration);
        for (Channel& channel : source.clips[c].channels) joined.channels.push_back(std::move(channel));
    }
    joined.name = said.name;
    source.clips.assign(1, std::move(joined));
    const double last = std::isfinite(said.end) ? said.end : std::max(source.clips[0].duration, said.start);
    cutClip(source, 0, said.start, last);
    return std::move(source.clips[0]);
}

}  // namespace

RigSource readCollada(const std::filesystem::path& path) {
    checkReadable(path);
    std::ifstream in(path, std::ios::binary);
    const std::string xml{std::istreambuf_iterator<char>(in), {}};
    if (xml.empty()) failAtFile(path, "is empty");
    ColladaText collada = prepareCollada(xml, path);
    const auto read = [&](const std::string& text) {
        return importInChild(
            path, [&](const std::filesystem::path& file) { return importTextWithAssimp(file, text); },
            importLimits(text.size()));
    };
    RigSource source = read(collada.clips.empty() ? collada.text : collada.clips[0].text);
    std::vector<Clip> clips;
    for (std::size_t c = 0; c < collada.clips.size(); ++c) {
        if (c == 0) {
            clips.push_back(joinedClip(source, collada.clips[0]));
            continue;
        }
        RigSource other = read(collada.clips[c].text);
        clips.push_back(joinedClip(other, collada.clips[c]));
    }
    if (!clips.empty()) source.clips = std::move(clips);
    source.notes.insert(source.notes.end(), collada.notes.begin(), collada.notes.end());
    return source;
}

}  // namespace penumbra
