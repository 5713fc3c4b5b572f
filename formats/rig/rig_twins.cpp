// Finds meshes that stand for others: levels of detail, collision hulls, proxies.
//
// Problem: files for games often hold the same head three times, with fewer and fewer triangles, and a hull around it
// for collisions. The engine shows one of them. Whoever draws all of them sees a head inside a head, and the inner one
// is black.
//
// Naive: leave out what has such a name. Names are a habit, and a wrong guess would take something away that is seen.
//
// Here: nothing is left out, but the user is told, once by the names that engines know, and once by the shape: two
// meshes whose boxes are nearly the same, one of which lies near the other everywhere, or has few corners.
// docs/inputs.md lists the names.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "formats/rig/rig_build.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

constexpr double kNear = 0.05;        // in box diagonals: largest distance of the surfaces and of the boxes' sides
constexpr double kMax = 0.9;          // share of the vertices
constexpr double kRound = 1e-5;       // in diagonals
constexpr std::size_t kFew = 8;       // times fewer points
constexpr std::size_t kTested = 512;  // vertices of a mesh at most
constexpr std::size_t kMaxShells = 2048;

// All that one node draws.
struct Shell {
    std::string name;
    std::vector<Vec3> points;  // at rest, those that triangles use
    std::size_t triangles = 0;
    BoundingBox box;
};

std::string lowerCase(std::string text) {
    for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

struct Level {
    std::string stem;
    int number = 0;
};

// Splits "head_LOD1" into "head_" and 1.
std::optional<Level> levelOf(const std::string& name) {
    const std::string text = lowerCase(name);
    for (std::size_t at = text.find("lod"); at != std::string::npos; at = text.find("lod", at + 1)) {
        const bool starts = at == 0 || !std::isalpha(static_cast<unsigned char>(text[at - 1])) ||
                            std::islower(static_cast<unsigned char>(name[at - 1])) != 0;
        std::size_t digits = at + 3;
        if (digits < text.size() && (text[digits] == '_' || text[digits] == ' ')) ++digits;
        if (!starts || digits >= text.size() || !std::isdigit(static_cast<unsigned char>(text[digits]))) continue;
        return Level{text.substr(0, at) + text.substr(digits + 1), text[digits] - '0'};
    }
    return std::nullopt;
}

// Tells whether engines take a mesh of this name for collisions.
bool namesCollision(const std::string& name) {
    const std::string text = lowerCase(name);
    for (const char* prefix : {"ucx_", "ubx_", "usp_", "ucp_", "mcdcx_"})
        if (text.rfind(prefix, 0) == 0) return true;
    for (const char* word : {"collision", "collider", "hitbox", "proxy"})
        if (text.find(word) != std::string::npos) return true;
    return false;
}

// The points of a shell in cubes, so that those near a place are found.
class NearPoints {
public:
    NearPoints(const std::vector<Vec3>& points, double distance) : distance_(distance) {
        for (const Vec3 p : points) cells_[keyOf(p)].push_back(p);
    }
    bool hasNear(Vec3 place) const {
        const Key key = keyOf(place);
        for (std::int64_t i = 0; i < 27; ++i) {
            const auto cell = cells_.find({key[0] + i % 3 - 1, key[1] + i / 3 % 3 - 1, key[2] + i / 9 - 1});
            if (cell == cells_.end()) continue;
            for (const Vec3 p : cell->second)
                if (length(toDouble(p) - toDouble(place)) <= distance_) return true;
        }
        return false;
    }

private:
    using Key = std::array<std::int64_t, 3>;
    Key keyOf(Vec3 p) const {
        const auto index = [&](float v) { return std::int64_t(std::floor(double(v) / distance_)); };
        return {index(p.x), index(p.y), index(p.z)};
    }
    double distance_;
    std::map<Key, std::vector<Vec3>> cells_;
};

bool sameBoxes(const BoundingBox& a, const BoundingBox& b, double distance) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(a.low[axis] - b.low[axis]) > distance || std::abs(a.high[axis] - b.high[axis]) > distance)
            return false;
    return true;
}

// Tells whether `coarse` lies near `fine` everywhere, and has nearly its box.
bool liesOn(const Shell& coarse, const Shell& fine) {
    const double distance = kNear * 2 * fine.box.radius();
    if (!(distance > 0) || !sameBoxes(coarse.box, fine.box, distance)) return false;
    const NearPoints near(fine.points, distance);
    const std::size_t step = (coarse.points.size() + kTested - 1) / kTested;
    std::size_t tested = 0, found = 0;
    for (std::size_t i = 0; i < coarse.points.size(); i += step, ++tested) found += near.hasNear(coarse.points[i]);
    return double(found) >= kMax * double(tested);
}

