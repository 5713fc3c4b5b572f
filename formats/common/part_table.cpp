#include "formats/common/part_table.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "sh/bounding_box.h"

namespace penumbra {

namespace {

constexpr std::uint16_t kNoPart = 0xffff;
constexpr std::uint8_t kNoWay = 255;

std::vector<std::uint16_t> ownersOfVertices(const Skin& skin, std::size_t vertices) {
    std::vector<std::uint16_t> owner(vertices);
    for (std::size_t v = 0; v < vertices; ++v) owner[v] = skin.joints[v * std::size_t(skin.influences)];
    return owner;
}

std::uint16_t ownerOfTriangle(const Triangle& triangle, std::span<const std::uint16_t> owner) {
    const std::uint16_t a = owner[triangle[0]], b = owner[triangle[1]], c = owner[triangle[2]];
    return b == c ? b : a;
}

// Returns the joints, every parent before its children.
std::vector<std::size_t> parentsFirst(const std::vector<std::int32_t>& parents) {
    std::vector<std::size_t> depth(parents.size()), order(parents.size());
    for (std::size_t j = 0; j < parents.size(); ++j)
        for (std::int32_t p = parents[j]; p >= 0; p = parents[std::size_t(p)]) ++depth[j];
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return depth[a] < depth[b]; });
    return order;
}

// Bounds of the vertices owned by a joint and by the joints merged into it.
struct Owned {
    std::optional<BoundingBox> box;

    double radius() const { return box ? box->radius() : -1; }
    void add(const BoundingBox& other) { box = box ? merged(*box, other) : other; }
};

// Merges small parts into their ancestors, children before parents, and then the smallest ones while there are too
// many. Returns which joint each joint's part has, kNoPart where no ancestor has one.
std::vector<std::uint16_t> mergeSmall(const Skin& skin, std::vector<Owned>& owned, double least_radius) {
    const std::vector<std::size_t> order = parentsFirst(skin.parents);
    const auto ancestor = [&](std::size_t j) {
        std::int32_t p = skin.parents[j];
        while (p >= 0 && !owned[std::size_t(p)].box) p = skin.parents[std::size_t(p)];
        return p;
    };
    const auto merge = [&](std::size_t j, std::int32_t into) {
        owned[std::size_t(into)].add(*owned[j].box);
        owned[j].box.reset();
    };
    for (auto j = order.rbegin(); j != order.rend(); ++j)
        if (const std::int32_t into = ancestor(*j); into >= 0 && owned[*j].box && owned[*j].radius() < least_radius)
            merge(*j, into);
    for (;;) {
        std::size_t parts = 0, smallest = owned.size();
        for (std::size_t j : order) {
            if (!owned[j].box) continue;
            ++parts;
            const bool smaller = smallest == owned.size() || owned[j].radius() < owned[smallest].radius();
            if (ancestor(j) >= 0 && smaller) smallest = j;
        }
        if (parts <= kMaxParts || smallest == owned.size()) break;
        merge(smallest, ancestor(smallest));
    }
    std::vector<std::uint16_t> joint_of_joint(skin.parents.size(), kNoPart);
    for (std::size_t j : order) {
        if (owned[j].box)
            joint_of_joint[j] = std::uint16_t(j);
        else if (skin.parents[j] >= 0)
            joint_of_joint[j] = joint_of_joint[std::size_t(skin.parents[j])];
    }
    return joint_of_joint;
}

// The distance between joints counts the edges below which a joint with a part hangs.
std::vector<std::uint8_t> stepsOf(const Skin& skin, const std::vector<std::uint16_t>& joint_of_part,
                                  const std::vector<bool>& has_part) {
    const auto way = [&](std::size_t j) {  // from the joint up to its root
        std::vector<std::size_t> up{j};
        while (skin.parents[up.back()] >= 0) up.push_back(std::size_t(skin.parents[up.back()]));
        return up;
    };
    const auto cost = [&](const std::vector<std::size_t>& up, std::size_t count) {
        return std::size_t(
            std::count_if(up.begin(), up.begin() + std::ptrdiff_t(count), [&](std::size_t j) { return has_part[j]; }));
    };
    const std::size_t parts = joint_of_part.size();
    std::vector<std::uint8_t> steps(parts * parts, kNoWay);
    for (std::size_t a = 0; a < parts; ++a)
        for (std::size_t b = 0; b < parts; ++b) {
            std::vector<std::size_t> from = way(joint_of_part[a]), to = way(joint_of_part[b]);
            if (from.back() != to.back()) continue;
            std::size_t shared = 0;
            while (shared < std::min(from.size(), to.size()) &&
                   from[from.size() - 1 - shared] == to[to.size() - 1 - shared])
                ++shared;
            const std::size_t sum = cost(from, from.size() - shared) + cost(to, to.size() - shared);
            steps[a * parts + b] = std::uint8_t(std::min<std::size_t>(sum, kNoWay - 1));
        }
    return steps;
}

