#include "formats/rig/assimp/xml_tree.h"

#include <algorithm>

namespace penumbra {

const XmlNode* XmlNode::child(std::string_view child_name) const {
    const auto found =
        std::find_if(children.begin(), children.end(), [&](const XmlNode& node) { return node.name == child_name; });
    return found == children.end() ? nullptr : &*found;
}

XmlNode* XmlNode::child(std::string_view child_name) {
    return const_cast<XmlNode*>(std::as_const(*this).child(child_name));
}

std::string_view XmlNode::attribute(std::string_view key) const {
    for (const auto& [name_of, value] : attributes)
        if (name_of == key) return value;
    return {};
}

void XmlNode::setAttribute(std::string_view key, std::string value) {
    for (auto& [name_of, old] : attributes)
        if (name_of == key) {
            old = std::move(value);
            return;
        }
    attributes.emplace_back(key, std::move(value));
}

namespace {

constexpr std::string_view kXmlBlanks = " \t\r\n";
constexpr int kDeepestElement = 256;

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(kXmlBlanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(kXmlBlanks) - first + 1);
}

// Each function returns false where the text is not what it reads.
struct XmlParser {
    std::string_view xml;
    std::size_t at = 0;

    bool accept(std::string_view token) {
        if (xml.substr(at, token.size()) != token) return false;
        at += token.size();
        return true;
    }
    bool skipPast(std::string_view token) {
        const std::size_t found = xml.find(token, at);
        if (found == std::string_view::npos) return false;
        at = found + token.size();
        return true;
    }
    void skipBlanks() { at = std::min(xml.find_first_not_of(kXmlBlanks, at), xml.size()); }
    std::string_view nameHere() {
        const std::size_t end = std::min(xml.find_first_of(" \t\r\n=/<>\"'", at), xml.size());
        const std::string_view name = xml.substr(at, end - at);
        at = end;
        return name;
    }
    // Passes over a comment, a declaration or an instruction. A DOCTYPE with brackets is not read.
    bool skipOther() {
        if (accept("<!--")) return skipPast("-->");
        if (accept("<?")) return skipPast("?>");
        return xml.substr(at, 9) == "<!DOCTYPE" && skipPast(">");
    }
    bool attribute(XmlNode& node) {
        const std::string_view key = nameHere();
        skipBlanks();
        if (key.empty() || !accept("=")) return false;
        skipBlanks();
        if (at >= xml.size() || (xml[at] != '"' && xml[at] != '\'')) return false;
        const char quote = xml[at++];
        const std::size_t end = xml.find(quote, at);
        if (end == std::string_view::npos) return false;
        node.attributes.emplace_back(key, std::string(xml.substr(at, end - at)));
        at = end + 1;
        return true;
    }
    bool content(XmlNode& node, int depth) {
        for (;;) {
            const std::size_t end = xml.find('<', at);
            if (end == std::string_view::npos) return false;
            const std::string_view text = trimmed(xml.substr(at, end - at));
            if (!text.empty()) {
                if (!node.text.empty()) return false;  // text in two pieces, around a comment
                node.text = text;
            }
            at = end;
            if (accept("</")) {
                if (nameHere() != node.name) return false;
                skipBlanks();
                return accept(">");
            }
            if (xml.substr(at, 2) == "<!" || xml.substr(at, 2) == "<?") {
                if (!skipOther()) return false;
            } else if (!element(node.children.emplace_back(), depth + 1)) {
                return false;
            }
        }
    }
    bool element(XmlNode& node, int depth) {
        if (depth > kDeepestElement || !accept("<")) return false;
        node.name = nameHere();
        if (node.name.empty()) return false;
        for (skipBlanks();; skipBlanks()) {
            if (accept("/>")) return true;
            if (accept(">")) break;
            if (!attribute(node)) return false;
        }
        if (!content(node, depth)) return false;
        if (!node.children.empty()) node.text = {};
        return true;
    }
};

void write(const XmlNode& node, std::string& out) {
    out.append("<").append(node.name);
    for (const auto& [key, value] : node.attributes) {
        const char quote = value.find('"') == std::string::npos ? '"' : '\'';
        out.append(" ").append(key).append("=").append(1, quote).append(value).append(1, quote);
    }
    if (node.children.empty() && node.content().empty()) {
        out += "/>";
        return;
    }
    out += ">";
    out += node.content();
    for (const XmlNode& child : node.children) write(child, out);
    out.append("</").append(node.name).append(">");
}

}  // namespace

std::optional<XmlNode> parseXml(std::string_view xml) {
    XmlParser parser{xml};
    parser.accept("\xef\xbb\xbf");
    XmlNode root;
    for (parser.skipBlanks(); parser.xml.substr(parser.at, 2) == "<?" || parser.xml.substr(parser.at, 2) == "<!";
         parser.skipBlanks())
        if (!parser.skipOther()) return std::nullopt;
    if (!parser.element(root, 0)) return std::nullopt;
    return root;
}

std::string textOf(const XmlNode& root) {
    std::string out = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";
    write(root, out);
    return out;
}

}  // namespace penumbra
