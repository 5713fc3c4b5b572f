// Writes the mean over all frames into vertex attributes, which nearly every program reads.
#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/export/export_files.h"
#include "pack/export/uv_sets.h"

namespace penumbra {

OcclusionFrame FrameReader::read(std::size_t frame, FrameParts parts) const {
    throwIfInterrupted();
    OcclusionFrame out = source.read(frame, parts, threads);
    progress(frame + 1);
    return out;
}

namespace {

// The mean over frames. Bent normals count by what they see. `rms` becomes how far the ambient visibility of frames is
// from it.
OcclusionFrame meanOf(const FrameReader& frames, double& rms) {
    const std::size_t count = frames.source.frames().frameCount();
    const std::size_t points = frames.source.mesh().vertexCount();
    std::vector<double> ambient(points), squares(points);
    std::vector<Vec3d> bent(points), bounced(frames.source.hasBounces() ? points : 0);
    for (std::size_t f = 0; f < count; ++f) {
        const OcclusionFrame frame = frames.read(f, FrameParts::kAll);
        for (std::size_t p = 0; p < points; ++p) {
            ambient[p] += double(frame.ambient[p]);
            squares[p] += double(frame.ambient[p]) * double(frame.ambient[p]);
            bent[p] += toDouble(frame.bent[p]) * double(frame.ambient[p]);
            if (!bounced.empty()) bounced[p] += toDouble(frame.bounced[p]);
        }
    }
    OcclusionFrame out;
    double variance = 0;
    for (std::size_t p = 0; p < points; ++p) {
        const double mean = ambient[p] / double(count);
        variance += std::max(squares[p] / double(count) - mean * mean, 0.0) / double(points);
        out.ambient.push_back(float(mean));
        const Vec3 direction = toFloat(normalized(bent[p]));
        out.bent.push_back(direction == Vec3{} ? frames.source.restNormals()[p] : direction);
        if (!bounced.empty()) out.bounced.push_back(toFloat(bounced[p] / double(count)));
    }
    rms = std::sqrt(variance);
    return out;
}

template <class Number>
std::span<const float> flat(const std::vector<Number>& values) {
    static_assert(sizeof(Vec3) == 3 * sizeof(float));
    return {reinterpret_cast<const float*>(values.data()), values.size() * sizeof(Number) / sizeof(float)};
}

struct RowValues {
    std::vector<float> ambient;
    std::vector<Vec3> bent, bounced;
};

class StaticWriter {
public:
    StaticWriter(const ExportOptions& options, RowValues values, ExportedGlb& out)
        : options_(options), values_(std::move(values)), out_(out), uv_(freeUvSet(out.glb, out.targets, 2)) {}

    std::size_t uvSet() const { return uv_; }
    void write(const GlbTarget& target);

private:
    const ExportOptions& options_;
    const RowValues values_;
    ExportedGlb& out_;
    std::size_t uv_;

    void add(const GlbTarget& target, const char* name, std::span<const float> numbers, int components) {
        const std::size_t accessor = addAccessor(out_.glb, numbers, components, AccessorUse::kVertices);
        primitiveOf(out_.glb, target).at("attributes")[name] = accessor;
    }
    void writeColor(const GlbTarget& target, const std::vector<float>& e);
    void writeDirections(const GlbTarget& target, const std::vector<float>& e);
};

void StaticWriter::writeColor(const GlbTarget& target, const std::vector<float>& e) {
    std::vector<Vec3> factor;
    if (options_.value == TableValue::kBounced)
        for (const Vec3 light : valuesOf(out_.rig, target, values_.bounced))  // glTF has no colours above 1
            factor.push_back({std::min(light.x, 1.0f), std::min(light.y, 1.0f), std::min(light.z, 1.0f)});
    else
        for (const float visible : e) factor.push_back({visible, visible, visible});
    VertexColors colors = ownColors(out_, target, 4);
    multiplyColors(colors.values, 4, factor);
    writeColors(out_, target, colors);
    // (c + sum of w t) o = c o + sum of w (t o)
    for (ColorMorph& own : ownColorMorphs(out_, target, 4)) {
        multiplyColors(own.values, 4, factor);
        const std::size_t accessor = addAccessor(out_.glb, own.values, 4, AccessorUse::kVertices);
        primitiveOf(out_.glb, target).at("targets").at(own.morph)["COLOR_0"] = accessor;
    }
}

void StaticWriter::writeDirections(const GlbTarget& target, const std::vector<float>& e) {
    // Instances may be turned, so each brings its own to the primitive.
    std::vector<Vec3> bent = values_.bent;
    for (const std::size_t p : target.parts) {
        const ColoredPart& part = out_.rig.part_colors[p];
        bringToPrimitive(part, std::span(bent).subspan(part.first_vertex, part.vertices));
    }
    bent = valuesOf(out_.rig, target, bent);
    std::vector<float> custom, uv_xy, uv_zw;
    for (std::size_t v = 0; v < bent.size(); ++v) {
        const Vec3 b = bent[v] = normalized(bent[v]);
        custom.insert(custom.end(), {b.x, b.y, b.z, e[v]});
        uv_xy.insert(uv_xy.end(), {b.x, b.y});
        uv_zw.insert(uv_zw.end(), {b.z, e[v]});
    }
    add(target, "_BENT_NORMAL", flat(bent), 3);
    add(target, "_CUSTOM0", custom, 4);
    if (!values_.bounced.empty()) add(target, "_BOUNCED", flat(valuesOf(out_.rig, target, values_.bounced)), 3);
    addUvSet(out_.glb, target, uv_, uv_xy);
    addUvSet(out_.glb, target, uv_ + 1, uv_zw);
}

void StaticWriter::write(const GlbTarget& target) {
    const std::vector<float> e = valuesOf(out_.rig, target, values_.ambient);
    if (options_.color == ColorAttribute::kWritten) writeColor(target, e);
    add(target, "_OCCLUSION", e, 1);
    if (options_.color == ColorAttribute::kWritten) writeDirections(target, e);
}

}  // namespace

void bringToPrimitive(const ColoredPart& part, std::span<Vec3> directions) {
    Mat3d linear;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) linear(row, column) = part.to_rest[std::size_t(4 * row + column)];
    for (Vec3& b : directions) b = toFloat(normalized(transposed(linear) * toDouble(b)));
}

double exportStatic(const FrameReader& frames, const ExportOptions& options, ExportedGlb& out) {
    if (options.value == TableValue::kBounced && !frames.source.hasBounces())
        throw BadOption("bounced", "the source has no light that bounces");
    double rms = 0;
    const OcclusionFrame mean = meanOf(frames, rms);
    RowValues values{valuesOfRows(out.rows, mean.ambient), valuesOfRows(out.rows, mean.bent), {}};
    if (!mean.bounced.empty()) values.bounced = valuesOfRows(out.rows, mean.bounced);
    StaticWriter writer(options, std::move(values), out);
    nlohmann::ordered_json mark{{"version", 1}, {"as", "static"}};
    if (options.color == ColorAttribute::kWritten) mark["texcoord"] = writer.uvSet();
    markExport(out.glb, std::move(mark));
    for (const GlbTarget& target : out.targets) writer.write(target);
    return rms;
}

}  // namespace penumbra
