#pragma once
// Two skeletons whose joints are matched, and how their rest poses differ (rig_retarget.cpp tells why).
#include <functional>
#include <vector>

#include "formats/rig/rig_build.h"

namespace penumbra {

struct RestPose {
    std::vector<Matrix> globals;
    std::vector<Quaternion> rotations;
    std::vector<Vec3d> positions;
};

// How the rest poses of a rig and of a clip differ.
enum class Relation : std::uint8_t {
    kSameAxes,   // the joints have the same axes
    kOtherAxes,  // the bones point the same ways, but the joints have other axes
    kInClip,     // the clip's nodes stand in its first frame
    kNoRest      // the clip's nodes have no transforms
};

struct Bone {
    int parent = -1, child = -1;  // nodes of the rig
    Vec3d of_rig, of_clip;        // from parent to child at rest, in the model frame
};

struct Skeletons {
    const RigSource& rig;
    const RigSource& from;
    const std::vector<int>& clip_of;
    RestPose rig_rest, clip_rest;
    std::vector<int> parent;             // [node of the rig] the nearest ancestor that is matched, or -1
    std::vector<bool> rotates;           // [node of the clip] a channel turns it
    std::vector<Bone> bones;             // between matched joints
    double rig_size = 0, clip_size = 0;  // sums of the bones' lengths
    // diagonals of the boxes around matched joints
    double rig_extent = 0, clip_extent = 0;

    std::size_t clipNode(int n) const { return std::size_t(clip_of[std::size_t(n)]); }
    const std::string& name(int n) const { return rig.nodes[std::size_t(n)].name; }
};

// Compares the two. `clip_of[n]` is the node of `from` that moves node n of `rig`, or -1; all must outlive the result.
// Throws InvalidInput where a joint hangs on another one in the clip's file.
Skeletons skeletonsOf(const RigSource& rig, const RigSource& from, const std::vector<int>& clip_of);
// Tells whether there are long bones, and all of them point the same ways within 20 degrees once `turn` has turned
// those of the clip.
bool longBonesAgree(const Skeletons& skeletons, const std::function<Vec3d(Vec3d)>& turn);
// Throws InvalidInput where the rest poses do not fit, with the joints and by how much they are turned.
Relation relationOf(const Skeletons& skeletons);
// Returns how many times as large the rig is: by the height of the first joint that is high above the ground at rest
// (the hips), or by the bones' lengths where no joint is or the clip has no rest pose.
double sizeRatio(const Skeletons& skeletons, Relation relation);
// Pushes notes of what is not the same.
void sayDifferences(const Skeletons& skeletons, Relation relation, double ratio, std::vector<RigNote>& notes);

}  // namespace penumbra
