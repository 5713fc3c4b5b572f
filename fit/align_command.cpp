// penumbra-fit align A.poses.json B.poses.json -o OUT.poses.json: two tracks of one camera in one frame.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "fit/camera/align_tracks.h"
#include "fit/fit_verbs.h"
#include "formats/common/errors.h"
#include "formats/common/natural_order.h"
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
    app.add_option("-o,--output", command.output,
                   "poses.json to write, in B's order: B in A's frame, and A where B has no pose")
        ->required();
}

std::string nameOf(const TrackFrame& frame) { return std::filesystem::path(frame.file).filename().string(); }

bool comesBefore(const TrackFrame& a, const TrackFrame& b) { return naturallyBefore(nameOf(a), nameOf(b)); }

// Every picture of B in its order, with the pose of A where B has none. Those that only A has stand where their names
// belong among B's, or at the end where B is in no order of names.
CameraTrack joinedTrack(const CameraTrack& a, const CameraTrack& b, const FrameMap& map) {
    std::map<std::string, const TrackFrame*> by_name;
    for (const TrackFrame& frame : a.frames)
        if (!frame.file.empty()) by_name[nameOf(frame)] = &frame;
    CameraTrack out{a.camera, {}};
    std::set<const TrackFrame*> used;
    for (std::size_t i = 0; i < b.frames.size(); ++i) {
        TrackFrame& frame = out.frames.emplace_back(b.frames[i]);
        if (frame.pose) frame.pose = poseInA(map, *frame.pose);
        const TrackFrame* other = nullptr;
        if (const auto found = by_name.find(nameOf(frame)); found != by_name.end())
            other = found->second;
        else if (by_name.empty() && frame.file.empty() && i < a.frames.size())
            other = &a.frames[i];
        if (!other) continue;
        used.insert(other);
        if (!frame.pose) frame = *other;
        frame.file = other->file;
    }
    const bool in_order = std::ranges::is_sorted(out.frames, comesBefore);
    for (const TrackFrame& frame : a.frames) {
        if (used.contains(&frame)) continue;
        const auto place = in_order ? std::ranges::upper_bound(out.frames, frame, comesBefore) : out.frames.end();
        out.frames.insert(place, frame);
    }
    return out;
}

// Largest distance in pixels between where two cameras see the directions of the corners and the middle of a picture,
// over its diagonal.
double cameraDifference(const PinholeCamera& a, const PinholeCamera& b) {
    double most = 0;
    for (const double x : {0.0, (a.width - 1) / 2.0, a.width - 1.0})
        for (const double y : {0.0, (a.height - 1) / 2.0, a.height - 1.0})
            if (const std::optional<PixelPoint> seen = project(b, viewRay(a, {x, y})))
                most = std::max(most, std::hypot(seen->x - x, seen->y - y));
    return most / std::hypot(a.width, a.height);
}

std::string parametersOf(const PinholeCamera& camera) {
    char text[160];
    std::snprintf(text, sizeof text, "f %.1f, cx %.1f, cy %.1f, k1 %.3g, k2 %.3g", camera.f, camera.cx, camera.cy,
                  camera.k1, camera.k2);
    return text;
}

// The tracks must be of one camera: the joined one has A's numbers. Throws InvalidInput (without a name).
void compareCameras(const PinholeCamera& a, const PinholeCamera& b) {
    constexpr double kDoubtful = 0.005, kOther = 0.05;  // of the diagonal
    if (a.width != b.width || a.height != b.height)
        throw InvalidInput("have cameras of different sizes, " + std::to_string(a.width) + "x" +
                           std::to_string(a.height) + " and " + std::to_string(b.width) + "x" +
                           std::to_string(b.height) + ": they must be tracks of one camera");
    const double difference = cameraDifference(a, b);
    if (!(difference > kDoubtful)) return;
    char text[128];
    std::snprintf(text, sizeof text,
                  "have cameras that differ by up to %.1f%% of the picture's diagonal: ", 100 * difference);
    const std::string all = text + parametersOf(a) + "; and " + parametersOf(b);
    if (difference > kOther) throw InvalidInput(all + ": they must be tracks of one camera");
    reportWarning("penumbra-fit", "the tracks " + all +
                                      ": the joined track has the first, and poses of the second "
                                      "are less exact with it");
}

AlignedFrames alignTracks(const AlignCommand& command, const CameraTrack& a, const CameraTrack& b,
                          std::size_t& pictures) {
    try {
        compareCameras(a.camera, b.camera);
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
