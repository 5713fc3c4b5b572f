#include "player/picture_view.h"

#include <stdexcept>

#include "formats/errors.h"
#include "formats/mesh.h"
#include "sh/camera.h"

namespace penumbra {

FrameView makePictureView(const RenderOptions& options, const AssetView& asset, std::span<const Vec3> positions) {
    const double radius = 0.5 * boxDiagonal({asset.mesh.positions.begin(), asset.mesh.positions.end()});
    FrameView view;
    view.error_max = options.error_max;
    try {
        const Camera camera = makeCamera(options.camera, positions, radius);
        clipFromModel(camera, double(options.width) / options.height, radius, view.clip_from_model);
        view.eye = toFloat(cameraPosition(camera));
    } catch (const std::invalid_argument& problem) {
        throw UsageError(std::string("--camera: ") + problem.what());
    }
    return view;
}

}  // namespace penumbra
