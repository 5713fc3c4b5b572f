// Chooses the joints of a rig: those of its skins, and one for whatever else moves rigidly.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"
#include "sh/bounding_box.h"

namespace penumbra {

void failAtFile(const std::filesystem::path& file, const std::string& what) {
    throw InvalidInput(file.string() + ": " + cleanText(what));
}

void failAtNode(const RigSource& source, int node, const std::string& what) {
    failAtFile(source.file, "node '" + source.nodes[std::size_t(node)].name + "': " + what);
}

namespace {

std::span<const double> restValue(const Node& node, Channel::Path path) {
    if (path == Channel::Path::kTranslation) return node.translation;
    if (path == Channel::Path::kRotation) return node.rotation;
    return node.scale;
}

// Tells whether a channel moves its node. Exporters write constant channels for every node; those that repeat the
// rest value move nothing.
bool moves(const Node& node, const Channel& channel) {
    if (channel.interpolation == Interpolation::kCubicSpline) return true;
    const std::span<const double> rest = restValue(node, channel.path);
    double size = 0;
    for (const double v : rest) size = std::max(size, std::abs(v));
    for (std::size_t i = 0; i < channel.values.size(); ++i)
        if (std::abs(channel.values[i] - rest[i % rest.size()]) > 1e-6 * size) return true;
    return false;
}

std::vector<bool> animatedNodes(const RigSource& source) {
    std::vector<bool> animated(source.nodes.size());
    for (const Clip& clip : source.clips)
        for (const Channel& channel : clip.channels)
            if (moves(source.nodes[std::size_t(channel.node)], channel)) animated[std::size_t(channel.node)] = true;
    return animated;
}

bool nearlyEqual(const Matrix& a, const Matrix& b) {
    double size = 0, difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        size = std::max({size, std::abs(a[i]), std::abs(b[i])});
        difference = std::max(difference, std::abs(a[i] - b[i]));
    }
    return difference <= 1e-6 * size;
}

struct Builder {
    JointTable table;
    std::multimap<int, int> joints_at_node;

