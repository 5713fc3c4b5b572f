// Bakes what each rigid part of a character blocks.
//
// Problem: at run time a vertex needs the visibility of every part that is far from it, in any pose. A part moves
// rigidly, so its visibility is a fixed function of the place in the part's rest frame. Tabulate that function.
//
// Naive: one grid of V - 1 around the part. Far away it wastes points, near by it has too few, and V - 1 itself falls
// with the square of the distance, which linear interpolation follows badly.
//
// Here: two nested boxes and four spheres (sh/far/part_field.h), which hold (V - 1)(d^2 + r^2/4). A point inside the
// part would be blocked all around and would bleed into its neighbours outside; it holds what the nearest surface point
// sees instead, and a signed distance tells lookups how deep they are.
#include "bake/fields/part_fields.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake/fields/occluder_motion.h"
#include "bake/fields/part_tracer.h"
#include "bake/fields/signed_distance.h"
#include "bake/fields/standing_parts.h"
#include "bake/source/bake_source.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/part_table.h"
#include "formats/common/twin_triangles.h"
#include "formats/common/write_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr int kFullByte = 127;
constexpr std::size_t kPointsPerTask = 64;
constexpr double kMegabyte = 1e6;

}  // namespace

// --- The plan -------------------------------------------------------------------------------------------------------

namespace {

std::string optionsJson(const FieldOptions& options) {
    nlohmann::ordered_json json;
    json["rays"] = options.rays;
    json["seed"] = options.seed;
    json["cells"] = options.cells;
    json["megabytes"] = options.megabytes;
    json["fade"] = options.fade;
    if (options.parts) json["parts"] = {options.parts->begin, options.parts->end};
    if (options.inputs) json["inputs"] = options.inputs->filename().string();
    listRigOptions(options.rig, json);
    if (options.cache.metres != 1) json["metres"] = options.cache.metres;
    if (options.cache.z_up) json["up"] = "z";
    return json.dump();
}

// The parts of a mesh without joints: there is one.
PartTable wholeAsOnePart(const Mesh& mesh) {
    PartTable table;
    table.joint_of_part = {0};
    table.part_of_triangle.assign(mesh.triangles.size(), 0);
    table.steps = {0};
    return table;
}

// A part needs an extent, and boxes whose corners differ as floats do. The box of a flat part is as thick as its
// borders, 0.24 radii (part_surface.cpp).
void checkPart(const std::filesystem::path& file, const FieldFile& fields, std::size_t part) {
    const PartField& field = fields.fields.parts[part];
    constexpr float kThinnest = 0.12f;  // in radii
    bool usable = std::isfinite(field.radius) && field.radius > 0;
    for (const FieldBox& box : field.boxes)
        for (int axis = 0; axis < 3; ++axis)
            usable = usable && box.high[axis] - box.low[axis] > kThinnest * field.radius;
    if (!usable)
        throw InvalidInput(file.string() + ": part '" + fields.partName(part) +
                           "' is too small, or too far from the origin for its size; --without leaves a mesh out");
}

// The triangles of a source as they face outwards in the space of the rest positions, where the parts are, with the
// shape that the rest weights of morph targets give (part_table.h tells which parts may have it).
Mesh meshAtRest(const BakeSource& source) {
    const Mesh& mesh = source.mesh();
    Mesh out;
    out.triangles = mesh.triangles;
    out.rest_positions =
        restShape(mesh.morphs, {mesh.rest_positions, std::vector<Vec3>(mesh.vertexCount())}, mesh.morphs.rest_weights)
            .positions;
    out.opacity = mesh.opacity;
    if (!source.rig) return out;
    const std::vector<bool> mirrored = mirroredAtRest(*source.rig);
    std::vector<bool> turned;
    for (Triangle& t : out.triangles) {
        turned.push_back(mirrored[t[0]]);
        if (turned.back()) std::swap(t[1], t[2]);
    }
    out.opacity = turnedOpacity(mesh.opacity, turned);
    return out;
}

void addParts(const BakeSource& source, const PartTable& table, const FieldOptions& options, FieldPlan& plan) {
    const FrameRange range = options.parts.value_or(FrameRange{0, table.partCount(), 1});
    if (range.end > table.partCount())
        throw BadOption("parts", "ends at " + std::to_string(range.end) + ", but there are " +
                                     std::to_string(table.partCount()) + " parts");
    const Mesh mesh = meshAtRest(source);
    std::vector<PartMesh> meshes;
    const std::vector<std::uint32_t> twins =
        source.rig ? twinTriangles(source.mesh(), source.rig->skin) : std::vector<std::uint32_t>{};
    for (std::size_t part = 0; part < table.partCount(); ++part)
        meshes.push_back(partMesh(mesh, twins, table.part_of_triangle, part));
    if (source.rig) {
        const std::vector<bool> stands = standingParts(source, table);
        for (std::size_t part = 0; part < stands.size(); ++part) meshes[part].stands = stands[part];
    }
    const std::vector<PartField> fields =
        placeFields(meshes, options.cells, std::size_t(options.megabytes * kMegabyte));
    for (std::size_t part = range.begin; part < range.end; ++part) {
        plan.meshes.push_back(std::move(meshes[part]));
        plan.file.fields.parts.push_back(fields[part]);
        plan.file.fields.parts.back().joint = table.joint_of_part[part];
        checkPart(plan.files_read.front(), plan.file, plan.meshes.size() - 1);
    }
    if (options.parts) plan.file.shard = FieldShard{range.begin, table.partCount()};
}

}  // namespace

