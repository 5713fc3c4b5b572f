#include "player/bench/bench_characters.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "formats/common/parallel_for.h"
#include "player/draw/draw_frame.h"
#include "player/frame/framed_rest.h"
#include "player/gl/offscreen_target.h"
#include "sh/camera.h"

namespace penumbra {

namespace {

// Returns the bytes that the program has from malloc and not given back; 0 where another allocator is in its place
// (sanitizers).
std::size_t allocatedBytes() {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

struct Character {
    Evaluator evaluator;
    FrameVertices vertices;
    std::vector<Vec3> radiance;
    Vec3 offset;
};

// Places everybody on a square on the ground, 1.2 radii apart.
Vec3 placeOf(int index, int count, double radius) {
    const int columns = int(std::ceil(std::sqrt(count)));
    const double middle = 0.5 * (columns - 1);
    return toFloat(Vec3d{index % columns - middle, 0, index / columns - middle} * (1.2 * radius));
}

class Crowd {
public:
    Crowd(const Shot& shot, ShadingSet* shading, const Evaluator& first, int count, int threads)
        : asset_(shot.asset), shading_(shading), threads_(threads) {
        radius_ = restBox(*asset_).radius();
        characters_.reserve(std::size_t(count));
        for (int i = 0; i < count; ++i) {
            Character& c = characters_.emplace_back(Character{first, {}, {}, placeOf(i, count, radius_)});
            c.radiance.resize(c.evaluator.vertexCount());
        }
        poseAndSkin(0);  // makes the result arrays
        evaluate();
    }

    // Gives whole characters to each thread, or pieces of each where there are fewer of them than threads.
    template <class Body>
    void each(const Body& body) {
        const bool split = int(characters_.size()) < threads_;
        if (split)
            for (std::size_t i = 0; i < characters_.size(); ++i) body(i, characters_[i], threads_);
        else
            parallelFor(characters_.size(), threads_, [&](std::size_t i) { body(i, characters_[i], 1); });
    }
    void poseAndSkin(std::size_t run) {
        each([&](std::size_t i, Character& c, int threads) {
            const std::size_t frame = (run + 7 * i) % asset_->animation.frameCount();
            c.evaluator.setFrame(frame);
            skinFrame(c.evaluator, threads, c.vertices);
        });
    }
    void evaluate() {
        each([&](std::size_t, Character& c, int threads) { evaluateSkinned(c.evaluator, threads, c.vertices); });
    }
    void shade() {
        if (!shading_) return;
        each([&](std::size_t, Character& c, int threads) {
            shadeFrame(*shading_, c.vertices, eye_ - c.offset, threads, c.radiance);
        });
    }
    void lookAt(const RenderOptions& options) {
        std::vector<Vec3> corners;
        for (const Character& c : characters_)
            for (const Vec3& p : {c.vertices.positions.front(), c.vertices.positions.back()})
                corners.push_back(p + c.offset);
        const double radius = radius_ * std::max(1.0, 0.85 * std::ceil(std::sqrt(double(characters_.size()))));
        const Camera camera = makeCamera(options.camera, corners, radius, defaultPitch(asset_->mesh.positions));
        clipFromModel(camera, double(options.width) / options.height, radius, view_.clip_from_model);
        eye_ = toFloat(cameraPosition(camera));
        view_.display = DisplayTransform();
    }
    // Measures the GLSL path, where each character looks like the first.
    GpuCost onGpu(const OffscreenTarget& target, bool software, int runs) const {
        const auto asset = std::make_shared<GlAsset>(*asset_, shading_, &characters_.front().evaluator);
        std::vector<PosedCharacter> posed;
        for (const Character& c : characters_) {
            posed.push_back({&c.evaluator, placedAt(c.offset), shading_});
            if (asset->needsCoefficients()) posed.back().coefficients = c.vertices.coefficients;
        }
        const Channel channel = shading_ ? Channel::kShaded : Channel::kAmbient;
        FrameView view = view_;
        view.eye = eye_;
        return measureGpuCost(asset, channel, posed, view, target, software, runs);
    }
    const ShadingSet* shading() const { return shading_; }
    void draw(ValuePainter& painter) const {
        for (const Character& c : characters_) {
            FrameView view = view_;
            for (std::size_t row = 0; row < 4; ++row)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    view.clip_from_model[12 + row] += view_.clip_from_model[4 * axis + row] * c.offset[int(axis)];
            painter.upload(c.vertices.positions, c.radiance, {c.vertices.normals, c.vertices.tangents, {}});
            painter.draw(view);
        }
    }

private:
    const AssetView* asset_;
    ShadingSet* shading_;
    int threads_;
    double radius_ = 1;
    std::vector<Character> characters_;
    FrameView view_;
    Vec3 eye_;
};

void measureCpu(Crowd& crowd, int runs, CharactersCost& cost) {
    cost.pose_skin = timeRuns(runs, [&](std::size_t run) { crowd.poseAndSkin(run); }).median;
    cost.evaluate = timeRuns(runs, [&](std::size_t) { crowd.evaluate(); }).median;
    cost.shade = timeRuns(runs, [&](std::size_t) { crowd.shade(); }).median;
}

void measureGl(const RenderOptions& options, const Crowd& crowd, const AssetView& asset, bool software, int runs,
               CharactersCost& cost) {
    const OffscreenTarget target(options.width, options.height, options.samples, GL_RGBA8);
    ValuePainter painter(asset.mesh, Channel::kShaded, Sides::kSeen, 0, crowd.shading());
    cost.draw = timeRuns(runs, [&](std::size_t) {
                    target.begin();
                    crowd.draw(painter);
                    gl::Finish();
                }).median;
    cost.glsl = crowd.onGpu(target, software, runs);
}

}  // namespace

std::vector<CharactersCost> benchCharacters(const RenderOptions& options, const Shot& shot, ShadingSet* shading,
                                            std::vector<int> counts, int runs, int threads) {
    if (counts.empty()) return {};
    counts.push_back(1);
    std::sort(counts.begin(), counts.end());
    counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
    if (threads <= 0) threads = hardwareThreads();
    const std::size_t before = allocatedBytes();
    const Evaluator first(*shot.asset);
    const std::size_t decoded = allocatedBytes() - before;
    const std::unique_ptr<GlContext> context = createGlContext(options.backend);
    std::vector<CharactersCost> costs;
    for (int count : counts) {
        CharactersCost& cost = costs.emplace_back();
        cost.count = count;
        cost.bytes_decoded = decoded;
        const std::size_t without = allocatedBytes();
        Crowd crowd(shot, shading, first, count, threads);
        cost.bytes_each = (allocatedBytes() - without) / std::size_t(count);
        crowd.lookAt(options);
        const int some = std::max(3, runs / count);
        measureCpu(crowd, some, cost);
        measureGl(options, crowd, *shot.asset, context->software, std::max(3, some / 4), cost);
    }
    return costs;
}

}  // namespace penumbra
