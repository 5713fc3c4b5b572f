// penumbra-fit align A.poses.json B.poses.json -o OUT.poses.json: two tracks of one camera in one frame.
#include <cstdio>
#include <map>
#include <set>

#include "fit/camera/align_tracks.h"
#include "fit/fit_verbs.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

// Below this spread of the cameras about the marker, scale and place are told badly.
constexpr double kLittleSpreadDegrees = 15;

struct AlignCommand {
    std::filesystem::path a, b, output;

    std::vector<std::filesystem::path> inputs() const { return {a, b}; }
};

void defineAlign(CLI::App& app, AlignCommand& command) {
    app.add_option("a", command.a, "A.poses.json: the track whose frame and metres stay, as of a marker")->required();
    app.add_option("b", command.b, "B.poses.json: the track that is brought there, in any frame and scale")->required();
    app.add_option("-o,--output", command.output, "poses.json to write: B in A's frame, and A where B has no pose")
        ->required();
}

// Every picture of A, with the pose of B where there is one, and then those that only B has.
CameraTrack joinedTrack(const CameraTrack& a, const CameraTrack& b, const FrameMap& map) {
    const auto nameOf = [](const TrackFrame& frame) { return std::filesystem::path(frame.file).filename().string(); };
    std::map<std::string, const TrackFrame*> by_name;
    for (const TrackFrame& frame : b.frames)
        if (!frame.file.empty()) by_name[nameOf(frame)] = &frame;
    CameraTrack out{a.camera, {}};
    std::set<const TrackFrame*> used;
    for (std::size_t i = 0; i < a.frames.size(); ++i) {
        TrackFrame& frame = out.frames.emplace_back(a.frames[i]);
        const TrackFrame* other = nullptr;
        if (const auto found = by_name.find(nameOf(frame)); found != by_name.end())
            other = found->second;
        else if (by_name.empty() && frame.file.empty() && i < b.frames.size())
            other = &b.frames[i];
        if (!other) continue;
        used.insert(other);
        if (!other->pose) continue;
        const std::string file = frame.file;
        frame = *other;
        frame.file = file;
        frame.pose = poseInA(map, *other->pose);
    }
    for (const TrackFrame& frame : b.frames) {
        if (used.contains(&frame)) continue;
        out.frames.push_back(frame);
        if (frame.pose) out.frames.back().pose = poseInA(map, *frame.pose);
    }
    return out;
}

AlignedFrames alignTracks(const AlignCommand& command, const CameraTrack& a, const CameraTrack& b,
                          std::size_t& pictures) {
    try {
        if (a.camera.width != b.camera.width || a.camera.height != b.camera.height)
            throw InvalidInput("have cameras of different sizes, " + std::to_string(a.camera.width) + "x" +
                               std::to_string(a.camera.height) + " and " + std::to_string(b.camera.width) + "x" +
                               std::to_string(b.camera.height) + ": they must be tracks of one camera");
        std::vector<PosePair> pairs;
        for (const FramePair& pair : pairFrames(a, b))
            pairs.push_back({*a.frames[pair.a].pose, *b.frames[pair.b].pose});
        pictures = pairs.size();
        return alignFrames(pairs);
    } catch (const InvalidInput& problem) {
        throw InvalidInput(command.a.string() + " and " + command.b.string() + ": " + problem.what());
    }
}

void runAlign(const AlignCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const CameraTrack a = readCameraTrack(command.a), b = readCameraTrack(command.b);
    if (common.dry_run) {
        std::printf("would join tracks of %zu and %zu pictures\n", a.frames.size(), b.frames.size());
        return;
    }
    report.phase("fit");
    std::size_t pictures = 0;
    const AlignedFrames found = alignTracks(command, a, b, pictures);
    if (found.spread < kLittleSpreadDegrees) {
        char text[160];
        std::snprintf(text, sizeof text,
                      "the cameras stand within %.1f degrees about the marker: scale and place are uncertain",
                      found.spread);
        reportWarning("penumbra-fit", text);
    }
    const auto& m = found.map.rotation.m;
    const Vec3d o = found.map.origin;
    report.figures = {{"pictures", pictures},
                      {"scale", found.map.scale},
                      {"R", {{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}}},
                      {"origin", {o.x, o.y, o.z}},
                      {"place_rms", found.place_rms},
                      {"turn_rms_degrees", found.turn_rms},
                      {"spread_degrees", found.spread}};
    if (!common.quiet)
        std::printf(
            "%zu pictures: a metre of A is %.6g of B; the tracks agree within %.4g m and %.3f degrees rms; cameras "
            "stand up to %.0f degrees apart\n",
            pictures, found.map.scale, found.place_rms, found.turn_rms, found.spread);
    report.phase("write");
    writeWholeFile(command.output, cameraTrackText(joinedTrack(a, b, found.map)));
}

}  // namespace

Verb alignVerb() {
    return verbOf<AlignCommand, const AlignCommand>(
        "align", "Bring a second track of a camera into the frame and scale of the first.", defineAlign, runAlign);
}

}  // namespace penumbra
