// penumbra-player render X.pnb -o OUT.(png|exr): frames as pictures.
#include <cstdio>

#include "formats/common/errors.h"
#include "formats/image/exposure.h"
#include "player/frame/open_asset.h"
#include "player/player_verbs.h"
#include "player/render/image_error.h"
#include "player/render/scene_picture.h"
#include "player/render_flags.h"
#include "player/render_report.h"
#include "player/scene/side_by_side.h"

namespace penumbra {

namespace {

struct RenderRun {
    const RenderCommand& command;
    BatchPlan plan;
    float exposure = 1;  // BatchResult::exposure
};

BatchPlan makePlan(const RenderCommand& command, const AssetView& asset, const AssetView* truth) {
    BatchPlan plan{command.options, resolveLook(command.options, asset, truth)};
    plan.chosen = chooseFrames(asset, command.frames.choice);
    plan.framing = command.frames.framing.value_or(command.frames.choice.sequence ? Framing::kClips : Framing::kFrame);
    if (FramePattern::looksLikeOne(command.output)) {
        const FramePattern pattern(command.output);
        for (const ListedFrame& frame : plan.chosen.frames) plan.files.push_back(pattern.name(frame.listed));
    } else {
        plan.files = {command.output};
    }
    plan.relative_error = truth && command.frames.choice.sequence;
    findTruth(plan);
    return plan;
}

void listFiles(const RenderRun& run) {
    const RenderOptions& options = run.plan.options;
    for (std::size_t i = 0; i < run.plan.files.size(); ++i) {
        const ListedFrame& at = run.plan.chosen.frames[i];
        std::printf("would draw frame %zu of clip %s, %d x %d pixels, to %s\n", at.number,
                    std::string(run.plan.look.asset->animation.clips[at.clip].name).c_str(), options.width,
                    options.height, run.plan.files[i].c_str());
    }
}

// Writes a picture over its background, if there is one. `exposure` is a factor on the colours of a shaded PNG.
void writePicture(const RenderOptions& options, const std::filesystem::path& file, Image image, float exposure) {
    const bool png = file.extension() == ".png";
    if (png && options.channel == Channel::kShaded) {
        if (options.tone != ToneMap::kOff) {
            image = toneMapped(std::move(image), exposure, options.tone);
            exposure = 1;
        }
        if (!options.background) return writePng(file, image, exposure);
        return writePng(file, overBackground(image, exposure, *options.background), 1);
    }
    if (options.background) putBehind(image, *options.background);
    if (png) image = forDisplay(std::move(image), options.channel);
    writeImage(file, image, 1);
}

BatchSink sinkOf(RenderRun& run, Progress& progress) {
    const auto write = [&run](std::size_t i, const Image& picture) {
        writePicture(run.plan.options, run.plan.files[i], picture, run.exposure);
    };
    return {.picture = write,
            .progress = [&progress](std::size_t done) { progress.update(double(done)); },
            .exposure = [&run](float exposure) { run.exposure = exposure; }};
}

BatchResult runFrames(RenderRun& run, const CommonOptions& common) {
    Progress progress(common.progress, "rendering", "frames", double(run.plan.chosen.frames.size()));
    return runBatch(run.plan, common.threads, sinkOf(run, progress));
}

// Prints how far a picture of a scene is from one by brute force, as a PNG of this exposure would show both.
void compareScene(const RenderCommand& command, const Image& image, const Image& truth, float exposure,
                  const CommonOptions& common, Report& report) {
    const ImageError error = imageError(image, truth, exposure, ImageMetrics::kRmseAndFlip, common.threads);
    report.figures["flip"] = error.flip();
    report.figures["image_rmse"] = error.rmse();
    if (!common.quiet)
        std::printf("against %s: FLIP %.4f, RMSE %.2f of 255\n", command.compared.c_str(), error.flip(), error.rmse());
}

// Reads the picture of --compare, if there is one.
std::optional<Image> readCompared(const RenderCommand& command) {
    if (command.compared.empty()) return std::nullopt;
    Image truth = readImage(command.compared);
    const RenderOptions& options = command.options;
    if (truth.width != options.width || truth.height != options.height)
        throw InvalidInput(command.compared.string() + ": has " + std::to_string(truth.width) + " x " +
                           std::to_string(truth.height) + " pixels, and --size asks for " +
                           std::to_string(options.width) + " x " + std::to_string(options.height));
    if (truth.alpha.empty()) throw InvalidInput(command.compared.string() + ": has no alpha");
    return truth;
}

// Returns what --scene says, or where several assets stand.
SceneDescription describedScene(const RenderCommand& command, Report& report) {
    if (!command.scene.empty()) {
        SceneDescription scene = readScene(command.scene);
        report.willRead(filesNamedIn(scene));
        return scene;
    }
    SceneDescription scene = sceneSideBySide(command.assets);
    for (SceneCharacter& one : scene.characters) one.material = command.options.brdf;
    scene.light.name = command.options.light;
    scene.light.rotation = command.options.light_rotation;
    return scene;
}

void runScene(const RenderCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    PosedScene scene(describedScene(command, report), command.cast);
    if (command.time) scene.pose(*command.time);
    const std::optional<Image> compared = readCompared(command);
    std::optional<OpenAsset> truth;
    if (!command.truth.empty()) truth.emplace(command.truth);
    const RenderOptions& options = command.options;
    report.figures = {{"members", scene.members().size()}, {"casters", scene.cast().casterCount()}};
    if (common.dry_run) {
        std::printf("would draw %zu characters and props, %zu of which cast, %d x %d pixels, to %s\n",
                    scene.members().size(), scene.cast().casterCount(), options.width, options.height,
                    command.output.c_str());
        return;
    }
    report.phase("frames");
    ScenePicture picture = drawScene(scene, options, common.threads, truth ? &truth->view : nullptr);
    const float automatic = automaticExposure(compared ? *compared : picture.image);
    if (compared) compareScene(command, picture.image, *compared, options.exposure.value_or(automatic), common, report);
    report.phase("write");
    const bool exposes = options.channel == Channel::kShaded && command.output.extension() == ".png";
    const float exposure = !exposes ? 1 : options.exposure.value_or(automatic);
    if (picture.sky) putBehind(picture.image, *picture.sky);
    writePicture(options, command.output, std::move(picture.image), exposure);
    if (exposes) reportExposure(options, exposure, common, report);
    if (!common.quiet)
        std::printf("%s: %zu characters and props, %zu of which cast\n", command.output.c_str(), scene.members().size(),
                    scene.cast().casterCount());
}

void runRender(RenderCommand& command, const CommonOptions& common, Report& report) {
    checkRender(command);
    if (command.isScene()) return runScene(command, common, report);
    report.phase("read");
    const OpenAsset asset(command.assets.front());
    std::optional<OpenAsset> truth;
    if (!command.truth.empty()) truth.emplace(command.truth);
    RenderRun run{command, makePlan(command, asset.view, truth ? &truth->view : nullptr)};
    if (FramePattern::looksLikeOne(command.output)) report.willWrite(run.plan.files);
    if (common.dry_run) return listFiles(run);

    report.phase("frames");
    const BatchResult result = runFrames(run, common);
    report.phase("write");
    if (command.frames.choice.sequence)
        reportBatch(run.plan, result, common, report);
    else
        reportFrame(run.plan, result, common, report);
}

}  // namespace

Verb renderVerb() {
    Verb verb = verbOf<RenderCommand>("render", "Draw frames of an asset or a scene, without a window.", defineRender,
                                      runRender);
    verb.output = [output = verb.output] {  // a plain name is known before the asset is read
        return FramePattern::looksLikeOne(output()) ? std::filesystem::path() : output();
    };
    verb.names_outputs = true;
    return verb;
}

}  // namespace penumbra
