#include "bake/trace/blockers.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "formats/cache/numbered_files.h"
#include "formats/common/disjoint_sets.h"
#include "formats/common/errors.h"
#include "formats/common/mesh_places.h"
#include "formats/common/twin_triangles.h"
#include "formats/stage/pose_file.h"
#include "sh/dihedral_angles.h"

namespace penumbra {

namespace {

struct Part {
    std::int64_t open_edges = 0;  // sides of triangles that no other triangle shares
    double volume = 0;            // six times the signed volume
    std::int32_t solid = 0;
};

}  // namespace

void Blockers::add(std::span<const Triangle> more, std::span<const Vec3> rest, std::vector<std::uint32_t> places) {
    const std::vector<Triangle> joined = places.empty() ? std::vector<Triangle>() : trianglesOfPlaces(more, places);
    if (!places.empty()) more = joined;  // surfaces hang together across hard edges
    if (vertices == 0) place_of_vertex = std::move(places);
    // 1. Sum up for every connected part its signed volume, and how many sides of triangles stand alone.
    const std::vector<std::uint32_t> part_of = connectedParts(more, rest.size());
    std::map<std::uint32_t, Part> parts;
    for (const Triangle& t : more) {
        Part& part = parts[part_of[t[0]]];
        const Vec3d o = toDouble(rest[part_of[t[0]]]);
        part.open_edges += 3;
        part.volume += dot(toDouble(rest[t[0]]) - o, cross(toDouble(rest[t[1]]) - o, toDouble(rest[t[2]]) - o));
    }
    for (const InnerEdge& edge : innerEdges(more)) parts[part_of[edge[0]]].open_edges -= 2;
    // 2. A part without open edges is a closed surface; the sign of its volume tells which way its fronts face.
    for (auto& [vertex, part] : parts)
        if (part.open_edges == 0 && part.volume != 0) part.solid = ++solids;
    // 3. Append the triangles, and for the mesh itself also what its vertices need.
    const bool of_mesh = vertices == 0;
    if (of_mesh) fans = makeFans(more, rest.size());
    for (const Triangle& t : more) {
        const Part& part = parts[part_of[t[0]]];
        solid.push_back(part.volume < 0 ? -part.solid : part.solid);
        const auto first = std::uint32_t(vertices);
        triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    for (std::size_t v = 0; of_mesh && v < rest.size(); ++v) {
        const auto found = parts.find(part_of[placeOf(std::uint32_t(v))]);
        solid_of_vertex.push_back(found == parts.end() ? 0 : found->second.solid);
    }
    vertices += rest.size();
}

void Blockers::addSurface(const Mesh& mesh, const Skin* skin) {
    appendOpacity(mesh.opacity, triangles.size(), opacity);
    const std::vector<std::uint32_t> more =
        skin && !mesh.two_sided ? twinTriangles(mesh, *skin) : std::vector<std::uint32_t>{};
    if (more.empty()) return;
    const auto first = std::uint32_t(triangles.size());
    if (first == 0) front_of_vertex = tracedVertices(mesh, more);
    for (auto t = std::uint32_t(twins.size()); t < first; ++t) twins.push_back(t);
    for (const std::uint32_t twin : more) twins.push_back(first + twin);
}

void Blockers::keepToTwins(const Mesh& mesh) {
    of_sheet.assign(solid_of_vertex.size(), 0);
    for (std::uint32_t t = 0; t < twins.size() && t < mesh.triangles.size(); ++t)
        if (twins[t] != t)
            for (const std::uint32_t corner : mesh.triangles[t]) of_sheet[placeOf(frontOf(corner))] = 1;
}

namespace {

// Tells whether a source has a single pose.
bool standsStill(const BakeSource& source) {
    if (source.rig) return source.rig->clips.empty();
    return source.cache->clips.empty() || (source.cache->clips.size() == 1 && source.cache->clips[0].times.size() == 1);
}

}  // namespace

std::vector<std::filesystem::path> filesOfOccluder(const std::filesystem::path& occluder) {
    std::error_code error;
    if (std::filesystem::exists(occluder, error)) return {occluder};  // the name of a file may hold colons
    std::vector<std::filesystem::path> files;
    const std::string text = occluder.string();
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find(':', at), text.size());
        if (end == at) return {occluder};
        files.emplace_back(text.substr(at, end - at));
        at = end + 1;
    }
    return files;
}

std::vector<std::filesystem::path> singleFilesOf(const std::vector<std::filesystem::path>& occluders) {
    std::vector<std::filesystem::path> files;
    for (const std::filesystem::path& occluder : occluders)
        for (const std::filesystem::path& file : filesOfOccluder(occluder))
            if (!namesSequence(file)) files.push_back(file);
    return files;
}

std::vector<Occluder> readOccluders(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options,
                                    const std::vector<std::string>& clips) {
    const bool one_clip = std::set<std::string>(clips.begin(), clips.end()).size() == 1;
    std::vector<Occluder> out;
    for (const std::filesystem::path& path : paths) {
        Occluder occluder{readSource(filesOfOccluder(path), options), path.string(), {}};
        const std::vector<std::string> known = occluder.source.clipNames();
        for (const std::string& name : clips) {
            int clip = clipIndices(occluder.source, {name}).front();
            if (clip < 0 && known.size() == 1 && one_clip) clip = 0;
            if (standsStill(occluder.source)) clip = -1;
            if (clip < 0 && !standsStill(occluder.source))
                throw BadOption("occluder", path.string() + " moves, but has no clip '" + name + "'");
            occluder.clips.push_back(clip);
        }
        out.push_back(std::move(occluder));
    }
    return out;
}

namespace {

// Returns the time of a clip's last frame.
double endOf(const BakeSource& source, std::size_t clip) {
    return source.rig ? source.rig->clips[clip].duration : source.cache->clips[clip].times.back();
}

}  // namespace

void appendPositions(const Occluder& occluder, std::size_t clip, double time, std::vector<Vec3>& positions) {
    const int own = occluder.clips[clip];
    if (own >= 0 && time > endOf(occluder.source, std::size_t(own)) + kSameTime)
        throw InvalidInput(occluder.name + ": ends at " + std::to_string(endOf(occluder.source, std::size_t(own))) +
                           " s, but is wanted at " + std::to_string(time) + " s");
    const std::vector<Vec3> more = sourcePositions(occluder.source, own, time);
    for (std::size_t v = 0; v < more.size(); ++v)
        if (!std::isfinite(dot(more[v], more[v])))
            throw InvalidInput(occluder.name + ": vertex " + std::to_string(v) + " is not finite at " +
                               std::to_string(time) + " s");
    positions.insert(positions.end(), more.begin(), more.end());
}

}  // namespace penumbra
