#include "bake/poses/limbs.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <utility>

#include "bake/poses/attached_joints.h"

namespace penumbra {

constexpr double kFar = 0.06;        // in rest diagonals
constexpr double kSamePlace = 0.02;  // in rest diagonals

std::size_t Limbs::mirroredCount() const {
    return std::size_t(std::count_if(mirrored_limb.begin(), mirrored_limb.end(), [](int limb) { return limb >= 0; }));
}

namespace {

// The joints as a tree in the rest space. Of the joints that share a node the first one stands for all of them, and the
// others have neither parents nor children.
struct Skeleton {
    std::vector<int> first;                  // [J] the joint that stands for each
    std::vector<int> parents;                // [J]
    std::vector<std::vector<int>> children;  // [J]
    std::vector<int> order;                  // the joints that stand for themselves, parents before children
    std::vector<Vec3d> origin;               // [J]
    std::vector<std::vector<Vec3d>> places;  // [J] rest positions of the vertices that the joint dominates
    std::vector<char> carries;               // [J]
    std::vector<Vec3d> center;               // [J] subtreeCenters()
    double diagonal = 1;
};

void buildTree(const Rig& rig, Skeleton& out) {
    std::vector<int> joint_at_node(rig.nodes.size(), -1);
    out.children.resize(rig.skin.jointCount());
    for (std::size_t j = 0; j < rig.skin.jointCount(); ++j) {
        int& first = joint_at_node[std::size_t(rig.node_of_joint[j])];
        if (first < 0) first = int(j);
        out.first.push_back(first);
        out.parents.push_back(first == int(j) ? rig.skin.parents[j] : -1);
        if (out.parents[j] >= 0) out.children[std::size_t(out.parents[j])].push_back(int(j));
        if (first == int(j) && out.parents[j] < 0) out.order.push_back(int(j));
    }
    for (std::size_t i = 0; i < out.order.size(); ++i) {
        const std::vector<int>& below = out.children[std::size_t(out.order[i])];
        out.order.insert(out.order.end(), below.begin(), below.end());
    }
}

// Brings vertices of joints that share a node into the rest space of the first of them.
void placeVertices(const Rig& rig, Skeleton& out) {
    out.places.resize(rig.skin.jointCount());
    std::vector<std::optional<Matrix>> bind;
    for (std::size_t j = 0; j < rig.skin.jointCount(); ++j) {
        bind.push_back(inverse(rig.inverse_bind[j]));
        out.origin.push_back(bind[j] ? transformPoint(*bind[j], {0, 0, 0}) : Vec3d{});
    }
    const auto influences = std::size_t(rig.skin.influences);
    for (std::size_t v = 0; v < rig.mesh.vertexCount(); ++v) {
        const std::size_t joint = rig.skin.joints[v * influences];
        const auto first = std::size_t(out.first[joint]);
        Vec3d p = toDouble(rig.mesh.rest_positions[v]);
        if (first != joint && bind[first]) p = transformPoint(multiply(*bind[first], rig.inverse_bind[joint]), p);
        out.places[first].push_back(p);
    }
}

// Returns the mean of the origins of the joints of each subtree that carry vertices. It tells joints apart that stand
// at one place, like the first joints of two legs.
std::vector<Vec3d> subtreeCenters(const Skeleton& skeleton) {
    std::vector<Vec3d> sum = skeleton.origin;
    std::vector<double> count(sum.size(), 1);
    for (auto joint = skeleton.order.rbegin(); joint != skeleton.order.rend(); ++joint) {
        const auto j = std::size_t(*joint);
        if (skeleton.parents[j] < 0 || !skeleton.carries[j]) continue;
        sum[std::size_t(skeleton.parents[j])] += sum[j];
        count[std::size_t(skeleton.parents[j])] += count[j];
    }
    for (std::size_t j = 0; j < sum.size(); ++j) sum[j] = sum[j] / count[j];
    return sum;
}

Skeleton skeletonOf(const Rig& rig) {
    Skeleton out;
    buildTree(rig, out);
    placeVertices(rig, out);
    out.diagonal = characterDiagonal(rig.mesh);
    out.carries.resize(rig.skin.jointCount());
    for (std::size_t i = 0; i < rig.skin.weights.size(); ++i)
        if (rig.skin.weights[i] > 0) out.carries[std::size_t(out.first[rig.skin.joints[i]])] = 1;
    for (auto j = out.order.rbegin(); j != out.order.rend(); ++j)
        if (const int parent = out.parents[std::size_t(*j)]; parent >= 0 && out.carries[std::size_t(*j)])
            out.carries[std::size_t(parent)] = 1;
    out.center = subtreeCenters(out);
    return out;
}

// Returns how far the vertices of the subtree of `joint` are from `point` at most.
double farthestVertex(const Skeleton& skeleton, int joint, Vec3d point) {
    double farthest = 0;
    std::vector<int> below{joint};
    for (std::size_t i = 0; i < below.size(); ++i) {
        for (const Vec3d p : skeleton.places[std::size_t(below[i])]) farthest = std::max(farthest, length(p - point));
        for (const int child : skeleton.children[std::size_t(below[i])]) below.push_back(child);
    }
    return farthest;
}

bool isTwistBone(const Skeleton& skeleton, int joint, int fork) {
    const auto carries = [&](int child) { return skeleton.carries[std::size_t(child)] != 0; };
    const std::vector<int>& below = skeleton.children[std::size_t(joint)];
    if (std::any_of(below.begin(), below.end(), carries)) return false;
    const Vec3d from = skeleton.origin[std::size_t(fork)];
    const double farthest = farthestVertex(skeleton, joint, from);
    const std::vector<int>& siblings = skeleton.children[std::size_t(fork)];
    return std::any_of(siblings.begin(), siblings.end(), [&](int sibling) {
        return sibling != joint && carries(sibling) && farthest <= length(skeleton.origin[std::size_t(sibling)] - from);
    });
}

// Returns the children of a joint whose subtrees are limbs.
std::vector<int> limbRoots(const Skeleton& skeleton, int fork) {
    std::vector<int> roots;
    const std::vector<int>& children = skeleton.children[std::size_t(fork)];
    if (children.size() < 2) return roots;
    for (const int child : children) {
        const double reach = farthestVertex(skeleton, child, skeleton.origin[std::size_t(child)]);
        if (reach >= kFar * skeleton.diagonal && !isTwistBone(skeleton, child, fork)) roots.push_back(child);
    }
    if (roots.size() < 2) roots.clear();
    return roots;
}

void cutAtForks(const Skeleton& skeleton, Limbs& limbs) {
    limbs.limb_of_joint.assign(skeleton.parents.size(), 0);
    std::vector<char> is_root(skeleton.parents.size(), 0);
    for (const int joint : skeleton.order) {
        const auto j = std::size_t(joint);
        if (is_root[j])
            limbs.limb_of_joint[j] = int(limbs.count++);
        else if (skeleton.parents[j] >= 0)
            limbs.limb_of_joint[j] = limbs.limb_of_joint[std::size_t(skeleton.parents[j])];
        for (const int root : limbRoots(skeleton, joint)) is_root[std::size_t(root)] = 1;
    }
    for (std::size_t j = 0; j < skeleton.first.size(); ++j)
        limbs.limb_of_joint[j] = limbs.limb_of_joint[std::size_t(skeleton.first[j])];
}

// Makes one limb of those that a pair of joints joins, and numbers the limbs anew in the same order.
void joinLimbs(const std::vector<std::pair<int, int>>& pairs, Limbs& limbs) {
    std::vector<int> joined(limbs.count);  // the first limb that each one is joined with
    std::iota(joined.begin(), joined.end(), 0);
    for (const auto& [a, b] : pairs) {
        const int one = joined[std::size_t(limbs.limb_of_joint[std::size_t(a)])];
        const int other = joined[std::size_t(limbs.limb_of_joint[std::size_t(b)])];
        std::replace(joined.begin(), joined.end(), std::max(one, other), std::min(one, other));
    }
    std::vector<int> number(limbs.count, -1);
    limbs.count = 0;
    for (const int limb : joined)
        if (number[std::size_t(limb)] < 0) number[std::size_t(limb)] = int(limbs.count++);
    for (int& limb : limbs.limb_of_joint) limb = number[std::size_t(joined[std::size_t(limb)])];
}

void placeNodes(const Rig& rig, Limbs& limbs) {
    constexpr int kNone = -1, kSeveral = -2;
    std::vector<int> own(rig.nodes.size(), kNone);
    for (std::size_t j = 0; j < rig.node_of_joint.size(); ++j)
        if (int& limb = own[std::size_t(rig.node_of_joint[j])]; limb == kNone) limb = limbs.limb_of_joint[j];
    std::vector<int> below(rig.nodes.size(), kNone);  // the limb of all joints at or under a node
    for (std::size_t n = rig.nodes.size(); n-- > 0;) {
        if (own[n] != kNone) below[n] = own[n];
        if (rig.nodes[n].parent < 0 || below[n] == kNone) continue;
        int& above = below[std::size_t(rig.nodes[n].parent)];
        above = above == kNone || above == below[n] ? below[n] : kSeveral;
    }
    for (std::size_t n = 0; n < rig.nodes.size(); ++n) {
        const int parent = rig.nodes[n].parent;
        const int inherited = parent < 0 ? 0 : limbs.limb_of_node[std::size_t(parent)];
        limbs.limb_of_node.push_back(own[n] != kNone ? own[n] : below[n] >= 0 ? below[n] : inherited);
    }
}

// --- Mirror images --------------------------------------------------------------------------------------------------

struct Plane {
    int axis = 0;
    double offset = 0;
    Vec3d image(Vec3d p) const {
        p[axis] = 2 * offset - p[axis];
        return p;
    }
};

// The plane goes through the median of the joints, which a few asymmetric ones cannot shift.
Plane planeThroughMedian(const Skeleton& skeleton, int axis) {
    std::vector<double> at;
    for (std::size_t j = 0; j < skeleton.origin.size(); ++j)
        if (skeleton.carries[j]) at.push_back(skeleton.origin[j][axis]);
    if (at.empty()) return {axis, 0};
    std::sort(at.begin(), at.end());
    return {axis, (at[(at.size() - 1) / 2] + at[at.size() / 2]) / 2};
}

struct Images {
    std::vector<int> joint;          // [J], -1 where there is none
    std::size_t found = 0, off = 0;  // joints that carry vertices and have an image; of these, off the plane
};

// Matches each of `joints` with the one of `others` that lies nearest to its image.
void matchSiblings(const Skeleton& skeleton, const Plane& plane, const std::vector<int>& joints,
                   const std::vector<int>& others, Images& images) {
    const auto distance = [&](int a, int b) {
        return length(plane.image(skeleton.origin[std::size_t(a)]) - skeleton.origin[std::size_t(b)]);
    };
    const auto apart = [&](int a, int b) {
        return distance(a, b) + length(plane.image(skeleton.center[std::size_t(a)]) - skeleton.center[std::size_t(b)]);
    };
    for (const int a : joints) {
        int best = -1;
        for (const int b : others)
            if (distance(a, b) <= kSamePlace * skeleton.diagonal &&
                skeleton.carries[std::size_t(a)] == skeleton.carries[std::size_t(b)] &&
                (best < 0 || apart(a, b) < apart(a, best)))
                best = b;
        images.joint[std::size_t(a)] = best;
    }
}

// Keeps only pairs that are each other's image, and counts them.
void keepMutual(const Skeleton& skeleton, const Plane& plane, Images& images) {
    std::vector<int> mutual(images.joint.size(), -1);
    for (std::size_t j = 0; j < mutual.size(); ++j) {
        const int image = images.joint[j];
        if (image < 0 || images.joint[std::size_t(image)] != int(j)) continue;
        mutual[j] = image;
        if (!skeleton.carries[j]) continue;
        ++images.found;
        const double from_plane = std::abs(skeleton.origin[j][plane.axis] - plane.offset);
        if (from_plane > kSamePlace * skeleton.diagonal) ++images.off;
    }
    images.joint = mutual;
}

// Goes down the tree. The children of a joint are matched with those of its image, or with one another where it has
// none, so that an asymmetric trunk does not hide that the arms are symmetric.
Images findImages(const Skeleton& skeleton, const Plane& plane) {
    Images images{std::vector<int>(skeleton.parents.size(), -1)};
    std::vector<int> roots;
    std::copy_if(skeleton.order.begin(), skeleton.order.end(), std::back_inserter(roots),
                 [&](int j) { return skeleton.parents[std::size_t(j)] < 0; });
    matchSiblings(skeleton, plane, roots, roots, images);
    for (const int joint : skeleton.order) {
        const int image = images.joint[std::size_t(joint)] < 0 ? joint : images.joint[std::size_t(joint)];
        matchSiblings(skeleton, plane, skeleton.children[std::size_t(joint)], skeleton.children[std::size_t(image)],
                      images);
    }
    keepMutual(skeleton, plane, images);
    return images;
}

Matrix reflectionAt(const Plane& plane) {
    Matrix out = kIdentityMatrix;
    out[std::size_t(5 * plane.axis)] = -1;
    out[std::size_t(4 * plane.axis + 3)] = 2 * plane.offset;
    return out;
}

// A node that has a matrix cannot be posed, and a singular joint has no place at rest.
bool canBePosed(const Rig& rig, std::size_t joint) {
    return !rig.nodes[std::size_t(rig.node_of_joint[joint])].matrix && inverse(rig.inverse_bind[joint]).has_value();
}

// Returns the limb that the images of a limb's joints form, or -1.
int imageOfLimb(const Rig& rig, const Limbs& limbs, int limb) {
    int image_limb = -1;
    for (std::size_t j = 0; j < limbs.limb_of_joint.size(); ++j) {
        if (limbs.limb_of_joint[j] != limb || !limbs.carries[j]) continue;
        const int image = limbs.mirrored_joint[j], parent = rig.skin.parents[j];
        if (image < 0 || !canBePosed(rig, j) || (parent >= 0 && !inverse(rig.inverse_bind[std::size_t(parent)])))
            return -1;
        const int found = limbs.limb_of_joint[std::size_t(image)];
        if (image_limb >= 0 && found != image_limb) return -1;
        image_limb = found;
        // Inside of the limb parents must be one another's images. Above its first joint they may be the same joint.
        const int image_parent = rig.skin.parents[std::size_t(image)];
        if ((parent < 0) != (image_parent < 0)) return -1;
        if (parent >= 0 && limbs.mirrored_joint[std::size_t(parent)] != image_parent && parent != image_parent)
            return -1;
    }
    return image_limb;
}

// Takes the axis at which most joints have an image. A chain in a plane is its own image at more than one axis, which
// says nothing about left and right. So joints off the plane must have images, and most joints.
void findMirror(const Rig& rig, const Skeleton& skeleton, Limbs& limbs) {
    limbs.mirrored_joint.assign(skeleton.parents.size(), -1);
    limbs.mirrored_limb.assign(limbs.count, -1);
    Images best;
    for (int axis = 0; axis < 3; ++axis) {
        const Plane plane = planeThroughMedian(skeleton, axis);
        Images images = findImages(skeleton, plane);
        if (images.off == 0 || std::pair(images.found, images.off) <= std::pair(best.found, best.off)) continue;
        best = std::move(images);
        limbs.reflection = reflectionAt(plane);
    }
    const auto carrying = std::size_t(std::count(limbs.carries.begin(), limbs.carries.end(), 1));
    if (2 * best.found < carrying || best.found == 0) return;
    limbs.mirrored_joint = best.joint;
    for (std::size_t limb = 0; limb < limbs.count; ++limb)
        limbs.mirrored_limb[limb] = imageOfLimb(rig, limbs, int(limb));
    // A limb that is no image of its own image has other joints than that.
    const std::vector<int> images = limbs.mirrored_limb;
    for (std::size_t limb = 0; limb < limbs.count; ++limb)
        if (images[limb] >= 0 && images[std::size_t(images[limb])] != int(limb)) limbs.mirrored_limb[limb] = -1;
}

}  // namespace

std::vector<char> carryingJoints(const Rig& rig) { return skeletonOf(rig).carries; }

Limbs findLimbs(const Rig& rig, std::span<const RigFrame> frames, int threads) {
    const Skeleton skeleton = skeletonOf(rig);
    Limbs limbs;
    limbs.carries = skeleton.carries;
    cutAtForks(skeleton, limbs);
    joinLimbs(attachedJoints(rig, frames, threads), limbs);
    placeNodes(rig, limbs);
    findMirror(rig, skeleton, limbs);
    return limbs;
}

}  // namespace penumbra
