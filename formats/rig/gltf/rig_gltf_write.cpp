// Writes a rig as a glTF 2.0 binary. What readRig() welded, bound to joints and turned is written as one skinned
// mesh, so that reading finds nothing left to do.
#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/common/errors.h"
#include "formats/common/provenance.h"
#include "formats/common/write_file.h"
#include "formats/rig/rig_matrix.h"
#include "formats/rig/rig_morphs.h"
#include "formats/rig/rig_poses.h"

namespace penumbra {

using OrderedJson = nlohmann::ordered_json;

namespace {

// Component types of glTF 2.0, section 5.1.3.
enum Component : int { kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126 };

class GlbWriter {
public:
    OrderedJson json;

    // Adds one accessor with a buffer view of its own, and returns its index. Every array is a multiple of 4 bytes
    // long.
    template <class T>
    std::size_t add(const std::vector<T>& values, Component component, const char* type, std::size_t width) {
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", values.size() * sizeof(T)}});
        const char* bytes = reinterpret_cast<const char*>(values.data());
        binary_.append(bytes, values.size() * sizeof(T));
        binary_.resize((binary_.size() + 3) / 4 * 4, '\0');
        json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                     {"componentType", int(component)},
                                     {"count", values.size() / width},
                                     {"type", type}});
        return json["accessors"].size() - 1;
    }

    // Adds an accessor with its range, which the specification wants for positions and key times.
    std::size_t addWithRange(const std::vector<float>& values, const char* type, std::size_t width) {
        const std::size_t index = add(values, kFloat, type, width);
        std::vector<float> low(values.begin(), values.begin() + std::ptrdiff_t(width)), high = low;
        for (std::size_t i = 0; i < values.size(); ++i) {
            low[i % width] = std::min(low[i % width], values[i]);
            high[i % width] = std::max(high[i % width], values[i]);
        }
        json["accessors"][index]["min"] = low;
        json["accessors"][index]["max"] = high;
        return index;
    }

    // Adds an accessor of `count` zeros, except for rows of `values` at the ascending `indices`.
    std::size_t addSparse(const std::vector<std::uint32_t>& indices, const std::vector<float>& values,
                          std::size_t count) {
        OrderedJson accessor{{"componentType", int(kFloat)}, {"count", count}, {"type", "VEC3"}};
        if (!indices.empty()) {
            add(indices, kUnsignedInt, "SCALAR", 1);  // the accessors of the two views are not needed
            add(values, kFloat, "VEC3", 3);
            json["accessors"].erase(json["accessors"].size() - 1);
            json["accessors"].erase(json["accessors"].size() - 1);
            const std::size_t views = json["bufferViews"].size();
            accessor["sparse"] = {{"count", indices.size()},
                                  {"indices", {{"bufferView", views - 2}, {"componentType", int(kUnsignedInt)}}},
                                  {"values", {{"bufferView", views - 1}}}};
        }
        json["accessors"].push_back(std::move(accessor));
        return json["accessors"].size() - 1;
    }

    std::string bytes(const std::filesystem::path& path) {
        json["buffers"] = {{{"byteLength", binary_.size()}}};
        std::string text = json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const std::uint64_t size = 28 + std::uint64_t(text.size()) + binary_.size();
        if (size > 0xffffffffu) throw Unsupported(path.string() + ": would exceed the 4 GiB of a glTF binary");
        return "glTF" + number(2) + number(size) + number(text.size()) + "JSON" + text + number(binary_.size()) +
               std::string("BIN\0", 4) + binary_;
    }

private:
    std::string binary_;

    static std::string number(std::uint64_t value) {
        const auto v = std::uint32_t(value);
        return {char(v), char(v >> 8), char(v >> 16), char(v >> 24)};
    }
};

// The nodes as they are written. glTF allows a node once in a skin, so the second joint of a node moves with a copy.
struct WrittenNodes {
    std::vector<Node> nodes;
    std::vector<int> original;       // original node of each written one
    std::vector<int> node_of_joint;  // [J]
};

