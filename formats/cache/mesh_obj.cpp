// Wavefront .obj: v, f, o, g and usemtl lines; all others (vt, vn, s, l, p, mtllib, ...) are passed over.
// Why not assimp: it makes a vertex of every corner of a face and drops unused ones, so the file's numbering is lost.
#include <algorithm>
#include <charconv>

#include "formats/cache/mesh_file.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {
struct ObjParser {
    std::string_view rest;
    std::string name;
    int line = 1;
    MeshFile mesh;
    std::string object, material = kDefaultSlot;
    bool has_parts = false;  // the file has an o, g or usemtl line
    std::vector<std::uint32_t> corners;

    [[noreturn]] void fail(const std::string& problem) const {
        throw InvalidInput(name + ": line " + std::to_string(line) + ": " + problem);
    }
};

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

// Returns the next word of the line, or "" at its end. A backslash at the end of a line joins it with the next.
std::string_view nextWord(ObjParser& parser) {
    std::string_view& rest = parser.rest;
    for (;;) {
        while (!rest.empty() && isBlank(rest.front())) rest.remove_prefix(1);
        const std::size_t joint = rest.starts_with("\\\n") ? 2 : rest.starts_with("\\\r\n") ? 3 : 0;
        if (joint == 0) break;
        rest.remove_prefix(joint);
        ++parser.line;
    }
    std::size_t size = 0;
    while (size < rest.size() && !isBlank(rest[size]) && rest[size] != '\n' && rest[size] != '\\') ++size;
    if (size == 0 && !rest.empty() && rest.front() == '\\') size = 1;
    const std::string_view word = rest.substr(0, size);
    rest.remove_prefix(size);
    return word;
}

void skipLine(ObjParser& parser) {
    while (!nextWord(parser).empty()) {
    }
    if (parser.rest.empty()) return;
    parser.rest.remove_prefix(1);
    ++parser.line;
}

double readNumber(ObjParser& parser) {
    std::string_view word = nextWord(parser);
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) parser.fail("a vertex needs three numbers");
    return value;
}

void readVertex(ObjParser& parser) {
    const double x = readNumber(parser), y = readNumber(parser), z = readNumber(parser);
    // A fourth number alone is a weight. Some readers divide by it and others do not; more numbers are a colour.
    const std::string_view weight = nextWord(parser), next = nextWord(parser);
    double w = 1;
    std::from_chars(weight.data(), weight.data() + weight.size(), w);
    if (w != 1 && (next.empty() || next.front() == '#')) parser.fail("the weight w of a vertex is not 1");
    parser.mesh.positions.push_back({x, y, z});
    if (parser.mesh.positions.size() > kMaxSourceVertices) throw Unsupported(parser.name + ": has too many vertices");
}

// Reads "7", "7/1", "7//2" or "7/1/2", which count from 1. Negative ones count back from the last vertex so far.
std::uint32_t cornerOf(const ObjParser& parser, std::string_view word) {
    const std::string_view index = word.substr(0, word.find('/'));
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), value);
    const std::int64_t vertices = std::int64_t(parser.mesh.positions.size());
    if (error != std::errc() || end != index.data() + index.size())
        parser.fail("'" + cleanText(std::string(word.substr(0, 40))) + "' is not a vertex of a face");
    const std::int64_t vertex = value < 0 ? vertices + value : value - 1;
    if (value == 0 || vertex < 0 || vertex >= vertices)
        parser.fail("a face names vertex " + std::to_string(value) + " of " + std::to_string(vertices));
    return std::uint32_t(vertex);
}

std::uint16_t currentSlot(ObjParser& parser) {
    std::vector<std::string>& slots = parser.mesh.slots;
    const std::string name = (parser.object.empty() ? "mesh" : parser.object) + "/" + parser.material;
    if (!slots.empty() && slots.back() == name) return std::uint16_t(slots.size() - 1);
    const auto found = std::find(slots.begin(), slots.end(), name);
    if (found != slots.end()) return std::uint16_t(found - slots.begin());
    if (slots.size() == 65535) throw Unsupported(parser.name + ": more than 65535 parts");
    slots.push_back(name);
    return std::uint16_t(slots.size() - 1);
}

constexpr std::uint16_t kNoSlot = 65535;

void readFace(ObjParser& parser) {
    std::vector<std::uint32_t>& corners = parser.corners;
    corners.clear();
    for (std::string_view word = nextWord(parser); !word.empty() && word[0] != '#'; word = nextWord(parser))
        corners.push_back(cornerOf(parser, word));
    if (corners.size() < 3) parser.fail("a face needs three vertices");
    MeshFile& mesh = parser.mesh;
    for (std::size_t k = 2; k < corners.size(); ++k) mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    const std::uint16_t slot = currentSlot(parser);
    mesh.slot_of_vertex.resize(mesh.positions.size(), kNoSlot);
    for (const std::uint32_t v : corners)
        if (mesh.slot_of_vertex[v] == kNoSlot) mesh.slot_of_vertex[v] = slot;
}

void readName(ObjParser& parser, std::string& name) {
    name = cleanText(std::string(nextWord(parser)));
    parser.has_parts = true;
}

void finishSlots(ObjParser& parser) {
    MeshFile& mesh = parser.mesh;
    if (!parser.has_parts || mesh.triangles.empty()) {
        mesh.slots.clear();
        mesh.slot_of_vertex.clear();
        return;
    }
    mesh.slot_of_vertex.resize(mesh.positions.size(), kNoSlot);
    // vertices in no face
    std::replace(mesh.slot_of_vertex.begin(), mesh.slot_of_vertex.end(), kNoSlot, std::uint16_t(0));
}

}  // namespace

MeshFile parseObj(std::string_view text, const std::string& name) {
    ObjParser parser;
    parser.rest = text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;  // without a byte order mark
    parser.name = name;
    while (!parser.rest.empty()) {
        const std::string_view word = nextWord(parser);
        if (word == "v") readVertex(parser);
        if (word == "f") readFace(parser);
        if (word == "o" || word == "g") readName(parser, parser.object);
        if (word == "usemtl") {
            readName(parser, parser.material);
            if (parser.material.empty()) parser.material = kDefaultSlot;
        }
        skipLine(parser);
    }
    if (parser.mesh.positions.empty()) throw InvalidInput(name + ": has no vertices");
    finishSlots(parser);
    return std::move(parser.mesh);
}

}  // namespace penumbra
