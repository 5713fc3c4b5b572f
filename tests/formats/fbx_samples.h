#pragma once
// Small FBX files for tests: nodes that are written as ASCII and as binary files, with arrays deflated or not.
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <numbers>
#include <string>
#include <variant>
#include <vector>

namespace penumbra::samples {

using FbxNumbers = std::vector<double>;
using FbxIntegers = std::vector<std::int64_t>;
using FbxSampleValue = std::variant<std::int64_t, double, std::string, FbxNumbers, FbxIntegers>;

struct FbxSample {
    std::string name;
    std::vector<FbxSampleValue> values;
    std::vector<FbxSample> children;

    FbxSample& add(FbxSample child) { return children.emplace_back(std::move(child)); }
};

inline std::string fbxNumber(double v) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", v);
    return text;
}

inline std::string asciiOf(const FbxSample& node) {
    std::string text = node.name + ": ", rest;
    for (std::size_t i = 0; i < node.values.size(); ++i) {
        if (i > 0) text += ", ";
        if (const auto* integer = std::get_if<std::int64_t>(&node.values[i])) text += std::to_string(*integer);
        if (const auto* number = std::get_if<double>(&node.values[i])) text += fbxNumber(*number);
        if (const auto* words = std::get_if<std::string>(&node.values[i])) text += "\"" + *words + "\"";
        const auto list = [&](const auto& numbers, auto print) {
            text += "*" + std::to_string(numbers.size()) + " {\n a: ";
            for (std::size_t k = 0; k < numbers.size(); ++k) text += (k > 0 ? "," : "") + print(numbers[k]);
            text += "\n}";
        };
        if (const auto* numbers = std::get_if<FbxNumbers>(&node.values[i])) list(*numbers, fbxNumber);
        if (const auto* integers = std::get_if<FbxIntegers>(&node.values[i]))
            list(*integers, [](std::int64_t v) { return std::to_string(v); });
    }
    const bool is_object = node.values.size() == 3 && node.name.size() > 1;  // the FBX SDK wants its braces
    if (node.children.empty() && !is_object) return text + "\n";
    text += " {\n";
    for (const FbxSample& child : node.children) text += asciiOf(child);
    return text + "}\n";
}

// Adds the counts of objects, without which the FBX SDK reads no mesh.
inline FbxSample withDefinitions(FbxSample root) {
    std::map<std::string, std::int64_t> counts;
    for (const FbxSample& section : root.children)
        if (section.name == "Objects")
            for (const FbxSample& object : section.children) ++counts[object.name];
    FbxSample definitions{"Definitions", {}, {{"Version", {std::int64_t(100)}, {}}}};
    for (const auto& [kind, count] : counts) definitions.add({"ObjectType", {kind}, {{"Count", {count}, {}}}});
    root.children.insert(root.children.begin() + 2, std::move(definitions));
    return root;
}

inline std::string asciiFile(const FbxSample& plain_root) {
    const FbxSample root = withDefinitions(plain_root);
    std::string text = "; FBX 7.4.0 project file\n";
    for (const FbxSample& node : root.children) text += asciiOf(node);
    return text;
}

