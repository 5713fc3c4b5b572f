#pragma once
// Elements of an XML file, as much of it as Collada has: elements, attributes, and text in elements without children.
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace penumbra {

// Names and values are as the file spells them, entities included. Views point into the file.
struct XmlNode {
    std::string_view name;
    std::vector<std::pair<std::string_view, std::string>> attributes;
    std::string_view text;                // without blanks around it; "" with children
    std::optional<std::string> new_text;  // stands in for it
    std::vector<XmlNode> children;

    std::string_view content() const { return new_text ? std::string_view(*new_text) : text; }
    const XmlNode* child(std::string_view child_name) const;
    XmlNode* child(std::string_view child_name);
    // Returns the value of an attribute, "" without it.
    std::string_view attribute(std::string_view key) const;
    void setAttribute(std::string_view key, std::string value);
};

// Returns the root element; nothing where the text is no well-formed XML, has a CDATA section or is nested deeper than
// 256 elements. Comments, declarations and text beside elements are passed over.
std::optional<XmlNode> parseXml(std::string_view xml);
std::string textOf(const XmlNode& root);

}  // namespace penumbra
