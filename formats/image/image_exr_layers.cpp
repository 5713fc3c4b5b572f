// Lists the layers of an OpenEXR file and chooses the one that is the picture.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfPartType.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "formats/common/joined.h"
#include "formats/common/warning.h"
#include "formats/image/image_codecs.h"
#include "formats/image/image_exr_file.h"

namespace penumbra {

bool ExrBytes::read(char out[], int count) {
    if (count < 0 || std::uint64_t(count) > bytes_.left()) throw InvalidInput("cut short");
    bytes_.read(std::as_writable_bytes(std::span(out, std::size_t(count))));
    return bytes_.left() > 0;
}

void ExrBytes::seekg(std::uint64_t position) {
    if (position > size_) throw InvalidInput("cut short");
    bytes_.seek(position);
}

void limitExr() {
    Imf::Header::setMaxImageSize(kMaxImageSide, kMaxImageSide);
    Imf::Header::setMaxTileSize(kMaxImageSide, kMaxImageSide);
}

void checkExrParts(const Imf::MultiPartInputFile& file, const std::string& name) {
    constexpr int kMaxChannels = 256;  // bounds the decoder's buffers, which hold every channel
    for (int part = 0; part < file.parts(); ++part) {
        int count = 0;
        const Imf::ChannelList& channels = file.header(part).channels();
        for (auto channel = channels.begin(); channel != channels.end(); ++channel) ++count;
        if (count > kMaxChannels) throw Unsupported(name + ": more than 256 channels");
    }
}

namespace {

bool isDeep(const Imf::Header& header) { return header.hasType() && !Imf::isImage(header.type()); }

std::string partName(const Imf::Header& header) { return header.hasName() ? header.name() : ""; }

std::string lowered(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

// The channels of a part by what stands before the last dot, then by what follows it in small letters.
using ExrGroups = std::map<std::string, std::map<std::string, std::string>>;

ExrGroups groupsOf(const Imf::ChannelList& channels) {
    ExrGroups groups;
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
        const std::string whole = channel.name();
        const std::size_t dot = whole.rfind('.');
        const std::string prefix = dot == std::string::npos ? "" : whole.substr(0, dot);
        groups[prefix].emplace(lowered(whole.substr(dot == std::string::npos ? 0 : dot + 1)), whole);
    }
    return groups;
}

std::string shownName(const Imf::MultiPartInputFile& file, int part, const std::string& prefix) {
    const std::string name = partName(file.header(part));
    if (file.parts() == 1 || name.empty()) return prefix;
    if (prefix.empty() || prefix == name || prefix.starts_with(name + ".")) return prefix.empty() ? name : prefix;
    return name + "." + prefix;
}

// Adds the picture that a group of channels is, if it is one. Y beside X is no luminance but a coordinate.
void addLayer(const std::map<std::string, std::string>& group, ExrLayer layer, std::vector<ExrLayer>& layers) {
    const auto find = [&](const char* name) {
        const auto found = group.find(name);
        return found == group.end() ? std::string() : found->second;
    };
    for (const auto& names : {std::array{"r", "g", "b"}, std::array{"red", "green", "blue"}}) {
        layer.color = {find(names[0]), find(names[1]), find(names[2])};
        if (std::ranges::none_of(layer.color, &std::string::empty)) break;
        layer.color = {};
    }
    if (layer.color[0].empty() && !find("y").empty() && find("x").empty()) {
        layer.color.fill(find("y"));
        layer.has_chroma = !find("ry").empty() && !find("by").empty();
    }
    if (layer.color[0].empty()) return;
    layer.alpha = find("a").empty() ? find("alpha") : find("a");
    layers.push_back(std::move(layer));
}

bool isLuminance(const ExrLayer& layer) { return layer.color[0] == layer.color[1]; }

std::string describeLayers(const std::vector<ExrLayer>& layers) {
    return joined(layers, ", ", [](const ExrLayer& layer) {
        return layer.shown.empty() ? isLuminance(layer) ? std::string("Y") : std::string("R, G, B")
                                   : oneLine(layer.shown);
    });
}

// Lists the parts and, of each, the groups of channels: "part depth: Z; part rgba: B, G, R, N (X, Y, Z)".
std::string describeFile(const Imf::MultiPartInputFile& file) {
    constexpr std::size_t kMax = 600;  // letters
    std::string text;
    for (int part = 0; part < file.parts(); ++part) {
        const Imf::Header& header = file.header(part);
        if (part > 0) text += "; ";
        if (file.parts() > 1)
            text += "part " + (partName(header).empty() ? std::to_string(part) : partName(header)) + ": ";
        if (isDeep(header)) text += "deep pixels of ";
        bool first = true;
        for (const auto& named : groupsOf(header.channels())) {
            const std::string& prefix = named.first;
            const auto& group = named.second;
            if (!first) text += ", ";
            first = false;
            const std::string names = joined(group, ", ", [&](const auto& one) {
                return one.second.substr(prefix.empty() ? 0 : prefix.size() + 1);
            });
            text += prefix.empty() ? names : prefix + " (" + names + ")";
        }
    }
    if (text.size() > kMax) text = text.substr(0, kMax) + " ...";
    return oneLine(text);
}

// Pictures of places and of normals have channels of these names, too, so that nothing tells whether they are colours.
constexpr const char* kXyzAdvice =
    ". If X, Y, Z are CIE XYZ, write the file as R, G, B of a colour space that --colorspace knows";

bool holdsXyz(const Imf::MultiPartInputFile& file) {
    for (int part = 0; part < file.parts(); ++part)
        for (const auto& [prefix, group] : groupsOf(file.header(part).channels()))
            if (group.contains("x") && group.contains("y") && group.contains("z")) return true;
    return false;
}

}  // namespace

std::vector<ExrLayer> layersOf(const Imf::MultiPartInputFile& file) {
    std::vector<ExrLayer> layers;
    for (int part = 0; part < file.parts(); ++part) {
        if (isDeep(file.header(part))) continue;
        for (const auto& [prefix, group] : groupsOf(file.header(part).channels()))
            addLayer(group, {part, prefix, shownName(file, part, prefix), {}, "", false}, layers);
    }
    return layers;
}

ExrLayer chooseLayer(const Imf::MultiPartInputFile& file, const std::string& wanted, const std::string& name) {
    std::vector<ExrLayer> layers = layersOf(file);
    if (layers.empty())
        throw InvalidInput(name + ": no picture, which is channels R, G, B, or Y alone; it holds " +
                           describeFile(file) + (holdsXyz(file) ? kXyzAdvice : ""));
    if (!wanted.empty()) {
        const std::vector<ExrLayer> all = layers;
        std::erase_if(layers, [&](const ExrLayer& layer) { return layer.shown != wanted; });
        if (layers.empty()) {
            layers = all;
            std::erase_if(layers, [&](const ExrLayer& layer) {
                return layer.prefix != wanted && partName(file.header(layer.part)) != wanted;
            });
        }
        if (layers.empty())
            throw BadOption("layer", name + ": no layer '" + oneLine(wanted) + "', only " + describeLayers(all));
        if (layers.size() > 1)
            throw BadOption("layer", name + ": '" + oneLine(wanted) + "' is several: " + describeLayers(layers));
        return layers.front();
    }
    // A picture without a layer's name is the file's own; luminance is one only where nothing has colours.
    for (const auto& worse : {+[](const ExrLayer& layer) { return isLuminance(layer); },
                              +[](const ExrLayer& layer) { return !layer.prefix.empty(); }})
        if (!std::ranges::all_of(layers, worse)) std::erase_if(layers, worse);
    if (layers.size() == 1) return layers.front();
    throw InvalidInput(name + ": holds several pictures, and no layer is chosen: " + describeLayers(layers));
}

}  // namespace penumbra
