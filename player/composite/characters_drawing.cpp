#include "player/composite/characters_drawing.h"

#include <algorithm>

#include "player/render/sunlight_of_scene.h"

namespace penumbra {

namespace {

bool showsPictures(const SceneMesh& mesh) { return mesh.shading && mesh.shading->showsSurface(); }

}  // namespace

CharactersDrawing::CharactersDrawing(const PosedScene& scene, const SceneFrames& frames, const RenderOptions& options,
                                     const PinholeCamera& camera)
    : scene_(scene),
      frames_(frames),
      camera_(camera),
      samples_(options.samples),
      context_(createGlContext(options.backend)) {
    if (!sunsAtVertices()) suns_ = sunlightOf(scene, frames, options.sun_map);
    for (const SceneMesh& mesh : frames.meshes()) {
        const BrdfModels sunlit = suns_ ? frames.lobes().models(mesh.surface.lobes) : 0;
        if (showsPictures(mesh))
            painters_.emplace_back(*mesh.mesh, mesh.channel, mesh.sides, sunlit, mesh.shading);
        else
            painters_.emplace_back(mesh.triangles, mesh.channel, mesh.sides, sunlit);
    }
    for (const std::unique_ptr<SceneMember>& member : scene.members())
        if (member->file->real) hiding_.emplace_back(member->asset->view.mesh.triangles, Channel::kShaded);
    for (const RealMesh& mesh : scene.realMeshes()) hiding_.emplace_back(mesh.triangles, Channel::kShaded);
}

// Draws those in the photograph into the depths alone.
void CharactersDrawing::drawHiding(const FrameView& view) {
    if (hiding_.empty()) return;
    gl::ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    std::size_t next = 0;
    const auto draw = [&](std::span<const Vec3> positions) {
        const std::vector<Vec3> black(positions.size());
        hiding_[next++].draw(view, positions, black);
    };
    for (std::size_t m = 0; m < scene_.members().size(); ++m)
        if (scene_.members()[m]->file->real) draw(frames_.members()[m].positions);
    for (const RealMesh& mesh : scene_.realMeshes()) draw(mesh.positions);
    gl::ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

// The rectangle that holds all characters: the whole picture where one reaches behind the camera.
CharactersDrawing::Part CharactersDrawing::partOf(const SceneView& view) const {
    constexpr int kBorder = 2, kStep = 32;  // pixels; sizes grow in steps, so that few targets are made
    double low_x = camera_.width, low_y = camera_.height, high_x = -1, high_y = -1;
    const Mat3d turn = view.turn();
    const Vec3d eye = view.eye();
    for (std::size_t m = 0; m < frames_.members().size(); ++m) {
        if (!frames_.lookOf(m).drawn) continue;
        for (const Vec3 p : frames_.members()[m].positions) {
            const Vec3d at = turn * (toDouble(p) - eye);
            if (!(at.z > 1e-3)) return {0, 0, camera_.width, camera_.height};
            const double x = camera_.cx + camera_.f * at.x / at.z, y = camera_.cy + camera_.f * at.y / at.z;
            low_x = std::min(low_x, x), high_x = std::max(high_x, x);
            low_y = std::min(low_y, y), high_y = std::max(high_y, y);
        }
    }
    int x0 = int(std::clamp(low_x - kBorder, 0.0, double(camera_.width))),
        y0 = int(std::clamp(low_y - kBorder, 0.0, double(camera_.height)));
    const int x1 = int(std::clamp(high_x + kBorder + 1, 0.0, double(camera_.width))),
              y1 = int(std::clamp(high_y + kBorder + 1, 0.0, double(camera_.height)));
    if (x1 <= x0 || y1 <= y0) return {0, 0, 0, 0};
    // Derivatives of texture coordinates are those of blocks of 2 x 2 pixels, which stay where the whole picture has
    // them. OpenGL counts rows from below.
    if (std::ranges::any_of(frames_.meshes(), showsPictures)) {
        x0 -= x0 % 2;
        y0 -= std::min(y0, (camera_.height - y0) % 2);
    }
    return {x0, y0, (x1 - x0 + kStep - 1) / kStep * kStep, (y1 - y0 + kStep - 1) / kStep * kStep};
}

bool CharactersDrawing::sunsAtVertices() const {
    constexpr std::size_t kPixels = 64;  // pixels of the picture per vertex
    constexpr BrdfModels kFragments = 1u << int(BrdfModel::kMirror) | kMembranes;
    if (!context_->software || (frames_.lobes().models() & kFragments)) return false;
    if (std::ranges::any_of(frames_.meshes(), showsPictures)) return false;
    const std::size_t least = std::size_t(camera_.width) * std::size_t(camera_.height) / kPixels;
    return std::ranges::all_of(frames_.meshes(), [&](const SceneMesh& mesh) {
        return mesh.triangles.size() / 6 >= least;  // a closed mesh has half as many vertices as triangles
    });
}

void CharactersDrawing::drawMeshes(const FrameView& view, std::span<const std::vector<Vec3>> sunlit) {
    std::size_t next = 0, member = 0;
    for (const SceneMesh& mesh : frames_.meshes()) {
        while (!frames_.lookOf(member).drawn) ++member;
        ValuePainter& painter = painters_[next++];
        if (suns_ || showsPictures(mesh))
            painter.upload(mesh.positions, mesh.values, mesh.surface);
        else
            painter.upload(mesh.positions, sunlit[member]);
        painter.draw(view, suns_ ? &*suns_ : nullptr);
        ++member;
    }
}

FrameView CharactersDrawing::frameView(const SceneView& view) const {
    FrameView frame;
    frame.eye = toFloat(view.eye());
    std::vector<BoundingBox> boxes;
    for (const FrameVertices& member : frames_.members()) boxes.push_back(boundsOf(member.positions));
    for (const RealMesh& mesh : scene_.realMeshes()) boxes.push_back(boundsOf(mesh.positions));
    clipFromPhotograph(view, boxes, 0, frame.clip_from_model);
    return frame;
}

DrawnPart CharactersDrawing::drawRatios(SceneView view, std::span<const RealSurface> surfaces) {
    view.camera = camera_;
    if (!surfaces_target_) {
        surfaces_target_.emplace(camera_.width, camera_.height, samples_);
        for (const RealSurface& surface : surfaces) surfaces_.emplace_back(surface.triangles, Channel::kShaded);
    }
    const FrameView frame = frameView(view);
    surfaces_target_->begin();
    for (std::size_t s = 0; s < surfaces.size(); ++s)
        surfaces_[s].draw(frame, surfaces[s].positions, surfaces[s].ratio);
    return {surfaces_target_->read(), 0, 0};
}

DrawnPart CharactersDrawing::draw(SceneView view, std::span<const std::vector<Vec3>> sunlit, bool moved) {
    const Part part = partOf(view);
    if (part.width == 0) return {};
    view.camera = camera_;
    view.camera.cx -= part.x;
    view.camera.cy -= part.y;
    view.camera.width = part.width;
    view.camera.height = part.height;
    const FrameView frame = frameView(view);
    if (suns_ && (moved || !shone_)) suns_->shine(frames_.suns(), frames_.sunCasters());
    shone_ = true;
    if (!target_ || target_->width() != part.width || target_->height() != part.height)
        target_.emplace(part.width, part.height, samples_);
    target_->begin();
    drawHiding(frame);
    drawMeshes(frame, sunlit);
    return {target_->read(), part.x, part.y};
}

}  // namespace penumbra
