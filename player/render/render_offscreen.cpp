#include "player/render/render_offscreen.h"

#include "player/draw/picture_view.h"
#include "player/frame/mirror_sight.h"
#include "player/frame/orbit_camera.h"
#include "player/frame/visibility_lobe.h"
#include "player/papers/transfer/transfer_model.h"

namespace penumbra {

namespace {

const std::vector<float> kNoTruth;

}  // namespace

OffscreenRenderer::OffscreenRenderer(const RenderOptions& options, const Shot& look)
    : asset_(look.asset),
      context_(createGlContext(options.backend)),
      path_(options.path.value_or(context_->software ? EvaluationPath::kCpu : EvaluationPath::kGlsl)),
      target_(options.width, options.height, options.samples) {
    if (look.shaded) shading_.emplace(shadingOf(look));
    if (!hasVisibility(*look.asset)) path_ = EvaluationPath::kCpu;
    if (!look.suns) return;
    lobes_ = lobe_table_.add(*shading_);
    slot_lobes_ = lobe_table_.addSlots(*shading_);
    sunlight_.emplace(lobe_table_, options.sun_map);
    sunlight_->reflect(skyPicture(asset_->lights[shading_->light()]));
    sunlight_->turnSky(shading_->lightRotation());
}

void OffscreenRenderer::shineOn(std::span<const Vec3> positions) {
    const SunCaster body{positions, asset_->mesh.castingTriangles()};
    sunlight_->shine(shading_->suns(), {{body}});
}

// Returns what the picture shows of every vertex.
std::vector<Vec3> OffscreenRenderer::valuesOf(const Panel& panel, PosedFrame& frame, Vec3 eye) {
    if (panel.channel == Channel::kTransferError) {
        std::vector<Vec3> values;
        if (!transfer_error_) transfer_error_.emplace(*asset_, *frame.shot().truth);
        for (const float error : transfer_error_->of(frame)) values.push_back({error, 0, 0});
        return values;
    }
    if (panel.channel == Channel::kShaded) return frame.radiance(panel.source, *shading_, eye);
    const std::vector<float>& truth =
        panel.channel == Channel::kError ? frame.ambient(VisibilitySource::kTruth) : kNoTruth;
    return channelValues(frame.shot(), panel.channel, nullptr, frame.vertices(panel.source), truth, eye,
                         frame.threads());
}

void OffscreenRenderer::drawValues(const Panel& panel, PosedFrame& frame, const FrameView& view) {
    const bool sunlit = panel.channel == Channel::kShaded && sunlight_;
    auto at = value_painters_.find(panel.channel);
    const ShadingSet* const pictured = panel.channel == Channel::kShaded && shading_ ? &*shading_ : nullptr;
    if (at == value_painters_.end())
        at = value_painters_
                 .emplace(panel.channel, ValuePainter(asset_->mesh, panel.channel, Sides::kBoth,
                                                      sunlit ? lobe_table_.models(lobes_) : 0, PicturedMesh(pictured)))
                 .first;
    std::vector<Vec3> values = valuesOf(panel, frame, view.eye);
    const FrameVertices& vertices = sunlit ? frame.vertices(panel.source) : frame.skinned();
    std::vector<float> sight;
    if (sunlit) {
        sight = takeMirrorsOut(asset_->model.convention, asset_->model.stride, vertices, view.eye, frame.threads(),
                               lobe_table_, lobes_, values);
        shineOn(vertices.positions);
    }
    at->second.upload(vertices.positions, values, {vertices.normals, vertices.tangents, lobes_, sight});
    target_.begin();
    at->second.draw(view, sunlit ? &*sunlight_ : nullptr);
}

void OffscreenRenderer::drawModel(const Panel& panel, PosedFrame& frame, const FrameView& view) {
    const ShadingSet* shading = shading_ ? &*shading_ : nullptr;
    if (!gl_asset_) gl_asset_ = std::make_shared<GlAsset>(*asset_, shading, &frame.evaluator());
    if (!model_painter_) model_painter_.emplace(gl_asset_, 1);
    PosedCharacter character{&frame.evaluator(), {}, shading};
    if (panel.source == VisibilitySource::kTruth || gl_asset_->needsCoefficients())
        character.coefficients = frame.coefficients(panel.source);
    if (panel.channel == Channel::kError) character.true_ambient = frame.ambient(VisibilitySource::kTruth);
    const bool sunlit = panel.channel == Channel::kShaded && sunlight_;
    if (sunlit) {
        character.lobes = slot_lobes_;
        shineOn(frame.positions());
    }
    model_painter_->evaluate(panel.channel, {&character, 1}, view.eye);
    target_.begin();
    model_painter_->draw(view, sunlit ? &*sunlight_ : nullptr);
}

void OffscreenRenderer::drawOverlays(const Panel& panel, PosedFrame& frame, const FrameView& frame_view) {
    FrameView view = frame_view;
    if (panel.channel == Channel::kShaded) view.scale = 1 / exposure_;
    const Shot& shot = frame.shot();
    const Evaluator& evaluator = frame.evaluator();
    if (!shot.boxes.empty())
        overlays_.drawBoxes(fieldBoxEdges(*asset_->model.composition, evaluator.bones(), shot.boxes), view);
    if (!shot.lobe) return;
    VisibilityFactor factor = visibilityFactor(evaluator, *shot.lobe, shot.lobe_of);
    const FrameVertices& at = frame.vertices(panel.source);
    if (panel.source == VisibilitySource::kTruth)
        std::copy_n(at.coefficients.begin() + std::ptrdiff_t(*shot.lobe * std::size_t(asset_->model.stride)),
                    factor.coefficients.size(), factor.coefficients.begin());
    const float radius = float(kLobeRadius * boundsOf(frame.positions()).radius());
    overlays_.drawLobe(factor, {at.positions[*shot.lobe], at.normals[*shot.lobe], at.tangents[*shot.lobe]}, radius,
                       view);
}

void OffscreenRenderer::drawCharacter(const Panel& panel, PosedFrame& frame, const FrameView& view) {
    if (path_ == EvaluationPath::kCpu || panel.channel == Channel::kTransferError)
        drawValues(panel, frame, view);
    else
        drawModel(panel, frame, view);
}

Image OffscreenRenderer::draw(const Panel& panel, PosedFrame& frame, const FrameView& view) {
    drawCharacter(panel, frame, view);
    drawOverlays(panel, frame, view);
    return target_.read();
}

Image OffscreenRenderer::drawWithoutOverlays(const Panel& panel, PosedFrame& frame, const FrameView& view) {
    drawCharacter(panel, frame, view);
    return target_.read();
}

Image OffscreenRenderer::drawSky(const FrameView& view) {
    if (!sky_) {
        sky_.emplace();
        sky_->upload(skyPicture(asset_->lights[shading_->light()]));
    }
    target_.begin();
    sky_->draw(view, shading_->lightRotation());
    Image sky = target_.read();
    sky.alpha.clear();
    return sky;
}

void putBehind(Image& image, const Image& background) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] += background.pixels[i] * (1 - image.alpha[i]);
    image.alpha.clear();
}

void putBehind(Image& image, Vec3 background) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] += background * (1 - image.alpha[i]);
    image.alpha.clear();
}

Image forDisplay(Image image, Channel channel) {
    if (channel != Channel::kNormals) return image;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float alpha = image.alpha.empty() ? 1 : image.alpha[i];
        if (alpha == 0) continue;
        for (int c = 0; c < 3; ++c) image.pixels[i][c] = alpha * linearFromSrgb(image.pixels[i][c] / alpha);
    }
    return image;
}

RenderResult renderOffscreen(const RenderOptions& options, const AssetView& asset, const AssetView* truth,
                             int threads) {
    const Shot shot = resolveShot(options, asset, truth);
    PosedFrame frame(shot, threads);
    frame.pose(shot.frame, truth ? std::optional(shot.truth_frame) : std::nullopt);
    const FrameView view = makePictureView(options, asset, frame.positions());
    OffscreenRenderer renderer(options, shot);
    RenderResult result{renderer.draw({options.channel, options.source}, frame, view), renderer.gl(), renderer.path()};
    if (options.background) putBehind(result.image, *options.background);
    if (options.light_background && shot.shaded) putBehind(result.image, renderer.drawSky(view));
    return result;
}

}  // namespace penumbra