WrittenNodes nodesToWrite(const Rig& rig) {
    WrittenNodes out{rig.nodes, {}, {}};
    for (std::size_t n = 0; n < rig.nodes.size(); ++n) out.original.push_back(int(n));
    std::map<int, int> uses;
    for (const int node : rig.node_of_joint) {
        if (uses[node]++ == 0) {
            out.node_of_joint.push_back(node);
            continue;
        }
        out.node_of_joint.push_back(int(out.nodes.size()));
        out.nodes.push_back(rig.nodes[std::size_t(node)]);
        out.original.push_back(node);
    }
    return out;
}

void writeNodes(const WrittenNodes& nodes, GlbWriter& out) {
    OrderedJson roots = OrderedJson::array(), list = OrderedJson::array();
    for (std::size_t n = 0; n < nodes.nodes.size(); ++n) {
        const Node& node = nodes.nodes[n];
        OrderedJson entry{{"name", node.name}};
        if (node.matrix) {
            entry["matrix"] = *node.matrix;
        } else {
            entry["translation"] = node.translation;
            entry["rotation"] = node.rotation;
            entry["scale"] = node.scale;
        }
        list.push_back(std::move(entry));
        if (node.parent < 0)
            roots.push_back(n);
        else
            list[std::size_t(node.parent)]["children"].push_back(n);
    }
    roots.push_back(list.size());
    list.push_back({{"name", "mesh"}, {"mesh", 0}, {"skin", 0}});
    out.json["scene"] = 0;
    out.json["scenes"] = {{{"nodes", roots}}};
    out.json["nodes"] = std::move(list);
}

// Tells which joints mirror at rest. Reading turns the triangles whose first vertex hangs on such a joint
// (rig_weld.cpp), so these are written turned.
std::vector<bool> mirroringJoints(const Rig& rig) {
    const std::vector<Matrix> globals = restGlobals(rig.nodes);
    std::vector<bool> mirrors;
    for (std::size_t j = 0; j < rig.inverse_bind.size(); ++j)
        mirrors.push_back(determinant(multiply(globals[std::size_t(rig.node_of_joint[j])], rig.inverse_bind[j])) < 0);
    return mirrors;
}

// Returns the shading point of each vertex that is written: those of the source, then the points that have none (of a
// vertex that became several).
std::vector<std::uint32_t> writtenPoints(const Mesh& mesh) {
    std::vector<std::uint32_t> points = mesh.source_vertex;
    std::vector<bool> seen(mesh.vertexCount());
    for (const std::uint32_t p : points) seen[p] = true;
    for (std::uint32_t p = 0; p < seen.size(); ++p)
        if (!seen[p]) points.push_back(p);
    return points;
}

std::vector<std::uint32_t> cornersOf(const Rig& rig, const std::vector<std::uint32_t>& written) {
    // Any written vertex of a shading point will do, as reading welds it again.
    std::vector<std::uint32_t> source_of_point(rig.mesh.vertexCount());
    for (std::size_t r = written.size(); r-- > 0;) source_of_point[written[r]] = std::uint32_t(r);
    const std::vector<bool> mirrors = mirroringJoints(rig);
    std::vector<std::uint32_t> corners;
    for (const Triangle& t : rig.mesh.triangles) {
        const bool mirrored = mirrors[rig.skin.joints[t[0] * std::size_t(rig.skin.influences)]];
        for (const std::uint32_t v : {t[0], t[mirrored ? 2 : 1], t[mirrored ? 1 : 2]})
            corners.push_back(source_of_point[v]);
    }
    return corners;
}

