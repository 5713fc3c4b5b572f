// Reads the nodes of ASCII FBX files: "Name: value, value {" children "}", arrays as "Name: *9 {" "a: 1,2,3" "}", and
// comments behind ";". Values may go on in the next line, so what follows a value tells where a list ends.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "formats/common/errors.h"
#include "formats/rig/fbx/fbx_tree.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

bool isFbxWord(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '+' || c == '.' || c == '|' || c == '#' || c == '*' || c == '$' || c == '/' || c == '(' || c == ')';
}

struct FbxTextParser {
    std::string_view text;
    const std::filesystem::path& path;
    std::size_t at = 0;
    std::uint64_t numbers = 0, nodes = 0;

    [[noreturn]] void fail(const std::string& problem) const {
        const auto line = 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(std::min(at, text.size())), '\n');
        failAtFile(path, "line " + std::to_string(line) + ": " + problem);
    }
    void skipBlanks() {
        while (at < text.size()) {
            if (text[at] == ';')
                at = std::min(text.find('\n', at), text.size());
            else if (text[at] == ' ' || (text[at] >= '\t' && text[at] <= '\r'))
                ++at;
            else
                return;
        }
    }
    // Returns the next character that is no blank, 0 at the end.
    char peek() {
        skipBlanks();
        return at < text.size() ? text[at] : '\0';
    }
    bool accept(char c) {
        if (peek() != c) return false;
        ++at;
        return true;
    }
    std::string_view word() {
        skipBlanks();
        const std::size_t first = at;
        while (at < text.size() && isFbxWord(text[at])) ++at;
        return text.substr(first, at - first);
    }
};

std::string unquoted(std::string_view text) {
    std::string out(text.substr(0, 4096));
    for (std::size_t i = 0; (i = out.find("&quot;", i)) != std::string::npos; ++i) out.replace(i, 6, "\"");
    return out;
}

FbxValue valueOf(std::string_view word) {
    FbxValue value;
    value.text = word;
    if (word.starts_with('+')) word.remove_prefix(1);
    double number = 0;
    if (std::from_chars(word.data(), word.data() + word.size(), number).ec == std::errc() && std::isfinite(number))
        value.number = number;
    std::from_chars(word.data(), word.data() + word.size(), value.integer);
    return value;
}

// Reads one value, or nothing where the next word is the name of a node or no value follows.
std::optional<FbxValue> readTextValue(FbxTextParser& parser) {
    if (parser.accept('"')) {
        const std::size_t end = parser.text.find('"', parser.at);
        if (end == std::string_view::npos) parser.fail("is cut short: a text does not end");
        FbxValue value;
        value.text = unquoted(parser.text.substr(parser.at, end - parser.at));
        parser.at = end + 1;
        return value;
    }
    const std::size_t before = parser.at;
    const std::string_view word = parser.word();
    if (word.empty() || parser.peek() == ':') {
        parser.at = before;
        return std::nullopt;
    }
    return valueOf(word);
}

void keepValue(FbxTextParser& parser, FbxValue&& value, bool array, FbxNode& node) {
    ++node.count;
    if (array) {
        if (++parser.numbers > kMaxFbxNumbers) parser.fail("'" + node.name + "' has too many numbers");
        node.numbers.push_back(value.number);
    }
    if (node.values.size() < kMaxFbxValues) node.values.push_back(std::move(value));
}

void readValues(FbxTextParser& parser, bool array, FbxNode& node) {
    parser.accept(',');  // pictures begin with one
    for (std::optional<FbxValue> value = readTextValue(parser); value; value = readTextValue(parser)) {
        keepValue(parser, std::move(*value), array, node);
        if (!parser.accept(',')) return;
    }
}

// Passes over the numbers of an array that nobody reads, up to its brace.
void skipNumbers(FbxTextParser& parser) {
    while (parser.at < parser.text.size() && parser.text[parser.at] != '}' && parser.text[parser.at] != '{')
        ++parser.at;
}

void readTextNodes(FbxTextParser& parser, int depth, FbxNode& parent);

// Reads what stands in braces behind the count of an array.
void readTextArray(FbxTextParser& parser, FbxNode& node) {
    node.count =
        std::uint64_t(std::max<std::int64_t>(0, valueOf(std::string_view(node.values[0].text).substr(1)).integer));
    if (!isFbxArrayRead(node.name)) {
        skipNumbers(parser);
    } else {
        FbxNode list;
        list.name = node.name;
        if (parser.word() != "a" || !parser.accept(':')) parser.fail("'" + node.name + "': its array has no numbers");
        readValues(parser, true, list);
        node.numbers = std::move(list.numbers);
        if (node.numbers.size() != node.count)
            parser.fail("'" + node.name + "' does not have as many numbers as it says");
    }
    if (!parser.accept('}')) parser.fail("is cut short: the array '" + node.name + "' does not end");
}

void readTextNode(FbxTextParser& parser, int depth, FbxNode& node) {
    readValues(parser, isFbxArrayRead(node.name), node);
    if (!parser.accept('{')) return;
    if (node.values.size() == 1 && node.values[0].text.starts_with('*')) {
        parser.numbers -= node.numbers.size();
        node.numbers.clear();
        readTextArray(parser, node);
        return;
    }
    readTextNodes(parser, depth + 1, node);
    if (!parser.accept('}')) parser.fail("is cut short: the node '" + node.name + "' does not end");
}

void readTextNodes(FbxTextParser& parser, int depth, FbxNode& parent) {
    if (depth > kDeepestFbxNode) parser.fail("its nodes are nested too deeply");
    while (parser.peek() != '\0' && parser.peek() != '}') {
        const std::string_view name = parser.word();
        if (name.empty() || !parser.accept(':')) parser.fail("the name of an FBX node is expected");
        if (++parser.nodes > kMaxFbxNodes) parser.fail("the file has too many nodes");
        FbxNode& node = parent.children.emplace_back();
        node.name = name;
        readTextNode(parser, depth, node);
    }
}

}  // namespace

FbxTree parseFbxText(std::string_view text, const std::filesystem::path& path) {
    FbxTextParser parser{text, path};
    FbxTree tree;
    tree.ascii = true;
    if (text.find("FBXHeaderExtension") > 65536) failAtFile(path, "is no FBX file");
    readTextNodes(parser, 0, tree.root);
    if (parser.at < text.size() && parser.peek() != '\0') parser.fail("a brace closes nothing");
    const FbxNode* header = tree.root.child("FBXHeaderExtension");
    const FbxNode* version = header ? header->child("FBXVersion") : nullptr;
    tree.version = version ? int(std::clamp<std::int64_t>(version->value(0).integer, 0, 99999)) : 0;
    return tree;
}

}  // namespace penumbra
