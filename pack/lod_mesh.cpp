#include "pack/lod_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/surface_tree.h"
#include "formats/source/source_readers.h"

namespace penumbra {

namespace {

constexpr double kFarthest = 0.02;      // diagonals from the fitted surface
constexpr double kMaxFar = 0.01;        // share of the vertices that may be farther
constexpr double kSameRest = 1e-3;      // diagonals that the joints of a vertex may disagree about where it rests
constexpr std::size_t kNamesShown = 8;  // missing joints that a message names

// Returns the inverse of an affine map, in double. A map that is singular gives numbers that are not finite.
Affine inverseOf(const Affine& map) {
    const Mat3d linear = toDouble(map.linear()), cofactors = cofactor(linear);
    const double determinant =
        linear(0, 0) * cofactors(0, 0) + linear(0, 1) * cofactors(0, 1) + linear(0, 2) * cofactors(0, 2);
    const Mat3d turned = transposed(cofactors);
    const Vec3d way = turned * toDouble(map.translation());
    Affine out;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            out.m[std::size_t(4 * row + column)] = float(turned(row, column) / determinant);
        out.m[std::size_t(4 * row + 3)] = float(-way[row] / determinant);
    }
    return out;
}

Affine product(const Affine& a, const Affine& b) {
    const Mat3 linear = a.linear() * b.linear();
    const Vec3 way = a.point(b.translation());
    return {{linear.m[0], linear.m[1], linear.m[2], way.x, linear.m[3], linear.m[4], linear.m[5], way.y, linear.m[6],
             linear.m[7], linear.m[8], way.z}};
}

// Returns the model's joint for each joint of the level that moves a vertex.
std::vector<std::uint16_t> matchJoints(const Model& fitted, const Skin& skin, const std::string& file) {
    const std::size_t known = fitted.skin.jointCount() - fitted.input_joints.size();
    const auto begin = fitted.skin.joint_names.begin(), end = begin + std::ptrdiff_t(known);
    std::vector<bool> used(skin.jointCount());
    for (std::size_t i = 0; i < skin.joints.size(); ++i)
        if (skin.weights[i] > 0) used[skin.joints[i]] = true;
    std::vector<std::uint16_t> joints(skin.jointCount());
    std::vector<std::string> missing;
    for (std::size_t j = 0; j < joints.size(); ++j) {
        const auto found = std::find(begin, end, skin.joint_names[j]);
        joints[j] = found == end ? std::uint16_t(0) : std::uint16_t(found - begin);
        if (found == end && used[j]) missing.push_back("'" + skin.joint_names[j] + "'");
    }
    if (missing.empty()) return joints;
    const std::size_t count = missing.size();
    missing.resize(std::min(count, kNamesShown));
    throw InvalidInput(file + ": is of another skeleton: the model has no joint " +
                       joined(missing, ", ", [](const std::string& name) { return name; }) +
                       (count > kNamesShown ? " and " + std::to_string(count - kNamesShown) + " more" : ""));
}

// Moves the level from its rest space to that of the model: each joint takes a place to where the model has it. Throws
// InvalidInput where the joints of a vertex do not agree, because the level is bound in another pose.
void moveToRest(const Model& fitted, const std::vector<std::uint16_t>& joints, const std::string& file, Rig& rig) {
    if (fitted.skin.inverse_bind.empty() || rig.skin.inverse_bind.empty()) return;
    std::vector<Affine> moves;
    for (std::size_t j = 0; j < joints.size(); ++j)
        moves.push_back(fitted.skin.inverse_bind[joints[j]] == rig.skin.inverse_bind[j]
                            ? Affine{}
                            : product(inverseOf(fitted.skin.inverse_bind[joints[j]]), rig.skin.inverse_bind[j]));
    if (std::all_of(moves.begin(), moves.end(), [](const Affine& move) { return move == Affine{}; })) return;
    if (!rig.mesh.morphs.empty())
        throw Unsupported(file + ": has morph targets and is bound elsewhere than the model: export both in one file");
    std::vector<Vec3> positions, normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, moves, positions, normals);
    const double bound = kSameRest * boxDiagonal(fitted.mesh.rest_positions);
    const auto influences = std::size_t(rig.skin.influences);
    for (std::size_t i = 0; i < rig.skin.joints.size(); ++i) {
        if (!(rig.skin.weights[i] > 0)) continue;
        const std::size_t v = i / influences;
        const double away = length(moves[rig.skin.joints[i]].point(rig.mesh.rest_positions[v]) - positions[v]);
        if (!(away <= bound))
            throw InvalidInput(file + ": rests in another pose than the model: joint '" +
                               rig.skin.joint_names[rig.skin.joints[i]] + "' is " + std::to_string(away) +
                               " m from where the model has it");
    }
    rig.mesh.rest_positions = std::move(positions);
    rig.rest_normals = std::move(normals);
}