template <class T>
void putFbx(std::string& out, T value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
void putFbxArray(std::string& out, char type, const std::vector<T>& numbers, bool deflated) {
    std::string raw(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
    if (deflated) {
        std::string packed(compressBound(uLong(raw.size())), '\0');
        uLongf size = uLongf(packed.size());
        compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
                 uLong(raw.size()));
        raw = packed.substr(0, size);
    }
    out += type;
    for (const std::size_t v : {numbers.size(), std::size_t(deflated), raw.size()}) putFbx(out, std::uint32_t(v));
    out += raw;
}

// `wide`: as from version 7500 on.
inline void putBinary(const FbxSample& node, std::string& out, bool wide, bool deflated) {
    const std::size_t start = out.size(), word = wide ? 8 : 4;
    out.append(3 * word, '\0');
    out += char(node.name.size());
    out += node.name;
    const std::size_t values = out.size();
    for (const FbxSampleValue& value : node.values) {
        if (const auto* integer = std::get_if<std::int64_t>(&value)) {
            out += 'L';
            putFbx(out, *integer);
        } else if (const auto* number = std::get_if<double>(&value)) {
            out += 'D';
            putFbx(out, *number);
        } else if (const auto* text = std::get_if<std::string>(&value)) {
            const std::size_t colons = text->find("::");  // "Model::arm" is "arm\0\1Model"
            const std::string stored = colons == std::string::npos ? *text
                                                                   : text->substr(colons + 2) + std::string("\0\1", 2) +
                                                                         text->substr(0, colons);
            out += 'S';
            putFbx(out, std::uint32_t(stored.size()));
            out += stored;
        } else if (const auto* numbers = std::get_if<FbxNumbers>(&value)) {
            putFbxArray(out, 'd', *numbers, deflated);
        } else {
            putFbxArray(out, 'l', std::get<FbxIntegers>(value), deflated);
        }
    }
    const std::uint64_t head[3] = {0, node.values.size(), out.size() - values};
    for (const FbxSample& child : node.children) putBinary(child, out, wide, deflated);
    if (!node.children.empty()) out.append(3 * word + 1, '\0');
    for (std::size_t i = 0; i < 3; ++i) {
        const std::uint64_t v = i == 0 ? out.size() : head[i];
        std::memcpy(out.data() + start + i * word, &v, word);
    }
}

inline std::string binaryFile(const FbxSample& plain_root, std::uint32_t version, bool deflated) {
    const FbxSample root = withDefinitions(plain_root);
    std::string out("Kaydara FBX Binary  \0\x1a\0", 23);
    putFbx(out, version);
    for (const FbxSample& node : root.children) putBinary(node, out, version >= 7500, deflated);
    out.append(version >= 7500 ? 25 : 13, '\0');
    return out;
}

// A tube of two rings on the bones "root" and "arm", y up, in centimetres, with one take. Tests change it.
struct FbxRig {
    static constexpr double kTicks = 46186158000.0;
    FbxSample root;
    std::int64_t next = 2000;

    FbxSample& section(const std::string& name) {
        for (FbxSample& node : root.children)
            if (node.name == name) return node;
        return root.add({name, {}, {}});
    }
    FbxSample& object(const std::string& kind, std::int64_t id) {
        for (FbxSample& node : section("Objects").children)
            if (node.name == kind && std::get<std::int64_t>(node.values[0]) == id) return node;
        return root;
    }
    void link(std::int64_t child, std::int64_t parent, const std::string& property = "") {
        FbxSample node{"C", {property.empty() ? "OO" : "OP", child, parent}, {}};
        if (!property.empty()) node.values.push_back(property);
        section("Connections").add(std::move(node));
    }
    // The FBX SDK goes by the type that stands in the file.
    static FbxSample property(const std::string& name, std::vector<FbxSampleValue> values) {
        const bool whole = std::holds_alternative<std::int64_t>(values.at(0));
        std::string type = whole ? "int" : values.size() == 3 ? "Vector3D" : "Number";
        if (name.starts_with("Lcl ")) type = name;
        if (name == "InheritType" || name == "TimeMode") type = "enum";
        if (name.starts_with("Local")) type = "KTime";
        FbxSample p{"P", {name, type, std::string(""), std::string("A")}, {}};
        p.values.insert(p.values.end(), values.begin(), values.end());
        return p;
    }
    void setProperty(const std::string& kind, std::int64_t id, FbxSample p) {
        FbxSample& node = object(kind, id);
        for (FbxSample& child : node.children)
            if (child.name == "Properties70") {
                child.add(std::move(p));
                return;
            }
        node.add({"Properties70", {}, {std::move(p)}});
    }
    void model(std::int64_t id, const std::string& name, const std::string& kind, std::int64_t parent) {
        section("Objects").add({"Model", {id, "Model::" + name, kind}, {}});
        setProperty("Model", id, property("InheritType", {std::int64_t(1)}));
        setProperty("Model", id, property("DefaultAttributeIndex", {std::int64_t(0)}));
        link(id, parent);
    }
    // A take, and its layer 1 above it.
    void take(std::int64_t id, const std::string& name, double start, double stop) {
        section("Objects").add({"AnimationStack", {id, "AnimStack::" + name, std::string("")}, {}});
        for (const auto& [key, seconds] : {std::pair("LocalStart", start), std::pair("LocalStop", stop)})
            setProperty("AnimationStack", id, property(key, {std::int64_t(seconds * kTicks)}));
        layer(id + 1, id);
    }
    void layer(std::int64_t id, std::int64_t of_take) {
        section("Objects").add({"AnimationLayer", {id, std::string("AnimLayer::base"), std::string("")}, {}});
        link(id, of_take);
    }
    // Curves of a property: times and values of each axis; an axis without times has no curve. flag 4: linear.
    void curves(std::int64_t of_layer, std::int64_t of_object, const std::string& of_property,
                const std::vector<std::pair<FbxNumbers, FbxNumbers>>& axes, std::int64_t flag = 4) {
        const std::int64_t node = next++;
        section("Objects").add(
            {"AnimationCurveNode",
             {node, std::string("AnimCurveNode::R"), std::string("")},
             {{"Properties70", {}, {property("d|X", {0.0}), property("d|Y", {0.0}), property("d|Z", {0.0})}}}});
        link(node, of_layer);
        link(node, of_object, of_property);
        for (std::size_t axis = 0; axis < axes.size(); ++axis) {
            const auto& [times, values] = axes[axis];
            if (times.empty()) continue;
            const std::int64_t curve = next++;
            FbxIntegers ticks;
            for (const double t : times) ticks.push_back(std::int64_t(t * kTicks));
            section("Objects").add({"AnimationCurve",
                                    {curve, std::string("AnimCurve::"), std::string("")},
                                    {{"Default", {0.0}, {}},
                                     {"KeyVer", {std::int64_t(4008)}, {}},
                                     {"KeyTime", {ticks}, {}},
                                     {"KeyValueFloat", {values}, {}},
                                     {"KeyAttrFlags", {FbxIntegers{flag}}, {}},
                                     {"KeyAttrDataFloat", {FbxIntegers{0, 0, 0, 0}}, {}},
                                     {"KeyAttrRefCount", {FbxIntegers{std::int64_t(times.size())}}, {}}}});
            link(curve, node, std::string("d|") + "XYZ"[axis]);
        }
    }
    void cluster(std::int64_t id, std::int64_t bone, const FbxIntegers& vertices, const FbxNumbers& weights, double y) {
        const FbxNumbers there{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -y, 0, 1},
            back{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, y, 0, 1};
        section("Objects").add({"Deformer",
                                {id, std::string("SubDeformer::"), std::string("Cluster")},
                                {{"Version", {std::int64_t(100)}, {}},
                                 {"Indexes", {vertices}, {}},
                                 {"Weights", {weights}, {}},
                                 {"Transform", {there}, {}},
                                 {"TransformLink", {back}, {}}}});
        link(id, 300);
        link(bone, id);
    }

    static constexpr std::int64_t kGeometry = 100, kMesh = 200, kRoot = 210, kArm = 211, kSkin = 300, kTake = 400,
                                  kLayer = 401;

    FbxRig() {
        root.add({"FBXHeaderExtension", {}, {{"FBXVersion", {std::int64_t(7400)}, {}}}});
        root.add({"GlobalSettings",
                  {},
                  {{"Properties70",
                    {},
                    {property("UpAxis", {std::int64_t(1)}), property("UpAxisSign", {std::int64_t(1)}),
                     property("FrontAxis", {std::int64_t(2)}), property("FrontAxisSign", {std::int64_t(1)}),
                     property("CoordAxis", {std::int64_t(0)}), property("CoordAxisSign", {std::int64_t(1)}),
                     property("UnitScaleFactor", {1.0}), property("TimeMode", {std::int64_t(6)})}}}});
        FbxNumbers points;
        FbxIntegers polygons, low, high;
        constexpr int kSides = 6;
        for (int ring = 0; ring < 3; ++ring)
            for (int s = 0; s < kSides; ++s) {
                const double angle = 2 * std::numbers::pi * s / kSides;
                points.insert(points.end(), {10 * std::cos(angle), 30.0 * ring, 10 * std::sin(angle)});
                (ring < 2 ? low : high).push_back(ring * kSides + s);
            }
        for (int ring = 0; ring < 2; ++ring)
            for (int s = 0; s < kSides; ++s) {
                const std::int64_t a = ring * kSides + s, b = ring * kSides + (s + 1) % kSides;
                polygons.insert(polygons.end(), {a, a + kSides, -b - 1, b, a + kSides, -(b + kSides) - 1});
            }
        section("Objects").add({"Geometry",
                                {kGeometry, std::string("Geometry::body"), std::string("Mesh")},
                                {{"Vertices", {points}, {}}, {"PolygonVertexIndex", {polygons}, {}}}});
        model(kMesh, "body", "Mesh", 0);
        model(kRoot, "root", "LimbNode", 0);
        model(kArm, "arm", "LimbNode", kRoot);
        setProperty("Model", kArm, property("Lcl Translation", {0.0, 30.0, 0.0}));
        section("Objects").add({"Deformer",
                                {kSkin, std::string("Deformer::"), std::string("Skin")},
                                {{"Version", {std::int64_t(101)}, {}}}});
        link(kGeometry, kMesh);
        link(kSkin, kGeometry);
        cluster(310, kRoot, low, FbxNumbers(low.size(), 1.0), 0);
        cluster(311, kArm, high, FbxNumbers(high.size(), 1.0), 30);
        take(kTake, "turn", 0, 1);
    }
};

// The arm turns about z by 90 degrees in a second. `flag` 4: linear, 8: cubic, 2: steps.
inline FbxRig turningRig(std::int64_t flag = 4) {
    FbxRig rig;
    const FbxNumbers ends{0, 1};
    rig.curves(FbxRig::kLayer, FbxRig::kArm, "Lcl Rotation", {{ends, {0, 0}}, {ends, {0, 0}}, {ends, {0, 90}}}, flag);
    return rig;
}

}  // namespace penumbra::samples
