// penumbra-fit capture (ball BRACKET.json | roam SHOTS.json) --at x/y/z -o E.exr: the light at a place, from
// photographs.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fit/camera/find_response.h"
#include "fit/fit_verbs.h"
#include "fit/report/capture_report.h"
#include "fit/report/residual_report.h"
#include "formats/camera/bracket_file.h"
#include "formats/camera/camera_file.h"
#include "formats/capture/ball_panorama.h"
#include "formats/capture/bracket_pose.h"
#include "formats/capture/capture_words.h"
#include "formats/capture/roam_panorama.h"
#include "formats/capture/shot_pictures.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/image/exif_orientation.h"
#include "sh/angles.h"
#include "sh/key_values.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

namespace {

enum class CaptureWay { kBall, kRoam };
constexpr Word<CaptureWay> kCaptureWords[] = {{"ball", CaptureWay::kBall}, {"roam", CaptureWay::kRoam}};

struct CaptureCommand {
    CaptureWay way = CaptureWay::kBall;
    std::filesystem::path list, output;
    std::optional<MirrorBall> ball;
    Vec3d at;
    double paper = 0;  // reflectance; 0: not given
    std::optional<TagChoice> tag;
    int width = 512;
    bool no_ground = false;

    std::vector<std::filesystem::path> inputs() const { return {list}; }
    Ground ground() const { return no_ground ? Ground::kNone : Ground::kLevel; }
};

void define(CLI::App& app, CaptureCommand& command) {
    addChoice(app, "way", command.way, kCaptureWords, "what was photographed: a mirror ball, or all that is around")
        ->required();
    app.add_option("list", command.list, "BRACKET.json or SHOTS.json: the pictures and their camera")->required();
    app.add_option("-o,--output", command.output, "E.exr to write, lat-long in the scene's frame")
        ->required()
        ->check(endsIn({".exr"}));
    addParsed(app, "--ball", command.ball, parseBall,
              "x/y/z,radius[,reflectance] of the ball, metres of the marker's frame");
    addParsed(app, "--at", command.at, parsePlace,
              "x/y/z where the light is wanted, the middle of the character, metres of the marker's frame")
        ->required();
    app.add_option("--paper", command.paper,
                   "reflectance of the marker's white paper: clipped pixels are raised until the paper has its light")
        ->check(aShare());
    addParsed(
        app, "--tag", command.tag, readTag,
        "FAMILY:ID:SIDE of the marker, as 36h11:3:0.7 (metres), where the list has none: whose paper is measured");
    app.add_flag("--no-ground", command.no_ground,
                 "count everything as far away, where no level ground z = 0 is around");
    app.add_option("--width", command.width, "pixels of the picture, which is half as high")
        ->check(within(16, 8192))
        ->capture_default_str();
}

// The contents of a list, with its pictures.
struct ReadShots {
    BracketFile list;
    std::vector<TexturePicture> pictures;
    CameraResponse response;
};

std::vector<std::filesystem::path> filesOf(const BracketFile& list) {
    std::vector<std::filesystem::path> files;
    for (const ExposedPicture& picture : list.pictures) files.push_back(picture.file);
    return files;
}

std::vector<double> exposuresOf(const BracketFile& list) {
    std::vector<double> exposures;
    for (const ExposedPicture& picture : list.pictures) exposures.push_back(picture.exposure);
    return exposures;
}

// Returns the response that the list names, or finds it in the pictures of a bracket.
CameraResponse responseOf(const CaptureCommand& command, const ReadShots& shots, Report& report) {
    const BracketFile& list = shots.list;
    if (list.response.empty()) throw InvalidInput(list.name + ": /: has no \"response\"");
    if (list.response != "find") return readResponse(list.response);
    if (command.way == CaptureWay::kRoam)
        throw InvalidInput(list.name +
                           ": /response: is \"find\", which needs a bracket: name the file that "
                           "penumbra-fit response made of one");
    const FoundResponse found = findResponse({list.name, shots.pictures, exposuresOf(list)});
    report.figures["response_rms"] = {found.channels[0].rms, found.channels[1].rms, found.channels[2].rms};
    return found.response;
}

ReadShots readPictures(const CaptureCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    ReadShots out;
    out.list = command.way == CaptureWay::kBall ? readBracket(command.list) : readShots(command.list);
    if (!out.list.camera) throw InvalidInput(out.list.name + ": /: has no \"camera\"");
    std::vector<std::filesystem::path> files = filesOf(out.list);
    report.willRead(files);
    if (const std::string turned = findTurned(files); !turned.empty()) reportWarning("penumbra-fit", turned);
    out.pictures = readShotPictures(files, *out.list.camera, common.threads);
    report.phase("response");
    out.response = responseOf(command, out, report);
    return out;
}

// Merges pictures [first, last) of the list, which have one pose.
PosedPicture mergeShots(const ReadShots& shots, const CameraPose& pose, std::size_t first, std::size_t last) {
    const std::vector<std::filesystem::path> files = filesOf(shots.list);
    const std::vector<double> exposures = exposuresOf(shots.list);
    const ExposureSet set{std::span(shots.pictures).subspan(first, last - first),
                          std::span(exposures).subspan(first, last - first),
                          std::span(files).subspan(first, last - first)};
    // In a walk around, some pictures may show nothing but a white wall.
    const bool is_all = set.pictures.size() == shots.pictures.size();
    if (const std::string problem = is_all ? findProblem(set) : findExposureProblem(set); !problem.empty())
        throw InvalidInput(problem);
    return {mergeExposures(set.pictures, set.exposures, shots.response), *shots.list.camera, pose};
}

CaptureSummary summaryOf(const CaptureCommand& command, const ReadShots& shots) {
    CaptureSummary out;
    out.name = command.output.string();
    out.pictures = shots.pictures.size();
    std::vector<double> exposures = exposuresOf(shots.list);
    std::ranges::sort(exposures);
    out.shortest = exposures.front();
    out.longest = exposures.back();
    const auto next = std::ranges::find_if(exposures, [&](double t) { return t > out.shortest * 1.01; });
    out.step = next == exposures.end() ? 1 : std::log2(*next / out.shortest);
    out.dark_stops = darkStops(shots.response);
    return out;
}

// Refuses a radiance that the file cannot hold: one above the largest half float, or light of which half is below the
// smallest one that has all its digits.
void requireHalfFloats(const Panorama& panorama, const std::string& list) {
    constexpr float kMax = 65504, kMin = 6.104e-5f;
    float most = 0;
    std::vector<float> light;
    for (const Vec3& pixel : panorama.radiance) {
        most = std::max({most, pixel.x, pixel.y, pixel.z});
        if (const float y = luminance(pixel); y > 0) light.push_back(y);
    }
    std::ranges::sort(light);
    if (const float middle = light.empty() ? kMin : light[light.size() / 2]; middle < kMin)
        throw InvalidInput(list + ": /pictures: half of the radiance is below " + shortest(double(middle)) +
                           ", less than half floats hold: divide every exposure by " +
                           shortest(std::exp2(std::ceil(std::log2(double(kMin / middle))) + 8)) + " or so");
    if (most > kMax)
        throw InvalidInput(list + ": /pictures: the brightest radiance is " + shortest(double(most)) +
                           ", more than half floats hold: multiply every exposure by " +
                           shortest(std::exp2(std::ceil(std::log2(double(most / kMax))))) + " or more");
}

// All that a panorama is put together from.
struct CaptureSources {
    ReadShots read;
    std::vector<PosedPicture> shots;
    std::optional<TagChoice> tag;       // tag whose paper is measured
    std::optional<BracketPose> by_tag;  // the pose, where it came from the tag
};

// Uses the paper as a light meter.
void raiseByPaper(const CaptureCommand& command, const CaptureSources& from, Panorama& panorama,
                  CaptureSummary& summary) {
    const std::string& list = from.read.list.name;
    if (!from.tag) throw UsageError("--paper: needs --tag FAMILY:ID:SIDE");
    if (summary.paper.places == 0) throw InvalidInput(list + ": no picture shows the paper around the tag");
    if (!summary.paper.found())
        throw InvalidInput(list + ": the paper is clipped in every picture that shows it: take a shorter exposure");
    Vec3d wanted;
    for (int c = 0; c < 3; ++c) wanted[c] = paperIrradiance(summary.paper.radiance[c], command.paper);
    summary.raised = raiseClipped(panorama, {0, 1, 0}, wanted);
}

// Fills, raises and writes what was put together.
void finish(const CaptureCommand& command, const CaptureSources& from, Panorama& panorama, Report& report,
            const CommonOptions& common) {
    CaptureSummary summary = summaryOf(command, from.read);
    summary.holes = fillHoles(panorama, command.ground());
    measurePanorama(panorama, summary);
    if (from.tag) summary.paper = measurePaper(from.shots, paperOf(*from.tag));
    if (command.paper > 0) raiseByPaper(command, from, panorama, summary);
    requireHalfFloats(panorama, from.read.list.name);
    if (!common.quiet) printCapture(summary);
    describeCapture(summary, report);
    if (from.by_tag && !common.quiet)
        std::printf("%s: the pose by the tag has a residual of %.2f pixels, its mirror a margin of %.2f\n",
                    command.output.c_str(), from.by_tag->estimate.residual, from.by_tag->estimate.margin);
    if (from.by_tag)
        report.figures["pose"] = {{"pictures", from.by_tag->pictures},
                                  {"residual", from.by_tag->estimate.residual},
                                  {"margin", from.by_tag->estimate.margin}};
    report.phase("write");
    writeExr(command.output, {panorama.width, panorama.height, std::move(panorama.radiance), {}});
}
TagChoice tagOfList(const BracketFile& list) {
    try {
        return parseTag(list.tag);
    } catch (const BadOption& error) {
        throw InvalidInput(list.name + ": /tag: " + error.problem);
    }
}

// Finds the pose of a bracket: that of the list, or by the list's tag, or by --tag.
CameraPose findPose(const CommonOptions& common, const RadiancePicture& merged, CaptureSources& from) {
    const BracketFile& list = from.read.list;
    if (list.pose) return *list.pose;
    if (!from.tag) throw InvalidInput(list.name + ": /: has neither \"tag\" nor a pose (\"R\", \"t\")");
    try {
        from.by_tag = poseOfBracket(from.read.pictures, *list.camera, from.read.response, *from.tag, common.threads);
    } catch (const std::invalid_argument& error) {
        throw InvalidInput(list.name + ": " + error.what());
    }
    from.by_tag = refineByEdges(merged, *list.camera, *from.tag, *from.by_tag);
    if (from.by_tag->clipped)
        reportWarning("penumbra-fit", list.name +
                                          ": the tag's paper is clipped in every picture that shows it: the pose "
                                          "is less exact");
    judgeResidual(list.name + ": the corners of the tag are", from.by_tag->estimate.residual, *list.camera);
    return from.by_tag->estimate.pose;
}

Panorama captureBall(const CaptureCommand& command, const CommonOptions& common, CaptureSources& from) {
    const BracketFile& list = from.read.list;
    from.shots.push_back(mergeShots(from.read, {}, 0, from.read.pictures.size()));
    from.shots[0].pose = findPose(common, from.shots[0].picture, from);
    try {
        const BallOutline outline = outlineOf(from.shots[0], *command.ball);
        if (outline.in_picture < 1)
            reportWarning("penumbra-fit", list.name + ": only " + shortest(std::round(100 * outline.in_picture)) +
                                              "% of the ball's outline lie in the picture");
    } catch (const std::invalid_argument& error) {
        throw InvalidInput(list.name + ": " + error.what());
    }
    return panoramaOfBall(from.shots[0], *command.ball,
                          {command.at, command.width, 2, common.threads, command.ground()});
}

// Pictures that follow one another and have the same pose are a bracket.
Panorama captureRoam(const CaptureCommand& command, const CommonOptions& common, CaptureSources& from) {
    const std::vector<ExposedPicture>& pictures = from.read.list.pictures;
    if (const std::string problem = findDarkness(from.read.pictures); !problem.empty())
        throw InvalidInput(from.read.list.name + ": /pictures: " + problem);
    for (std::size_t first = 0; first < pictures.size();) {
        const CameraPose& pose = *pictures[first].pose;
        std::size_t last = first + 1;
        while (last < pictures.size() && pictures[last].pose->rotation == pose.rotation &&
               pictures[last].pose->translation == pose.translation)
            ++last;
        from.shots.push_back(mergeShots(from.read, pose, first, last));
        first = last;
    }
    return panoramaOfPictures(from.shots, {command.at, command.width, 3, common.threads, command.ground()});
}

void checkOptions(const CaptureCommand& command) {
    const bool ball = command.way == CaptureWay::kBall;
    if (ball && !command.ball) throw UsageError("--ball: needed to capture a ball: x/y/z,radius[,reflectance]");
    if (!ball && command.ball) throw UsageError("--ball: only `capture ball` has one");
    if (command.width % 2 != 0) throw UsageError("--width: must be even, not " + std::to_string(command.width));
}

void run(CaptureCommand& command, const CommonOptions& common, Report& report) {
    checkOptions(command);
    CaptureSources from;
    from.read = readPictures(command, common, report);
    from.tag = command.tag;
    if (!from.tag && !from.read.list.tag.empty()) from.tag = tagOfList(from.read.list);
    if (common.dry_run) {
        std::printf("would put %zu pictures together and write %s\n", from.read.pictures.size(),
                    command.output.c_str());
        return;
    }
    report.phase("capture");
    Panorama panorama =
        command.way == CaptureWay::kBall ? captureBall(command, common, from) : captureRoam(command, common, from);
    finish(command, from, panorama, report, common);
}

}  // namespace

Verb captureVerb() {
    return verbOf<CaptureCommand>("capture", "The light at a place, from photographs of a mirror ball or all around.",
                                  define, run);
}

}  // namespace penumbra
