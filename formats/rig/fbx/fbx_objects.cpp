#include "formats/rig/fbx/fbx_objects.h"

#include <utility>

namespace penumbra {

namespace {

// The id of an object: its number, or in FBX 6 its name.
std::string idOf(const FbxNode& object) {
    const FbxValue& first = object.value(0);
    return object.values.size() >= 3 || first.text.empty() || first.integer != 0 ? std::to_string(first.integer)
                                                                                 : first.text;
}

std::string idOf(const FbxValue& value, bool by_name) { return by_name ? value.text : std::to_string(value.integer); }

void addLinks(const FbxTree& tree, FbxObjects& objects) {
    const FbxNode* list = tree.root.child("Connections");
    if (!list) return;
    const bool by_name = tree.version < 7000;
    for (const FbxNode& node : list->children) {
        if ((node.name != "C" && node.name != "Connect") || node.values.size() < 3) continue;
        const std::size_t index = objects.links.size();
        objects.links.push_back({idOf(node.values[1], by_name), idOf(node.values[2], by_name), node.value(3).text});
        objects.links_of_child[objects.links.back().child].push_back(index);
        objects.links_of_parent[objects.links.back().parent].push_back(index);
    }
}

void addTemplates(const FbxTree& tree, FbxObjects& objects) {
    const FbxNode* list = tree.root.child("Definitions");
    if (!list) return;
    for (const FbxNode& type : list->children) {
        const FbxNode* defaults = type.name == "ObjectType" ? type.child("PropertyTemplate") : nullptr;
        if (defaults) objects.template_of_kind[type.value(0).text] = defaults;
    }
}

// Where the values of a property begin: name, type, a second type and flags stand before them, in FBX 6 without the
// second type.
std::size_t firstValue(const FbxNode& property) { return property.name == "P" ? 4 : 3; }

const FbxNode* propertyIn(const FbxNode& object, std::string_view name) {
    for (const char* list_name : {"Properties70", "Properties60"})
        if (const FbxNode* list = object.child(list_name))
            for (const FbxNode& property : list->children)
                if (property.value(0).text == name) return &property;
    return nullptr;
}

}  // namespace

FbxObjects objectsOf(const FbxTree& tree) {
    FbxObjects objects;
    if (const FbxNode* list = tree.root.child("Objects"))
        for (const FbxNode& object : list->children) {
            const std::string id = tree.version < 7000 ? object.value(0).text : idOf(object);
            if (objects.object_of_id.emplace(id, &object).second) objects.ids.push_back(id);
        }
    addLinks(tree, objects);
    addTemplates(tree, objects);
    return objects;
}

std::string objectName(const FbxNode& object) {
    std::string name = object.values.empty() ? "" : object.values[0].text;
    if (object.values.size() >= 3) name = object.values[1].text;
    if (const std::size_t end = name.find(std::string("\0\1", 2)); end != std::string::npos) return name.substr(0, end);
    const std::size_t colons = name.find("::");
    return colons == std::string::npos ? name : name.substr(colons + 2);
}

const std::string& objectKind(const FbxNode& object) {
    static const std::string none;
    return object.values.size() >= 2 ? object.values.back().text : none;
}

const FbxNode* findProperty(const FbxObjects& objects, const FbxNode& object, std::string_view name) {
    if (const FbxNode* own = propertyIn(object, name)) return own;
    const auto defaults = objects.template_of_kind.find(object.name);
    return defaults == objects.template_of_kind.end() ? nullptr : propertyIn(*defaults->second, name);
}

double propertyNumber(const FbxObjects& objects, const FbxNode& object, std::string_view name, double otherwise,
                      std::size_t index) {
    const FbxNode* property = findProperty(objects, object, name);
    if (!property || property->values.size() <= firstValue(*property) + index) return otherwise;
    return property->values[firstValue(*property) + index].number;
}

std::string_view propertyTextOf(const FbxNode& property) { return property.value(firstValue(property)).text; }

}  // namespace penumbra
