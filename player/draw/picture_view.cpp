#include "player/draw/picture_view.h"

#include <array>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/common/mesh.h"
#include "formats/common/write_file.h"
#include "sh/camera.h"

namespace penumbra {

namespace {

double restRadius(const AssetView& asset) {
    return 0.5 * boxDiagonal({asset.mesh.positions.begin(), asset.mesh.positions.end()});
}

FrameView makeView(const RenderOptions& options, const AssetView& asset, std::span<const Vec3> positions,
                   double radius) {
    FrameView view;
    view.error_max = options.error_max;
    try {
        const Camera camera = makeCamera(options.camera, positions, radius, defaultPitch(asset.mesh.positions));
        clipFromModel(camera, double(options.width) / options.height, radius, view.clip_from_model);
        view.eye = toFloat(cameraPosition(camera));
    } catch (const std::invalid_argument& problem) {
        throw BadOption("camera", problem.what());
    }
    return view;
}

}  // namespace

FrameView makePictureView(const RenderOptions& options, const AssetView& asset, std::span<const Vec3> positions) {
    return makeView(options, asset, positions, restRadius(asset));
}

FrameView makeSequenceView(const RenderOptions& options, const AssetView& asset, const BoundingBox& box) {
    const std::array<Vec3, 2> corners = {box.low, box.high};
    return makeView(options, asset, corners, std::max(restRadius(asset), box.radius()));
}

BoundingBox boundsOfClips(PosedFrame& frame, std::span<const std::size_t> clips) {
    BoundingBox all;
    bool first = true;
    for (const std::size_t c : clips) {
        const ClipView& clip = frame.shot().asset->animation.clips[c];
        for (std::size_t number = 0; number < clip.frame_count; ++number) {
            throwIfInterrupted();
            frame.pose(clip.first_frame + number, std::nullopt);
            const BoundingBox box = boundsOf(frame.positions());
            all = first ? box : merged(all, box);
            first = false;
        }
    }
    return all;
}

}  // namespace penumbra
