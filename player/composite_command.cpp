// penumbra-player composite S.json --plate P.%03d.jpg -o OUT.%03d.png: characters and their shadows in photographs.
#include <algorithm>
#include <cstdio>

#include "formats/camera/camera_file.h"
#include "formats/common/errors.h"
#include "formats/common/warning.h"
#include "formats/image/exif_orientation.h"
#include "player/cast_flags.h"
#include "player/composite/photograph_frames.h"
#include "player/composite/picture_stream.h"
#include "player/composite/plate_grain.h"
#include "player/composite/plate_poses.h"
#include "player/look_flags.h"
#include "player/picture_flags.h"
#include "player/player_verbs.h"
#include "player/render/frame_list.h"

namespace penumbra {

namespace {

// How photographs without a pose are treated.
enum class WithoutPose { kRefuse, kKeep };
constexpr Word<WithoutPose> kWithoutPoseWords[] = {{"refuse", WithoutPose::kRefuse}, {"keep", WithoutPose::kKeep}};

// How a .y4m mixes its colours, which it does not say.
enum class MatrixChoice { kByHeight, k601, k709 };
constexpr Word<MatrixChoice> kMatrixWords[] = {
    {"auto", MatrixChoice::kByHeight}, {"bt601", MatrixChoice::k601}, {"bt709", MatrixChoice::k709}};
std::optional<Y4mMatrix> matrixOf(MatrixChoice choice) {
    if (choice == MatrixChoice::kByHeight) return std::nullopt;
    return choice == MatrixChoice::k709 ? Y4mMatrix::k709 : Y4mMatrix::k601;
}

struct CompositeCommand {
    std::filesystem::path scene, plate, output, character, alpha;
    std::string response = "srgb";
    double exposure = 1;
    std::optional<double> time, fps;
    MatrixChoice matrix = MatrixChoice::kByHeight;
    bool grain = false, resume = false;
    WithoutPose without_pose = WithoutPose::kRefuse;
    bool shadow = true, bounce = true;
    RenderOptions options;

    std::vector<std::filesystem::path> inputs() const { return namedFiles({scene, character, alpha}); }
};

// Everything that one run has open.
struct CompositeRun {
    const CompositeCommand& command;
    PosedScene scene;
    PhotographFrames frames;
    PlateSource source;
    PlatePoses poses;
    PictureSink sink;
    Composer composer;
    std::optional<Image> character;
    std::optional<PlateGrain> grain;
    std::size_t written = 0, skipped = 0, kept = 0;
    PhotographFrames::Cost cost;  // sums

    CompositeRun(const CompositeCommand& options, SceneDescription description, const CommonOptions& common)
        : command(options),
          scene(std::move(description)),
          frames(scene, options.options, common.threads, options.character.empty()),
          source(options.plate, matrixOf(options.matrix)),
          poses(frames.cameras(), source.files()),
          sink(options.output, source.header(), options.fps.value_or(25), matrixOf(options.matrix)),
          composer(readResponse(options.response), float(options.exposure)) {
        if (!options.character.empty()) character = readCharacter(options.character, options.alpha);
        frames.setParts({options.shadow, options.bounce});
    }

