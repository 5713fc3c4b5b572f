#include "formats/rig/fbx/fbx_faults.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "formats/rig/fbx/fbx_takes.h"

namespace penumbra {

namespace {

// Keys as close as these are as good as those of a baked curve, whatever is between them. seconds
constexpr double kDenseKeys = 1 / 23.0;

std::string quoted(const std::string& name) { return "'" + name + "'"; }

std::string nameOfTake(const FbxScan& scan, int take) { return quoted(scan.takes[std::size_t(take)].name); }

// --- Curves ---------------------------------------------------------------------------------------------------------

bool isDense(const FbxCurve& curve) {
    for (std::size_t k = 1; k < curve.times.size(); ++k)
        if (curve.times[k] - curve.times[k - 1] > kDenseKeys) return false;
    return true;
}

// Tells whether the curve is, between its keys, the line that assimp takes it for.
bool isLinear(const FbxCurve& curve) {
    constexpr int kLinear = 4;
    if (!curve.varies()) return true;
    for (std::size_t k = 1; k < curve.times.size(); ++k)
        if (curve.times[k] - curve.times[k - 1] > kDenseKeys && !(curve.flags[k - 1] & kLinear)) return false;
    return true;
}

bool varies(const std::optional<FbxCurve>& curve) { return curve && curve->varies(); }

bool isTransform(const FbxTrack& track) { return track.model >= 0 && track.property.starts_with("Lcl "); }

// Tells whether a property of a model turns in more than one axis between far keys. Between two keys assimp turns along
// the shortest arc, the file by its Euler angles.
bool turnsBetweenFarKeys(const FbxTrack& track) {
    if (track.property != "Lcl Rotation") return false;
    const auto axes = std::count_if(track.curves.begin(), track.curves.end(), varies);
    const auto far = [](const auto& curve) { return varies(curve) && !isDense(*curve); };
    return axes > 1 && std::any_of(track.curves.begin(), track.curves.end(), far);
}

void addAssimpFaultsOfTrack(const FbxScan& scan, const FbxTrack& track, std::vector<std::string>& faults) {
    if (!isTransform(track)) return;
    const FbxModel& model = scan.models[std::size_t(track.model)];
    const std::string where = "clip " + nameOfTake(scan, track.take) + ": node " + quoted(track.name) + ": ";
    const std::optional<FbxSpan> span = spanOfClip(scan, track.take);
    bool far = false;
    for (const std::optional<FbxCurve>& curve : track.curves) {
        if (!varies(curve)) continue;
        far |= !isDense(*curve);
        if (!isLinear(*curve)) return faults.push_back(where + "the curves of " + track.property + " are not linear");
        if ((curve->after != 'C' && curve->last() < span->last - kDenseKeys) ||
            (curve->before != 'C' && curve->first() > span->first + kDenseKeys))
            return faults.push_back(where + "the curves of " + track.property + " go on behind their keys");
    }
    if (turnsBetweenFarKeys(track)) return faults.push_back(where + "turns about several axes between far keys");
    if (far && model.pivots && track.property != "Lcl Translation")
        faults.push_back(where + "turns about a pivot between far keys");
    if (model.rotation_order == 6 && track.property == "Lcl Rotation")
        faults.push_back(where + "its rotation order is spherical");
}

// --- Takes ----------------------------------------------------------------------------------------------------------

bool hasSeveralLayers(const FbxScan& scan, int take) {
    std::set<int> layers;
    for (const FbxTrack& track : scan.tracks)
        if (track.take == take && isTransform(track) &&
            std::any_of(track.curves.begin(), track.curves.end(), [](const auto& curve) { return curve.has_value(); }))
            layers.insert(track.layer);
    return layers.size() > 1;
}

void addAssimpFaultsOfTake(const FbxScan& scan, int take, std::vector<std::string>& faults) {
    const std::optional<FbxSpan> keys = spanOfKeys(scan, take, FbxCurves::kAll);
    if (!keys) return;
    const std::string where = "clip " + nameOfTake(scan, take) + ": ";
    if (hasSeveralLayers(scan, take)) faults.push_back(where + "has several layers");
    const FbxTake& said = scan.takes[std::size_t(take)];
    const double start = said.start.value_or(0);
    if (!said.stop || *said.stop <= start) return;
    if (keys->first < start - kDenseKeys || keys->last > *said.stop + kDenseKeys)
        faults.push_back(where + "is a part of its keys");
    else if (keys->first > start + kDenseKeys)
        faults.push_back(where + "begins before its keys");
}

// Curves that go on behind their keys, in a take that does, too.
bool goesOnBehindKeys(const FbxScan& scan, int take) {
    const std::optional<FbxSpan> keys = spanOfKeys(scan, take, FbxCurves::kAll);
    const FbxTake& said = scan.takes[std::size_t(take)];
    if (!keys || !said.stop || *said.stop <= said.start.value_or(0)) return false;
    const bool before = said.start.value_or(0)<keys->first - kDenseKeys, after = *said.stop> keys->last + kDenseKeys;
    for (const FbxTrack& track : scan.tracks)
        for (const std::optional<FbxCurve>& curve : track.curves)
            if (track.take == take && track.model >= 0 && varies(curve) &&
                ((before && curve->before != 'C') || (after && curve->after != 'C')))
                return true;
    return false;
}

bool changesOutside(const FbxCurve& curve, const std::optional<FbxSpan>& inside, const FbxSpan& clip, double frame) {
    if (!inside) return curve.varies();
    for (std::size_t k = 1; k < curve.times.size(); ++k)
        if (curve.values[k] != curve.values[k - 1] &&
            ((curve.times[k] > inside->last + 1.5 * frame && curve.times[k - 1] < clip.last - frame) ||
             (curve.times[k - 1] < inside->first - 1.5 * frame && curve.times[k] > clip.first + frame)))
            return true;
    return false;
}

// The converter takes the first curves of all properties for the length of a clip.
bool changesBeyondFirstCurves(const FbxScan& scan, int take) {
    const std::optional<FbxSpan> inside = spanOfKeys(scan, take, FbxCurves::kFirstOfEach),
                                 clip = spanOfClip(scan, take);
    for (const FbxTrack& track : scan.tracks)
        for (const std::optional<FbxCurve>& curve : track.curves)
            if (track.take == take && track.model >= 0 && varies(curve) &&
                changesOutside(*curve, inside, *clip, 1.0 / framesASecond(scan)))
                return true;
    return false;
}

// --- Layers ---------------------------------------------------------------------------------------------------------

bool isTurned(const std::optional<FbxCurve>& curve) {
    return curve &&
           std::any_of(curve->values.begin(), curve->values.end(), [](double v) { return std::abs(v) > 1e-4; });
}

// Tells whether layers of a take turn one node about several axes, and one above the first adds its turn as a whole
// (RotationAccumulationMode 0), not angle by angle. About one axis both are the same.
bool accumulatesTurns(const FbxScan& scan, int take) {
    struct Turns {
        std::set<int> layers;
        std::array<bool, 3> axes{};
        bool as_a_whole = false;
    };
    std::map<int, Turns> turns_of_model;
    for (const FbxTrack& track : scan.tracks) {
        if (track.take != take || track.model < 0 || track.property != "Lcl Rotation") continue;
        Turns& turns = turns_of_model[track.model];
        turns.layers.insert(track.layer);
        bool turned = false;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if (isTurned(track.curves[axis])) turned = turns.axes[axis] = true;
        turns.as_a_whole |= turned && track.layer > 0 && !track.by_channel;
    }
    return std::any_of(turns_of_model.begin(), turns_of_model.end(), [](const auto& entry) {
        const Turns& turns = entry.second;
        return turns.layers.size() > 1 && turns.as_a_whole &&
               std::count(turns.axes.begin(), turns.axes.end(), true) > 1;
    });
}

// --- Scales ---------------------------------------------------------------------------------------------------------

struct FbxScales {
    bool any = false;     // some scale is not 1
    bool uneven = false;  // axes differ, or may
};

std::vector<FbxScales> scalesOf(const FbxScan& scan) {
    std::vector<FbxScales> scales(scan.models.size());
    for (std::size_t m = 0; m < scan.models.size(); ++m) {
        const auto& s = scan.models[m].scale;
        for (std::size_t i = 0; i < 3; ++i) {
            scales[m].any |= std::abs(s[i] - 1) > 1e-4;
            scales[m].uneven |= std::abs(s[i] - s[0]) > 1e-4 * std::abs(s[0]);
        }
    }
    for (const FbxTrack& track : scan.tracks)
        for (const std::optional<FbxCurve>& curve : track.curves)
            if (track.model >= 0 && track.property == "Lcl Scaling" && curve)
                for (const double v : curve->values)
                    if (std::abs(v - 1) > 1e-4) {
                        scales[std::size_t(track.model)].any = true;
                        scales[std::size_t(track.model)].uneven |= curve->varies();
                    }
    return scales;
}

// Returns the nodes that do not inherit their parent's scale as both readers have it.
std::vector<std::string> scaleFaults(const FbxScan& scan) {
    const std::vector<FbxScales> scales = scalesOf(scan);
    std::vector<std::string> faults;
    for (const FbxModel& model : scan.models) {
        if (model.parent < 0 || model.inherit == 1) continue;
        const FbxScales& parent = scales[std::size_t(model.parent)];
        if (model.inherit == 2 ? parent.any : parent.uneven)
            faults.push_back("node " + quoted(model.name) + " does not inherit the scale of " +
                             quoted(scan.models[std::size_t(model.parent)].name) +
                             (model.inherit == 2 ? " (segment scale compensation)" : " (inherit type 0)"));
    }
    return faults;
}

// The converter takes the scale of a node with segment scale compensation for 1.
void addLostScales(const FbxScan& scan, std::vector<std::string>& faults) {
    const std::vector<FbxScales> scales = scalesOf(scan);
    std::set<int> used;
    for (const FbxGeometry& geometry : scan.geometries) {
        used.insert(geometry.models.begin(), geometry.models.end());
        for (const FbxSkin& skin : geometry.skins)
            for (const FbxCluster& cluster : skin.clusters) used.insert(cluster.model);
    }
    for (std::size_t m = 0; m < scan.models.size(); ++m)
        if (scan.models[m].inherit == 2 && scan.models[m].parent >= 0 && scales[m].any && used.contains(int(m)))
            faults.push_back("node " + quoted(scan.models[m].name) + " has a scale (segment scale compensation)");
}

// --- Meshes ---------------------------------------------------------------------------------------------------------

bool isUsed(const FbxScan& scan, const FbxShapes& shapes) {
    if (std::abs(shapes.percent) > 1e-6) return true;
    for (const FbxTrack& track : scan.tracks)
        if (track.shapes >= 0 && track.name == shapes.name && track.curves[0])
            for (const double v : track.curves[0]->values)
                if (std::abs(v) > 1e-6) return true;
    return false;
}

bool isUneven(const std::vector<double>& weights) {
    return std::any_of(weights.begin(), weights.end(), [&](double w) { return w != weights[0]; });
}

// In-betweens, and the shapes of a vertex group, which some exporters write as full weights of vertices.
void addShapeFaults(const FbxScan& scan, std::vector<std::string>& faults) {
    for (const FbxGeometry& geometry : scan.geometries)
        for (const FbxShapes& shapes : geometry.shapes) {
            if (!isUsed(scan, shapes)) continue;
            const std::string where = "mesh " + quoted(geometry.name) + ": shape " + quoted(shapes.name);
            if (shapes.shapes > 1)
                faults.push_back(where + " has in-betweens");
            else if (isUneven(shapes.full_weights))
                faults.push_back(where + " is limited to a vertex group");
        }
}

void addInstanceFaults(const FbxScan& scan, std::vector<std::string>& faults) {
    for (const FbxGeometry& geometry : scan.geometries)
        for (const int model : geometry.models)
            if (scan.models[std::size_t(model)].geometric != scan.models[std::size_t(geometry.models[0])].geometric) {
                faults.push_back("mesh " + quoted(geometry.name) + " is drawn with several geometric transforms");
                break;
            }
}

void addMeshFaultsOfAssimp(const FbxScan& scan, std::vector<std::string>& faults) {
    constexpr std::array<double, 9> kNone{0, 0, 0, 0, 0, 0, 1, 1, 1};
    for (const FbxGeometry& geometry : scan.geometries) {
        for (const FbxShapes& shapes : geometry.shapes)
            if (isUsed(scan, shapes)) {
                faults.push_back("mesh " + quoted(geometry.name) + " has blend shapes");
                break;
            }
        for (const int model : geometry.models)
            if (!geometry.skins.empty() && scan.models[std::size_t(model)].geometric != kNone)
                faults.push_back("node " + quoted(scan.models[std::size_t(model)].name) +
                                 " has a geometric transform and a skin");
    }
}

// assimp finds bones and what moves by name.
void addNameFaults(const FbxScan& scan, std::vector<std::string>& faults) {
    std::map<std::string, int> uses;
    for (const FbxModel& model : scan.models) ++uses[model.name];
    const auto check = [&](int model, const char* what) {
        if (model < 0 || uses[scan.models[std::size_t(model)].name] < 2) return false;
        faults.push_back(std::string(what) + " " + quoted(scan.models[std::size_t(model)].name) +
                         " has the name of another node");
        return true;
    };
    for (const FbxGeometry& geometry : scan.geometries)
        for (const FbxSkin& skin : geometry.skins)
            for (const FbxCluster& cluster : skin.clusters)
                if (check(cluster.model, "bone")) return;
    for (const FbxTrack& track : scan.tracks)
        if (isTransform(track) && check(track.model, "node")) return;
    for (std::size_t m = 0; m < scan.models.size(); ++m)
        if (scan.models[m].hidden && check(int(m), "hidden node")) return;
}

}  // namespace

std::vector<std::string> assimpFaults(const FbxScan& scan) {
    std::vector<std::string> faults;
    if (scan.version < 7100) faults.push_back("it does not read FBX " + std::to_string(scan.version));
    for (int take = 0; take < int(scan.takes.size()); ++take) {
        addAssimpFaultsOfTake(scan, take, faults);
        if (goesOnBehindKeys(scan, take))
            faults.push_back("clip " + nameOfTake(scan, take) + ": its curves go on behind their keys");
    }
    for (const FbxTrack& track : scan.tracks) addAssimpFaultsOfTrack(scan, track, faults);
    for (std::string& fault : scaleFaults(scan)) faults.push_back(std::move(fault));
    addMeshFaultsOfAssimp(scan, faults);
    addNameFaults(scan, faults);
    return faults;
}

std::vector<std::string> converterFaults(const FbxScan& scan) {
    std::vector<std::string> faults;
    if (scan.audio) faults.push_back("it crashes on files with audio: export without audio");
    if (scan.other_ticks) faults.push_back("its times are counted as FBX 2020 does (TCDefinition): export as FBX 2018");
    if (scan.odd_names) faults.push_back("a name is not UTF-8: rename it");
    for (int take = 0; take < int(scan.takes.size()); ++take) {
        const std::string where = "clip " + nameOfTake(scan, take) + ": ";
        if (changesBeyondFirstCurves(scan, take))
            faults.push_back(where + "is not keyed on all axes over its take: bake the animation on export");
        else if (goesOnBehindKeys(scan, take))
            faults.push_back(where + "its curves go on behind their keys: bake the animation on export");
    }
    for (int take = 0; take < int(scan.takes.size()); ++take)
        if (accumulatesTurns(scan, take))
            faults.push_back("clip " + nameOfTake(scan, take) +
                             ": its layers accumulate turns about several axes: bake the animation on export");
    for (const std::string& fault : scaleFaults(scan))
        faults.push_back(fault + ": turn that off, or bake it into the mesh");
    addLostScales(scan, faults);
    addShapeFaults(scan, faults);
    addInstanceFaults(scan, faults);
    return faults;
}

std::vector<RigNote> fbxNotes(const FbxScan& scan) {
    std::vector<RigNote> notes;
    for (const FbxGeometry& geometry : scan.geometries)
        for (const FbxSkin& skin : geometry.skins)
            if (skin.type == "DualQuaternion" || skin.type == "Blend")
                notes.push_back({scan.file.string(), geometry.name, "dual quaternion skinning",
                                 "is read as linear, which bends and twists lose volume by"});
    for (const FbxModel& model : scan.models)
        if (model.hidden && model.kind == "Mesh")
            notes.push_back({scan.file.string(), model.name, "hidden", "is left out"});
    return notes;
}

std::vector<RigNote> converterNotes(const FbxScan& scan) {
    std::vector<RigNote> notes;
    for (const FbxCutWeights& cut : cutWeights(scan)) {
        char effect[120];
        std::snprintf(effect, sizeof effect, "%zu vertices keep the 4 largest, and lose up to %.1f%% of their weight",
                      cut.vertices, 100 * cut.most);
        notes.push_back({scan.file.string(), cut.mesh, "more than 4 influences", effect});
    }
    if (hasOtherRate(scan))
        notes.push_back({scan.file.string(), "", "frame rate",
                         "frames lie between those of FBX2glTF, 60 a second, where movement is linear"});
    std::set<int> told;
    constexpr int kConstant = 2;
    for (const FbxTrack& track : scan.tracks)
        for (const std::optional<FbxCurve>& curve : track.curves) {
            if (track.model < 0 || !varies(curve) || !(curve->flags[0] & kConstant) || isDense(*curve)) continue;
            if (told.insert(track.take).second)
                notes.push_back({scan.file.string(), track.name, "stepped keys of clip " + nameOfTake(scan, track.take),
                                 "become ramps of 1/" + std::to_string(framesASecond(scan)) + " s"});
        }
    return notes;
}

}  // namespace penumbra
