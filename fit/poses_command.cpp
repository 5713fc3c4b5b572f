// penumbra-fit poses FRAMES... --camera cam.json --tag FAMILY:ID:SIDE -o poses.json: where the camera stood.
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "fit/fit_verbs.h"
#include "fit/report/residual_report.h"
#include "formats/cache/numbered_files.h"
#include "formats/camera/colmap_model.h"
#include "formats/camera/tag_track.h"
#include "formats/capture/capture_words.h"
#include "formats/capture/tag_edges.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/progress.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"
#include "formats/image/exif_orientation.h"

namespace penumbra {

namespace {

enum class Gaps { kFill, kLeave };
constexpr Word<Gaps> kGapWords[] = {{"fill", Gaps::kFill}, {"leave", Gaps::kLeave}};

constexpr double kMinMargin = 0.2;  // below it the mirrored pose fits nearly as well

// Puts the files of a sequence in the place of the pattern that names them.
std::vector<std::filesystem::path> listed(const std::vector<std::filesystem::path>& named) {
    std::vector<std::filesystem::path> out;
    for (const std::filesystem::path& one : named) {
        if (!namesSequence(one)) {
            out.push_back(one);
            continue;
        }
        const NumberedFiles files = findNumberedFiles(one, {".jpg", ".jpeg", ".png"});
        out.insert(out.end(), files.files.begin(), files.files.end());
    }
    return out;
}

struct PosesCommand {
    std::vector<std::filesystem::path> pictures;
    std::filesystem::path camera, colmap, output;
    std::vector<TagChoice> tags;
    std::string response = "srgb";
    Gaps gaps = Gaps::kFill;
    double smooth = 0;

