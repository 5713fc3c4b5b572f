#include "player/render/scene_picture.h"

#include <memory>

#include "formats/common/errors.h"
#include "formats/scene/scene_placement.h"
#include "player/draw/draw_frame.h"
#include "player/frame/shot.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "player/scene/scene_ground.h"
#include "player/scene/scene_receivers.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

// A mesh with a value at each vertex.
struct Drawn {
    std::span<const std::uint32_t> triangles;
    std::vector<Vec3> positions, values;
};

// The member's asset with the light of the scene.
AssetView litView(const PosedScene& scene, const SceneMember& member) {
    AssetView view = member.asset->view;
    view.lights = scene.lightAsset().lights;
    return view;
}

Drawn drawMember(const PosedScene& scene, std::size_t index, const RenderOptions& options, Vec3 eye,
                 FrameVertices vertices, int threads) {
    const SceneMember& member = *scene.members()[index];
    const AssetView view = litView(scene, member);
    RenderOptions look;
    look.channel = options.channel;
    look.shading = options.shading;
    look.brdf = member.file->material;
    for (const auto& [slot, material] : member.file->slots) look.slots.push_back(slot + "=" + material);
    look.light = scene.file().light.name;
    look.light_rotation = scene.file().light.rotation;
    const Shot shot = [&] {
        try {
            return resolveLook(look, view, nullptr);
        } catch (const UsageError& error) {
            throw UsageError(member.file->at + ": " + error.what());
        }
    }();
    std::optional<ShadingSet> shading;
    if (shot.shaded) shading.emplace(shadingOf(shot));
    Drawn out;
    out.triangles = member.asset->view.mesh.triangles;
    out.values = channelValues(shot, options.channel, shading ? &*shading : nullptr, vertices, {}, eye, threads);
    out.positions = std::move(vertices.positions);
    return out;
}

Drawn drawGround(const PosedScene& scene, const GroundVertices& ground, Channel channel) {
    Drawn out{ground.triangles, ground.positions, {}};
    if (channel == Channel::kShaded) {
        out.values = groundRadiance(scene, ground);
        return out;
    }
    for (const float e : groundAmbient(ground)) out.values.push_back({e, 0, 0});
    return out;
}

FrameView viewOf(const PosedScene& scene, const RenderOptions& options, std::span<const FrameVertices> members) {
    std::vector<Vec3> corners;
    for (const FrameVertices& vertices : members) {
        const BoundingBox box = boundsOf(vertices.positions);
        corners.insert(corners.end(), {box.low, box.high});
    }
    const double radius = std::max<double>(boundsOf(corners).radius(), 1e-3);
    const double reach = scene.file().ground ? std::max(radius, scene.file().ground->size) : radius;
    const Camera camera = cameraOf(scene.file(), options.camera, corners);
    FrameView view;
    clipFromModel(camera, double(options.width) / options.height, reach, view.clip_from_model);
    view.eye = toFloat(cameraPosition(camera));
    return view;
}

}  // namespace

Image drawScene(const PosedScene& scene, const RenderOptions& options, int threads) {
    if (options.channel == Channel::kShaded && !scene.light())
        throw UsageError("the scene has no light: name an asset that has one under \"light\", or ask for --channel ao");
    std::vector<FrameVertices> members;
    for (std::size_t m = 0; m < scene.members().size(); ++m) members.push_back(memberVertices(scene, m, threads));
    const FrameView view = viewOf(scene, options, members);
    std::vector<Drawn> drawn;
    for (std::size_t m = 0; m < members.size(); ++m)
        drawn.push_back(drawMember(scene, m, options, view.eye, std::move(members[m]), threads));
    GroundVertices ground;
    if (scene.file().ground) {
        ground = groundVertices(scene, threads);
        drawn.push_back(drawGround(scene, ground, options.channel));
    }
    const std::unique_ptr<GlContext> context = createGlContext(options.backend);
    const OffscreenTarget target(options.width, options.height, options.samples);
    target.begin();
    for (const Drawn& one : drawn) ValuePainter(one.triangles, options.channel).draw(view, one.positions, one.values);
    return target.read();
}

}  // namespace penumbra
