// Plans a bake: finds everything that is known before the first ray, such as which frames of what it will trace.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bake/source/choose_points.h"
#include "bake/source/frame_choice.h"
#include "bake/source/surface_colors.h"
#include "bake/trace/far_bias.h"
#include "bake/visibility/bake_visibility.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

// Notes a choice of colours, if there is one.
void addColor(const char* name, const ColorChoice& choice, nlohmann::ordered_json& json) {
    if (choice.color) json[name] = {choice.color->x, choice.color->y, choice.color->z};
    if (choice.table) json[name] = choice.table->filename().string();
}

// Lists every option that changes the result. Those that few bakes need are listed only where they are used.
std::string optionsJson(const BakeOptions& options, const std::string& albedo_from) {
    nlohmann::ordered_json json;
    json["clips"] = options.clips;
    json["fps"] = options.fps;
    if (options.frames) json["frames"] = {options.frames->begin, options.frames->end, options.frames->step};
    if (options.points > 0) json["points"] = options.points;
    json["order"] = options.order;
    json["rays"] = options.rays;
    json["seed"] = options.seed;
    json["bias"] = options.bias;
    json["ground"] = options.ground;
    if (options.ground_y) json["ground_y"] = *options.ground_y;
    if (options.distance > 0) json["distance"] = options.distance;
    json["precision"] = options.precision == Precision::kFloat16 ? "f16" : "f32";
    if (options.blocks > 1) json["blocks"] = options.blocks;
    listRigOptions(options.rig, json);
    if (options.cache.metres != 1) json["metres"] = options.cache.metres;
    if (options.cache.z_up) json["up"] = "z";
    if (options.cache.fps > 0) json["cache_fps"] = options.cache.fps;
    if (options.two_sided) json["two_sided"] = true;
    for (const std::filesystem::path& occluder : options.occluders) {
        std::string name;
        for (const std::filesystem::path& file : filesOfOccluder(occluder))
            name += (name.empty() ? "" : ":") + file.filename().string();
        json["occluders"].push_back(name);
    }
    if (options.inputs) json["inputs"] = options.inputs->filename().string();
    if (options.local) json["local"] = {{"steps", options.local->steps}, {"order", options.local->order}};
    if (options.transfer) {
        json["quantity"] = kDiffuseTransfer;
        json["bounces"] = options.transfer->bounces;
        addColor("albedo", options.transfer->albedo, json);
        if (!albedo_from.empty() && !options.transfer->albedo.any()) json["albedo_from"] = albedo_from;
        addColor("transmission", options.transfer->transmission, json);
    }
    return json.dump();
}

// Lists all frames of the chosen clips. BakeOptions::frames slices this list later.
FrameList listFrames(BakeSource& source, const BakeOptions& options) {
    if (!options.poses) return sampleFrames(source, options.clips, options.fps);
    if (!source.rig) throw BadOption("poses", "lists frames of a rig, not of a point cache");
    FrameList frames = readPoseFrames(*options.poses, *source.rig);
    source.filesRead().push_back(*options.poses);
    if (!options.clips.empty()) appendFrames(sampleFrames(source, options.clips, options.fps), frames);
    return frames;
}

// Chooses the frames of the bake, and tells where they belong if they are only a part.
void chooseFrames(BakePlan& plan, const BakeOptions& options) {
    VisibilityHeader& header = plan.header;
    const FrameList listed = listFrames(plan.source, options);
    const FrameList all = cutIntoBlocks(listed, options.blocks);
    std::vector<std::size_t> chosen(all.frameCount());
    std::iota(chosen.begin(), chosen.end(), std::size_t(0));
    header.frames = all;
    if (options.frames) {
        header.frames = sliceFrames(all, *options.frames);
        chosen = slice(chosen, *options.frames);
    }
    // Each clip of the bake is a clip of the source, or a block of one.
    for (const std::string& name : header.frames.clip_names)
        plan.source_clip.push_back(clipIndices(plan.source, {options.blocks > 1 ? clipOfBlock(name) : name}).front());
    if (plan.source.cache) plan.turns = continuousTurns(plan.source, header.edges, listed, chosen);
    // A bake of some frames stores where they belong, so that a merge can put them there.
    if (options.clips.empty() && !options.frames) return;
    const FrameList known =
        options.poses ? all : cutIntoBlocks(sampleFrames(plan.source, {}, options.fps), options.blocks);
    header.shard = ShardPlace{known.clip_names, framesOfClips(known), numberInClip(all)};
    if (options.frames) header.shard->frame_in_clip = slice(numberInClip(all), *options.frames);
}

// Makes the weights of morph targets inputs, behind those of the table --inputs.
void addMorphWeights(VisibilityHeader& header, const std::string& table) {
    const std::vector<std::string>& names = header.mesh.morphs.names;
    for (const std::string& name : names)
        if (std::find(header.input_names.begin(), header.input_names.end(), name) != header.input_names.end())
            throw InvalidInput(table + ": column '" + name + "' has the name of a morph target; rename it");
    header.input_names.insert(header.input_names.end(), names.begin(), names.end());
    header.pose_size += int(names.size());
}

