#include "player/draw/picture_view.h"

#include <array>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "player/frame/framed_rest.h"
#include "sh/camera.h"

namespace penumbra {

namespace {

double restRadius(const BoundingBox& rest) { return 0.5 * length(toDouble(rest.high) - toDouble(rest.low)); }

std::array<Vec3, 2> cornersOf(const BoundingBox& box) { return {box.low, box.high}; }

FrameView makeView(const RenderOptions& options, const BoundingBox& rest, const BoundingBox& seen, double radius) {
    FrameView view;
    view.error_max = options.error_max;
    try {
        const Camera camera = makeCamera(options.camera, cornersOf(seen), radius, defaultPitch(cornersOf(rest)));
        clipFromModel(camera, double(options.width) / options.height, radius, view.clip_from_model);
        view.eye = toFloat(cameraPosition(camera));
    } catch (const std::invalid_argument& problem) {
        throw BadOption("camera", problem.what());
    }
    return view;
}

}  // namespace

FrameView makePictureView(const RenderOptions& options, const AssetView& asset, std::span<const Vec3> positions) {
    const BoundingBox rest = restBox(asset);
    return makeView(options, rest, framedBox(asset, positions), restRadius(rest));
}

FrameView makeSequenceView(const RenderOptions& options, const AssetView& asset, const BoundingBox& box) {
    const BoundingBox rest = restBox(asset);
    return makeView(options, rest, box, std::max(restRadius(rest), box.radius()));
}

BoundingBox boundsOfClips(PosedFrame& frame, std::span<const std::size_t> clips) {
    BoundingBox all;
    bool first = true;
    for (const std::size_t c : clips) {
        const ClipView& clip = frame.shot().asset->animation.clips[c];
        for (std::size_t number = 0; number < clip.frame_count; ++number) {
            throwIfInterrupted();
            frame.pose(clip.first_frame + number, std::nullopt);
            const BoundingBox box = framedBox(*frame.shot().asset, frame.positions());
            all = first ? box : merged(all, box);
            first = false;
        }
    }
    return all;
}

}  // namespace penumbra
