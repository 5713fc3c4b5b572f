// Reads what morph targets do to a rig.
//
// Problem: glTF gives targets by primitive and weights by node. A pose needs one list of numbers, and a shading point
// needs to know what each of them does to it after vertices were welded.
//
// Here: targets of one mesh or one name are one weight unless some clip tells them apart. Each vertex has a sparse list
// of changes, by which welding compares vertices. Afterwards the lists of the points that are left become the targets
// of the mesh. What changes less than kNoMove diagonals is dropped, as exporters write noise for vertices that stand
// still: all targets of a face together then err by less than 1e-5.
#include "formats/rig/rig_morphs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_keys.h"

namespace penumbra {

constexpr double kNoMove = 1e-7;      // in diagonals of the rest mesh
constexpr float kNoTurn = 1e-3f;      // change of a unit normal
constexpr float kOtherTurn = 0.347f;  // 2 sin(10 degrees): normals that turn apart by 20 degrees

namespace {

// Returns the channel that drives a node's weights in a clip; null where none does.
const MorphChannel* channelOf(const RigSource& source, int clip, int node) {
    const MorphChannel* found = nullptr;
    for (const MorphChannel& channel : source.morphs)
        if (channel.clip == clip && channel.node == node) found = &channel;
    return found;
}

// A target of a node's mesh.
struct NodeTarget {
    int node = 0;
    std::size_t target = 0, targets = 0;  // the target's index, and how many there are
    float rest = 0;
    bool operator==(const NodeTarget&) const = default;
};

// Tells whether two channels give two targets the same weights. Their nodes may have other numbers of targets.
bool sameCurves(const MorphChannel& x, const NodeTarget& a, const MorphChannel& y, const NodeTarget& b) {
    if (x.interpolation != y.interpolation || x.times != y.times) return false;
    const std::size_t rows = x.times.size() * (x.interpolation == Interpolation::kCubicSpline ? 3 : 1);
    for (std::size_t row = 0; row < rows; ++row)
        if (x.values[row * a.targets + a.target] != y.values[row * b.targets + b.target]) return false;
    return true;
}

bool driveAlike(const RigSource& source, const NodeTarget& a, const NodeTarget& b) {
    if (a.rest != b.rest) return false;
    for (std::size_t clip = 0; clip < source.clips.size(); ++clip) {
        const MorphChannel *x = channelOf(source, int(clip), a.node), *y = channelOf(source, int(clip), b.node);
        if (!x && !y) continue;
        if (!x || !y || !sameCurves(*x, a, *y, b)) return false;
    }
    return true;
}

// Returns a part of a node's mesh that has morph targets, or nothing.
const SourcePart* partWithTargets(const RigSource& source, int node) {
    for (const SourcePart& part : source.parts)
        if (part.node == node && !part.targets.empty()) return &part;
    return nullptr;
}

constexpr std::size_t kNoTarget = std::size_t(-1);

// Tells whether each target has a name of its own.
bool haveNames(const SourcePart& part) {
    const std::set<std::string> names(part.target_names.begin(), part.target_names.end());
    return names.size() == part.targets.size() && !names.contains("");
}

// Returns for each target of `to` the one of `from` that drives it: that of the same name where both files name all,
// else that of the same number where there are equally many. Empty: none is driven.
std::vector<std::size_t> drivers(const SourcePart* from, const SourcePart* to) {
    std::vector<std::size_t> out;
    if (!from || !to) return out;
    const bool named = haveNames(*from) && haveNames(*to);
    if (!named && from->targets.size() != to->targets.size()) return out;
    for (std::size_t t = 0; t < to->targets.size(); ++t) {
        const auto& names = from->target_names;
        const auto at = named ? std::find(names.begin(), names.end(), to->target_names[t]) : names.end();
        out.push_back(!named ? t : at == names.end() ? kNoTarget : std::size_t(at - names.begin()));
    }
    if (std::all_of(out.begin(), out.end(), [](std::size_t t) { return t == kNoTarget; })) out.clear();
    return out;
}

// Returns the weights of a channel in the order of the targets that they drive; what none drives keeps its rest weight.
std::vector<float> drivenValues(const MorphChannel& channel, std::size_t targets, const SourcePart& to,
                                std::span<const std::size_t> driver) {
    const std::size_t rows = channel.values.size() / targets;
    const bool cubic = channel.interpolation == Interpolation::kCubicSpline;
    std::vector<float> out;
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t t = 0; t < driver.size(); ++t) {
            const bool tangent = cubic && row % 3 != 1;
            out.push_back(driver[t] != kNoTarget ? channel.values[row * targets + driver[t]]
                          : tangent              ? 0
                                                 : float(to.rest_weights[t]));
        }
    return out;
}

// The names of the targets that drive nothing.
std::string idleTargets(const SourcePart& from, std::span<const std::size_t> driver) {
    std::string names;
    for (std::size_t t = 0; t < from.targets.size(); ++t)
        if (std::find(driver.begin(), driver.end(), t) == driver.end())
            names += (names.empty() ? "'" : ", '") + from.target_names[t] + "'";
    return names;
}

// "NAME.x" would be a coordinate of a point, as inputs have them (input_table.h).
std::string weightName(const std::string& of_file, std::size_t target) {
    std::string name = of_file.empty() ? "morph" + std::to_string(target) : of_file;
    if (name.ends_with(".x")) name[name.size() - 2] = '_';
    return name;
}

// The weights while they are chosen.
struct WeightPlan {
    std::vector<NodeTarget> first;   // [M] the first target of each
    std::vector<std::string> names;  // [M] of the file
    std::multimap<std::string, std::uint32_t> of_name;
    std::multimap<std::pair<int, std::size_t>, std::uint32_t> of_mesh;  // by mesh and target
};

// Returns the weight of a target: one that another target has already, or a new one. `taken` are the node's own.
std::uint32_t weightOfTarget(const RigSource& source, const SourcePart& part, const NodeTarget& target,
                             const std::vector<std::uint32_t>& taken, WeightPlan& plan) {
    const std::string name = target.target < part.target_names.size() ? part.target_names[target.target] : "";
    std::vector<std::uint32_t> candidates;
    const auto collect = [&](auto range) {
        for (auto at = range.first; at != range.second; ++at) candidates.push_back(at->second);
    };
    if (part.mesh >= 0) collect(plan.of_mesh.equal_range({part.mesh, target.target}));
    if (!name.empty()) collect(plan.of_name.equal_range(name));
    for (const std::uint32_t weight : candidates)
        if (std::find(taken.begin(), taken.end(), weight) == taken.end() &&
            driveAlike(source, plan.first[weight], target))
            return weight;
    const auto weight = std::uint32_t(plan.first.size());
    plan.first.push_back(target);
    plan.names.push_back(name);
    if (!name.empty()) plan.of_name.emplace(name, weight);
    if (part.mesh >= 0) plan.of_mesh.emplace(std::pair(part.mesh, target.target), weight);
    return weight;
}

// Names that several weights have get the name of a node in front of them.
std::vector<std::string> namesOfWeights(const RigSource& source, const WeightPlan& plan) {
    std::vector<std::string> names;
    std::map<std::string, int> uses;
    for (std::size_t m = 0; m < plan.first.size(); ++m) {
        names.push_back(weightName(plan.names[m], plan.first[m].target));
        ++uses[names.back()];
    }
    for (std::size_t m = 0; m < names.size(); ++m)
        if (uses[names[m]] > 1) names[m] = source.nodes[std::size_t(plan.first[m].node)].name + "/" + names[m];
    return uniqueNames(std::move(names));
}

}  // namespace

