// .ply 1.0, ASCII and binary: x, y, z of the element "vertex", the list vertex_indices (or vertex_index) of "face";
// other elements and properties are passed over.
// Why not assimp: it takes faces of vertices that are not there, and allocates what a header of 180 bytes asks for.
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>

#include "formats/cache/mesh_file.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {
enum class Type : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct Property {
    std::string name;
    Type type = Type::kFloat32;
    std::optional<Type> count;  // only for a list: the type of its count
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

struct PlyParser {
    std::string_view rest;
    std::string name;
    bool ascii = true, swapped = false;
    std::vector<Element> elements;

    [[noreturn]] void fail(const std::string& problem) const { throw InvalidInput(name + ": " + problem); }
};

Type typeOf(const PlyParser& parser, std::string_view word) {
    struct Name {
        const char *old_name, *new_name;
        Type type;
    };
    for (const Name& n : {Name{"char", "int8", Type::kInt8}, Name{"uchar", "uint8", Type::kUint8},
                          Name{"short", "int16", Type::kInt16}, Name{"ushort", "uint16", Type::kUint16},
                          Name{"int", "int32", Type::kInt32}, Name{"uint", "uint32", Type::kUint32},
                          Name{"float", "float32", Type::kFloat32}, Name{"double", "float64", Type::kFloat64}})
        if (word == n.old_name || word == n.new_name) return n.type;
    parser.fail("unknown type '" + cleanText(std::string(word.substr(0, 40))) + "'");
}

std::size_t sizeOf(Type type) {
    switch (type) {
        case Type::kInt8:
        case Type::kUint8:
            return 1;
        case Type::kInt16:
        case Type::kUint16:
            return 2;
        case Type::kFloat64:
            return 8;
        default:
            return 4;
    }
}

// --- Header ---------------------------------------------------------------------------------------------------------

std::vector<std::string_view> wordsOfLine(PlyParser& parser) {
    const std::size_t end = parser.rest.find('\n');
    if (end == std::string_view::npos || end > 4096) parser.fail("its header is cut short");
    std::string_view line = parser.rest.substr(0, end);
    parser.rest.remove_prefix(end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    std::vector<std::string_view> words;
    for (std::size_t at = 0; (at = line.find_first_not_of(" \t", at)) != std::string_view::npos;) {
        const std::size_t stop = std::min(line.find_first_of(" \t", at), line.size());
        words.push_back(line.substr(at, stop - at));
        at = stop;
    }
    return words;
}

void setFormat(PlyParser& parser, std::string_view format) {
    parser.ascii = format == "ascii";
    if (!parser.ascii && format != "binary_little_endian" && format != "binary_big_endian")
        parser.fail("unknown format '" + cleanText(std::string(format.substr(0, 40))) + "'");
    parser.swapped = (format == "binary_big_endian") == (std::endian::native == std::endian::little);
}

void addElement(PlyParser& parser, std::string_view name, std::string_view count) {
    Element element;
    element.name = cleanText(std::string(name.substr(0, 40)));
    const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (error != std::errc() || end != count.data() + count.size())
        parser.fail("element " + element.name + ": its number is not one");
    parser.elements.push_back(std::move(element));
}

void addProperty(PlyParser& parser, const std::vector<std::string_view>& words) {
    if (parser.elements.empty()) parser.fail("its header has a property before an element");
    Property property;
    const bool is_list = words[1] == "list";
    if (words.size() != (is_list ? 5 : 3)) parser.fail("its header has a damaged property");
    property.type = typeOf(parser, words[is_list ? 3 : 1]);
    if (is_list) property.count = typeOf(parser, words[2]);
    property.name = words.back();
    parser.elements.back().properties.push_back(std::move(property));
}

void readHeader(PlyParser& parser) {
    bool has_format = false;
    for (std::vector<std::string_view> words = wordsOfLine(parser); words.empty() || words[0] != "end_header";
         words = wordsOfLine(parser)) {
        if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
        if (words.size() < 3) parser.fail("its header is damaged");
        if (words[0] == "format") {
            setFormat(parser, words[1]);
            has_format = true;
        } else if (words[0] == "element") {
            addElement(parser, words[1], words[2]);
        } else if (words[0] == "property") {
            addProperty(parser, words);
        } else {
            parser.fail("its header is damaged");
        }
    }
    if (!has_format) parser.fail("its header has no format");
}

// --- Numbers --------------------------------------------------------------------------------------------------------

double readWord(PlyParser& parser, const std::string& where) {
    const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    while (!parser.rest.empty() && is_blank(parser.rest.front())) parser.rest.remove_prefix(1);
    const auto end = std::find_if(parser.rest.begin(), parser.rest.end(), is_blank);
    std::string_view word = parser.rest.substr(0, std::size_t(end - parser.rest.begin()));
    if (word.empty()) parser.fail(where + ": the file is cut short");
    parser.rest.remove_prefix(word.size());
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || stop != word.data() + word.size())
        parser.fail(where + ": '" + cleanText(std::string(word.substr(0, 40))) + "' is not a number");
    return value;
}

template <class T>
double numberOf(const PlyParser& parser) {
    std::array<char, sizeof(T)> bytes;
    std::copy_n(parser.rest.begin(), sizeof(T), bytes.begin());
    if (parser.swapped) std::reverse(bytes.begin(), bytes.end());
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    return double(value);
}

double readBinary(PlyParser& parser, Type type, const std::string& where) {
    if (parser.rest.size() < sizeOf(type)) parser.fail(where + ": the file is cut short");
    double value = 0;
    switch (type) {
        case Type::kInt8:
            value = numberOf<std::int8_t>(parser);
            break;
        case Type::kUint8:
            value = numberOf<std::uint8_t>(parser);
            break;
        case Type::kInt16:
            value = numberOf<std::int16_t>(parser);
            break;
        case Type::kUint16:
            value = numberOf<std::uint16_t>(parser);
            break;
        case Type::kInt32:
            value = numberOf<std::int32_t>(parser);
            break;
        case Type::kUint32:
            value = numberOf<std::uint32_t>(parser);
            break;
        case Type::kFloat32:
            value = numberOf<float>(parser);
            break;
        case Type::kFloat64:
            value = numberOf<double>(parser);
            break;
    }
    parser.rest.remove_prefix(sizeOf(type));
    return value;
}

double readNumber(PlyParser& parser, Type type, const std::string& where) {
    return parser.ascii ? readWord(parser, where) : readBinary(parser, type, where);
}

std::size_t readCount(PlyParser& parser, const Property& list, const std::string& where) {
    const double count = readNumber(parser, *list.count, where);
    const double most = double(parser.rest.size() / (parser.ascii ? 1 : sizeOf(list.type)));
    if (!(count >= 0 && count <= most) || count != std::floor(count))
        parser.fail(where + ": a list is longer than the file, or not of a whole length");
    return std::size_t(count);
}

// --- Elements -------------------------------------------------------------------------------------------------------

// Refuses more elements than the file can hold: every property takes a byte or more.
void checkCount(const PlyParser& parser, const Element& element) {
    std::size_t least = 0;
    for (const Property& p : element.properties) least += parser.ascii ? 1 : sizeOf(p.count.value_or(p.type));
    if (least == 0 ? element.count > 0 : element.count > parser.rest.size() / least)
        parser.fail("element " + element.name + ": the file is too short for " + std::to_string(element.count));
}

void skipProperty(PlyParser& parser, const Property& property, const std::string& where) {
    const std::size_t count = property.count ? readCount(parser, property, where) : 1;
    for (std::size_t i = 0; i < count; ++i) readNumber(parser, property.type, where);
}

void readVertices(PlyParser& parser, const Element& element, MeshFile& mesh) {
    std::vector<int> axis;
    for (const Property& p : element.properties)
        axis.push_back(p.count                                                      ? -1
                       : p.name.size() == 1 && p.name[0] >= 'x' && p.name[0] <= 'z' ? p.name[0] - 'x'
                                                                                    : -1);
    for (int a = 0; a < 3; ++a)
        if (std::count(axis.begin(), axis.end(), a) != 1)
            parser.fail(std::string("element vertex: needs one property ") + char('x' + a));
    if (element.count > kMaxSourceVertices) throw Unsupported(parser.name + ": has too many vertices");
    mesh.positions.resize(element.count);
    for (std::size_t v = 0; v < element.count; ++v) {
        const std::string where = "vertex " + std::to_string(v);
        for (std::size_t p = 0; p < axis.size(); ++p) {
            if (axis[p] < 0)
                skipProperty(parser, element.properties[p], where);
            else
                mesh.positions[v][axis[p]] = readNumber(parser, element.properties[p].type, where);
        }
    }
}

void readFace(PlyParser& parser, const Property& list, const std::string& where, std::vector<std::uint32_t>& corners) {
    corners.clear();
    const std::size_t count = readCount(parser, list, where);
    if (count < 3) parser.fail(where + ": needs three vertices");
    for (std::size_t i = 0; i < count; ++i) {
        const double v = readNumber(parser, list.type, where);
        if (!(v >= 0 && v < double(kMaxSourceVertices)) || v != std::floor(v))
            parser.fail(where + ": names a vertex that does not exist");
        corners.push_back(std::uint32_t(v));
    }
}

void readFaces(PlyParser& parser, const Element& element, MeshFile& mesh) {
    const auto is_faces = [](const Property& p) {
        return p.count && (p.name == "vertex_indices" || p.name == "vertex_index");
    };
    const auto& properties = element.properties;
    if (std::count_if(properties.begin(), properties.end(), is_faces) != 1)
        parser.fail("element face: needs one list vertex_indices");
    std::vector<std::uint32_t> corners;
    for (std::size_t f = 0; f < element.count; ++f) {
        const std::string where = "face " + std::to_string(f);
        for (const Property& p : properties) {
            if (!is_faces(p)) {
                skipProperty(parser, p, where);
                continue;
            }
            readFace(parser, p, where, corners);
            for (std::size_t k = 2; k < corners.size(); ++k)
                mesh.triangles.push_back({corners[0], corners[k - 1], corners[k]});
        }
    }
}

// Checks corners after reading, because faces may stand before the vertices.
void checkIndices(const PlyParser& parser, const MeshFile& mesh) {
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            if (v >= mesh.positions.size())
                parser.fail("a face names vertex " + std::to_string(v) + " of " +
                            std::to_string(mesh.positions.size()));
}

}  // namespace

MeshFile parsePly(std::string_view bytes, const std::string& name) {
    PlyParser parser;
    parser.rest = bytes;
    parser.name = name;
    if (!bytes.starts_with("ply\n") && !bytes.starts_with("ply\r\n")) parser.fail("is not a PLY file");
    readHeader(parser);
    MeshFile mesh;
    for (const Element& element : parser.elements) {
        checkCount(parser, element);
        if (element.name == "vertex") {
            readVertices(parser, element, mesh);
        } else if (element.name == "face") {
            readFaces(parser, element, mesh);
        } else {
            for (std::size_t i = 0; i < element.count; ++i)
                for (const Property& p : element.properties) skipProperty(parser, p, "element " + element.name);
        }
    }
    if (mesh.positions.empty()) parser.fail("has no vertices");
    checkIndices(parser, mesh);
    return mesh;
}

}  // namespace penumbra