// Tells which parts morph targets move by more than kMaxMorph of their diagonal. `boxes` are of the parts.
std::vector<bool> morphingParts(const Mesh& mesh, const std::vector<std::uint16_t>& part_of_vertex, std::size_t parts) {
    std::vector<Owned> owned(parts);
    for (std::size_t v = 0; v < part_of_vertex.size(); ++v)
        owned[part_of_vertex[v]].add({mesh.rest_positions[v], mesh.rest_positions[v]});
    std::vector<bool> morphing(parts);
    for (std::size_t r = 0; r < mesh.morphs.vertices.size(); ++r) {
        const std::size_t part = part_of_vertex[mesh.morphs.vertices[r]];
        const double diagonal = 2 * owned[part].radius();
        if (length(toDouble(mesh.morphs.positions[r])) > kMaxMorph * diagonal) morphing[part] = true;
    }
    return morphing;
}

// Skin binds parts that share an edge of the mesh, whatever way the skeleton takes: legs that hang from a bone of their
// own beside the spine still bend the belly. As rigid far parts they would sink into each other and go dark.
void makeTouchingLocal(const Mesh& mesh, PartTable& table) {
    const std::size_t parts = table.partCount();
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t u : triangle)
            for (const std::uint32_t v : triangle) {
                const std::size_t a = table.part_of_vertex[u], b = table.part_of_vertex[v];
                if (a != b) table.steps[a * parts + b] = 1;
            }
}

// A field holds one shape. A part that morphs is next to all others, so that models learn what it blocks from its
// weights.
void makeMorphingLocal(const Mesh& mesh, PartTable& table) {
    if (mesh.morphs.empty()) return;
    const std::size_t parts = table.partCount();
    const std::vector<bool> morphing = morphingParts(mesh, table.part_of_vertex, parts);
    for (std::size_t a = 0; a < parts; ++a)
        for (std::size_t b = 0; b < parts; ++b)
            if (a != b && (morphing[a] || morphing[b])) table.steps[a * parts + b] = 1;
}

}  // namespace

PartTable makePartTable(const Mesh& mesh, const Skin& skin) {
    const std::vector<std::uint16_t> owner = ownersOfVertices(skin, mesh.vertexCount());
    std::vector<Owned> owned(skin.jointCount());
    for (const Triangle& triangle : mesh.triangles)
        for (std::uint32_t corner : triangle) {
            const Vec3 p = mesh.rest_positions[corner];
            owned[ownerOfTriangle(triangle, owner)].add({p, p});
        }
    // A vertex without triangles still needs a part to belong to.
    for (std::size_t v = 0; v < owner.size() && mesh.triangles.empty(); ++v)
        owned[owner[v]].add({mesh.rest_positions[v], mesh.rest_positions[v]});
    std::vector<std::uint16_t> joint_of_joint = mergeSmall(skin, owned, kMinPartRadius * characterDiagonal(mesh));

    PartTable table;
    std::vector<bool> has_part(skin.jointCount());
    std::vector<std::uint16_t> part_at(skin.jointCount());
    for (std::size_t j = 0; j < owned.size(); ++j) {
        has_part[j] = owned[j].box.has_value();
        if (!has_part[j]) continue;
        part_at[j] = std::uint16_t(table.joint_of_part.size());
        table.joint_of_part.push_back(std::uint16_t(j));
    }
    // A joint above all parts takes the first one: it moves none of them alone.
    for (std::size_t j = 0; j < owned.size(); ++j)
        table.part_of_joint.push_back(joint_of_joint[j] == kNoPart ? 0 : part_at[joint_of_joint[j]]);
    for (std::uint16_t joint : owner) table.part_of_vertex.push_back(table.part_of_joint[joint]);
    for (const Triangle& triangle : mesh.triangles)
        table.part_of_triangle.push_back(table.part_of_joint[ownerOfTriangle(triangle, owner)]);
    table.steps = stepsOf(skin, table.joint_of_part, has_part);
    makeTouchingLocal(mesh, table);
    makeMorphingLocal(mesh, table);
    return table;
}

}  // namespace penumbra