bool addWeightChannels(const RigSource& from, int clip, const std::map<std::string, int>& node_of_name,
                       RigSource& rig) {
    bool any = false;
    for (const MorphChannel& channel : from.morphs) {
        if (channel.clip != clip) continue;
        const std::string& name = from.nodes[std::size_t(channel.node)].name;
        const auto node = node_of_name.find(name);
        const SourcePart* source = partWithTargets(from, channel.node);
        const SourcePart* target = node == node_of_name.end() ? nullptr : partWithTargets(rig, node->second);
        const std::vector<std::size_t> driver = drivers(source, target);
        const std::string feature = "morph weights of clip '" + from.clips[std::size_t(clip)].name + "'";
        if (driver.empty()) {
            rig.notes.push_back({from.file.string(), name, feature,
                                 "they move nothing, as " + rig.file.string() +
                                     " has no node of this name whose morph targets have the same names, or are "
                                     "equally many"});
            continue;
        }
        if (const std::string idle = idleTargets(*source, driver); !idle.empty())
            rig.notes.push_back({from.file.string(), name, feature,
                                 "the target of these names is not there, and they move nothing: " + idle});
        rig.morphs.push_back(channel);
        rig.morphs.back().clip = int(rig.clips.size());
        rig.morphs.back().node = node->second;
        rig.morphs.back().values = drivenValues(channel, source->targets.size(), *target, driver);
        any = true;
    }
    return any;
}

