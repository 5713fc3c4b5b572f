#include "formats/rig/assimp/collada_text.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/assimp/xml_tree.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

// Calls `visit` with every element of a name.
template <class Node, class Visit>
void visitElements(Node& node, std::string_view name, Visit visit) {
    if (node.name == name) visit(node);
    for (auto& child : node.children) visitElements(child, name, visit);
}

std::string withoutHash(std::string_view url) { return std::string(url.substr(url.starts_with('#') ? 1 : 0)); }

// assimp takes a skin over a morph controller for a skin over nothing, and does not read a morph controller that
// nothing shows.
void skinBaseMeshes(XmlNode& root, const std::filesystem::path& path, std::vector<RigNote>& notes) {
    std::map<std::string, std::string> mesh_of_morph;
    std::set<std::string> skinned;
    visitElements(root, "controller", [&](const XmlNode& controller) {
        if (const XmlNode* morph = controller.child("morph"))
            mesh_of_morph[std::string(controller.attribute("id"))] = morph->attribute("source");
    });
    visitElements(root, "skin", [&](XmlNode& skin) {
        const auto morph = mesh_of_morph.find(withoutHash(skin.attribute("source")));
        if (morph == mesh_of_morph.end()) return;
        notes.push_back({path.string(), cleanText(withoutHash(morph->second)), "morph targets under a skin",
                         "are left out, the mesh stays as it is"});
        skin.setAttribute("source", morph->second);
        skinned.insert(morph->first);
    });
    for (XmlNode& library : root.children)
        if (library.name == "library_controllers")
            std::erase_if(library.children, [&](const XmlNode& controller) {
                return skinned.contains(std::string(controller.attribute("id")));
            });
}

bool saysTwoSides(const XmlNode& element) {
    bool says = false;
    for (const XmlNode& child : element.children)
        if (child.name == "extra")
            visitElements(child, "double_sided",
                          [&](const XmlNode& sides) { says |= sides.content() == "1" || sides.content() == "true"; });
    return says;
}

// Exporters say in three places that both sides are drawn: in the profile of an effect, which assimp reads, beside it,
// and at a geometry, whose material may belong to others, too.
void readSides(XmlNode& root, const std::filesystem::path& path, std::vector<RigNote>& notes) {
    visitElements(root, "effect", [](XmlNode& effect) {
        XmlNode* profile = effect.child("profile_COMMON");
        if (profile == nullptr || !saysTwoSides(effect)) return;
        for (const XmlNode& child : effect.children)
            if (child.name == "extra") profile->children.push_back(child);
    });
    visitElements(root, "geometry", [&](const XmlNode& geometry) {
        if (saysTwoSides(geometry))
            notes.push_back({path.string(), cleanText(std::string(geometry.attribute("id"))), "double_sided of a mesh",
                             "sides are read from materials alone"});
    });
}

// assimp does not tell which way round a picture is transparent.
void leaveOutZeroPictures(XmlNode& root, const std::filesystem::path& path, std::vector<RigNote>& notes) {
    visitElements(root, "effect", [&](XmlNode& effect) {
        for (const char* model : {"constant", "lambert", "phong", "blinn"})
            visitElements(effect, model, [&](XmlNode& shader) {
                const XmlNode* transparent = shader.child("transparent");
                if (transparent == nullptr || transparent->child("texture") == nullptr) return;
                const std::string_view opaque = transparent->attribute("opaque");
                if (opaque.empty() || opaque == "A_ONE") return;
                notes.push_back({path.string(), "",
                                 "transparency of effect '" + cleanText(std::string(effect.attribute("id"))) + "'",
                                 std::string(opaque) + " with a picture is not read: the surface is solid"});
                std::erase_if(shader.children, [](const XmlNode& child) {
                    return child.name == "transparent" || child.name == "transparency";
                });
            });
    });
}

double secondsOf(const XmlNode& clip, const char* name, double otherwise, const std::filesystem::path& path) {
    const std::string_view text = clip.attribute(name);
    if (text.empty()) return otherwise;
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || !(number >= 0 && number < 1e9))
        failAtFile(path, "animation clip '" + std::string(clip.attribute("id")) + "': its " + name + " is not a time");
    return number;
}