    std::vector<std::filesystem::path> inputs() const {
        if (!colmap.empty()) return {colmap / "cameras.txt", colmap / "images.txt"};
        std::vector<std::filesystem::path> files = listed(pictures);
        files.push_back(camera);
        return namedFiles(files);
    }
};

struct TagSearch {
    std::vector<TagFrame> frames;
    std::size_t clipped = 0;            // frames whose paper is clipped
    double milliseconds = 0;            // a frame, detection alone
    std::size_t seen(bool any) const {  // frames with a tag, or without one
        return std::size_t(std::ranges::count_if(frames, [any](const TagFrame& f) { return f.tags.empty() != any; }));
    }
};

TexturePicture readFrame(const std::filesystem::path& file, const PinholeCamera& camera) {
    TexturePicture picture = readTexture(file, file.string());
    if (picture.width != camera.width || picture.height != camera.height)
        throw InvalidInput(file.string() + ": has " + std::to_string(picture.width) + " x " +
                           std::to_string(picture.height) + " pixels, and the camera has " +
                           std::to_string(camera.width) + " x " + std::to_string(camera.height));
    return picture;
}

TagSearch search(const PosesCommand& command, const PinholeCamera& camera, const CommonOptions& common) {
    const std::vector<std::filesystem::path> files = listed(command.pictures);
    if (const std::string turned = findTurned(files); !turned.empty()) reportWarning("penumbra-fit", turned);
    const CameraResponse response = readResponse(command.response);
    std::vector<TagFamily> families;
    for (const TagChoice& tag : command.tags) families.push_back(tag.family);
    TagDetector detector(families, std::max(1, common.threads));
    TagSearch out;
    Progress progress(common.progress, "finding tags", "pictures", double(files.size()));
    for (const std::filesystem::path& file : files) {
        const TexturePicture picture = readFrame(file, camera);
        const auto start = std::chrono::steady_clock::now();
        std::vector<DetectedTag> found = detector.detect(picture, response);
        refineCorners(picture, camera, response, command.tags, found);
        const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
        out.milliseconds += took.count() / double(files.size());
        out.frames.push_back(chosenTags(file.string(), found, command.tags));
        out.clipped += std::ranges::any_of(out.frames.back().tags,
                                           [](const DetectedTag& tag) { return tag.paper_code >= kMaxCode; });
        progress.update(double(out.frames.size()));
    }
    return out;
}

CameraTrack trackOf(const PosesCommand& command, const PinholeCamera& camera, const TagSearch& found) {
    const TagPlaces places = placeTags(camera, command.tags, found.frames);
    CameraTrack track{camera, {}};
    for (const TagFrame& frame : found.frames) {
        TrackFrame& one = track.frames.emplace_back();
        one.file = frame.file;
        const std::optional<PoseEstimate> pose = poseInFrame(camera, command.tags, places, frame);
        if (!pose) continue;
        one.pose = pose->pose;
        one.margin = std::clamp(pose->margin, 0.0, 1.0);
        one.residual = pose->residual;
    }
    for (std::size_t k = 1; k < places.size(); ++k)
        if (!places[k])
            reportWarning("penumbra-fit", std::string("tag ") + nameOf(command.tags[k].family) + ":" +
                                              std::to_string(command.tags[k].id) +
                                              " is never seen together with a tag whose place is known: left out");
    return track;
}

// Warns of what makes poses worse. Throws InvalidInput where the camera is not that of the pictures.
void warnOf(const CameraTrack& track, const TagSearch& found) {
    std::vector<double> residuals;
    std::size_t doubtful = 0;
    for (const TrackFrame& frame : track.frames) {
        if (!frame.pose) continue;
        residuals.push_back(frame.residual);
        doubtful += frame.margin < kMinMargin;
    }
    const auto of = [&](std::size_t count) {
        return std::to_string(count) + " of " + std::to_string(track.frames.size()) + " pictures: ";
    };
    const auto warn = [](const std::string& text) { reportWarning("penumbra-fit", text); };
    if (found.clipped > 0)
        warn(of(found.clipped) +
             "the paper of the tag is clipped, which moves its corners: expose so that it stays "
             "below code 250");
    if (doubtful > 0) warn(of(doubtful) + "the mirrored pose fits nearly as well: come nearer, or print a larger tag");
    if (const std::size_t none = found.seen(false); none > 0)
        warn(of(none) + "no tag is seen; the first is " +
             std::ranges::find_if(found.frames, [](const TagFrame& f) { return f.tags.empty(); })->file);
    std::ranges::sort(residuals);
    judgeResidual(found.frames.front().file + ": half of the tags are", residuals[residuals.size() / 2], track.camera);
}

// Turns the model of structure from motion into a track.
void runColmap(const PosesCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    CameraTrack track = readColmapModel(command.colmap);
    if (common.dry_run) {
        std::printf("would write %zu poses\n", track.frames.size());
        return;
    }
    if (command.smooth > 0) smoothTrack(track.frames, command.smooth);
    report.figures = {{"pictures", track.frames.size()}};
    if (!common.quiet)
        std::printf("%s: %zu poses in a frame of unknown scale: penumbra-fit align brings them to a marker's\n",
                    command.output.c_str(), track.frames.size());
    report.phase("write");
    writeWholeFile(command.output, cameraTrackText(track));
}

void runPoses(const PosesCommand& command, const CommonOptions& common, Report& report) {
    if (!command.colmap.empty()) return runColmap(command, common, report);
    if (command.pictures.empty()) throw UsageError("pictures or --colmap: give one of them");
    if (command.camera.empty()) throw UsageError("--camera is required");
    if (command.tags.empty()) throw UsageError("--tag is required");
    report.phase("read");
    const PinholeCamera camera = readCamera(command.camera);
    if (common.dry_run) {
        std::printf("would find tags in %zu pictures\n", listed(command.pictures).size());
        return;
    }
    report.phase("find tags");
    const TagSearch found = search(command, camera, common);
    if (found.seen(true) == 0)
        throw InvalidInput(found.frames.front().file +
                           ": no such tag is seen in any picture; its family, id and "
                           "response must be those of the print and the camera");
    report.phase("poses");
    CameraTrack track = trackOf(command, camera, found);
    if (std::ranges::none_of(track.frames, [](const TrackFrame& frame) { return frame.pose.has_value(); }))
        throw InvalidInput(found.frames.front().file + ": the first tag is seen in no picture, and it is the marker");
    warnOf(track, found);
    const std::size_t filled = command.gaps == Gaps::kFill ? fillGaps(track.frames) : 0;
    if (command.smooth > 0) smoothTrack(track.frames, command.smooth);
    report.phase("write");
    writeWholeFile(command.output, cameraTrackText(track));
    report.figures = {{"pictures", track.frames.size()},
                      {"with_tags", found.seen(true)},
                      {"filled", filled},
                      {"clipped", found.clipped},
                      {"detection_ms", found.milliseconds}};
    for (const TrackFrame& frame : track.frames)
        report.figures["residual_px"].push_back(frame.pose && !frame.filled ? nlohmann::ordered_json(frame.residual)
                                                                            : nlohmann::ordered_json());
    if (!common.quiet)
        std::printf("%s: %zu of %zu pictures have a tag, %zu poses are filled in; %.1f ms a picture\n",
                    command.output.c_str(), found.seen(true), track.frames.size(), filled, found.milliseconds);
}

void definePoses(CLI::App& app, PosesCommand& command) {
    CLI::Option* frames = app.add_option(
        "frames", command.pictures,
        "pictures, JPEG or PNG, in the order of their times; a folder or a pattern as f.%03d.jpg names all");
    CLI::Option* camera =
        app.add_option("--camera", command.camera, "cam.json: f, cx, cy, size, k1, k2 (formats/README.md)");
    CLI::Option* colmap = app.add_option("--colmap", command.colmap,
                                         "folder of a text model of COLMAP (cameras.txt, images.txt), instead of "
                                         "pictures: its poses as they are, without metres")
                              ->excludes(frames)
                              ->excludes(camera);
    addTagOption(app, command.tags,
                 "FAMILY:ID:SIDE of printed tags, 36h11, 25h9, 16h5 or 4x4_50; side of its black square in metres; the "
                 "first is the marker's frame")
        ->excludes(colmap);
    app.add_option("--response", command.response, "srgb, linear, rec709 or a file of penumbra-fit response");
    addChoice(app, "--gaps", command.gaps, kGapWords,
              "pictures without a tag: a pose between those of their neighbours, or none");
    app.add_option("--smooth", command.smooth,
                   "standard deviation of a Gaussian over the poses, in pictures; it looks ahead as far as back, so "
                   "that nothing lags, and needs all pictures")
        ->check(within(0.0, 100.0));
    app.add_option("-o,--output", command.output, "poses.json to write")->required();
}

}  // namespace

Verb posesVerb() {
    return verbOf<PosesCommand, const PosesCommand>(
        "poses", "Find where a camera stood by printed tags in its pictures.", definePoses, runPoses);
}

}  // namespace penumbra