SourceMorphs planMorphs(const RigSource& source) {
    SourceMorphs out;
    out.of_node.resize(source.nodes.size());
    out.first = {0};
    WeightPlan plan;
    for (const SourcePart& part : source.parts) {
        if (part.targets.empty()) continue;
        std::vector<std::uint32_t>& weights = out.of_node[std::size_t(part.node)];
        if (!weights.empty() && weights.size() != part.targets.size())
            failAtNode(source, part.node, "its primitives have different numbers of morph targets");
        if (!weights.empty()) continue;
        for (std::size_t t = 0; t < part.targets.size(); ++t)
            weights.push_back(weightOfTarget(
                source, part, {part.node, t, part.targets.size(), float(part.rest_weights[t])}, weights, plan));
    }
    if (plan.first.size() > 65535) throw Unsupported(source.file.string() + ": more than 65535 morph targets");
    for (const NodeTarget& target : plan.first) out.rest_weights.push_back(target.rest);
    out.names = namesOfWeights(source, plan);
    return out;
}

void appendMorphs(const SourcePart& part, const std::array<double, 12>& placement, SourceMorphs& out) {
    if (out.empty()) return;
    const std::vector<std::uint32_t>& weights = out.of_node[std::size_t(part.node)];
    const Mat3d linear{{placement[0], placement[1], placement[2], placement[4], placement[5], placement[6],
                        placement[8], placement[9], placement[10]}};
    const Mat3d turn = cofactor(linear);
    for (std::size_t v = 0; v < part.positions.size(); ++v) {
        const Vec3d normal = part.normals.empty() || part.targets.empty() ? Vec3d{} : turn * toDouble(part.normals[v]);
        const double scale = length(normal) > 0 ? 1 / length(normal) : 0;
        out.normals.push_back(toFloat(normal * scale));
        for (std::size_t t = 0; t < part.targets.size(); ++t) {
            MorphChange change{weights[t], {}, {}};
            if (!part.targets[t].empty()) change.move = toFloat(linear * toDouble(part.targets[t][v]));
            if (t < part.target_normals.size() && !part.target_normals[t].empty())
                change.turn = toFloat(turn * toDouble(part.target_normals[t][v]) * scale);
            if (change.move != Vec3{} || change.turn != Vec3{}) out.changes.push_back(change);
        }
        out.first.push_back(std::uint32_t(out.changes.size()));
    }
}

bool sameMorphs(const SourceMorphs& morphs, std::size_t a, std::size_t b, double radius) {
    if (morphs.empty()) return true;
    std::map<std::uint32_t, MorphChange> differences;
    for (const MorphChange& change : morphs.of(a)) differences[change.weight] = change;
    for (const MorphChange& change : morphs.of(b)) {
        MorphChange& difference = differences[change.weight];
        difference.move = difference.move - change.move;
        difference.turn = difference.turn - change.turn;
    }
    return std::all_of(differences.begin(), differences.end(), [&](const auto& one) {
        return length(toDouble(one.second.move)) <= radius && length(one.second.turn) <= kOtherTurn;
    });
}

namespace {

// Offsets of all points for one target.
struct DenseTarget {
    std::vector<Vec3> moves, turns;  // [V]
};

// Sets the turns of points that the file gives no normals for: how the normals of the triangles change.
void computeTurns(const Mesh& mesh, const std::vector<Vec3>& at_rest, const std::vector<bool>& given,
                  DenseTarget& target) {
    std::vector<Vec3> moved = mesh.rest_positions;
    for (std::size_t p = 0; p < moved.size(); ++p) moved[p] = moved[p] + target.moves[p];
    const std::vector<Vec3> normals = vertexNormals(mesh.triangles, moved);
    for (std::size_t p = 0; p < moved.size(); ++p)
        if (!given[p]) target.turns[p] = normals[p] - at_rest[p];
}

void appendRows(const DenseTarget& target, double least_move, MorphTargets& out) {
    for (std::size_t p = 0; p < target.moves.size(); ++p) {
        if (!(length(toDouble(target.moves[p])) > least_move) && !(length(target.turns[p]) > kNoTurn)) continue;
        out.vertices.push_back(std::uint32_t(p));
        out.positions.push_back(target.moves[p]);
        out.normals.push_back(target.turns[p]);
    }
    out.first.push_back(std::uint32_t(out.vertices.size()));
}

}  // namespace