struct ClipElement {
    ColladaClip clip;
    std::set<std::string> animations;  // ids
};

std::vector<ClipElement> clipElements(const XmlNode& root, const std::filesystem::path& path) {
    std::vector<ClipElement> clips;
    visitElements(root, "animation_clip", [&](const XmlNode& element) {
        ClipElement clip;
        const std::string_view name = element.attribute("name"), id = element.attribute("id");
        clip.clip.name = cleanText(std::string(name.empty() ? id : name));
        if (clip.clip.name.empty()) clip.clip.name = "clip" + std::to_string(clips.size());
        clip.clip.start = secondsOf(element, "start", 0, path);
        clip.clip.end = secondsOf(element, "end", clip.clip.end, path);
        if (!(clip.clip.end > clip.clip.start))
            failAtFile(path, "animation clip '" + clip.clip.name + "': ends before it starts");
        for (const XmlNode& child : element.children)
            if (child.name == "instance_animation") clip.animations.insert(withoutHash(child.attribute("url")));
        clips.push_back(std::move(clip));
    });
    return clips;
}

// Leaves out the animations of other clips. Returns whether something is left.
bool keepAnimations(XmlNode& parent, const std::set<std::string>& ids) {
    bool any = false;
    std::erase_if(parent.children, [&](XmlNode& child) {
        if (child.name != "animation") return false;
        const bool kept = ids.contains(std::string(child.attribute("id"))) || keepAnimations(child, ids);
        any |= kept;
        return !kept;
    });
    return any;
}

std::string textOfClip(const XmlNode& root, const ClipElement& clip, const std::filesystem::path& path) {
    XmlNode copy = root;
    bool any = false;
    for (XmlNode& library : copy.children)
        if (library.name == "library_animations") any |= keepAnimations(library, clip.animations);
    if (!any) failAtFile(path, "animation clip '" + clip.clip.name + "': names no animation of the file");
    return textOf(copy);
}

// Animations that are in no clip.
void noteOthers(const XmlNode& root, const std::vector<ClipElement>& clips, const std::filesystem::path& path,
                std::vector<RigNote>& notes) {
    std::set<std::string> named;
    for (const ClipElement& clip : clips) named.insert(clip.animations.begin(), clip.animations.end());
    for (const XmlNode& library : root.children)
        for (const XmlNode& animation : library.children) {
            if (animation.name != "animation") continue;
            bool used = false;
            visitElements(animation, "animation",
                          [&](const XmlNode& inner) { used |= named.contains(std::string(inner.attribute("id"))); });
            if (!used)
                notes.push_back({path.string(), "",
                                 "animation '" + cleanText(std::string(animation.attribute("id"))) + "'",
                                 "is in no clip and left out"});
        }
}

}  // namespace

ColladaText prepareCollada(std::string_view xml, const std::filesystem::path& path) {
    ColladaText out;
    std::optional<XmlNode> root = parseXml(xml);
    if (!root || root->name != "COLLADA") {
        out.text = xml;
        return out;
    }
    straightenCurves(*root, path);
    skinBaseMeshes(*root, path, out.notes);
    readSides(*root, path, out.notes);
    leaveOutZeroPictures(*root, path, out.notes);
    const std::vector<ClipElement> clips = clipElements(*root, path);
    std::erase_if(root->children, [](const XmlNode& child) { return child.name == "library_animation_clips"; });
    constexpr std::size_t kMaxClips = 1000;
    if (clips.size() > kMaxClips) throw Unsupported(path.string() + ": has more than 1000 animation clips");
    if (clips.empty()) {
        out.text = textOf(*root);
        return out;
    }
    noteOthers(*root, clips, path, out.notes);
    for (const ClipElement& clip : clips) {
        out.clips.push_back(clip.clip);
        out.clips.back().text = textOfClip(*root, clip, path);
    }
    return out;
}

}  // namespace penumbra
