// A bake: its mesh, its frames and the range of its coefficients.
#include <array>
#include <cmath>
#include <numeric>

#include "bake/info/info_files.h"
#include "bake/visibility/bake_visibility.h"
#include "formats/common/write_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

namespace {

// Tells which frames a bake of some frames has, and of how many.
Json describe(const ShardPlace& shard, const FrameList& frames) {
    std::vector<ClipFrame> here;
    for (std::size_t f = 0; f < frames.frameCount(); ++f)
        here.push_back({frames.clip_names[frames.clip[f]], shard.frame_in_clip[f]});
    return {{"frames", frames.frameCount()},
            {"of", std::accumulate(shard.clip_frames.begin(), shard.clip_frames.end(), std::uint64_t(0))},
            {"ranges", rangesText(here, 20)}};
}

// Finds the least and the greatest coefficient, and the mean open share of the hemisphere, which for transfer is
// weighted by the cosine. Reads all frames of some vertices, in the blocks that the file keeps together, or of all
// vertices.
Json describeCoefficients(const VisibilityReader& reader, VertexSample sample) {
    constexpr std::size_t kBlock = 64, kSampledBlocks = 16;
    const VisibilityHeader& header = reader.header();
    const std::size_t vertices = header.mesh.vertexCount(), blocks = (vertices + kBlock - 1) / kBlock;
    const std::size_t step = sample == VertexSample::kAll ? 1 : std::max<std::size_t>(1, blocks / kSampledBlocks);
    const std::size_t stride = header.coefficientCount(), frames = header.frames.frameCount();
    const double unblocked = unblockedOf(header.quantity);
    double least = INFINITY, greatest = -INFINITY, open = 0;
    std::size_t read = 0;
    for (std::size_t begin = 0; begin < vertices; begin += step * kBlock) {
        throwIfInterrupted();
        const std::size_t end = std::min(begin + kBlock, vertices);
        std::vector<float> coefficients(frames * (end - begin) * stride);
        reader.readVertices(begin, end, coefficients);
        const auto [low, high] = std::minmax_element(coefficients.begin(), coefficients.end());
        least = std::min(least, double(*low));
        greatest = std::max(greatest, double(*high));
        for (std::size_t i = 0; i < coefficients.size(); i += stride) open += coefficients[i] / unblocked;
        read += end - begin;
    }
    return {{"vertices_read", read},
            {"least", least},
            {"greatest", greatest},
            {"mean_open_share", open / double(frames * read)}};
}

// Tells where the albedo came from, as the options of the bake say it; null where they do not.
Json albedoFrom(const Provenance& provenance) {
    const Json options = Json::parse(provenance.options_json, nullptr, false);
    if (!options.is_object()) return nullptr;
    if (const auto from = options.find("albedo_from"); from != options.end()) return *from;
    const auto albedo = options.find("albedo");
    if (albedo == options.end()) return nullptr;
    return albedo->is_string() ? "table " + albedo->get<std::string>() : "one colour";
}

// Tells what the surface reflects, and the shares of the rays that hit it, as means over all frames.
Json describeBounces(const VisibilityReader& reader) {
    const VisibilityHeader& header = reader.header();
    Vec3d albedo;
    for (Vec3 color : header.colors.albedo) albedo += toDouble(color) / double(header.mesh.vertexCount());
    const std::size_t frames = header.frames.frameCount();
    double hits = 0, backs = 0;
    for (std::size_t f = 0; f < frames; ++f) {
        const std::array<float, 2> shares = reader.readHitShares(f);
        hits += double(shares[0]) / double(frames);
        backs += double(shares[1]) / double(frames);
    }
    return {{"mean_albedo", {albedo.x, albedo.y, albedo.z}},
            {"albedo_from", albedoFrom(header.provenance)},
            {"transmission", !header.colors.transmission.empty()},
            {"mean_hit_share", hits},
            {"mean_back_share_of_hits", backs}};
}

}  // namespace

Json describeVisibility(const std::filesystem::path& path, VertexSample sample) {
    const VisibilityReader reader(path);
    const VisibilityHeader& header = reader.header();
    Json json{{"quantity", header.quantity},
              {"sh_order", header.order},
              {"rays", header.rays},
              {"seed", header.seed},
              {"bounces", header.bounces}};
    if (header.ground_y) json["ground_y"] = *header.ground_y;
    if (header.distance) json["distance"] = *header.distance;
    if (header.local) json["local"] = {{"steps", header.local->steps}, {"sh_order", header.local->order}};
    if (header.hasBounces()) json["light_that_bounces"] = describeBounces(reader);
    json["mesh"] = describe(header.mesh);
    if (header.drawn) json["drawn_mesh"] = describe(header.drawn->mesh);
    json["joints"] = header.skin ? header.skin->jointCount() : 0;
    json["influences"] = header.skin ? header.skin->influences : 0;
    json["pose"] = {{"numbers", header.pose_size}, {"parameterisation", header.pose_parameterisation}};
    if (!header.edges.empty()) json["edges"] = header.edges.size();
    if (!header.input_names.empty()) json["inputs"] = header.input_names;
    if (const MorphTargets& morphs = header.mesh.morphs; !morphs.empty())
        json["morph_targets"] = {{"count", morphs.count()}, {"changed_vertices", morphs.vertices.size()}};
    json["frames"] = header.frames.frameCount();
    json["clips"] = describe(header.frames);
    if (reader.isVirtual()) json["virtual"] = true;
    if (header.shard) json["shard"] = describe(*header.shard, header.frames);
    json["coefficients"] = describeCoefficients(reader, sample);
    json["provenance"] = describe(header.provenance);
    return json;
}

}  // namespace penumbra