std::size_t FieldPlan::pointCount() const {
    std::size_t count = 0;
    for (const PartField& part : file.fields.parts) count += part.pointCount();
    return count;
}

FieldPlan planFields(const std::vector<std::filesystem::path>& paths, const FieldOptions& options) {
    const BakeSource source = readSource(paths, options.cache, options.rig);
    if (source.rig && (options.cache.metres != 1 || options.cache.z_up))
        throw BadOption(options.cache.metres != 1 ? "units" : "up",
                        "is for point caches, and " + paths.front().string() + " is a rig");
    const Mesh& mesh = source.mesh();
    const double diagonal = characterDiagonal(mesh);
    if (!(diagonal > 0 && std::isfinite(diagonal)))
        throw InvalidInput(paths.front().string() + ": the rest positions have no extent");
    const PartTable table = source.rig ? makePartTable(mesh, source.rig->skin) : wholeAsOnePart(mesh);
    FieldPlan plan;
    plan.files_read = source.filesRead();
    plan.notes = source.notes();
    FieldFile& file = plan.file;
    if (source.rig) file.joint_names = source.rig->skin.joint_names;
    file.part_of_joint = table.part_of_joint;
    file.steps = table.steps;
    file.vertex_count = mesh.vertexCount();
    file.mesh_sha256 = meshSha256(mesh);
    file.rays = options.rays;
    file.fields.fade = float(options.fade * diagonal);
    addParts(source, table, options, plan);
    if (options.inputs) {
        if (source.rig) throw BadOption("inputs", "of a mesh without skin only; a rig's parts move with its bones");
        plan.files_read.push_back(*options.inputs);
    }
    file.motion = motionOf(source, options.inputs);
    plan.receivers = fieldReceivers(source, table);
    file.provenance = makeProvenance("penumbra-bake fields", optionsJson(options), plan.files_read);
    file.provenance.notes = plan.notes;
    return plan;
}

// --- Tracing --------------------------------------------------------------------------------------------------------