// Reads everything else that the rays of a frame can hit, and the numbers that only other files know.
void addSurroundings(BakePlan& plan, const BakeOptions& options) {
    VisibilityHeader& header = plan.header;
    std::vector<std::string> clips = header.frames.clip_names;
    if (options.blocks > 1)
        for (std::string& clip : clips) clip = clipOfBlock(clip);
    plan.occluders = readOccluders(options.occluders, options.cache, clips);
    plan.blockers.addSurface(plan.source.mesh(), plan.source.rig ? &plan.source.rig->skin : nullptr);
    const bool all_sheets = plan.source.cache || options.two_sided || !plan.occluders.empty();
    plan.sheet_rules = all_sheets || !plan.blockers.twins.empty();
    if (plan.sheet_rules)
        plan.blockers.add(plan.source.mesh().triangles, sourcePositions(plan.source, -1, 0), plan.source.places());
    else
        plan.blockers.triangles = plan.source.mesh().triangles;  // nothing else will be asked of them
    if (plan.sheet_rules && !all_sheets) plan.blockers.keepToTwins(plan.source.mesh());
    if (!all_sheets) plan.places = plan.source.places();
    for (const Occluder& occluder : plan.occluders) {
        plan.blockers.addSurface(occluder.source.mesh(), occluder.source.rig ? &occluder.source.rig->skin : nullptr);
        plan.blockers.add(occluder.source.mesh().triangles, sourcePositions(occluder.source, -1, 0),
                          occluder.source.places());
    }
    if (options.inputs) {
        plan.inputs = placeInputs(readInputTable(*options.inputs), options.inputs->string(), plan.source);
        header.input_names = plan.inputs.names;
        header.pose_size += int(plan.inputs.names.size());
        for (std::size_t f = 0; f < header.frames.frameCount(); ++f)
            // This call throws here, before hours of tracing, when a frame has no row in the table.
            (void)inputsAt(plan.inputs, plan.source_clip[header.frames.clip[f]], header.frames.time[f]);
    }
    addMorphWeights(header, options.inputs ? options.inputs->string() : "");
    if (!options.two_sided) return;
    header.mesh = withBacks(header.mesh);
    appendBackNormals(header.rest_normals);
    if (header.skin) header.skin = withBacks(*header.skin);
}

std::vector<std::filesystem::path> filesRead(const BakePlan& plan, const BakeOptions& options) {
    std::vector<std::filesystem::path> files = plan.source.filesRead();
    for (const Occluder& occluder : plan.occluders)
        files.insert(files.end(), occluder.source.filesRead().begin(), occluder.source.filesRead().end());
    if (options.inputs) files.push_back(*options.inputs);
    files.insert(files.end(), plan.pictures.begin(), plan.pictures.end());
    if (options.transfer)
        for (const ColorChoice& choice : {options.transfer->albedo, options.transfer->transmission})
            if (choice.table) files.push_back(*choice.table);
    return files;
}

// Fills in what describes a pose. This must come before chooseFrames(), since the angles of the frames need the
// edges.
void describePose(const BakeSource& source, VisibilityHeader& header) {
    if (source.rig) {
        header.skin = source.rig->skin;
        header.rest_normals = source.rig->rest_normals;
        header.pose_size = int(3 * source.rig->skin.jointCount());
        return;
    }
    header.rest_normals = meshNormals(header.mesh, header.mesh.rest_positions);
    header.edges = innerEdges(header.mesh.triangles);
    header.pose_parameterisation = kDihedralAngles;
    header.pose_size = int(header.edges.size());
}

void describeTransfer(BakePlan& plan, const TransferOptions& options) {
    VisibilityHeader& header = plan.header;
    header.quantity = kDiffuseTransfer;
    header.bounces = options.bounces;
    if (options.bounces == 0) return;
    ChosenColors chosen = surfaceColors(plan.source, header.mesh, options);
    header.colors = std::move(chosen.colors);
    plan.albedo_from = std::move(chosen.albedo_from);
    plan.pictures = std::move(chosen.pictures);
}

// A surface that has the colours of its materials lacks what else these say.
void noteLooks(BakePlan& plan, const BakeOptions& options) {
    if (plan.albedo_from != kFromBaseColors && plan.albedo_from != kFromTextures) return;
    const std::vector<RigNote> notes = lookNotes(*plan.source.rig);
    if (options.rig.strict) refuseNotes(notes);
    plan.source.rig->notes.insert(plan.source.rig->notes.end(), notes.begin(), notes.end());
}

