// Reads the tangents that a file has for its normal maps, as turns of those that texture coordinates give.
//
// A tangent moves with the surface, and so does the direction in which u grows. The turn between the two stays as it is
// while bones move the surface, or an instance mirrors it.
#include <algorithm>
#include <cmath>

#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

struct UvFrame {
    Vec3d x, y;  // unit, across the normal; 0 where the coordinates have no area
};

UvFrame uvFrame(const SourcePart& part, const Triangle& t, Vec3d normal, const std::vector<std::array<double, 2>>& uv) {
    const Vec3d a = toDouble(part.positions[t[0]]), first = toDouble(part.positions[t[1]]) - a,
                second = toDouble(part.positions[t[2]]) - a;
    const double u1 = uv[t[1]][0] - uv[t[0]][0], u2 = uv[t[2]][0] - uv[t[0]][0], v1 = uv[t[1]][1] - uv[t[0]][1],
                 v2 = uv[t[2]][1] - uv[t[0]][1], turn = u1 * v2 - u2 * v1;
    Vec3d x = (first * v2 - second * v1) * turn;
    x = x - normal * dot(normal, x);
    if (!(dot(x, x) > 0)) return {};
    x = normalized(x);
    const double up = dot(normal, cross(first, second)) * turn > 0 ? -1 : 1;
    return {x, cross(normal, x) * up};
}

// A sum over triangles: the tangent in the frame of the coordinates, and how much the sides agree.
struct TurnSum {
    double cosine = 0, sine = 0, side = 0;

    TangentTurn stored() const {
        const double size = std::hypot(cosine, sine);
        if (!(size > 0)) return kSameTangent;
        const auto code = [](double x) { return std::int8_t(std::lround(127 * x)); };
        return {code(cosine / size), code(sine / size), code(side < 0 ? -1 : 1), 0};
    }
};

}  // namespace

std::vector<TangentTurn> readTangentTurns(const GltfFile& file, const tinygltf::Primitive& primitive,
                                          const std::string& where, const SourcePart& part,
                                          const std::vector<std::array<double, 2>>& uv) {
    const auto found = primitive.attributes.find("TANGENT");
    if (found == primitive.attributes.end()) return {};
    const AccessorValues values = readAccessor(file, found->second, where + " TANGENT");
    if (values.components != 4 || values.count() != part.positions.size())
        failAtFile(file.path, where + ": TANGENT does not have 4 numbers for every vertex");
    std::vector<TurnSum> sums(part.positions.size());
    for (const Triangle& t : part.triangles) {
        const Vec3d a = toDouble(part.positions[t[0]]);
        const Vec3d face = cross(toDouble(part.positions[t[1]]) - a, toDouble(part.positions[t[2]]) - a);
        if (!(dot(face, face) > 0)) continue;
        for (const std::uint32_t v : t) {
            const Vec3d normal = part.normals.empty() ? normalized(face) : toDouble(part.normals[v]);
            const UvFrame frame = uvFrame(part, t, normal, uv);
            const double* const row = &values.values[4 * std::size_t(v)];
            const Vec3d tangent{row[0], row[1], row[2]};
            sums[v].cosine += dot(tangent, frame.x);
            sums[v].sine += dot(tangent, frame.y);
            sums[v].side += dot(cross(normal, frame.x), frame.y) * (row[3] < 0 ? -1 : 1);
        }
    }
    std::vector<TangentTurn> turns;
    for (const TurnSum& sum : sums) turns.push_back(sum.stored());
    const bool any = std::ranges::any_of(
        turns, [](const TangentTurn& turn) { return turn[0] < 0 || std::abs(turn[1]) > 1 || turn[2] < 0; });
    return any ? turns : std::vector<TangentTurn>();
}

}  // namespace penumbra
