#include "formats/cache/point_cache.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <memory>
#include <numeric>
#include <tuple>

#include "formats/cache/point_cache_build.h"
#include "formats/common/errors.h"
#include "formats/rig/frame_sampling.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_keys.h"

namespace penumbra {

double metresOfUnit(const std::string& units) {
    for (const auto& [name, metres] : {std::pair("m", 1.0), {"cm", 0.01}, {"mm", 0.001}, {"inch", 0.0254}})
        if (units == name) return metres;
    double metres = 0;
    const auto [end, error] = std::from_chars(units.data(), units.data() + units.size(), metres);
    if (error != std::errc() || end != units.data() + units.size() || !(metres > 0 && metres < 1e12))
        throw std::invalid_argument("must be m, cm, mm, inch or a number of metres above 0, not '" + units + "'");
    return metres;
}

std::vector<double> evenTimes(std::size_t keys, double fps) {
    std::vector<double> times(keys);
    for (std::size_t i = 0; i < keys; ++i) times[i] = double(i) / fps;
    return times;
}

// --- One cache of several paths -------------------------------------------------------------------------------------

namespace {
// Tells where a clip of the cache comes from.
struct ClipPlace {
    std::size_t file = 0, clip = 0;
};

struct Sources {
    std::vector<CacheFile> files;
    std::vector<ClipPlace> clips;
    PointCacheOptions options;
};

Vec3 placed(const PointCacheOptions& options, Vec3d p) {
    if (options.z_up) p = {p.x, p.z, -p.y};
    return toFloat(p * options.metres);
}

std::vector<Vec3> placePositions(const PointCacheOptions& options, const std::vector<Vec3d>& positions,
                                 const std::function<std::string()>& name) {
    std::vector<Vec3> out(positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        out[v] = placed(options, positions[v]);
        if (!std::isfinite(out[v].x) || !std::isfinite(out[v].y) || !std::isfinite(out[v].z))
            throw InvalidInput(name() + ": vertex " + std::to_string(v) + " is not at a finite place");
    }
    return out;
}

std::vector<Vec3> readSource(const Sources& sources, std::size_t clip, std::size_t key) {
    const ClipPlace& place = sources.clips.at(clip);
    const CacheFile& file = sources.files[place.file];
    assert(key < file.clips[place.clip].times.size());
    return placePositions(sources.options, file.read(place.clip, key),
                          [&] { return file.frame_name(place.clip, key); });
}

std::vector<Vec3> sampleSource(const Sources& sources, std::size_t clip, double time) {
    const ClipPlace& place = sources.clips.at(clip);
    const CacheFile& file = sources.files[place.file];
    const std::vector<double>& times = file.clips[place.clip].times;
    const KeySpan span = findKeys(times, time);
    if (span.fraction == 0) return readSource(sources, clip, span.from);
    if (file.sample)
        return placePositions(sources.options, file.sample(place.clip, time),
                              [&] { return file.frame_name(place.clip, span.from) + " and the next"; });
    std::vector<Vec3> positions = readSource(sources, clip, span.from);
    const std::vector<Vec3> to = readSource(sources, clip, span.to);
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Vec3d from = toDouble(positions[v]);
        positions[v] = toFloat(from + span.fraction * (toDouble(to[v]) - from));
    }
    return positions;
}

// Returns the file that brings the faces. All others must have the same faces or none, and as many vertices.
const CacheFile& findMesh(const std::vector<CacheFile>& files) {
    const auto has_faces = [](const CacheFile& file) { return !file.triangles.empty(); };
    const auto mesh = std::find_if(files.begin(), files.end(), has_faces);
    if (mesh == files.end()) throw InvalidInput(files[0].file.string() + ": has no faces, and no mesh comes with it");
    for (const CacheFile& file : files)
        if (has_faces(file) && file.triangles != mesh->triangles)
            throw InvalidInput(file.file.string() + ": its faces are not those of " + mesh->file.string());
    return *mesh;
}

// Checks that all files have as many vertices. Faces alone (an .npy) only tell that there are no fewer vertices than
// they name.
void checkVertexCounts(const std::vector<CacheFile>& files) {
    const auto has_positions = [](const CacheFile& file) { return !file.clips.empty() || !file.rest.empty(); };
    const auto first = std::find_if(files.begin(), files.end(), has_positions);
    if (first == files.end()) throw InvalidInput(files[0].file.string() + ": has faces, and no positions come with it");
    for (const CacheFile& file : files)
        if (has_positions(file) ? file.vertex_count != first->vertex_count : file.vertex_count > first->vertex_count)
            throw InvalidInput(file.file.string() + (has_positions(file) ? ": has " : ": names ") +
                               std::to_string(file.vertex_count) + " vertices, and " + first->file.string() + " has " +
                               std::to_string(first->vertex_count));
}

void joinClips(Sources& sources, PointCache& cache) {
    std::vector<std::string> names;
    for (std::size_t f = 0; f < sources.files.size(); ++f)
        for (std::size_t c = 0; c < sources.files[f].clips.size(); ++c) {
            sources.clips.push_back({f, c});
            cache.clips.push_back(sources.files[f].clips[c]);
            names.push_back(cleanText(cache.clips.back().name));
        }
    if (names.empty()) throw InvalidInput(sources.files[0].file.string() + ": is a mesh, and no frames come with it");
    if (names.size() > 65535) throw Unsupported(sources.files[0].file.string() + ": more than 65535 clips");
    names = uniqueNames(std::move(names));
    for (std::size_t i = 0; i < names.size(); ++i) cache.clips[i].name = names[i];
}

// --- Welding --------------------------------------------------------------------------------------------------------

// Source vertices that have been at one place so far: two or more, ascending.
using Group = std::vector<std::uint32_t>;

// Splits a group by the places that its vertices have now, and keeps those parts that still have two vertices or
// more.
void splitGroup(Group group, const std::vector<Vec3>& positions, std::vector<Group>& out) {
    const auto place = [&](std::uint32_t v) { return std::tuple(positions[v].x, positions[v].y, positions[v].z); };
    std::stable_sort(group.begin(), group.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
    for (auto begin = group.begin(); begin != group.end();) {
        const auto end = std::find_if(begin, group.end(), [&](std::uint32_t v) { return place(v) != place(*begin); });
        if (end - begin > 1) out.emplace_back(begin, end);
        begin = end;
    }
}

// Finds the vertices of the source that never part. Reads frames until no group is left, so that it reads nothing
// where no two vertices share a place at rest.
std::vector<Group> findSeams(const Sources& sources, const PointCache& cache, const std::vector<Vec3>& rest) {
    Group all(rest.size());
    std::iota(all.begin(), all.end(), 0u);
    std::vector<Group> groups;
    splitGroup(std::move(all), rest, groups);
    for (std::size_t clip = 0; clip < cache.clips.size(); ++clip)
        for (std::size_t key = 0; key < cache.clips[clip].times.size() && !groups.empty(); ++key) {
            const std::vector<Vec3> positions = readSource(sources, clip, key);
            std::vector<Group> left;
            for (Group& group : groups) splitGroup(std::move(group), positions, left);
            groups = std::move(left);
        }
    return groups;
}

void weld(const CacheFile& source, const std::vector<Vec3>& rest, const std::vector<Group>& seams, PointCache& cache) {
    std::vector<std::uint32_t> first(rest.size());
    std::iota(first.begin(), first.end(), 0u);
    for (const Group& group : seams)
        for (const std::uint32_t v : group) first[v] = group[0];
    Mesh& mesh = cache.mesh;
    mesh.slots = source.slots;
    for (std::size_t v = 0; v < rest.size(); ++v) {
        if (first[v] != v) {
            mesh.source_vertex.push_back(mesh.source_vertex[first[v]]);
            continue;
        }
        mesh.source_vertex.push_back(std::uint32_t(cache.source_of_point.size()));
        cache.source_of_point.push_back(std::uint32_t(v));
        mesh.rest_positions.push_back(rest[v]);
        if (!mesh.slots.empty()) mesh.slot_of_vertex.push_back(source.slot_of_vertex[v]);
    }
    for (const Triangle& t : source.triangles) {
        const Triangle welded{mesh.source_vertex[t[0]], mesh.source_vertex[t[1]], mesh.source_vertex[t[2]]};
        if (hasArea(mesh.rest_positions, welded)) mesh.triangles.push_back(welded);
    }
}

std::vector<Vec3> restPositions(const Sources& sources) {
    for (const CacheFile& file : sources.files)
        if (!file.rest.empty())
            return placePositions(sources.options, file.rest, [&] { return file.file.string() + ": rest"; });
    return readSource(sources, 0, 0);
}

// Adds the files that were read. Two paths that name one file are one sequence, opened by each of its files: the
// shell has replaced a pattern.
void addFilesRead(const std::filesystem::path& path, const std::vector<std::filesystem::path>& read,
                  PointCache& cache) {
    std::vector<std::filesystem::path>& all = cache.files_read;
    for (const std::filesystem::path& file : read)
        if (read.size() > 1 && std::find(all.begin(), all.end(), file) != all.end())
            throw BadOption("rig", path.string() +
                                       " belongs to a sequence that is read already; name a sequence by its first " +
                                       "file or by a pattern in quotes");
    all.insert(all.end(), read.begin(), read.end());
}

}  // namespace

PointCache joinCache(const std::vector<std::filesystem::path>& paths, std::vector<CacheFile> files,
                     const PointCacheOptions& options) {
    assert(!files.empty());
    const auto sources = std::make_shared<Sources>();
    sources->files = std::move(files);
    sources->options = options;
    PointCache cache;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        addFilesRead(paths[i], sources->files[i].files_read, cache);
        if (!sources->files[i].note.empty()) cache.notes.push_back(sources->files[i].note);
    }
    const CacheFile& mesh = findMesh(sources->files);
    checkVertexCounts(sources->files);
    joinClips(*sources, cache);
    const std::vector<Vec3> rest = restPositions(*sources);
    const double diagonal = boxDiagonal(rest);
    if (!std::isfinite(diagonal) || !(diagonal > 0))
        throw InvalidInput(mesh.file.string() + ": its vertices are all at one place, or not finite");
    weld(mesh, rest, findSeams(*sources, cache, rest), cache);
    if (cache.mesh.triangles.empty()) throw InvalidInput(mesh.file.string() + ": has no triangle with an area");
    cache.read_source = [sources](std::size_t clip, std::size_t key) { return readSource(*sources, clip, key); };
    cache.sample_source = [sources](std::size_t clip, double time) { return sampleSource(*sources, clip, time); };
    return cache;
}

// --- Frames ---------------------------------------------------------------------------------------------------------

namespace {

std::vector<Vec3> weldedPositions(const PointCache& cache, const std::vector<Vec3>& source) {
    std::vector<Vec3> positions;
    positions.reserve(cache.source_of_point.size());
    for (const std::uint32_t v : cache.source_of_point) positions.push_back(source[v]);
    return positions;
}

}  // namespace

std::vector<Vec3> readFrame(const PointCache& cache, std::size_t clip, std::size_t key) {
    return weldedPositions(cache, cache.read_source(clip, key));
}

std::vector<Vec3> samplePositions(const PointCache& cache, std::size_t clip, double time) {
    return weldedPositions(cache, cache.sample_source(clip, time));
}

FrameList sampleFrames(const PointCache& cache, const std::vector<std::string>& clips, double fps) {
    std::vector<ClipTimes> times;
    for (const PointCacheClip& clip : cache.clips)
        times.push_back({clip.name, clip.times.front(), clip.times.back(), clip.times});
    return sampleClips(times, clips, fps, "the cache");
}

}  // namespace penumbra
