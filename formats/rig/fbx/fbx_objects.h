#pragma once
// Objects of an FBX file by their ids, and what is connected to what.
#include <map>
#include <string>
#include <vector>

#include "formats/rig/fbx/fbx_tree.h"

namespace penumbra {

struct FbxLink {
    std::string child, parent, property;  // ids; property: "" for a plain connection
};

struct FbxObjects {
    std::map<std::string, const FbxNode*> object_of_id;
    std::vector<std::string> ids;  // in the order of the file
    std::vector<FbxLink> links;
    std::map<std::string, std::vector<std::size_t>> links_of_child, links_of_parent;
    std::map<std::string, const FbxNode*> template_of_kind;  // default properties, by the name of the node
};

// Objects of FBX 7 are known by a number, those of FBX 6 by their name.
FbxObjects objectsOf(const FbxTree& tree);

// "walk" of "AnimStack::walk" and of "walk\0\1AnimStack".
std::string objectName(const FbxNode& object);
// "Mesh" of Model: 1, "Model::body", "Mesh".
const std::string& objectKind(const FbxNode& object);

// Returns the `index`th number of a property of an object, of its kind's template, or else nothing.
const FbxNode* findProperty(const FbxObjects& objects, const FbxNode& object, std::string_view name);
double propertyNumber(const FbxObjects& objects, const FbxNode& object, std::string_view name, double otherwise,
                      std::size_t index = 0);
std::string_view propertyTextOf(const FbxNode& property);

}  // namespace penumbra