// Makes the targets of the level those of the model, by name. Throws Unsupported for a target that the model does not
// know. One that the level does not have moves nothing of it, of which a note tells.
void matchMorphs(const Model& fitted, const std::string& file, MorphTargets& morphs, std::vector<std::string>& notes) {
    const std::vector<std::string>& known = fitted.mesh.morphs.names;
    for (const std::string& name : morphs.names)
        if (std::find(known.begin(), known.end(), name) == known.end())
            throw Unsupported(file + ": has the morph target '" + name +
                              "', which the model does not know: leave it out of this file, or bake and fit with it");
    const MorphTargets own = std::move(morphs);
    morphs = {known, fitted.mesh.morphs.rest_weights, {}, {}};
    if (known.empty()) return;
    morphs.first = {0};
    std::vector<std::string> missing;
    for (const std::string& name : known) {
        const auto found = std::find(own.names.begin(), own.names.end(), name);
        if (found == own.names.end()) {
            missing.push_back("'" + name + "'");
        } else {
            const MorphRows rows = own.rowsOf(std::size_t(found - own.names.begin()));
            morphs.vertices.insert(morphs.vertices.end(), rows.vertices.begin(), rows.vertices.end());
            morphs.positions.insert(morphs.positions.end(), rows.positions.begin(), rows.positions.end());
            morphs.normals.insert(morphs.normals.end(), rows.normals.begin(), rows.normals.end());
        }
        morphs.first.push_back(std::uint32_t(morphs.vertices.size()));
    }
    if (missing.empty()) return;
    const std::size_t count = missing.size();
    missing.resize(std::min(count, kNamesShown));
    notes.push_back(file + ": has no morph target " +
                    joined(missing, ", ", [](const std::string& name) { return name; }) +
                    (count > kNamesShown ? " and " + std::to_string(count - kNamesShown) + " more" : "") +
                    " of the model: the level does not move with them");
}

// Gives the triangles of the level the mean opacity of the fitted triangle that is nearest to their middle.
void takeOpacity(const Mesh& fitted, Mesh& level) {
    level.opacity = {};
    const std::vector<std::uint8_t> mean = meanOpacity(fitted.opacity, fitted.frontTriangleCount());
    if (mean.empty()) return;
    const SurfaceTree tree(fitted.frontTriangles(), fitted.rest_positions);
    for (std::uint32_t t = 0; t < level.frontTriangleCount(); ++t) {
        Vec3 middle;
        for (const std::uint32_t v : level.triangles[t]) middle += level.rest_positions[v] / 3.0f;
        const auto nearest = tree.nearest(middle, [](std::uint32_t, const std::array<double, 3>&) { return 0.0; });
        if (!nearest || mean[nearest->triangle] == kStopsAll) continue;
        level.opacity.triangles.push_back(t);
        level.opacity.pieces.push_back(1);
        level.opacity.first.push_back(std::uint32_t(level.opacity.values.size()));
        level.opacity.values.push_back(mean[nearest->triangle]);
    }
}