    int add(int node, const Matrix& inverse_bind) {
        const auto [first, last] = joints_at_node.equal_range(node);
        for (auto it = first; it != last; ++it)
            if (nearlyEqual(table.inverse_bind[std::size_t(it->second)], inverse_bind)) return it->second;
        const int joint = int(table.nodes.size());
        table.nodes.push_back(node);
        table.inverse_bind.push_back(inverse_bind);
        joints_at_node.emplace(node, joint);
        return joint;
    }
};

// Binds a part to a node. The rest positions of a part that hangs on joint j are inverse(inverse bind of j) x (joint
// to node) x POSITION, so that the joint's skinning matrix puts them where the node stands. Where no inverse exists,
// the rest positions are those in the joint's own space.
void bindToNode(Builder& builder, std::size_t part, int node, const Matrix& from_part) {
    int joint = builder.joints_at_node.lower_bound(node)->second;
    std::optional<Matrix> unbind = inverse(builder.table.inverse_bind[std::size_t(joint)]);
    if (!unbind) {
        joint = builder.add(node, kIdentityMatrix);
        unbind = kIdentityMatrix;
    }
    builder.table.joint_of_part[part] = joint;
    builder.table.placement_of_part[part] = multiply(*unbind, from_part);
}

// Goes up from the part's node to the first joint, or to the first animated node, which becomes a joint. At the top
// it takes `scene_node`.
void bindRigidPart(const RigSource& source, const std::vector<bool>& animated, const std::vector<Matrix>& globals,
                   std::size_t part, int scene_node, Builder& builder) {
    Matrix from_part = kIdentityMatrix;
    for (int n = source.parts[part].node; n >= 0; n = source.nodes[std::size_t(n)].parent) {
        if (animated[std::size_t(n)] && !builder.joints_at_node.contains(n))
            builder.add(n, inverse(globals[std::size_t(n)]).value_or(kIdentityMatrix));
        if (builder.joints_at_node.contains(n)) return bindToNode(builder, part, n, from_part);
        from_part = multiply(restTransform(source.nodes[std::size_t(n)]), from_part);
    }
    builder.add(scene_node, kIdentityMatrix);
    bindToNode(builder, part, scene_node, from_part);
}

// Returns the corners of the box around all positions that a skin moves. "Equal transforms" are compared at these
// corners.
std::vector<Vec3d> boxCorners(const RigSource& source, int skin) {
    std::optional<BoundingBox> box;
    for (const SourcePart& part : source.parts)
        if (part.skin == skin && !part.positions.empty())
            box = box ? merged(*box, boundsOf(part.positions)) : boundsOf(part.positions);
    const Vec3d nowhere{1e300, 1e300, 1e300};  // where the skin moves nothing
    const Vec3d low = box ? toDouble(box->low) : nowhere, high = box ? toDouble(box->high) : -nowhere;
    std::vector<Vec3d> corners;
    corners.reserve(8);
    for (int c = 0; c < 8; ++c)
        corners.push_back({c & 1 ? high.x : low.x, c & 2 ? high.y : low.y, c & 4 ? high.z : low.z});
    return corners;
}

bool sameOn(const std::vector<Vec3d>& corners, const Matrix& a, const Matrix& b) {
    const double size = length(transformPoint(a, corners[7]) - transformPoint(a, corners[0]));
    for (const Vec3d p : corners)
        if (!(length(transformPoint(a, p) - transformPoint(b, p)) <= 1e-6 * size)) return false;
    return true;
}

// Finds S, which takes a mesh to our rest space. Exporters often give each mesh a space of its own (by quantisation,
// or the transform of its node) and a skin with the same nodes, so that inverse bind = (inverse bind of the joint
// that we have) x S for all of them. Then the joints are shared. Returns the identity where there is no such S.
Matrix spaceOfSkin(const RigSource& source, const Builder& builder, int s) {
    const SourceSkin& skin = source.skins[std::size_t(s)];
    const std::vector<Vec3d> corners = boxCorners(source, s);
    std::optional<Matrix> space;
    for (std::size_t i = 0; i < skin.nodes.size(); ++i) {
        const auto joint = builder.joints_at_node.lower_bound(skin.nodes[i]);
        if (joint == builder.joints_at_node.end() || joint->first != skin.nodes[i]) continue;
        const Matrix& ours = builder.table.inverse_bind[std::size_t(joint->second)];
        if (!space) {
            const std::optional<Matrix> unbind = inverse(ours);
            if (!unbind) return kIdentityMatrix;
            space = multiply(*unbind, skin.inverse_bind[i]);
        }
        if (!sameOn(corners, skin.inverse_bind[i], multiply(ours, *space))) return kIdentityMatrix;
    }
    if (!space || !inverse(*space) || sameOn(corners, *space, kIdentityMatrix)) return kIdentityMatrix;
    return *space;
}

void addSkinJoints(const RigSource& source, Builder& builder) {
    builder.table.joint_of_skin.resize(source.skins.size());
    for (std::size_t s = 0; s < source.skins.size(); ++s) {
        const auto of_skin = [&](const SourcePart& part) { return part.skin == int(s) && !part.positions.empty(); };
        if (std::none_of(source.parts.begin(), source.parts.end(), of_skin)) continue;
        const SourceSkin& skin = source.skins[s];
        const Matrix space = spaceOfSkin(source, builder, int(s)), to_own = *inverse(space);
        for (std::size_t i = 0; i < skin.nodes.size(); ++i)
            builder.table.joint_of_skin[s].push_back(
                builder.add(skin.nodes[i], multiply(skin.inverse_bind[i], to_own)));
        for (std::size_t p = 0; p < source.parts.size(); ++p)
            if (of_skin(source.parts[p])) builder.table.placement_of_part[p] = space;
    }
}

}  // namespace

JointTable chooseJoints(RigSource& source) {
    Builder builder;
    builder.table.joint_of_part.assign(source.parts.size(), -1);
    builder.table.placement_of_part.assign(source.parts.size(), kIdentityMatrix);
    addSkinJoints(source, builder);

    std::vector<std::size_t> rigid;  // ancestors come first, because a prop's joint may carry another prop
    for (std::size_t p = 0; p < source.parts.size(); ++p)
        if (source.parts[p].skin < 0) rigid.push_back(p);
    std::stable_sort(rigid.begin(), rigid.end(),
                     [&](std::size_t a, std::size_t b) { return source.parts[a].node < source.parts[b].node; });

    const std::vector<bool> animated = animatedNodes(source);
    const std::vector<Matrix> globals = restGlobals(source.nodes);
    const int scene_node = int(source.nodes.size());
    for (const std::size_t p : rigid) bindRigidPart(source, animated, globals, p, scene_node, builder);
    if (builder.joints_at_node.contains(scene_node)) source.nodes.emplace_back().name = "scene";
    if (builder.table.nodes.size() > 65535) throw Unsupported(source.file.string() + ": more than 65535 joints");
    return std::move(builder.table);
}

std::vector<std::string> uniqueNames(std::vector<std::string> names) {
    const std::set<std::string> taken(names.begin(), names.end());
    std::map<std::string, int> uses;
    for (std::string& name : names) {
        int& count = uses[name];
        if (++count == 1) continue;
        while (taken.contains(name + "#" + std::to_string(count))) ++count;
        name += "#" + std::to_string(count);
    }
    return names;
}

}  // namespace penumbra
