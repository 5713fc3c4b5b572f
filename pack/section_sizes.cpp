// Counts the bytes of an asset by what they are for.
#include <algorithm>

#include "formats/asset/cluster_bytes.h"
#include "pack/pack_asset.h"

namespace penumbra {

std::vector<SizeOf> sectionSizes(const AssetView& asset, std::size_t file_size) {
    const MeshView& m = asset.mesh;
    const AnimationView& a = asset.animation;
    std::size_t regression =
        asset.model.joint_centers.size_bytes() + asset.model.pose_mean.size_bytes() + bytesOf(asset.model.pose_basis);
    const std::size_t visibility = outputBytes(asset.model.clusters);
    regression += regressionBytes(asset.model.clusters);
    const std::optional<CompositionView>& composition = asset.model.composition;
    if (composition)
        regression += regressionBytes(composition->residual) + composition->steps.size_bytes() +
                      composition->part_of_vertex.size_bytes();
    std::size_t materials = 0, lights = 0, pictures = 0;
    for (const MaterialView& material : asset.materials)
        materials += material.stored_slices.size_bytes() + material.operators.u.size_bytes() +
                     material.operators.w.size_bytes() + material.lobes.size_bytes() + material.steps.size_bytes() +
                     material.stored_step_slices.size_bytes();
    for (const LightView& light : asset.lights) {
        lights += light.sh.size_bytes() + light.lobes.directions.size_bytes() + light.lobes.coefficients.size_bytes() +
                  light.suns.size_bytes() + light.window.size_bytes();
        pictures += light.picture.texels.size_bytes();
    }
    std::vector<SizeOf> sizes = {
        {"mesh", m.positions.size_bytes() + m.normals.size_bytes() + m.tangents.size_bytes() +
                     m.triangles.size_bytes() + m.shading_point.size_bytes() + m.source_vertex.size_bytes() +
                     m.follower_corners.size_bytes() + m.follower_weights.size_bytes()},
        {"skin", m.skin_joints.size_bytes() + m.skin_weights.size_bytes()},
        {"animation", a.times.size_bytes() + a.bones.size_bytes() + a.pose.size_bytes() + a.parents.size_bytes() +
                          a.inputs.size_bytes()},
        {composition ? "local" : "visibility", visibility},
        {"regression", regression},
        {"truth", asset.truth.data.size()},
        {"materials", materials},
        {"lights", lights}};
    if (!m.morphs.empty())
        sizes.insert(sizes.begin() + 2,
                     {"morphs", m.morphs.first.size_bytes() + m.morphs.vertices.size_bytes() +
                                    m.morphs.positions.size_bytes() + m.morphs.normals.size_bytes()});
    if (asset.model.deforming) sizes.insert(sizes.begin() + 3, {"playback", a.playback.positions.size_bytes()});
    if (composition) {
        const auto local =
            std::find_if(sizes.begin(), sizes.end(), [](const SizeOf& s) { return s.section == "local"; });
        sizes.insert(local + 1,
                     {{"residual", outputBytes(composition->residual)}, {"fields", composition->byteCount()}});
        if (composition->near_count > 0)
            sizes.push_back(
                {"near parts", composition->near_parts.size_bytes() + composition->near_gains.size_bytes()});
    }
    if (const std::optional<IndirectView>& indirect = asset.model.indirect)
        sizes.push_back({kBouncedSection, outputBytes(indirect->clusters) + regressionBytes(indirect->clusters)});
    if (asset.transfer) {
        const TransferView& t = *asset.transfer;
        sizes.push_back({"transfer", t.angles.size_bytes() + t.pose_basis.size_bytes() + bytesOf(t.weights) +
                                         bytesOf(t.basis) + t.mean.size_bytes()});
    }
    if (!asset.blockers.spheres.empty()) sizes.push_back({"blockers", asset.blockers.byteCount()});
    if (asset.surface) {
        std::size_t textures = 0;
        for (const TextureView& texture : asset.surface->textures) textures += texture.bytes.size();
        sizes.push_back({"surface", asset.surface->byteCount() - textures});
        sizes.push_back({"textures", textures});
    }
    if (pictures > 0) sizes.push_back({"light pictures", pictures});
    std::size_t sum = 0;
    for (const SizeOf& size : sizes) sum += size.bytes;
    sizes.push_back({"names and layout", file_size - std::min(sum, file_size)});
    return sizes;
}

std::size_t modelBytes(const AssetView& asset, std::size_t file_size) {
    std::size_t bytes = 0;
    for (const SizeOf& size : sectionSizes(asset, file_size))
        for (const char* section :
             {"visibility", "local", "residual", "near parts", "regression", "transfer", "names and layout"})
            if (size.section == section) bytes += size.bytes;
    return bytes;
}

std::vector<double> componentBytes(const AssetView& asset) {
    std::vector<double> bytes;
    const auto add = [&](const std::vector<ClusterView>& clusters) {
        for (const ClusterView& c : clusters) {
            const double rows = double(bytesOf(c.basis) + bytesOf(c.weights) + c.bias.size_bytes());
            bytes.push_back(c.components() > 0 ? rows / double(c.components()) : 0);
        }
    };
    add(asset.model.clusters);
    if (asset.model.composition) add(asset.model.composition->residual);
    return bytes;
}

}  // namespace penumbra