// Tells whether `coarse` has nearly the box of `fine`, reaches as far to all sides, and has few of its points: so does
// a hull, whose corners are near nothing of what is inside.
bool enclosesWithFew(const Shell& coarse, const Shell& fine) {
    const double diagonal = 2 * fine.box.radius();
    if (coarse.points.size() * kFew > fine.points.size() || !sameBoxes(coarse.box, fine.box, kNear * diagonal))
        return false;
    for (int axis = 0; axis < 3; ++axis)
        if (coarse.box.low[axis] > fine.box.low[axis] + kRound * diagonal ||
            coarse.box.high[axis] < fine.box.high[axis] - kRound * diagonal)
            return false;
    return true;
}

// Groups what is left of each part's triangles by node. `posed` are the shading points at rest in the scene.
std::vector<Shell> shellsOf(const RigSource& source, const Rig& rig, const std::vector<Vec3>& posed) {
    std::map<int, Shell> shells;
    std::map<int, std::set<std::uint32_t>> used;
    for (std::size_t p = 0; p < source.parts.size(); ++p) {
        const int node = source.parts[p].node;
        Shell& shell = shells[node];
        shell.name = rig.nodes[std::size_t(node)].name;
        const std::size_t first = rig.part_colors[p].first_vertex;
        for (const Triangle& t : rig.part_colors[p].triangles) {
            for (const std::uint32_t corner : t) used[node].insert(rig.mesh.source_vertex[first + corner]);
            ++shell.triangles;
        }
    }
    std::vector<Shell> out;
    for (auto& [node, shell] : shells) {
        for (const std::uint32_t point : used[node]) shell.points.push_back(posed[point]);
        shell.box = boundsOf(shell.points);
        if (!shell.points.empty()) out.push_back(std::move(shell));
    }
    return out;
}

RigNote noteOf(const RigSource& source, const Shell& shell, const std::string& feature) {
    return {source.file.string(), shell.name, feature,
            "all are drawn, and what is inside is dark, unless '" + shell.name + "' is left out"};
}

// Returns what the name says that the shell stands for; "" where it says nothing.
std::string saidByName(const std::vector<Shell>& shells, const Shell& shell) {
    const auto is_collision = [](const Shell& other) { return namesCollision(other.name); };
    if (is_collision(shell) && !std::all_of(shells.begin(), shells.end(), is_collision))
        return "has the name of a mesh for collisions, or of a proxy";
    const std::optional<Level> own = levelOf(shell.name);
    if (!own) return "";
    for (const Shell& other : shells)
        if (const auto level = levelOf(other.name); level && level->stem == own->stem && level->number < own->number)
            return "has the name of a lower level of detail (LOD) of '" + other.name + "'";
    return "";
}

}  // namespace

void noteTwins(RigSource& source, const Rig& rig, const std::vector<Vec3>& posed) {
    const std::vector<Shell> shells = shellsOf(source, rig, posed);
    if (shells.size() < 2 || shells.size() > kMaxShells) return;
    std::vector<bool> noted(shells.size());
    for (std::size_t i = 0; i < shells.size(); ++i) {
        const std::string said = saidByName(shells, shells[i]);
        if (said.empty()) continue;
        source.notes.push_back(noteOf(source, shells[i], said));
        noted[i] = true;
    }
    for (std::size_t i = 0; i < shells.size(); ++i)
        for (std::size_t j = i + 1; j < shells.size() && !noted[i]; ++j) {
            if (noted[j]) continue;
            const bool first_is_coarse = shells[i].triangles < shells[j].triangles;
            const std::size_t coarse = first_is_coarse ? i : j, fine = first_is_coarse ? j : i;
            const bool lies = liesOn(shells[coarse], shells[fine]);
            if (!lies && !enclosesWithFew(shells[coarse], shells[fine])) continue;
            source.notes.push_back(noteOf(source, shells[coarse],
                                          lies ? "lies on '" + shells[fine].name + "' like a copy or a hull of it"
                                               : "stands around '" + shells[fine].name + "' like a hull"));
            noted[coarse] = true;
        }
}

}  // namespace penumbra
