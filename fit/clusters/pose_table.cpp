#include "fit/clusters/pose_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fit/clusters/deforming_pose.h"
#include "fit/clusters/rigid_parts.h"
#include "fit/numerics/pca.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/dihedral_angles.h"

namespace penumbra {

namespace {

// The contents of the file for every frame.
struct RawPoses {
    std::vector<Affine> bones;  // [F, J] of the file's own joints
    std::vector<float> inputs;  // [F, X]
    MatrixF angles;             // [F, E]; empty when no angles are asked for
};

// Reads every frame. A deforming mesh keeps its positions and normals; a character keeps its pose.
RawPoses readFrames(const VisibilityReader& reader, const PoseRequest& request, PoseTable& poses) {
    const VisibilityHeader& header = reader.header();
    const std::size_t frames = header.frames.frameCount(), fronts = header.mesh.frontVertexCount();
    const std::size_t inputs = header.input_names.size();
    RawPoses raw;
    if (poses.deforming && request.angle_variance > 0) raw.angles = MatrixF(frames, header.edges.size());
    for (std::size_t f = 0; f < frames; ++f) {
        throwIfInterrupted();
        const VisibilityFrame frame = reader.readPose(f);
        raw.bones.insert(raw.bones.end(), frame.bones.begin(), frame.bones.end());
        raw.inputs.insert(raw.inputs.end(), frame.pose.end() - long(inputs), frame.pose.end());
        if (!poses.deforming) {
            poses.pose.insert(poses.pose.end(), frame.pose.begin(), frame.pose.end());
            continue;
        }
        poses.positions.insert(poses.positions.end(), frame.positions.begin(), frame.positions.begin() + long(fronts));
        poses.normals.insert(poses.normals.end(), frame.normals.begin(), frame.normals.begin() + long(fronts));
        if (!raw.angles.values.empty()) std::copy_n(frame.pose.begin(), raw.angles.columns, raw.angles.row(f).begin());
    }
    return raw;
}

// Makes a skin in which near-rigid parts are joints, each the only one to move its vertices.
Skin skinOfParts(const VisibilityHeader& header, const PoseTable& poses, const PoseRequest& request) {
    const std::size_t fronts = header.mesh.frontVertexCount();
    const DeformingFrames mesh{std::span(header.mesh.triangles).first(header.mesh.frontTriangleCount()),
                               std::span(header.mesh.rest_positions).first(fronts), poses.positions, request.train};
    const RigidParts parts = findRigidParts(mesh, request.parts, request.threads);
    Skin skin;
    // The backs of a two-sided mesh follow the joints of their fronts.
    for (std::size_t p = 0; p < parts.count; ++p) skin.joint_names.push_back("part" + std::to_string(p));
    skin.parents.assign(parts.count, -1);
    skin.influences = 1;
    skin.joints = parts.part_of_vertex;
    if (header.mesh.two_sided) skin.joints.insert(skin.joints.end(), skin.joints.begin(), skin.joints.end());
    skin.weights.assign(skin.joints.size(), 1);
    return skin;
}

// Scales a number so that its mean over training frames is 0 and its range is 1. Features then do not depend on its
// unit.
void scaleNumber(InputJoint& joint, const RawPoses& raw, std::size_t inputs, std::span<const std::size_t> train,
                 double feature_scale) {
    double mean = 0, least = std::numeric_limits<double>::infinity(), most = -least;
    for (std::size_t f : train) {
        const double x = raw.inputs[f * inputs + joint.column];
        mean += x / double(train.size());
        least = std::min(least, x);
        most = std::max(most, x);
    }
    joint.offset = float(mean);
    joint.scale = float(feature_scale / (most > least ? most - least : 1));
}

// Returns the name, or "NAME#2" and so on where a joint has it: a file's joints have names of their own.
std::string unusedName(const std::string& name, const std::vector<std::string>& taken) {
    std::string out = name;
    for (int n = 2; std::find(taken.begin(), taken.end(), out) != taken.end(); ++n)
        out = name + "#" + std::to_string(n);
    return out;
}

// Returns the mean place at rest of what a target moves, weighted by how far.
Vec3 centerOfTarget(const Mesh& mesh, std::size_t target) {
    const MorphRows rows = mesh.morphs.rowsOf(target);
    Vec3d sum;
    double weight = 0;
    for (std::size_t r = 0; r < rows.vertices.size(); ++r) {
        const double move = length(toDouble(rows.positions[r]));
        sum += toDouble(mesh.rest_positions[rows.vertices[r]]) * move;
        weight += move;
    }
    return weight > 0 ? toFloat(sum / weight) : Vec3{};
}

// Adds the joints of the inputs behind the other joints.
void addInputJoints(const VisibilityHeader& header, const RawPoses& raw, const PoseRequest& request, PoseTable& poses) {
    const std::size_t inputs = header.input_names.size();
    poses.input_joints = inputJoints(header.input_names, poses.skin.jointCount());
    const double scale = characterDiagonal(header.mesh);
    // 1. Name the joints.
    for (const std::string& name : inputJointNames(header.input_names, poses.input_joints)) {
        poses.skin.joint_names.push_back(unusedName(name, poses.skin.joint_names));
        poses.skin.parents.push_back(-1);
        if (!poses.skin.rest_transforms.empty()) poses.skin.rest_transforms.push_back({});
        if (!poses.skin.inverse_bind.empty()) poses.skin.inverse_bind.push_back({});
    }
    // 2. Place them: a point is where it is in the first training frame.
    poses.joint_centers = jointCenters(header.mesh, poses.skin);
    for (InputJoint& joint : poses.input_joints) {
        const float* x = raw.inputs.data() + request.train.front() * inputs + joint.column;
        poses.joint_centers[joint.joint] = joint.absolute() ? Vec3{} : Vec3{x[0], x[1], x[2]};
        if (joint.absolute()) scaleNumber(joint, raw, inputs, request.train, scale);
        // A morph target is where it moves the mesh, so that clusters tell near targets from far ones.
        const std::size_t morphs = header.mesh.morphs.count();
        if (joint.absolute() && joint.column + morphs >= inputs)
            poses.joint_centers[joint.joint] = centerOfTarget(header.mesh, joint.column + morphs - inputs);
    }
}

// Makes a PCA of all dihedral angles over the training frames. It is scaled so that the first number has a standard
// deviation of 1 there.
void reduceAngles(const RawPoses& raw, const PoseRequest& request, PoseTable& poses) {
    const std::vector<double> mean = meanOfRows(raw.angles, request.train);
    poses.pose_mean.assign(mean.begin(), mean.end());
    MatrixF centered(request.train.size(), raw.angles.columns);
    for (std::size_t r = 0; r < centered.rows; ++r)
        for (std::size_t e = 0; e < centered.columns; ++e) {
            const float angle = raw.angles(request.train[r], e), middle = poses.pose_mean[e];
            centered(r, e) = addTurns(angle, turnsTowards(middle, angle)) - middle;
        }
    const Pca pca = principalComponents(centered);
    if (pca.energies.empty()) return;  // nothing moves
    poses.pose_basis = basisOf(pca, centered, componentsFor(pca, request.angle_variance)).values;
    const auto scale = float(1 / std::sqrt(pca.energies[0] / double(centered.rows)));
    for (float& x : poses.pose_basis) x *= scale;
}

// Writes the pose of a deforming mesh in every frame: reduced angles, if any, then the inputs.
void writePose(const RawPoses& raw, std::size_t inputs, PoseTable& poses) {
    const std::size_t frames = poses.frameCount();
    for (std::size_t f = 0; f < frames; ++f) {
        if (!poses.pose_mean.empty()) {
            const std::vector<float> reduced = reducedAngles(poses.pose_mean, poses.pose_basis, raw.angles.row(f));
            poses.pose.insert(poses.pose.end(), reduced.begin(), reduced.end());
        }
        const auto first = raw.inputs.begin() + long(f * inputs);
        poses.pose.insert(poses.pose.end(), first, first + long(inputs));
    }
    poses.pose_size = poses.pose.size() / frames;
}

}  // namespace

PoseTable readPoses(const VisibilityReader& reader, const PoseRequest& asked) {
    const VisibilityHeader& header = reader.header();
    const std::size_t frames = header.frames.frameCount(), inputs = header.input_names.size();
    // 1. Without a list of training frames, all frames are.
    PoseRequest request = asked;
    for (std::size_t f = 0; f < frames && asked.train.empty(); ++f) request.train.push_back(f);
    PoseTable poses;
    poses.deforming = !header.skin;
    // 2. Read the file, and find the parts of a mesh without a skeleton.
    const RawPoses raw = readFrames(reader, request, poses);
    poses.skin = header.skin ? *header.skin : skinOfParts(header, poses, request);
    const std::size_t own = poses.skin.jointCount();
    // 3. Add the inputs as joints.
    addInputJoints(header, raw, request, poses);
    poses.joints = poses.skin.jointCount();
    const std::size_t fronts = header.mesh.frontVertexCount();
    poses.bones.resize(frames * poses.joints);
    poses.rotations.resize(poses.bones.size());
    // 4. Compute the bones of every frame and their rotations.
    parallelFor(frames, request.threads, [&](std::size_t f) {
        std::vector<Affine> bones =
            poses.deforming
                ? partBones(header.mesh, poses.skin, own, std::span(poses.positions).subspan(f * fronts, fronts))
                : std::vector<Affine>(raw.bones.begin() + long(f * own), raw.bones.begin() + long((f + 1) * own));
        appendInputBones(poses.input_joints, poses.joint_centers, std::span(raw.inputs).subspan(f * inputs, inputs),
                         bones);
        std::ranges::copy(bones, poses.bones.begin() + long(f * poses.joints));
        std::ranges::copy(rotationsOf(bones), poses.rotations.begin() + long(f * poses.joints));
    });
    // 5. Compute the pose of every frame.
    if (!raw.angles.values.empty()) reduceAngles(raw, request, poses);
    if (poses.deforming)
        writePose(raw, inputs, poses);
    else
        poses.pose_size = std::size_t(header.pose_size);
    return poses;
}

std::vector<Mat3> rotationsOf(std::span<const Affine> bones) {
    std::vector<Mat3> rotations;
    for (const Affine& bone : bones) rotations.push_back(nearestRotation(bone.linear()));
    return rotations;
}

}  // namespace penumbra