// Writes JOINTS_n and WEIGHTS_n for n = 0, 1, ..., which have four influences each.
void writeInfluences(const Rig& rig, const std::vector<std::uint32_t>& written, OrderedJson& attributes,
                     GlbWriter& out) {
    const std::size_t influences = std::size_t(rig.skin.influences);
    for (std::size_t first = 0; first < influences; first += 4) {
        std::vector<std::uint16_t> joints;
        std::vector<float> weights;
        for (const std::uint32_t v : written)
            for (std::size_t k = first; k < first + 4; ++k) {
                joints.push_back(k < influences ? rig.skin.joints[v * influences + k] : std::uint16_t(0));
                weights.push_back(k < influences ? rig.skin.weights[v * influences + k] : 0.0f);
            }
        const std::string set = std::to_string(first / 4);
        attributes["JOINTS_" + set] = out.add(joints, kUnsignedShort, "VEC4", 4);
        attributes["WEIGHTS_" + set] = out.add(weights, kFloat, "VEC4", 4);
    }
}

std::vector<float> ofWritten(const std::vector<std::uint32_t>& written, const std::vector<Vec3>& of_point) {
    std::vector<float> out;
    for (const std::uint32_t v : written) out.insert(out.end(), {of_point[v].x, of_point[v].y, of_point[v].z});
    return out;
}

// Writes the targets by source vertices, each with the names and weights that reading finds again.
void writeTargets(const Rig& rig, GlbWriter& out) {
    const MorphTargets morphs = selectVertices(rig.mesh.morphs, rig.mesh.source_vertex);
    if (morphs.empty()) return;
    const std::size_t count = rig.mesh.source_vertex.size();
    OrderedJson targets = OrderedJson::array();
    for (std::size_t m = 0; m < morphs.count(); ++m) {
        const MorphRows rows = morphs.rowsOf(m);
        const std::vector<std::uint32_t> vertices(rows.vertices.begin(), rows.vertices.end());
        std::vector<float> positions, normals;
        for (std::size_t r = 0; r < vertices.size(); ++r) {
            positions.insert(positions.end(), {rows.positions[r].x, rows.positions[r].y, rows.positions[r].z});
            normals.insert(normals.end(), {rows.normals[r].x, rows.normals[r].y, rows.normals[r].z});
        }
        targets.push_back({{"POSITION", out.addSparse(vertices, positions, count)},
                           {"NORMAL", out.addSparse(vertices, normals, count)}});
    }
    OrderedJson& mesh = out.json["meshes"][0];
    mesh["primitives"][0]["targets"] = std::move(targets);
    mesh["weights"] = morphs.rest_weights;
    mesh["extras"]["targetNames"] = morphs.names;
}

void writeMesh(const Rig& rig, const WrittenNodes& nodes, GlbWriter& out) {
    // Normals turn as triangles do.
    const std::vector<bool> mirrors = mirroringJoints(rig);
    std::vector<Vec3> normals = rig.rest_normals;
    for (std::size_t p = 0; p < normals.size(); ++p)
        if (mirrors[rig.skin.joints[p * std::size_t(rig.skin.influences)]]) normals[p] = -normals[p];
    const std::vector<std::uint32_t> written = writtenPoints(rig.mesh);
    OrderedJson attributes;
    attributes["POSITION"] = out.addWithRange(ofWritten(written, rig.mesh.rest_positions), "VEC3", 3);
    attributes["NORMAL"] = out.add(ofWritten(written, normals), kFloat, "VEC3", 3);
    writeInfluences(rig, written, attributes, out);
    const std::size_t corners = out.add(cornersOf(rig, written), kUnsignedInt, "SCALAR", 1);
    out.json["meshes"] = {{{"primitives", {{{"attributes", attributes}, {"indices", corners}}}}}};
    writeTargets(rig, out);
    std::vector<float> inverse_bind;  // column by column
    for (const Matrix& m : rig.inverse_bind)
        for (std::size_t c = 0; c < 4; ++c)
            for (std::size_t r = 0; r < 4; ++r) inverse_bind.push_back(r < 3 ? float(m[4 * r + c]) : float(c == 3));
    out.json["skins"] = {
        {{"joints", nodes.node_of_joint}, {"inverseBindMatrices", out.add(inverse_bind, kFloat, "MAT4", 16)}}};
}