// Refuses a level that is not the fitted surface.
void checkDistances(const DrawnMesh& drawn, const PointDistances& distances, double diagonal, const std::string& file) {
    std::vector<std::size_t> far_of_joint(drawn.skin.jointCount());
    std::size_t far = 0, farthest = 0;
    for (std::size_t v = 0; v < distances.distance.size(); ++v) {
        if (distances.distance[v] > distances.distance[farthest]) farthest = v;
        if (double(distances.distance[v]) <= kFarthest * diagonal) continue;
        ++far;
        ++far_of_joint[drawn.skin.joints[v * std::size_t(drawn.skin.influences)]];
    }
    const double share = double(far) / double(distances.distance.size());
    if (share <= kMaxFar) return;
    const Vec3 p = drawn.mesh.rest_positions[farthest];
    const auto most = std::size_t(std::max_element(far_of_joint.begin(), far_of_joint.end()) - far_of_joint.begin());
    char text[240];
    std::snprintf(text, sizeof text,
                  ": %.1f%% of its vertices are farther than %g diagonals from the surface that the model was fitted "
                  "to, or look the other way; the worst is at (%.3g, %.3g, %.3g), most are moved by joint '",
                  100 * share, kFarthest, double(p.x), double(p.y), double(p.z));
    throw InvalidInput(file + text + drawn.skin.joint_names[most] + "'");
}

void measureDistances(const PointDistances& distances, double diagonal, LodMesh& lod) {
    double squared = 0;
    std::size_t near = 0;
    for (const float distance : distances.distance) {
        if (!std::isfinite(distance)) continue;
        ++near;
        squared += double(distance) * distance;
        lod.max_distance = std::max(lod.max_distance, distance / diagonal);
    }
    const auto count = double(distances.distance.size());
    lod.rms_distance = near > 0 ? std::sqrt(squared / double(near)) / diagonal : 0;
    lod.turned_share = (count - double(near)) / count;
}

}  // namespace

LodMesh readLod(const Model& fitted, const std::filesystem::path& file, const std::string& node, int threads) {
    if (fitted.deforming)
        throw Unsupported(file.string() + ": the model is of a mesh without a skeleton, which no other mesh follows");
    RigOptions options;
    if (!node.empty()) options.nodes = {node};
    if (fitted.mesh.two_sided) options.sides = RigSides::kFronts;  // each vertex gets its back below
    Rig rig = readRig({file}, options);
    const std::vector<std::uint16_t> joints = matchJoints(fitted, rig.skin, file.string());
    moveToRest(fitted, joints, file.string(), rig);
    LodMesh lod;
    lod.files_read = rig.files_read;
    for (const RigNote& note : rig.notes) lod.notes.push_back(textOf(note));
    DrawnMesh& drawn = lod.drawn;
    drawn.mesh = std::move(rig.mesh);
    matchMorphs(fitted, file.string(), drawn.mesh.morphs, lod.notes);
    takeOpacity(fitted.mesh, drawn.mesh);
    drawn.rest_normals = std::move(rig.rest_normals);
    drawn.skin = fitted.skin;
    drawn.skin.influences = rig.skin.influences;
    drawn.skin.weights = std::move(rig.skin.weights);
    drawn.skin.joints.clear();
    for (std::size_t i = 0; i < rig.skin.joints.size(); ++i)
        drawn.skin.joints.push_back(drawn.skin.weights[i] > 0 ? joints[rig.skin.joints[i]] : std::uint16_t(0));
    if (fitted.mesh.two_sided) {
        drawn.mesh = withBacks(drawn.mesh);
        drawn.skin = withBacks(drawn.skin);
        appendBackNormals(drawn.rest_normals);
    }
    PointDistances distances;
    drawn.points = nearestPoints({fitted.mesh, fitted.rest_normals}, {drawn.mesh, drawn.rest_normals}, nullptr, threads,
                                 distances);
    const double diagonal = boxDiagonal(fitted.mesh.rest_positions);
    checkDistances(drawn, distances, diagonal, file.string());
    measureDistances(distances, diagonal, lod);
    return lod;
}

}  // namespace penumbra