namespace {

FieldSamples tracePart(const PartMesh& mesh, const PartField& part, const ConeDirections& directions, int threads) {
    const PartTracer tracer(mesh, part, directions);
    const std::vector<Vec3> points = fieldPoints(part);
    const std::size_t fine = part.boxes[0].pointCount();
    FieldSamples samples{std::vector<float>(points.size() * kFieldCoefficients), std::vector<float>(fine)};
    std::vector<float> depth(fine);
    parallelFor((points.size() + kPointsPerTask - 1) / kPointsPerTask, threads, [&](std::size_t task) {
        throwIfInterrupted();
        const std::size_t end = std::min(points.size(), (task + 1) * kPointsPerTask);
        for (std::size_t p = task * kPointsPerTask; p < end; ++p) {
            const PointOfField point = tracer.trace(points[p], p < fine ? Distances::kAll : Distances::kInside);
            std::copy(point.blocked.begin(), point.blocked.end(),
                      samples.values.begin() + std::ptrdiff_t(p * kFieldCoefficients));
            if (p < fine) samples.distances[p] = point.distance;
            if (p < fine) depth[p] = point.depth;
        }
    });
    closeHoles(part.boxes[0], depth, samples.distances);
    return samples;
}

// The levels' points follow one another.
std::array<std::size_t, kFieldLevels + 1> firstPoints(const PartField& part) {
    const std::size_t fine = part.boxes[0].pointCount(), coarse = part.boxes[1].pointCount();
    return {0, fine, fine + coarse, part.pointCount()};
}

std::int8_t roundedToByte(float value, float scale) {
    if (!(scale > 0)) return 0;
    return std::int8_t(std::clamp(std::lround(value / scale), long(-kFullByte), long(kFullByte)));
}

}  // namespace

void quantizeField(const FieldSamples& samples, float fade, PartField& part, std::vector<std::int8_t>& values,
                   std::vector<std::int8_t>& distances) {
    const std::vector<Vec3> points = fieldPoints(part);
    const std::array<std::size_t, kFieldLevels + 1> first = firstPoints(part);
    // 1. What is stored varies less with the distance than V - 1 does.
    std::vector<float> scaled = samples.values;
    for (std::size_t p = 0; p < points.size(); ++p) {
        const Vec3 offset = points[p] - part.center;
        const float factor = dot(offset, offset) + 0.25f * part.radius * part.radius;
        for (std::size_t i = 0; i < kFieldCoefficients; ++i) scaled[p * kFieldCoefficients + i] *= factor;
    }
    // 2. Every band of a level has a scale of its own, so that its largest number becomes a full byte.
    for (std::size_t level = 0; level < kFieldLevels; ++level) {
        std::array<float, kFieldOrder> most{};
        for (std::size_t i = first[level] * kFieldCoefficients; i < first[level + 1] * kFieldCoefficients; ++i) {
            float& of_band = most[std::size_t(bandOfIndex(int(i % kFieldCoefficients)))];
            of_band = std::max(of_band, std::abs(scaled[i]));
        }
        for (std::size_t band = 0; band < most.size(); ++band) part.scale[level][band] = most[band] / kFullByte;
    }
    values.resize(scaled.size());
    for (std::size_t level = 0; level < kFieldLevels; ++level)
        for (std::size_t i = first[level] * kFieldCoefficients; i < first[level + 1] * kFieldCoefficients; ++i)
            values[i] =
                roundedToByte(scaled[i], part.scale[level][std::size_t(bandOfIndex(int(i % kFieldCoefficients)))]);
    // 3. Only distances near the surface matter.
    float cell = 0;
    for (int axis = 0; axis < 3; ++axis)
        cell = std::max(cell, (part.boxes[0].high[axis] - part.boxes[0].low[axis]) /
                                  float(part.boxes[0].size[std::size_t(axis)] - 1));
    part.distance_scale = std::max(4 * cell, fade) / kFullByte;
    distances.resize(samples.distances.size());
    for (std::size_t p = 0; p < distances.size(); ++p)
        distances[p] = roundedToByte(samples.distances[p], part.distance_scale);
}

FieldFile bakeFields(const FieldPlan& plan, const FieldOptions& options, int threads, ProgressStyle progress) {
    FieldFile file = plan.file;
    PartFields& fields = file.fields;
    const ConeDirections directions = makeConeDirections(options.rays, options.seed);
    Progress bar(progress, "tracing fields", "points", double(plan.pointCount()));
    fields.values.resize(fields.parts.size());
    fields.distances.resize(fields.parts.size());
    double done = 0;
    for (std::size_t p = 0; p < fields.parts.size(); ++p) {
        const FieldSamples samples = tracePart(plan.meshes[p], fields.parts[p], directions, threads);
        quantizeField(samples, fields.fade, fields.parts[p], fields.values[p], fields.distances[p]);
        done += double(fields.parts[p].pointCount());
        bar.update(done);
    }
    return file;
}

}  // namespace penumbra
