// Reads the nodes of binary FBX files. Every length is checked against the bytes that are there before it is used.
#include "formats/rig/fbx/fbx_tree.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

const FbxNode* FbxNode::child(std::string_view child_name) const {
    const auto found =
        std::find_if(children.begin(), children.end(), [&](const FbxNode& node) { return node.name == child_name; });
    return found == children.end() ? nullptr : &*found;
}

const FbxValue& FbxNode::value(std::size_t index) const {
    static const FbxValue nothing;
    return index < values.size() ? values[index] : nothing;
}

bool isFbxArrayRead(std::string_view name) {
    constexpr std::string_view kRead[] = {"KeyTime",          "KeyValueFloat", "KeyAttrFlags",
                                          "KeyAttrDataFloat", "Indexes",       "KeyAttrRefCount",
                                          "Weights",          "FullWeights",   "PolygonVertexIndex"};
    return std::find(std::begin(kRead), std::end(kRead), name) != std::end(kRead);
}

namespace {

constexpr std::string_view kMagic("Kaydara FBX Binary  \0\x1a\0", 23);

struct FbxBinaryParser {
    std::string_view bytes;
    const std::filesystem::path& path;
    bool wide = false;  // 64-bit lengths
    std::size_t at = 0;
    std::uint64_t numbers = 0, nodes = 0;

    [[noreturn]] void failCut() const {
        failAtFile(path, "is cut short: its FBX nodes go on behind byte " + std::to_string(bytes.size()));
    }
    [[noreturn]] void fail(const std::string& node, const char* problem) const {
        failAtFile(path, "FBX node '" + node + "': " + problem);
    }

