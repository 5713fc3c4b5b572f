#include "bake/reference/reference_blockers.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bake/source/frame_choice.h"
#include "formats/cache/numbered_files.h"
#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/mesh_places.h"
#include "formats/common/sha256.h"
#include "formats/common/twin_triangles.h"

namespace penumbra {

namespace {

// The options that the bake was told. Files that other programs made do not hold any.
struct BakeWords {
    std::vector<std::string> occluders;
    PointCacheOptions cache;
    bool blocks = false;
};

BakeWords wordsOf(const Provenance& provenance) try {
    const nlohmann::json options = nlohmann::json::parse(provenance.options_json);
    BakeWords words;
    words.occluders = options.value("occluders", words.occluders);
    words.cache.metres = options.value("metres", words.cache.metres);
    words.cache.fps = options.value("cache_fps", words.cache.fps);
    words.cache.z_up = options.value("up", std::string("y")) == "z";
    words.blocks = options.value("blocks", 1) > 1;
    return words;
} catch (const nlohmann::json::exception&) {
    return {};
}

// Returns all files of an occluder, with those of a sequence, which a pattern or a folder names.
std::vector<std::filesystem::path> everyFileOf(const std::filesystem::path& occluder) {
    std::vector<std::filesystem::path> all;
    for (const std::filesystem::path& path : filesOfOccluder(occluder)) {
        const NumberedFiles numbered =
            namesSequence(path) ? findNumberedFiles(path, {".obj", ".ply"}) : NumberedFiles{"", {path}};
        all.insert(all.end(), numbered.files.begin(), numbered.files.end());
    }
    return all;
}

// Checks that the bake had these occluders: as many, and each file with a hash that the provenance knows.
void checkGiven(const VisibilityHeader& header, const std::string& name, const BakeWords& words,
                const std::vector<std::filesystem::path>& occluders) {
    if (occluders.size() != words.occluders.size())
        throw BadOption("occluder", name + " was baked " +
                                        (words.occluders.empty() ? "without an occluder"
                                                                 : "with " + joined(words.occluders) + "; give each"));
    const auto& inputs = header.provenance.inputs;
    for (const std::filesystem::path& occluder : occluders)
        for (const std::filesystem::path& file : everyFileOf(occluder)) {
            const std::string sum = sha256OfFile(file);
            if (std::none_of(inputs.begin(), inputs.end(), [&](const ProvenanceInput& i) { return i.sha256 == sum; }))
                throw BadOption("occluder", occluder.string() + " is not what " + name + " was baked with (" +
                                                joined(words.occluders) + ")");
        }
}

// The places of the fronts of a rig; a cache has none.
std::vector<std::uint32_t> placesOf(const VisibilityHeader& header) {
    if (!header.skin) return {};
    const std::size_t fronts = header.mesh.frontVertexCount(), rows = fronts * std::size_t(header.skin->influences);
    Skin skin;
    skin.influences = header.skin->influences;
    skin.joints.assign(header.skin->joints.begin(), header.skin->joints.begin() + std::ptrdiff_t(rows));
    skin.weights.assign(header.skin->weights.begin(), header.skin->weights.begin() + std::ptrdiff_t(rows));
    Mesh mesh;
    mesh.triangles.assign(header.mesh.frontTriangles().begin(), header.mesh.frontTriangles().end());
    mesh.rest_positions.assign(header.mesh.rest_positions.begin(),
                               header.mesh.rest_positions.begin() + std::ptrdiff_t(fronts));
    std::vector<std::uint32_t> front(fronts);
    std::iota(front.begin(), front.end(), 0u);
    mesh.morphs = selectVertices(header.mesh.morphs, front);
    return firstOfSides(mesh, skin);
}

}  // namespace

ReferenceBlockers blockersOfFrame(const VisibilityHeader& header, std::size_t frame, const std::string& name,
                                  const std::vector<std::filesystem::path>& occluders) {
    const BakeWords words = wordsOf(header.provenance);
    checkGiven(header, name, words, occluders);
    ReferenceBlockers out;
    out.blockers.addSurface(header.mesh, header.skin ? &*header.skin : nullptr);
    if (header.skin && !header.mesh.two_sided && occluders.empty() && out.blockers.twins.empty()) return out;
    if (!out.blockers.twins.empty()) out.other_side = twinVertices(header.mesh, out.blockers.twins);
    for (std::uint32_t t = 0; t < out.blockers.twins.size(); ++t) out.front_alone.push_back(out.blockers.twins[t] == t);
    const std::span<const Vec3> rest(header.mesh.rest_positions);
    out.blockers.add(header.mesh.frontTriangles(), rest.first(header.mesh.frontVertexCount()), placesOf(header));
    if (header.skin && !header.mesh.two_sided && occluders.empty()) out.blockers.keepToTwins(header.mesh);
    std::vector<std::string> clips = header.frames.clip_names;
    if (words.blocks)
        for (std::string& clip : clips) clip = clipOfBlock(clip);
    for (const Occluder& occluder : readOccluders(occluders, words.cache, clips)) {
        out.blockers.addSurface(occluder.source.mesh(), occluder.source.rig ? &occluder.source.rig->skin : nullptr);
        out.blockers.add(occluder.source.mesh().triangles, sourcePositions(occluder.source, -1, 0),
                         occluder.source.places());
        appendPositions(occluder, header.frames.clip[frame], header.frames.time[frame], out.occluder_positions);
    }
    return out;
}

}  // namespace penumbra
