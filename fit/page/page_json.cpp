#include "fit/page/page_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/common/errors.h"
#include "formats/common/json_depth.h"

namespace penumbra {

namespace {

using PageValue = nlohmann::json;

// A value and its place in the file, for messages.
struct Node {
    const PageValue& value;
    std::string file, path;

    [[noreturn]] void refuse(const std::string& what) const {
        throw InvalidInput(file + ": " + (path.empty() ? "the file" : path) + ": " + what);
    }
    Node operator[](const char* key) const {
        const auto found = value.find(key);
        const Node node{found == value.end() ? value : *found, file, path + (path.empty() ? "" : ".") + key};
        if (found == value.end()) node.refuse("missing");
        return node;
    }
    Node operator[](std::size_t i) const { return {value[i], file, path + "[" + std::to_string(i) + "]"}; }
    bool has(const char* key) const { return value.contains(key); }
};

// An object with no other keys than these.
void checkKeys(const Node& node, const std::vector<std::string>& keys) {
    if (!node.value.is_object()) node.refuse("takes an object");
    for (const auto& item : node.value.items())
        if (std::find(keys.begin(), keys.end(), item.key()) == keys.end()) {
            std::string known;
            for (const std::string& key : keys) known += (known.empty() ? "" : ", ") + key;
            node.refuse("has the key '" + item.key() + "'; it takes " + known);
        }
}

std::string textOf(const Node& node) {
    if (!node.value.is_string()) node.refuse("takes text");
    return node.value.get<std::string>();
}

std::vector<Node> listOf(const Node& node) {
    if (!node.value.is_array()) node.refuse("takes a list");
    std::vector<Node> list;
    for (std::size_t i = 0; i < node.value.size(); ++i) list.push_back(node[i]);
    return list;
}

// A link that stays beside the page: relative, percent-encoded, without a scheme and without a host.
std::string linkOf(const Node& node) {
    const std::string link = textOf(node);
    const bool encoded = std::all_of(link.begin(), link.end(), [](char c) { return c > ' ' && c < 127 && c != '\\'; });
    const bool scheme = link.find(':') < std::min(link.find_first_of("/?#"), link.size());
    if (link.empty() || !encoded || scheme || link.starts_with("//"))
        node.refuse("takes a relative, percent-encoded link, not '" + link + "'");
    return link;
}

// Anchors that the page's own elements do not use begin with a letter or a digit.
std::string idOf(const Node& node, std::set<std::string>& known) {
    const std::string id = textOf(node);
    const auto plain = [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    };
    const bool good = !id.empty() && plain(id[0]) && std::all_of(id.begin(), id.end(), [&](char c) {
        return plain(c) || c == '.' || c == '_' || c == '-';
    });
    if (!good) node.refuse("takes a letter or digit, then letters, digits, '.', '_' and '-', not '" + id + "'");
    if (!known.insert(id).second) node.refuse("'" + id + "' is the id of an earlier section too");
    return id;
}

// "text", or {"text": "report", "link": "reports/a.json", "bad": true}.
TableCell cellOf(const Node& node) {
    if (node.value.is_string()) return {escapeXml(textOf(node)), !isNumber(textOf(node))};
    if (!node.value.is_object()) node.refuse("takes text or an object");
    checkKeys(node, {"text", "link", "bad"});
    const std::string text = textOf(node["text"]);
    std::string html = escapeXml(text);
    if (node.has("link")) html = "<a href=\"" + escapeXml(linkOf(node["link"])) + "\">" + html + "</a>";
    if (node.has("bad") && !node["bad"].value.is_boolean()) node["bad"].refuse("takes true or false");
    if (node.has("bad") && node["bad"].value.get<bool>()) html = "<span class=\"bad\">" + html + "</span>";
    return {html, !isNumber(text)};
}

std::string tableOf(const Node& node) {
    checkKeys(node, {"caption", "columns", "rows"});
    std::vector<TableColumn> columns;
    for (const Node& column : listOf(node["columns"])) columns.push_back({textOf(column), false});
    std::vector<std::vector<TableCell>> rows;
    for (const Node& row : listOf(node["rows"])) {
        std::vector<TableCell>& cells = rows.emplace_back();
        for (const Node& cell : listOf(row)) cells.push_back(cellOf(cell));
        if (cells.size() != columns.size())
            row.refuse("has " + std::to_string(cells.size()) + " cells, the table " + std::to_string(columns.size()) +
                       " columns");
    }
    for (std::size_t c = 0; !rows.empty() && c < columns.size(); ++c) columns[c].words = rows.front()[c].words;
    return tableHtml(textOf(node["caption"]), columns, rows);
}

// A picture leads to its file, where it can be seen in full size.
std::string pictureOf(const Node& node) {
    checkKeys(node, {"file", "alt"});
    const std::string file = escapeXml(linkOf(node["file"]));
    return tag("a", "href=\"" + file + "\"",
               "<img src=\"" + file + "\" alt=\"" + escapeXml(textOf(node["alt"])) + "\">");
}

std::string blockOf(const Node& node) {
    checkKeys(node, {"paragraph", "table", "picture"});
    if (node.value.size() != 1) node.refuse("takes exactly one of paragraph, table, picture");
    if (node.has("paragraph")) return tag("p", "class=\"method\"", escapeXml(textOf(node["paragraph"])));
    return node.has("table") ? tableOf(node["table"]) : pictureOf(node["picture"]);
}

PageSection sectionOf(const Node& node, std::set<std::string>& known) {
    checkKeys(node, {"id", "title", "blocks"});
    PageSection section{idOf(node["id"], known), textOf(node["title"]), {}};
    section.html = tag("h2", "", escapeXml(section.title));
    for (const Node& block : listOf(node["blocks"])) section.html += blockOf(block);
    return section;
}

PageValue parsed(std::string_view json, const std::string& name) try {
    if (nestedTooDeep(json)) throw InvalidInput(name + ": nested too deep");
    return PageValue::parse(json);
} catch (const PageValue::exception& error) {
    throw InvalidInput(name + ": no JSON: " + error.what());
}

}  // namespace

Page parsePage(std::string_view json, const std::string& name) {
    const PageValue value = parsed(json, name);
    const Node root{value, name, ""};
    checkKeys(root, {"schema", "schema_version", "title", "facts", "sections"});
    if (textOf(root["schema"]) != "penumbra.page") root["schema"].refuse("is not penumbra.page");
    if (root["schema_version"].value != PageValue(1)) root["schema_version"].refuse("is not 1");
    Page page;
    page.title = textOf(root["title"]);
    page.main_id = "_main";  // no section's id
    page.pictures = true;
    for (const Node& fact : listOf(root["facts"])) page.facts += tag("p", "class=\"source\"", escapeXml(textOf(fact)));
    std::set<std::string> known;
    for (const Node& section : listOf(root["sections"])) page.sections.push_back(sectionOf(section, known));
    return page;
}

}  // namespace penumbra