    std::string_view take(std::uint64_t size, std::size_t end) {
        if (at > end || size > end - at) failCut();
        const std::string_view taken = bytes.substr(at, std::size_t(size));
        at += std::size_t(size);
        return taken;
    }
    template <class T>
    T read(std::size_t end) {
        T value;
        std::memcpy(&value, take(sizeof value, end).data(), sizeof value);
        return value;
    }
    std::uint64_t readLength(std::size_t end) { return wide ? read<std::uint64_t>(end) : read<std::uint32_t>(end); }
};

template <class T>
std::vector<double> numbersOf(std::string_view raw) {
    std::vector<double> out(raw.size() / sizeof(T));
    for (std::size_t i = 0; i < out.size(); ++i) {
        T value;
        std::memcpy(&value, raw.data() + i * sizeof(T), sizeof(T));
        out[i] = double(value);
    }
    return out;
}

std::vector<double> numbersOf(std::string_view raw, char type) {
    switch (type) {
        case 'f':
            return numbersOf<float>(raw);
        case 'd':
            return numbersOf<double>(raw);
        case 'l':
            return numbersOf<std::int64_t>(raw);
        case 'i':
            return numbersOf<std::int32_t>(raw);
        default:
            return numbersOf<std::uint8_t>(raw);
    }
}

std::size_t sizeOfNumber(char type) {
    if (type == 'd' || type == 'l') return 8;
    return type == 'f' || type == 'i' ? 4 : 1;
}

// Reads an array: u32 count, u32 encoding (1 = deflated), u32 bytes, the bytes.
void readArray(FbxBinaryParser& parser, char type, std::size_t end, FbxNode& node) {
    const std::uint32_t count = parser.read<std::uint32_t>(end), encoding = parser.read<std::uint32_t>(end),
                        size = parser.read<std::uint32_t>(end);
    const std::string_view packed = parser.take(size, end);
    node.count = count;
    if (!isFbxArrayRead(node.name)) return;
    parser.numbers += count;
    if (parser.numbers > kMaxFbxNumbers) parser.fail(node.name, "its numbers are too many");
    const std::size_t raw_size = count * sizeOfNumber(type);
    if (encoding == 0) {
        if (packed.size() != raw_size) parser.fail(node.name, "its bytes are not as many as its numbers take");
        node.numbers = numbersOf(packed, type);
    } else if (encoding == 1) {
        // deflate makes at most 1032 bytes of one
        if (raw_size / 1032 > packed.size()) parser.fail(node.name, "its compressed bytes are too few");
        std::string raw(raw_size, '\0');
        uLongf got = uLongf(raw_size);
        if (uncompress(reinterpret_cast<Bytef*>(raw.data()), &got, reinterpret_cast<const Bytef*>(packed.data()),
                       uLong(packed.size())) != Z_OK ||
            got != raw_size)
            parser.fail(node.name, "its compressed bytes are damaged");
        node.numbers = numbersOf(raw, type);
    } else {
        parser.fail(node.name, "its array has an unknown encoding");
    }
}

template <class T>
FbxValue numberValue(FbxBinaryParser& parser, std::size_t end) {
    const T value = parser.read<T>(end);
    return {{}, double(value), std::is_integral_v<T> ? std::int64_t(value) : 0};
}

void readValue(FbxBinaryParser& parser, std::size_t end, FbxNode& node) {
    const char type = parser.read<char>(end);
    FbxValue value;
    switch (type) {
        case 'Y':
            value = numberValue<std::int16_t>(parser, end);
            break;
        case 'B':
        case 'C':
        case 'Z':
            value = numberValue<std::uint8_t>(parser, end);
            break;
        case 'I':
            value = numberValue<std::int32_t>(parser, end);
            break;
        case 'L':
            value = numberValue<std::int64_t>(parser, end);
            break;
        case 'F': {
            value.number = double(parser.read<float>(end));
            break;
        }
        case 'D':
            value.number = parser.read<double>(end);
            break;
        case 'S':
            value.text = parser.take(parser.read<std::uint32_t>(end), end).substr(0, 4096);
            break;
        case 'R':
            parser.take(parser.read<std::uint32_t>(end), end);
            break;
        case 'f':
        case 'd':
        case 'l':
        case 'i':
        case 'b':
        case 'c':
            readArray(parser, type, end, node);
            break;
        default:
            parser.fail(node.name, "has a value of an unknown type");
    }
    if (type != 'S' && type != 'R' && type < 'a') {  // FBX 6 writes arrays as so many values
        ++node.count;
        if (isFbxArrayRead(node.name)) {
            if (++parser.numbers > kMaxFbxNumbers) parser.fail(node.name, "its numbers are too many");
            node.numbers.push_back(value.number);
        }
    }
    if (node.values.size() < kMaxFbxValues) node.values.push_back(std::move(value));
}

// Reads records until an empty one. The list of a node may also end with its bytes; that of the file may not.
void readRecords(FbxBinaryParser& parser, std::size_t end, int depth, FbxNode& parent) {
    if (depth > kDeepestFbxNode) parser.fail(parent.name, "its nodes are nested too deeply");
    while (depth == 0 || parser.at < end) {
        const std::uint64_t node_end = parser.readLength(end), values = parser.readLength(end);
        parser.readLength(end);
        const std::uint8_t name_size = parser.read<std::uint8_t>(end);
        if (node_end == 0) return;
        if (++parser.nodes > kMaxFbxNodes) parser.fail(parent.name, "the file has too many nodes");
        FbxNode& node = parent.children.emplace_back();
        node.name = parser.take(name_size, end);
        if (node_end > parser.bytes.size()) parser.failCut();
        if (node_end > end || node_end < parser.at) parser.fail(node.name, "its end lies outside of its parent");
        for (std::uint64_t v = 0; v < values; ++v) readValue(parser, std::size_t(node_end), node);
        if (parser.at < node_end) readRecords(parser, std::size_t(node_end), depth + 1, node);
        parser.at = std::size_t(node_end);
    }
}

}  // namespace

FbxTree parseFbxTree(std::string_view bytes, const std::filesystem::path& path) {
    if (bytes.starts_with(kMagic.substr(0, 18)) && !bytes.starts_with(kMagic))
        failAtFile(path, "its binary FBX header is damaged, cut short or of a big-endian machine");
    if (!bytes.starts_with(kMagic)) return parseFbxText(bytes, path);
    FbxBinaryParser parser{bytes, path};
    parser.at = kMagic.size();
    FbxTree tree;
    tree.version = int(parser.read<std::uint32_t>(bytes.size()) & 0xffffff);
    parser.wide = tree.version >= 7500;
    readRecords(parser, bytes.size(), 0, tree.root);
    return tree;
}

FbxTree readFbxTree(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw IoError(path.string() + ": cannot be read: " + std::strerror(errno));
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    if (in.bad()) throw IoError(path.string() + ": cannot be read: " + std::strerror(errno));
    return parseFbxTree(bytes, path);
}

}  // namespace penumbra