OrderedJson writeChannel(const Channel& channel, OrderedJson& samplers, GlbWriter& out) {
    static constexpr std::array<const char*, 3> kPaths{"translation", "rotation", "scale"};
    static constexpr std::array<const char*, 3> kModes{"STEP", "LINEAR", "CUBICSPLINE"};
    const bool rotation = channel.path == Channel::Path::kRotation;
    const std::size_t times = out.addWithRange({channel.times.begin(), channel.times.end()}, "SCALAR", 1);
    samplers.push_back({{"input", times},
                        {"output", out.add(channel.values, kFloat, rotation ? "VEC4" : "VEC3", rotation ? 4 : 3)},
                        {"interpolation", kModes[std::size_t(channel.interpolation)]}});
    return {{"sampler", samplers.size() - 1}, {"target", {{"path", kPaths[std::size_t(channel.path)]}}}};
}

// Writes the weights of a clip as one channel, as glTF has one for a node. Curves of several meshes are brought to the
// keys of all, which changes nothing where all step or all are linear.
void writeWeights(const Rig& rig, int clip, OrderedJson& samplers, OrderedJson& channels, GlbWriter& out) {
    std::set<double> times;
    std::set<Interpolation> modes;
    for (const WeightCurve& curve : rig.weight_curves) {
        if (curve.clip != clip) continue;
        times.insert(curve.times.begin(), curve.times.end());
        modes.insert(curve.interpolation);
    }
    if (times.empty()) return;
    if (modes.size() > 1 || modes.contains(Interpolation::kCubicSpline))
        throw Unsupported("clip '" + rig.clips[std::size_t(clip)].name +
                          "': writes morph weights that all step or are all linear");
    std::vector<float> values;
    for (const double time : times) {
        const std::vector<float> weights = weightsAt(rig, clip, time);
        values.insert(values.end(), weights.begin(), weights.end());
    }
    const std::size_t input = out.addWithRange({times.begin(), times.end()}, "SCALAR", 1);
    samplers.push_back({{"input", input},
                        {"output", out.add(values, kFloat, "SCALAR", 1)},
                        {"interpolation", modes.contains(Interpolation::kStep) ? "STEP" : "LINEAR"}});
    channels.push_back(
        {{"sampler", samplers.size() - 1}, {"target", {{"node", out.json["nodes"].size() - 1}, {"path", "weights"}}}});
}

void writeClip(const Rig& rig, std::size_t index, const WrittenNodes& nodes, GlbWriter& out) {
    const Clip& clip = rig.clips[index];
    std::multimap<int, int> written_of_node;
    for (std::size_t n = 0; n < nodes.original.size(); ++n) written_of_node.emplace(nodes.original[n], int(n));
    OrderedJson samplers = OrderedJson::array(), channels = OrderedJson::array();
    for (const Channel& channel : clip.channels) {
        OrderedJson entry = writeChannel(channel, samplers, out);
        const auto [first, last] = written_of_node.equal_range(channel.node);
        for (auto it = first; it != last; ++it) {
            entry["target"]["node"] = it->second;
            channels.push_back(entry);
        }
    }
    writeWeights(rig, int(index), samplers, channels, out);
    out.json["animations"].push_back({{"name", clip.name}, {"samplers", samplers}, {"channels", channels}});
}

}  // namespace

void writeGlb(const std::filesystem::path& path, const Rig& rig, const std::string& extras) {
    GlbWriter out;
    out.json["asset"] = {{"version", "2.0"}, {"generator", "Penumbra " + std::string(penumbraVersion())}};
    if (!extras.empty()) out.json["extras"] = OrderedJson::parse(extras);
    const WrittenNodes nodes = nodesToWrite(rig);
    writeNodes(nodes, out);
    writeMesh(rig, nodes, out);
    for (std::size_t c = 0; c < rig.clips.size(); ++c) writeClip(rig, c, nodes, out);
    writeWholeFile(path, out.bytes(path));
}

}  // namespace penumbra
