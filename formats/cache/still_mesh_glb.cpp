// The triangles of a .glb at rest, without a library: the player links no reader of rigs.
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>

#include "formats/cache/still_mesh.h"
#include "formats/common/errors.h"
#include "formats/common/json_node.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxItems = 1 << 20;
constexpr double kMaxBytes = 2147483648.0, kFarthest = 1e9;

// A node's place: 3 rows of 4 numbers.
using Placement = std::array<double, 12>;
constexpr Placement kNotMoved{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

Vec3d moved(const Placement& m, Vec3d p) {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

Placement operator*(const Placement& a, const Placement& b) {
    Placement out{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column) {
            for (std::size_t k = 0; k < 3; ++k) out[4 * row + column] += a[4 * row + k] * b[4 * k + column];
            if (column == 3) out[4 * row + column] += a[4 * row + 3];
        }
    return out;
}

std::uint32_t wordAt(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    return word;
}

// The two chunks of a .glb (glTF 2.0, section 4.4).
struct Chunks {
    std::string json;
    std::span<const std::byte> binary;
};

Chunks chunksOf(std::span<const std::byte> bytes, const std::string& name) {
    constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBinary = 0x004E4942;
    if (bytes.size() < 20 || wordAt(bytes, 0) != kMagic) throw InvalidInput(name + ": is not a .glb, or is cut short");
    if (wordAt(bytes, 4) != 2) throw Unsupported(name + ": is not of glTF 2");
    Chunks out;
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
        const std::size_t size = wordAt(bytes, at);
        const std::uint32_t kind = wordAt(bytes, at + 4);
        if (size > bytes.size() - at - 8) throw InvalidInput(name + ": is cut short");
        const std::span<const std::byte> chunk = bytes.subspan(at + 8, size);
        if (at == 12 && kind != kJson) throw InvalidInput(name + ": does not begin with JSON");
        if (at == 12) out.json.assign(reinterpret_cast<const char*>(chunk.data()), size);
        if (at != 12 && kind == kBinary && out.binary.empty()) out.binary = chunk;
        at += 8 + size;
    }
    return out;
}

class GlbReader {
public:
    GlbReader(const nlohmann::json& json, std::span<const std::byte> binary, const std::string& name)
        : root_(json, name, ""), binary_(binary), name_(name) {
        if (!json.is_object()) root_.fail("must be an object");
        if (root_.has("extensionsRequired") && !root_.at("extensionsRequired").items(kMaxItems).empty())
            throw Unsupported(name + ": needs extensions of glTF, as of compressed meshes");
        nodes_ = listOf("nodes");
        meshes_ = listOf("meshes");
        accessors_ = listOf("accessors");
        views_ = listOf("bufferViews");
    }

    StillMesh read() {
        // Roots are the nodes that no other holds.
        std::vector<bool> is_child(nodes_.size());
        for (const JsonNode& node : nodes_)
            if (node.has("children"))
                for (const JsonNode& child : node.at("children").items(nodes_.size()))
                    is_child[indexOf(child, nodes_.size())] = true;
        visited_.assign(nodes_.size(), false);
        for (std::size_t n = 0; n < nodes_.size(); ++n)
            if (!is_child[n]) walk(n, kNotMoved);
        return std::move(out_);
    }

private:
    JsonNode root_;
    std::span<const std::byte> binary_;
    std::string name_;
    std::vector<JsonNode> nodes_, meshes_, accessors_, views_;
    std::vector<bool> visited_;
    StillMesh out_;

    std::vector<JsonNode> listOf(const char* key) const {
        return root_.has(key) ? root_.at(key).items(kMaxItems) : std::vector<JsonNode>();
    }
    static std::size_t indexOf(const JsonNode& node, std::size_t count) {
        if (count == 0) node.fail("names something that is not there");
        return std::size_t(node.whole(0, int(count - 1)));
    }

    // Every node is visited once, so that a circle ends. The stack is our own: files may nest as deep as they like.
    void walk(std::size_t root, const Placement& above) {
        std::vector<std::pair<std::size_t, Placement>> waiting{{root, above}};
        while (!waiting.empty()) {
            const auto [n, parent] = waiting.back();
            waiting.pop_back();
            if (visited_[n]) nodes_[n].fail("has two parents");
            visited_[n] = true;
            const Placement place = parent * placementOf(nodes_[n]);
            if (nodes_[n].has("mesh")) addMesh(meshes_[indexOf(nodes_[n].at("mesh"), meshes_.size())], place);
            if (!nodes_[n].has("children")) continue;
            for (const JsonNode& child : nodes_[n].at("children").items(nodes_.size()))
                waiting.emplace_back(indexOf(child, nodes_.size()), place);
        }
    }

    static Placement placementOf(const JsonNode& node) {
        Placement out = kNotMoved;
        if (node.has("matrix")) {  // column by column
            const std::vector<float> m = node.at("matrix").numbers(16, -kFarthest, kFarthest);
            for (std::size_t row = 0; row < 3; ++row)
                for (std::size_t column = 0; column < 4; ++column) out[4 * row + column] = double(m[4 * column + row]);
            return out;
        }
        std::vector<float> q{0, 0, 0, 1}, s{1, 1, 1}, t{0, 0, 0};
        if (node.has("rotation")) q = node.at("rotation").numbers(4, -2, 2);
        if (node.has("scale")) s = node.at("scale").numbers(3, -kFarthest, kFarthest);
        if (node.has("translation")) t = node.at("translation").numbers(3, -kFarthest, kFarthest);
        const double x = double(q[0]), y = double(q[1]), z = double(q[2]), w = double(q[3]);
        const std::array<double, 9> turn{1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                                         2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                                         2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
        for (std::size_t row = 0; row < 3; ++row) {
            for (std::size_t column = 0; column < 3; ++column)
                out[4 * row + column] = turn[3 * row + column] * double(s[column]);
            out[4 * row + 3] = double(t[row]);
        }
        return out;
    }

    struct Numbers {
        std::span<const std::byte> bytes;
        std::size_t count = 0, stride = 0;
        int type = 0;  // glTF's componentType
    };

    // Returns the numbers of an accessor, of which `width` belong together.
    Numbers numbersOf(const JsonNode& at, const char* shape, std::size_t width) const {
        const JsonNode accessor = accessors_[indexOf(at, accessors_.size())];
        if (accessor.required("type").text() != shape) accessor.at("type").fail("is not " + std::string(shape));
        if (accessor.has("sparse")) accessor.fail("is sparse, which is not read");
        Numbers out;
        out.type = accessor.required("componentType").whole(0, 1 << 16);
        const std::size_t size = out.type == 5121 ? 1 : out.type == 5123 ? 2 : 4;
        if (out.type != 5121 && out.type != 5123 && out.type != 5125 && out.type != 5126)
            accessor.at("componentType").fail("is of numbers that are not read");
        out.count = std::size_t(accessor.required("count").number(1, kMaxBytes));
        const JsonNode view = views_[indexOf(accessor.required("bufferView"), views_.size())];
        if (view.required("buffer").whole(0, 1 << 20) != 0) throw Unsupported(name_ + ": has a buffer outside of it");
        const auto offsetOf = [](const JsonNode& node) {
            return node.has("byteOffset") ? std::size_t(node.at("byteOffset").number(0, kMaxBytes)) : 0;
        };
        const std::size_t length = std::size_t(view.required("byteLength").number(0, kMaxBytes));
        const std::size_t first = offsetOf(view), inside = offsetOf(accessor);
        out.stride = view.has("byteStride") ? std::size_t(view.at("byteStride").whole(1, 252)) : size * width;
        if (first > binary_.size() || length > binary_.size() - first) view.fail("reaches past the end of the file");
        if (inside > length || out.stride < size * width || out.count - 1 > (length - inside) / out.stride ||
            (out.count - 1) * out.stride + size * width > length - inside)
            accessor.fail("reaches past the end of its buffer view");
        out.bytes = binary_.subspan(first + inside, length - inside);
        return out;
    }

    void addMesh(const JsonNode& mesh, const Placement& place) {
        for (const JsonNode& primitive : mesh.required("primitives").items(kMaxItems)) {
            if (primitive.has("mode") && primitive.at("mode").whole(0, 6) != 4) continue;  // lines and points
            const JsonNode at = primitive.required("attributes").required("POSITION");
            const Numbers points = numbersOf(at, "VEC3", 3);
            if (points.type != 5126) at.fail("must be of floats");
            const auto first = std::uint32_t(out_.positions.size());
            if (out_.positions.size() + points.count > kMaxItems * 64) mesh.fail("has too many vertices");
            for (std::size_t v = 0; v < points.count; ++v) {
                std::array<float, 3> p;
                std::memcpy(p.data(), points.bytes.data() + v * points.stride, sizeof p);
                out_.positions.push_back(toFloat(moved(place, {p[0], p[1], p[2]})));
            }
            addTriangles(primitive, first, std::uint32_t(points.count));
        }
    }

    void addTriangles(const JsonNode& primitive, std::uint32_t first, std::uint32_t vertices) {
        std::vector<std::uint32_t> corners;
        if (!primitive.has("indices")) {
            for (std::uint32_t v = 0; v < vertices; ++v) corners.push_back(v);
        } else {
            const JsonNode at = primitive.at("indices");
            const Numbers list = numbersOf(at, "SCALAR", 1);
            if (list.type == 5126) at.fail("must be of whole numbers");
            const std::size_t size = list.type == 5121 ? 1 : list.type == 5123 ? 2 : 4;
            for (std::size_t i = 0; i < list.count; ++i) {
                std::uint32_t corner = 0;  // little endian, as the file is
                std::memcpy(&corner, list.bytes.data() + i * list.stride, size);
                if (corner >= vertices) at.fail("names vertex " + std::to_string(corner) + ", which is not there");
                corners.push_back(corner);
            }
        }
        if (corners.size() % 3 != 0) primitive.fail("has no whole number of triangles");
        for (const std::uint32_t corner : corners) out_.triangles.push_back(first + corner);
    }
};

}  // namespace

StillMesh parseStillGlb(std::span<const std::byte> bytes, const std::string& name) {
    const Chunks chunks = chunksOf(bytes, name);
    const nlohmann::json json = parseJson(chunks.json, name);
    StillMesh mesh = GlbReader(json, chunks.binary, name).read();
    if (mesh.triangles.empty()) throw InvalidInput(name + ": has no triangles");
    return mesh;
}

}  // namespace penumbra