// Reduces the mesh of the bake to the points that are chosen. All of it still blocks rays, and is what is drawn.
void choosePointsOf(BakePlan& plan, const BakeOptions& options) {
    VisibilityHeader& header = plan.header;
    if (!header.skin) throw BadOption("points", "is for rigs; a point cache is baked at all of its vertices");
    if (options.two_sided) throw BadOption("points", "does not go with two sides");
    if (options.transfer)
        throw BadOption("points", "does not go with transfer, whose light bounces between all vertices");
    if (header.mesh.vertexCount() <= std::size_t(options.points)) return;
    header.drawn = DrawnMesh{std::move(header.mesh), std::move(*header.skin), std::move(header.rest_normals), {}, {}};
    Mesh joined;
    joined.rest_positions = header.drawn->mesh.rest_positions;
    joined.triangles = trianglesAcrossSlots(*header.drawn);
    ChosenPoints chosen = choosePoints(joined, std::size_t(options.points));
    plan.chosen = chosen.vertices;
    takePoints(std::move(chosen), header);
}

// Refuses options that have no effect: they say what a cache does not say itself, but rigs do.
void checkCacheOptions(const BakePlan& plan, const PointCacheOptions& options) {
    const auto is_cache = [](const Occluder& occluder) { return occluder.source.cache.has_value(); };
    const bool any = plan.source.cache || std::any_of(plan.occluders.begin(), plan.occluders.end(), is_cache);
    if (!any && (options.metres != 1 || options.z_up || options.fps > 0))
        throw BadOption(options.metres != 1 ? "units"
                        : options.z_up      ? "up"
                                            : "cache_fps",
                        "is for point caches, and none is read");
}

}  // namespace

BakePlan planBake(const std::vector<std::filesystem::path>& paths, const BakeOptions& options) {
    if (options.distance > 0 && options.local)
        throw BadOption("distance",
                        "does not go with local moments: composed models and their fields hide at any "
                        "distance");
    if (options.distance > 0 && options.transfer)
        throw BadOption("distance", "goes with visibility, not with transfer");
    BakePlan plan;
    RigOptions rig = options.rig;
    if (options.two_sided) rig.sides = RigSides::kFronts;  // each vertex gets its back below
    plan.source = readSource(paths, options.cache, rig);
    VisibilityHeader& header = plan.header;
    header.mesh = plan.source.mesh();
    describePose(plan.source, header);
    chooseFrames(plan, options);

    const std::vector<Vec3> positions = sourcePositions(plan.source, -1, 0);
    const BoundingBox box = characterBox(header.mesh.triangles, positions);
    plan.rest_diagonal = length(toDouble(box.high) - toDouble(box.low));
    if (!(plan.rest_diagonal > 0 && std::isfinite(plan.rest_diagonal)))
        throw InvalidInput(paths.front().string() + ": the rest pose has no extent");

    addSurroundings(plan, options);
    checkCacheOptions(plan, options.cache);
    if (options.transfer) describeTransfer(plan, *options.transfer);
    noteLooks(plan, options);
    plan.files_read = filesRead(plan, options);
    plan.bias = float(options.bias);
    plan.far_bias = farBiases(plan.source.mesh().triangles, positions, box, plan.bias);
    header.order = options.order;
    header.rays = options.rays;
    header.seed = options.seed;
    if (options.distance > 0) header.distance = float(options.distance);
    if (options.ground_y) header.ground_y = float(*options.ground_y);
    if (options.ground && !options.ground_y) header.ground_y = box.low.y;
    header.local = options.local;
    if (header.local)
        plan.local = makeLocalParts(header.mesh, header.skin, header.local->steps, plan.blockers.triangles.size());
    if (options.points > 0) choosePointsOf(plan, options);
    header.provenance =
        makeProvenance("penumbra-bake visibility", optionsJson(options, plan.albedo_from), plan.files_read);
    header.provenance.notes = plan.notes();
    return plan;
}

std::vector<std::string> BakePlan::notes() const {
    std::vector<std::string> lines = source.notes();
    for (const Occluder& occluder : occluders)
        for (std::string& line : occluder.source.notes()) lines.push_back(std::move(line));
    return lines;
}

double BakePlan::rays() const {
    return double(header.frames.frameCount()) * double(header.mesh.vertexCount()) * header.rays;
}

double BakePlan::bytes(Precision precision) const {
    const double vertices = double(header.mesh.vertexCount()), frames = double(header.frames.frameCount());
    const double coefficient = precision == Precision::kFloat16 ? 2 : 4;
    const double moments = double(header.coefficientsOfVertex());
    const double joints = header.skin ? double(header.skin->jointCount()) : 0;
    const double influences = header.skin ? double(header.skin->influences) : 0;
    const double frame = vertices * (24 + coefficient * moments) + 48.0 * joints + 4.0 * header.pose_size + 10;
    const double mesh = 12.0 * double(header.mesh.triangles.size()) + 4.0 * double(header.mesh.source_vertex.size()) +
                        16.0 * double(header.edges.size()) + vertices * (24 + 6.0 * influences);
    const double drawn = header.drawn ? double(header.drawn->mesh.vertexCount()) * (52 + 6.0 * influences) +
                                            12.0 * double(header.drawn->mesh.triangles.size())
                                      : 0;
    return mesh + drawn + frames * frame;
}

}  // namespace penumbra