    // Codes become the radiance that the camera would have seen.
    Image readCharacter(const std::filesystem::path& path, const std::filesystem::path& coverage) const {
        Image image = composer.radianceOf(readPlate(path));
        if (coverage.empty() && image.alpha.empty())
            throw InvalidInput(path.string() + ": has no alpha; --alpha takes it from a picture");
        if (coverage.empty()) return image;
        const TexturePicture alpha = readTexture(coverage, coverage.string());
        if (alpha.width != image.width || alpha.height != image.height)
            throw InvalidInput(coverage.string() + ": has another size than " + path.string());
        image.alpha.resize(image.pixels.size());
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            image.alpha[i] = float(alpha.rgb[3 * i]) / 255;
            image.pixels[i] *= image.alpha[i];
        }
        return image;
    }
};

std::string sizeText(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

void checkSize(const CompositeRun& run, int width, int height, const std::string& of) {
    const PinholeCamera& camera = run.frames.camera();
    if (width == camera.width && height == camera.height) return;
    throw InvalidInput(of + ": has " + sizeText(width, height) + " pixels, and the scene's camera has " +
                       sizeText(camera.width, camera.height));
}

std::string plateName(const CompositeRun& run, std::size_t i) {
    return run.source.files().empty() ? "picture " + std::to_string(i) : run.source.files()[i].string();
}

// The clip's time is that of the pose, so that a part of the photographs becomes what it becomes among all.
void computeFrame(CompositeRun& run, std::size_t i, PhotographFrame& frame) {
    const std::size_t picture = *run.poses.pictureOf(i);
    std::optional<double> seconds = run.command.time;
    if (run.command.fps) seconds = seconds.value_or(0) + double(picture) / *run.command.fps;
    run.frames.compute(picture, seconds, frame);
    const PhotographFrames::Cost& cost = run.frames.cost();
    run.cost.shade += cost.shade;
    run.cost.light += cost.light;
    run.cost.ground += cost.ground;
    run.cost.draw += cost.draw;
}

void composeOne(CompositeRun& run, std::size_t i, const Plate& plate, int threads) {
    checkSize(run, plate.width(), plate.height(), plateName(run, i));
    PhotographFrame frame;
    if (run.poses.hasPose(i)) {
        computeFrame(run, i, frame);
    } else {  // the photograph stays as it is
        frame.ratio.assign(std::size_t(plate.width()) * std::size_t(plate.height()), Vec3{1, 1, 1});
        ++run.kept;
    }
    const bool other = run.character && run.poses.hasPose(i);
    const Addition addition{other ? *run.character : frame.characters, frame.ratio};
    const std::size_t number = run.source.numberOf(i);
    if (run.sink.isLinear()) {
        run.sink.write(number, run.composer.composeLinear(plate, addition, threads));
    } else {
        TexturePicture picture = run.composer.compose(plate, addition, {}, threads);
        if (run.command.grain && !plate.isLinear()) {
            if (!run.grain) run.grain = measureGrain(plate.codes);
            picture = run.composer.compose(plate, addition, grainFor(*run.grain, picture, number), threads);
        }
        run.sink.write(number, picture);
    }
    ++run.written;
}

// Tells whether picture i is there already.
bool isDone(CompositeRun& run, std::size_t i) {
    const PinholeCamera& camera = run.frames.camera();
    return run.command.resume && run.sink.has(run.source.numberOf(i), camera.width, camera.height);
}

void composeAll(CompositeRun& run, const CommonOptions& common) {
    const std::size_t total = run.source.count().value_or(0);
    Progress progress(total ? common.progress : ProgressStyle::kNone, "composing", "pictures",
                      double(std::max<std::size_t>(total, 1)));
    Plate plate;
    for (std::size_t i = 0; !total || i < total; ++i) {
        throwIfInterrupted();
        if (total && isDone(run, i)) {
            ++run.skipped;
            continue;
        }
        if (!run.source.read(i, plate)) break;
        if (!total && !run.poses.pictureOf(i)) {
            reportWarning("penumbra-player", run.command.plate.string() + ": has more pictures than the " +
                                                 std::to_string(i) + " poses: the composite ends at the last pose");
            break;
        }
        composeOne(run, i, plate, common.threads);
        if (total) progress.update(double(i + 1));
    }
    run.sink.finish();
}

void checkComposite(const CompositeCommand& command) {
    const bool many =
        command.plate == "-" || command.plate.extension() == ".y4m" || FramePattern::looksLikeOne(command.plate);
    const bool video = command.output == "-" || command.output.extension() == ".y4m";
    if (many && !video && !FramePattern::looksLikeOne(command.output))
        throw BadOption("output", "is one file for many pictures; put %d or %04d into its name");
    if (!many && FramePattern::looksLikeOne(command.output))
        throw BadOption("output", "has a number in its name, and --plate is one picture");
    if (command.resume && video) throw BadOption("resume", "a .y4m is written whole; files of pictures can be resumed");
    if (command.grain && command.output.extension() == ".exr")
        reportWarning("penumbra-player", "--grain: an .exr has none");
}

void reportComposite(const CompositeRun& run, double seconds, const CommonOptions& common, Report& report) {
    const double each = double(std::max<std::size_t>(run.written, 1));
    report.figures["pictures"] = run.written;
    report.figures["skipped"] = run.skipped;
    report.figures["without_pose"] = run.kept;
    report.figures["suns"] = run.frames.sunCount();
    report.figures["milliseconds_a_picture"] = {{"all", 1000 * seconds / each},
                                                {"shade", run.cost.shade / each},
                                                {"light", run.cost.light / each},
                                                {"ground", run.cost.ground / each},
                                                {"draw", run.cost.draw / each}};
    if (run.kept > 0)
        reportWarning("penumbra-player", std::to_string(run.kept) + " photographs have no pose and stay as they are");
    if (!common.quiet)
        std::fprintf(run.command.output == "-" ? stderr : stdout,
                     "%s: %zu pictures, %zu were there, %.1f ms each (shading %.1f, light of characters %.1f, ground "
                     "%.1f, drawing %.1f)\n",
                     run.command.output.c_str(), run.written, run.skipped, 1000 * seconds / each, run.cost.shade / each,
                     run.cost.light / each, run.cost.ground / each, run.cost.draw / each);
}

// Says why photograph i has no pose.
std::string reasonWithout(const CompositeRun& run, std::size_t i) {
    const SceneCameras& cameras = run.frames.cameras();
    try {
        if (const auto picture = run.poses.pictureOf(i)) (void)cameras.view(*picture, {});
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    const bool named = std::ranges::any_of(cameras.files(), [](const std::string& file) { return !file.empty(); });
    const std::string at = run.command.scene.string() + ": /camera/poses: ";
    if (named) return at + "no frame has the name or the number of " + plateName(run, i);
    return at + "has " + std::to_string(cameras.count()) + " poses for " +
           std::to_string(run.source.count().value_or(0)) + " pictures";
}

// Refuses photographs without a pose before the first one is written.
void requirePoses(const CompositeRun& run) {
    const std::vector<std::size_t> without = run.poses.without();
    const std::size_t count = run.source.count().value_or(run.frames.cameras().count());
    if (without.empty() || (run.command.without_pose == WithoutPose::kKeep && without.size() < count)) return;
    std::string text = reasonWithout(run, without.front());
    if (without.size() < count && count > 1)
        text += ". " + std::to_string(without.size()) + " of " + std::to_string(count) +
                " photographs have no pose; --without-pose keep leaves them as they are";
    throw InvalidInput(text);
}

void runComposite(CompositeCommand& command, const CommonOptions& common, Report& report) {
    checkComposite(command);
    report.phase("read");
    SceneDescription description = readScene(command.scene);
    report.willRead(filesNamedIn(description));
    CompositeRun run(command, std::move(description), common);
    report.willRead(run.source.files());
    if (const std::string turned = findTurned(run.source.files()); !turned.empty())
        reportWarning("penumbra-player", turned);
    if (run.character) checkSize(run, run.character->width, run.character->height, command.character.string());
    if (!run.sink.isStream() && FramePattern::looksLikeOne(command.output)) {
        std::vector<std::filesystem::path> files;
        for (std::size_t i = 0; i < run.source.count().value_or(0); ++i)
            files.push_back(run.sink.fileOf(run.source.numberOf(i)));
        if (!command.resume) report.willWrite(files);
    }
    requirePoses(run);
    if (common.dry_run) {
        std::fprintf(command.output == "-" ? stderr : stdout, "would compose %zu pictures to %s\n",
                     run.source.count().value_or(0), command.output.c_str());
        return;
    }
    report.phase("compose");
    const auto start = std::chrono::steady_clock::now();
    composeAll(run, common);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    reportComposite(run, seconds, common, report);
}

void defineComposite(CLI::App& app, CompositeCommand& command) {
    app.add_option("scene", command.scene, "S.json with the camera of the photographs (docs/scene.md)")->required();
    app.add_option("--plate", command.plate,
                   "the photographs: P.jpg, P.png or P.exr (linear light), P.%03d.jpg, P.y4m, or - for a .y4m on "
                   "standard input")
        ->required();
    app.add_option("-o,--output", command.output,
                   "OUT.png or OUT.exr (linear light), OUT.%03d.png, OUT.y4m, or - for a .y4m on standard output")
        ->required();
    app.add_option("--response", command.response,
                   "response of the camera: srgb, linear, rec709, or a file of penumbra-fit response");
    app.add_option("--exposure", command.exposure,
                   "exposure of the photographs: light of 1 times this has the highest code")
        ->check(aboveZero());
    CLI::Option* character = app.add_option(
        "--character", command.character,
        "CHARACTER.exr with alpha: radiance of characters that another program drew, instead of ours; or codes of "
        "the camera, with --alpha");
    app.add_option("--alpha", command.alpha,
                   "ALPHA.png: how much --character covers of each pixel, linear; its colours are multiplied by it")
        ->needs(character);
    app.add_option("--fps", command.fps,
                   "pictures a second: characters move along their clips (default: they stand still)")
        ->check(aboveZero());
    addChoice(app, "--without-pose", command.without_pose, kWithoutPoseWords,
              "photographs without a pose: refuse them, or keep them as they are");
    addChoice(app, "--matrix", command.matrix, kMatrixWords,
              "how a .y4m mixes its colours; auto: bt709 from 720 rows on, bt601 below");
    app.add_flag("--grain", command.grain, "give characters the grain of the photographs");
    app.add_flag("--resume", command.resume, "keep pictures that exist and are complete");
    app.add_flag("!--no-shadow", command.shadow, "leave the ground as it is, for comparison");
    app.add_flag("!--no-bounce", command.bounce, "without the light from characters on the ground, for comparison");
    addTimeFlag(app, command.time);
    addTextureFlag(app, command.options.textures);
    addSunFlags(app, command.options.suns, command.options.sun_map);
    addChoice(app, "--aa", command.options.samples, kSampleWords, "samples a pixel")->group(kPictureGroup);
    addChoice(app, "--gl", command.options.backend, kGlWords, "what draws; auto: a GPU, else software")
        ->group(kPictureGroup);
}

}  // namespace

Verb compositeVerb() {
    Verb verb =
        verbOf<CompositeCommand>("composite", "Put the characters of a scene and their shadows into photographs.",
                                 defineComposite, runComposite);
    verb.output = [output = verb.output] {
        const std::filesystem::path path = output();
        return path == "-" || FramePattern::looksLikeOne(path) ? std::filesystem::path() : path;
    };
    verb.names_outputs = true;
    return verb;
}

}  // namespace penumbra