void setMorphs(const SourceMorphs& source, const PointSources& from, const std::vector<Vec3>& rest_normals,
               Mesh& mesh) {
    if (source.empty()) return;
    const std::size_t points = mesh.vertexCount();
    const std::vector<Vec3> at_rest = vertexNormals(mesh.triangles, mesh.rest_positions);
    const double least_move = kNoMove * characterDiagonal(mesh);
    // 1. Sort the changes by target. A normal of the file that looks inwards was turned, and its changes are, too.
    std::vector<std::vector<std::pair<std::uint32_t, MorphChange>>> of_target(source.names.size());
    std::vector<bool> given(points);
    for (std::size_t p = 0; p < points; ++p) {
        const Vec3 normal = source.normals[from.of_turns[p]];
        given[p] = normal != Vec3{};
        for (const MorphChange& change : source.of(from.of_moves[p]))
            of_target[change.weight].push_back({std::uint32_t(p), {change.weight, change.move, {}}});
        for (const MorphChange& change : source.of(from.of_turns[p])) {
            const Vec3 turn = dot(normal, rest_normals[p]) < 0 ? -change.turn : change.turn;
            of_target[change.weight].push_back({std::uint32_t(p), {change.weight, {}, turn}});
        }
    }
    // 2. Make the rows of each target.
    mesh.morphs.names = source.names;
    mesh.morphs.rest_weights = source.rest_weights;
    mesh.morphs.first = {0};
    const bool computes = std::find(given.begin(), given.end(), false) != given.end();
    for (const auto& changes : of_target) {
        DenseTarget target{std::vector<Vec3>(points), std::vector<Vec3>(points)};
        for (const auto& [p, change] : changes) {
            target.moves[p] = target.moves[p] + change.move;
            target.turns[p] = target.turns[p] + change.turn;
        }
        if (computes) computeTurns(mesh, at_rest, given, target);
        appendRows(target, least_move, mesh.morphs);
    }
}

std::vector<WeightCurve> weightCurves(const RigSource& source, const SourceMorphs& morphs) {
    std::vector<WeightCurve> curves;
    for (const MorphChannel& channel : source.morphs) {
        const std::vector<std::uint32_t>& weights = morphs.of_node[std::size_t(channel.node)];
        if (!weights.empty())  // nodes that share weights drive them alike
            curves.push_back({channel.clip, weights, channel.interpolation, channel.times, channel.values});
    }
    return curves;
}

std::vector<float> weightsAt(const Rig& rig, int clip, double time) {
    std::vector<float> weights = rig.mesh.morphs.rest_weights;
    for (const WeightCurve& curve : rig.weight_curves) {
        if (curve.clip != clip || clip < 0) continue;
        const KeySpan span = findKeys(curve.times, time);
        const bool cubic = curve.interpolation == Interpolation::kCubicSpline;
        const std::size_t count = curve.weights.size(), stride = (cubic ? 3 : 1) * count;
        const float *from = &curve.values[span.from * stride], *to = &curve.values[span.to * stride];
        const double fraction = curve.interpolation == Interpolation::kStep ? 0 : span.fraction;
        for (std::size_t i = 0; i < count; ++i)
            weights[curve.weights[i]] =
                float(cubic ? cubicSpline(from, to, count, i, span) : from[i] + fraction * (double(to[i]) - from[i]));
    }
    return weights;
}

void addWeightKeys(int clip, std::vector<float> weights, Rig& rig) {
    const std::size_t count = rig.mesh.morphs.count();
    if (weights.empty()) return;
    WeightCurve curve{clip, {}, Interpolation::kStep, {}, std::move(weights)};
    for (std::size_t m = 0; m < count; ++m) curve.weights.push_back(std::uint32_t(m));
    for (std::size_t k = 0; k < curve.values.size() / count; ++k) curve.times.push_back(double(k));
    rig.weight_curves.push_back(std::move(curve));
}

}  // namespace penumbra
