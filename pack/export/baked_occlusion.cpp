// Turns the moments of a bake into ambient visibility, bent normals and bounced light.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/parallel_for.h"
#include "pack/export/occlusion_source.h"
#include "pack/export/turn_to_rest.h"

namespace penumbra {

namespace {

// Factor of band 1. y_1 = sqrt(3 / 4 pi) (-y, z, -x), so the integral of V s over the hemisphere is that vector /
// kBand1.
const float kBand1 = float(std::sqrt(3 / (4 * std::numbers::pi)));
// Irradiance of a coefficient of band 0 under a light of radiance 1, over pi.
const float kBand0 = float(std::sqrt(4 * std::numbers::pi) / std::numbers::pi);

Vec3 visibleDirection(std::span<const float> moments) { return Vec3{-moments[3], -moments[1], moments[2]} / kBand1; }

class BakedOcclusion : public OcclusionSource {
public:
    BakedOcclusion(const VisibilityReader& reader, const std::vector<std::string>& clips);
    bool hasBounces() const override { return reader_.header().hasBounces(); }
    OcclusionFrame read(std::size_t frame, FrameParts parts, int threads) const override;

private:
    const VisibilityReader& reader_;
    std::vector<std::size_t> file_frames_;  // [F] of the file

    void readPoint(const VisibilityFrame& frame, std::size_t point, OcclusionFrame& out) const;
};

std::vector<bool> chosenClips(const std::vector<std::string>& known, const std::vector<std::string>& clips) {
    for (const std::string& clip : clips)
        if (std::find(known.begin(), known.end(), clip) == known.end())
            throw BadOption("clips", "no clip \"" + clip + "\"; there are: " + joined(known));
    std::vector<bool> chosen;
    for (const std::string& clip : known)
        chosen.push_back(clips.empty() || std::find(clips.begin(), clips.end(), clip) != clips.end());
    return chosen;
}

BakedOcclusion::BakedOcclusion(const VisibilityReader& reader, const std::vector<std::string>& clips)
    : reader_(reader) {
    const VisibilityHeader& header = reader.header();
    if (header.quantity != kHemisphereVisibility && header.quantity != kDiffuseTransfer)
        throw InvalidInput("quantity is " + header.quantity + "; exports take hemisphere_visibility or " +
                           kDiffuseTransfer);
    if (header.order < 2) throw InvalidInput("sh_order is 1: ambient visibility needs 2 bands");
    const std::vector<bool> chosen = chosenClips(header.frames.clip_names, clips);
    frames_.clip_names = header.frames.clip_names;
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) {
        if (!chosen[header.frames.clip[f]]) continue;
        file_frames_.push_back(f);
        frames_.clip.push_back(header.frames.clip[f]);
        frames_.time.push_back(header.frames.time[f]);
    }
    if (file_frames_.empty()) throw InvalidInput("has no frames");
    mesh_ = header.drawn ? header.drawn->mesh : header.mesh;
    mesh_.two_sided = false;  // backs are points like any other, which no source vertex leads to
    rest_normals_ = header.drawn ? header.drawn->rest_normals : header.rest_normals;
}

void BakedOcclusion::readPoint(const VisibilityFrame& frame, std::size_t point, OcclusionFrame& out) const {
    const VisibilityHeader& header = reader_.header();
    const std::size_t n2 = header.coefficientCount();
    const std::span<const float> moments = std::span(frame.coefficients).subspan(point * n2, n2);
    const Vec3 visible = visibleDirection(moments), normal = frame.normals[point];
    // Moments of visibility are weighted with the cosine here, and those of transfer were so by the bake.
    const float ambient =
        header.quantity == kDiffuseTransfer ? kBand0 * moments[0] : dot(visible, normal) / std::numbers::pi_v<float>;
    out.ambient[point] = std::clamp(ambient, 0.0f, 1.0f);
    if (!out.bent.empty()) {
        PointMotion motion{{}, {}, frame.bones, header.rest_normals[point], normal};
        if (header.skin) {
            const std::size_t k = std::size_t(header.skin->influences);
            motion.joints = std::span(header.skin->joints).subspan(point * k, k);
            motion.weights = std::span(header.skin->weights).subspan(point * k, k);
        }
        out.bent[point] = directionAtRest(motion, visible);
    }
    if (out.bounced.empty()) return;
    for (int c = 0; c < 3; ++c)
        out.bounced[point][c] = out.ambient[point] + kBand0 * frame.indirect[(3 * point + std::size_t(c)) * n2];
}

template <class Number>
std::vector<Number> interpolated(const PointTable& table, const std::vector<Number>& of_points) {
    std::vector<Number> out(of_points.empty() ? 0 : table.corners.size());
    for (std::size_t v = 0; v < out.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c) out[v] += table.weights[v][c] * of_points[table.corners[v][c]];
    return out;
}

OcclusionFrame BakedOcclusion::read(std::size_t frame, FrameParts parts, int threads) const {
    const VisibilityHeader& header = reader_.header();
    const VisibilityFrame baked = reader_.readFrame(file_frames_[frame]);
    const std::size_t points = header.mesh.vertexCount();
    OcclusionFrame out;
    out.ambient.resize(points);
    if (parts == FrameParts::kAll) out.bent.resize(points);
    if (parts == FrameParts::kAll && hasBounces()) out.bounced.resize(points);
    constexpr std::size_t kBlock = 1024;
    parallelFor((points + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
        for (std::size_t p = block * kBlock; p < std::min(points, (block + 1) * kBlock); ++p) readPoint(baked, p, out);
    });
    if (!header.drawn) return out;
    out = {interpolated(header.drawn->points, out.ambient), interpolated(header.drawn->points, out.bent),
           interpolated(header.drawn->points, out.bounced)};
    for (Vec3& b : out.bent) b = normalized(b);
    return out;
}

}  // namespace

std::unique_ptr<OcclusionSource> bakedOcclusion(const VisibilityReader& reader, const std::vector<std::string>& clips) {
    return std::make_unique<BakedOcclusion>(reader, clips);
}

}  // namespace penumbra
