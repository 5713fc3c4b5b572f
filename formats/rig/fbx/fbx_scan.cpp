// Collects what fbx_faults.cpp asks for. An object that is missing or of another kind than it should be is passed over:
// what reads the file for good refuses it.
#include "formats/rig/fbx/fbx_scan.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "formats/common/errors.h"
#include "formats/rig/fbx/fbx_objects.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

bool FbxCurve::varies() const {
    double size = 0;
    for (const double v : values) size = std::max(size, std::abs(v));
    for (const double v : values)
        if (!(std::abs(v - values.front()) <= 1e-5 * size)) return true;
    return false;
}

namespace {

constexpr double kTicksASecond = 46186158000.0, kTicksOfFbx2020 = 141120000.0;

struct FbxCollector {
    const FbxTree& tree;
    FbxObjects objects;
    FbxScan scan;
    std::map<std::string, int> model_of_id;
    std::map<std::string, std::pair<int, int>> layer_of_id;           // take, and index in it
    std::map<std::string, std::pair<int, std::string>> shapes_of_id;  // geometry, and the channel's name

    // Calls `visit` with every link from something to `id`.
    template <class Visit>
    void visitChildren(const std::string& id, Visit visit) const {
        const auto found = objects.links_of_parent.find(id);
        if (found == objects.links_of_parent.end()) return;
        for (const std::size_t link : found->second) {
            const auto child = objects.object_of_id.find(objects.links[link].child);
            if (child != objects.object_of_id.end()) visit(*child->second, objects.links[link]);
        }
    }
    template <class Visit>
    void visitParents(const std::string& id, Visit visit) const {
        const auto found = objects.links_of_child.find(id);
        if (found == objects.links_of_child.end()) return;
        for (const std::size_t link : found->second) visit(objects.links[link]);
    }
    template <class Visit>
    void visitObjects(const char* kind, Visit visit) const {
        for (const std::string& id : objects.ids)
            if (const FbxNode& object = *objects.object_of_id.at(id); object.name == kind) visit(id, object);
    }
};

int indexOf(const std::map<std::string, int>& indices, const std::string& id) {
    const auto found = indices.find(id);
    return found == indices.end() ? -1 : found->second;
}

int wholeNumber(double number) { return std::abs(number) < 1e9 ? int(number) : 0; }

// --- Header ---------------------------------------------------------------------------------------------------------

// Returns the file's mode of time, with that of a custom rate of 24, 30 or 60 where it has one.
int timeModeOf(const FbxObjects& objects, const FbxNode& settings) {
    const double mode = propertyNumber(objects, settings, "TimeMode", 0);
    const double rate = propertyNumber(objects, settings, "CustomFrameRate", 0);
    constexpr double kCustom = 14;
    if (mode == kCustom && (rate == 24 || rate == 30 || rate == 60)) return rate == 24 ? 11 : rate == 30 ? 6 : 3;
    return mode >= 0 && mode < 100 ? int(mode) : 0;
}

void readHeader(FbxCollector& collector) {
    const FbxNode& root = collector.tree.root;
    FbxScan& scan = collector.scan;
    scan.version = collector.tree.version;
    const FbxNode* settings = root.child("GlobalSettings");
    if (!settings && root.child("Objects")) settings = root.child("Objects")->child("GlobalSettings");
    if (settings) scan.time_mode = timeModeOf(collector.objects, *settings);
    if (const FbxNode* header = root.child("FBXHeaderExtension")) {
        const FbxNode* flags = header->child("OtherFlags");
        const FbxNode* ticks = flags ? flags->child("TCDefinition") : nullptr;
        scan.other_ticks = ticks && ticks->value(0).integer != 127 && scan.version >= 7000;
        const FbxNode* creator = header->child("Creator");
        const FbxNode* whole_creator = root.child("Creator");
        for (const FbxNode* by : {creator, whole_creator})
            if (by && by->value(0).text.find("Maya") != std::string::npos) scan.maya = true;
        if (const FbxNode* info = header->child("SceneInfo"))
            for (const char* name : {"Original|ApplicationName", "LastSaved|ApplicationName"})
                if (const FbxNode* by = findProperty(collector.objects, *info, name))
                    if (propertyTextOf(*by).find("Maya") != std::string_view::npos) scan.maya = true;
    }
    scan.seconds_a_tick = 1 / (scan.other_ticks ? kTicksOfFbx2020 : kTicksASecond);
    for (const char* kind : {"Audio", "AudioLayer"})
        collector.visitObjects(kind, [&](const std::string&, const FbxNode&) { scan.audio = true; });
}

// --- Models ---------------------------------------------------------------------------------------------------------

FbxModel modelOf(const FbxCollector& collector, const FbxNode& object) {
    FbxModel model;
    model.name = cleanText(objectName(object));
    model.kind = objectKind(object);
    const auto number = [&](const char* name, double otherwise, std::size_t index = 0) {
        return propertyNumber(collector.objects, object, name, otherwise, index);
    };
    model.inherit = wholeNumber(number("InheritType", 0));
    model.rotation_order = wholeNumber(number("RotationOrder", 0));
    model.hidden = number("Visibility", 1) == 0 || number("Show", 1) == 0;
    constexpr std::array kGeometric{"GeometricTranslation", "GeometricRotation", "GeometricScaling"};
    constexpr std::array kPivots{"RotationPivot", "ScalingPivot", "RotationOffset", "ScalingOffset"};
    for (std::size_t i = 0; i < 3; ++i) {
        model.scale[i] = number("Lcl Scaling", 1, i);
        for (std::size_t k = 0; k < 3; ++k) model.geometric[3 * k + i] = number(kGeometric[k], k == 2 ? 1 : 0, i);
        for (const char* pivot : kPivots) model.pivots |= std::abs(number(pivot, 0, i)) > 1e-9;
    }
    return model;
}

void readModels(FbxCollector& collector) {
    FbxScan& scan = collector.scan;
    std::vector<std::string> ids;
    std::vector<bool> inherits_hiding;
    collector.visitObjects("Model", [&](const std::string& id, const FbxNode& object) {
        collector.model_of_id[id] = int(scan.models.size());
        scan.models.push_back(modelOf(collector, object));
        inherits_hiding.push_back(propertyNumber(collector.objects, object, "Visibility Inheritance", 1) != 0);
        ids.push_back(id);
    });
    for (std::size_t m = 0; m < scan.models.size(); ++m)
        collector.visitParents(ids[m], [&](const FbxLink& link) {
            if (link.property.empty())
                scan.models[m].parent = std::max(scan.models[m].parent, indexOf(collector.model_of_id, link.parent));
        });
    for (std::size_t m = 0; m < scan.models.size(); ++m) {
        int steps = 0;
        for (int up = int(m); up >= 0 && inherits_hiding[std::size_t(up)] && steps < 10000; ++steps) {
            up = scan.models[std::size_t(up)].parent;
            if (up >= 0 && scan.models[std::size_t(up)].hidden) scan.models[m].hidden = true;
        }
        if (steps == 10000) failAtFile(scan.file, "model '" + scan.models[m].name + "' is its own ancestor");
    }
}

// --- Geometries -----------------------------------------------------------------------------------------------------

const std::vector<double>& numbersOfChild(const FbxNode& object, const char* name) {
    static const std::vector<double> none;
    const FbxNode* child = object.child(name);
    return child ? child->numbers : none;
}

FbxCluster clusterOf(const FbxCollector& collector, const std::string& id, const FbxNode& object) {
    FbxCluster cluster;
    cluster.vertices = numbersOfChild(object, "Indexes");
    cluster.weights = numbersOfChild(object, "Weights");
    cluster.weights.resize(cluster.vertices.size());
    collector.visitChildren(id, [&](const FbxNode& child, const FbxLink& link) {
        if (child.name == "Model") cluster.model = indexOf(collector.model_of_id, link.child);
    });
    return cluster;
}

FbxSkin skinOf(const FbxCollector& collector, const std::string& id, const FbxNode& object) {
    FbxSkin skin;
    if (const FbxNode* type = object.child("SkinningType")) skin.type = type->value(0).text;
    collector.visitChildren(id, [&](const FbxNode& child, const FbxLink& link) {
        if (objectKind(child) == "Cluster") skin.clusters.push_back(clusterOf(collector, link.child, child));
    });
    return skin;
}

FbxShapes shapesOf(const FbxCollector& collector, const std::string& id, const FbxNode& object) {
    FbxShapes shapes;
    shapes.name = cleanText(objectName(object));
    if (const FbxNode* percent = object.child("DeformPercent")) shapes.percent = percent->value(0).number;
    shapes.percent = propertyNumber(collector.objects, object, "DeformPercent", shapes.percent);
    shapes.full_weights = numbersOfChild(object, "FullWeights");
    collector.visitChildren(id,
                            [&](const FbxNode& child, const FbxLink&) { shapes.shapes += child.name == "Geometry"; });
    return shapes;
}

// Reads the deformers of a mesh, which stands in a Geometry or, in FBX 6, in a Model.
void readDeformers(FbxCollector& collector, const std::string& id, FbxGeometry& geometry) {
    collector.visitChildren(id, [&](const FbxNode& deformer, const FbxLink& link) {
        const std::string& kind = objectKind(deformer);
        if (kind == "Skin") geometry.skins.push_back(skinOf(collector, link.child, deformer));
        if (kind != "BlendShape") return;
        collector.visitChildren(link.child, [&](const FbxNode& channel, const FbxLink& to_channel) {
            if (objectKind(channel) != "BlendShapeChannel") return;
            geometry.shapes.push_back(shapesOf(collector, to_channel.child, channel));
            collector.shapes_of_id[to_channel.child] = {int(collector.scan.geometries.size()),
                                                        geometry.shapes.back().name};
        });
    });
}

// Refuses damaged polygons, because the readers leave out such a mesh, or such a polygon, without a word. The last
// index of a polygon is stored as -1 - index.
void checkPolygons(const FbxCollector& collector, const FbxGeometry& geometry, const FbxNode& object) {
    const auto fail = [&](const std::string& what) {
        failAtFile(collector.scan.file, "mesh '" + geometry.name + "': " + what);
    };
    const std::uint64_t numbers = object.child("Vertices")->count;
    if (numbers % 3 != 0) fail("Vertices has " + std::to_string(numbers) + " numbers, which is not three for each");
    const std::vector<double>& corners = object.child("PolygonVertexIndex")->numbers;
    for (const double corner : corners) {
        const double vertex = corner < 0 ? -1 - corner : corner;
        if (!(vertex < double(geometry.vertices)))
            fail("PolygonVertexIndex: vertex " + std::to_string(std::int64_t(vertex)) + " of " +
                 std::to_string(geometry.vertices));
    }
    if (!corners.empty() && corners.back() >= 0) fail("PolygonVertexIndex: its last polygon does not end");
}

void readGeometries(FbxCollector& collector) {
    FbxScan& scan = collector.scan;
    for (const char* kind : {"Geometry", "Model"})
        collector.visitObjects(kind, [&](const std::string& id, const FbxNode& object) {
            const FbxNode* vertices = object.child("Vertices");
            if (objectKind(object) != "Mesh" || !vertices || !object.child("PolygonVertexIndex")) return;
            FbxGeometry geometry;
            geometry.name = cleanText(objectName(object));
            geometry.vertices = vertices->count / 3;
            collector.visitParents(id, [&](const FbxLink& link) {
                const int model = indexOf(collector.model_of_id, link.parent);
                if (model >= 0 && object.name == "Geometry") geometry.models.push_back(model);
            });
            if (object.name == "Model") geometry.models.push_back(indexOf(collector.model_of_id, id));
            if (geometry.name.empty() && !geometry.models.empty())
                geometry.name = scan.models[std::size_t(geometry.models[0])].name;
            checkPolygons(collector, geometry, object);
            readDeformers(collector, id, geometry);
            scan.geometries.push_back(std::move(geometry));
        });
}

// --- Animation ------------------------------------------------------------------------------------------------------

char extrapolationOf(const FbxNode& curve, const char* name) {
    const FbxNode* node = curve.child(name);
    const FbxNode* type = node ? node->child("Type") : nullptr;
    if (!type) return 'C';
    const FbxValue& value = type->value(0);  // a letter, in binary files as its number
    return !value.text.empty() ? value.text[0] : value.integer > 0 && value.integer < 128 ? char(value.integer) : 'C';
}

// Returns nothing for a curve without keys, and for one whose arrays do not fit.
std::optional<FbxCurve> curveOf(const FbxScan& scan, const FbxNode& object) {
    FbxCurve curve;
    curve.times = numbersOfChild(object, "KeyTime");
    curve.values = numbersOfChild(object, "KeyValueFloat");
    if (curve.times.empty() || curve.times.size() != curve.values.size()) return std::nullopt;
    const auto isFinite = [](double v) { return std::isfinite(v); };
    for (const std::vector<double>* numbers : {&curve.times, &curve.values})
        if (!std::all_of(numbers->begin(), numbers->end(), isFinite)) return std::nullopt;
    for (double& time : curve.times) time *= scan.seconds_a_tick;
    const std::vector<double>&flags = numbersOfChild(object, "KeyAttrFlags"),
          &counts = numbersOfChild(object, "KeyAttrRefCount");
    for (std::size_t i = 0; i < flags.size() && i < counts.size(); ++i)
        for (double k = 0; k < counts[i] && curve.flags.size() < curve.times.size(); ++k)
            curve.flags.push_back(wholeNumber(flags[i]));
    curve.flags.resize(curve.times.size(), 8);
    curve.before = extrapolationOf(object, "Pre-Extrapolation");
    curve.after = extrapolationOf(object, "Post-Extrapolation");
    return curve;
}

// Tells whether a take of FBX 6 has a curve of more than one key.
bool hasOldKeys(const FbxNode& node) {
    return (node.name == "KeyCount" && node.value(0).integer > 1) ||
           std::any_of(node.children.begin(), node.children.end(), hasOldKeys);
}

void readTakes(FbxCollector& collector) {
    FbxScan& scan = collector.scan;
    collector.visitObjects("AnimationStack", [&](const std::string& id, const FbxNode& object) {
        FbxTake take;
        take.name = cleanText(objectName(object));
        const auto seconds = [&](const char* name) -> std::optional<double> {
            const FbxNode* property = findProperty(collector.objects, object, name);
            if (!property) return std::nullopt;
            return propertyNumber(collector.objects, object, name, 0) * scan.seconds_a_tick;
        };
        take.start = seconds("LocalStart");
        take.stop = seconds("LocalStop");
        const int index = int(scan.takes.size());
        scan.takes.push_back(take);
        int layers = 0;
        collector.visitChildren(id, [&](const FbxNode& child, const FbxLink& link) {
            if (child.name == "AnimationLayer") collector.layer_of_id[link.child] = {index, layers++};
        });
    });
    const FbxNode* old = collector.tree.root.child("Takes");
    if (!old || scan.version >= 7000) return;
    for (const FbxNode& node : old->children) {
        if (node.name != "Take") continue;
        FbxTake take;
        take.name = cleanText(node.value(0).text);
        if (const FbxNode* span = node.child("LocalTime")) {
            take.start = span->value(0).number * scan.seconds_a_tick;
            take.stop = span->value(1).number * scan.seconds_a_tick;
        }
        scan.old_clips |= hasOldKeys(node);
        scan.takes.push_back(take);
    }
}

void readTrack(FbxCollector& collector, const std::string& id) {
    FbxTrack track;
    collector.visitParents(id, [&](const FbxLink& link) {
        if (const auto layer = collector.layer_of_id.find(link.parent); layer != collector.layer_of_id.end()) {
            std::tie(track.take, track.layer) = layer->second;
            const FbxNode& object = *collector.objects.object_of_id.at(link.parent);
            track.by_channel = propertyNumber(collector.objects, object, "RotationAccumulationMode", 0) == 1;
        }
        if (link.property.empty()) return;
        if (const int model = indexOf(collector.model_of_id, link.parent); model >= 0) {
            track.model = model;
            track.name = collector.scan.models[std::size_t(model)].name;
            track.property = link.property;
        }
        if (const auto shapes = collector.shapes_of_id.find(link.parent); shapes != collector.shapes_of_id.end()) {
            std::tie(track.shapes, track.name) = shapes->second;
            track.property = link.property;
        }
    });
    if (track.take < 0) return;
    collector.visitChildren(id, [&](const FbxNode& child, const FbxLink& link) {
        if (child.name != "AnimationCurve") return;
        const std::size_t axis = link.property == "d|Y" ? 1 : link.property == "d|Z" ? 2 : 0;
        track.curves[axis] = curveOf(collector.scan, child);
    });
    collector.scan.tracks.push_back(std::move(track));
}

// --- Names ----------------------------------------------------------------------------------------------------------

bool isUtf8(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        const auto c = static_cast<unsigned char>(text[i++]);
        int more = 0;
        if (c >= 0xc2 && c < 0xe0)
            more = 1;
        else if (c >= 0xe0 && c < 0xf0)
            more = 2;
        else if (c >= 0xf0 && c < 0xf5)
            more = 3;
        else if (c >= 0x80)
            return false;
        for (; more > 0; --more, ++i)
            if (i >= text.size() || (static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return false;
    }
    return true;
}

void readTextures(FbxCollector& collector) {
    collector.visitObjects("Texture", [&](const std::string&, const FbxNode& object) {
        FbxTexture texture{cleanText(objectName(object)), ""};
        for (const char* name : {"RelativeFilename", "FileName"})
            if (const FbxNode* file = object.child(name); file && texture.file.empty())
                texture.file = file->value(0).text;
        collector.scan.textures.push_back(std::move(texture));
    });
}

void checkNames(FbxCollector& collector) {
    for (const std::string& id : collector.objects.ids)
        if (!isUtf8(objectName(*collector.objects.object_of_id.at(id)))) collector.scan.odd_names = true;
}

}  // namespace

FbxScan scanOf(const FbxTree& tree, const std::filesystem::path& path) {
    FbxCollector collector{
        .tree = tree, .objects = objectsOf(tree), .scan = {}, .model_of_id = {}, .layer_of_id = {}, .shapes_of_id = {}};
    collector.scan.file = path;
    const FbxNode* links = tree.root.child("Connections");
    if (!tree.root.child("Objects") || !links || (links->children.empty() && !collector.objects.ids.empty()))
        failAtFile(path, "is cut short: it has no FBX objects, or nothing that connects them");
    readHeader(collector);
    readModels(collector);
    readGeometries(collector);
    readTextures(collector);
    readTakes(collector);
    collector.visitObjects("AnimationCurveNode",
                           [&](const std::string& id, const FbxNode&) { readTrack(collector, id); });
    checkNames(collector);
    return std::move(collector.scan);
}

FbxScan scanFbx(const std::filesystem::path& path) { return scanOf(readFbxTree(path), path); }

}  // namespace penumbra
