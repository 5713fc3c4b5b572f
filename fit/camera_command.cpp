// penumbra-fit camera SHOTS... --tags 36h11:6x8:0.024:0.006 -o cam.json: focal length, principal point and lens.
#include <algorithm>
#include <cstdio>

#include "fit/camera/solve_camera.h"
#include "fit/camera/tag_grid.h"
#include "fit/fit_verbs.h"
#include "formats/camera/camera_file.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"
#include "formats/image/exif_orientation.h"

namespace penumbra {

namespace {

// Below these a calibration is doubtful.
constexpr std::size_t kFewShots = 6, kMinCorners = 8;
constexpr double kLittleTilt = 20, kLittleCoverage = 0.5;
constexpr double kMuchResidualPixels = 0.5, kWideDeviation = 0.003;  // of f

struct CameraCommand {
    std::vector<std::filesystem::path> shots;
    std::filesystem::path output;
    TagGrid grid;
    std::string response = "srgb";

    std::vector<std::filesystem::path> inputs() const { return shots; }
};

void defineCamera(CLI::App& app, CameraCommand& command) {
    app.add_option("shots", command.shots, "10 to 20 pictures of the grid, JPEG or PNG, from all sides")->required();
    const auto read = [](const std::string& text) {
        try {
            return parseTagGrid(text);
        } catch (const BadOption& problem) {
            throw std::invalid_argument(problem.problem);
        }
    };
    addParsed(app, "--tags", command.grid, read,
              "FAMILY:COLUMNSxROWS:SIDE:GAP of the printed grid in metres (scripts/ar/make_tags grid)")
        ->required();
    app.add_option("--response", command.response, "srgb, linear, rec709 or a file of penumbra-fit response");
    app.add_option("-o,--output", command.output, "cam.json to write")->required();
}

// The corners of every picture that shows enough of them.
struct FoundShots {
    int width = 0, height = 0;
    std::vector<GridShot> shots;
    std::size_t clipped = 0;  // pictures whose paper is clipped
};

std::vector<SeenPoint> cornersIn(const std::filesystem::path& file, const TagGrid& grid,
                                 std::span<const DetectedTag> tags) try {
    return seenGridCorners(grid, tags);
} catch (const InvalidInput& problem) {
    throw InvalidInput(file.string() + ": " + problem.what());
}

FoundShots findShots(const CameraCommand& command, const CommonOptions& common) {
    const CameraResponse response = readResponse(command.response);
    const TagFamily families[] = {command.grid.family};
    TagDetector detector(families, std::max(1, common.threads));
    FoundShots out;
    for (const std::filesystem::path& file : command.shots) {
        const TexturePicture picture = readTexture(file, file.string());
        if (out.width == 0) out.width = picture.width, out.height = picture.height;
        if (picture.width != out.width || picture.height != out.height)
            throw InvalidInput(file.string() + ": has " + std::to_string(picture.width) + " x " +
                               std::to_string(picture.height) + " pixels, and " + command.shots.front().string() +
                               " has " + std::to_string(out.width) + " x " + std::to_string(out.height));
        const std::vector<DetectedTag> tags = detector.detect(picture, response);
        out.clipped += std::ranges::any_of(tags, [](const DetectedTag& tag) { return tag.paper_code >= kMaxCode; });
        std::vector<SeenPoint> points = cornersIn(file, command.grid, tags);
        if (points.size() >= kMinCorners)
            out.shots.push_back({file.string(), std::move(points)});
        else
            reportWarning("penumbra-fit", file.string() + ": shows fewer than 2 tags of the grid, and is left out");
    }
    if (out.shots.empty())
        throw InvalidInput(command.shots.front().string() +
                           ": no picture shows the grid: its family, columns and rows must be those of the print");
    return out;
}

void warnOfShots(const FoundShots& found, const SolvedCamera& solved) {
    const auto warn = [](const std::string& text) { reportWarning("penumbra-fit", text); };
    if (found.clipped > 0)
        warn(std::to_string(found.clipped) +
             " pictures: the paper is clipped, which moves the corners: expose so that it stays below code 250");
    if (found.shots.size() < kFewShots)
        warn("only " + std::to_string(found.shots.size()) + " pictures show the grid: take 10 to 20");
    if (solved.tilt < kLittleTilt)
        warn("the grid is tilted by " + std::to_string(int(solved.tilt)) +
             " degrees at most: tilt it by 20 to 45, or f and the distance are hardly told apart");
    if (solved.coverage < kLittleCoverage)
        warn("the grid covers " + std::to_string(int(100 * solved.coverage)) +
             "% of the picture: bring it into all corners, where the lens bends most");
    if (solved.residual > kMuchResidualPixels)
        warn("corners are off by " + std::to_string(solved.residual).substr(0, 4) +
             " pixels: is the print flat and not scaled, and are side and gap as given?");
    if (!(solved.deviations[0] < kWideDeviation * solved.camera.f))
        warn("the pictures do not tell f well: its standard deviation is above 0.3%");
}

void describeCamera(const SolvedCamera& solved, Report& report, bool quiet) {
    const char* names[] = {"f", "cx", "cy", "k1", "k2"};
    const PinholeCamera& camera = solved.camera;
    const double values[] = {camera.f, camera.cx, camera.cy, camera.k1, camera.k2};
    report.figures["pictures"] = solved.poses.size();
    report.figures["corners"] = solved.points;
    report.figures["strays"] = solved.strays;
    report.figures["residual_px"] = solved.residual;
    report.figures["residuals_px"] = solved.residuals;
    report.figures["coverage"] = solved.coverage;
    report.figures["tilt_degrees"] = solved.tilt;
    for (std::size_t i = 0; i < 5; ++i)
        report.figures[names[i]] = {{"value", values[i]}, {"deviation", solved.deviations[i]}};
    if (quiet) return;
    for (std::size_t i = 0; i < 5; ++i) std::printf("%s %.6g +- %.2g\n", names[i], values[i], solved.deviations[i]);
    std::printf(
        "%zu corners in %zu pictures, %zu left out, %.3f px rms, %.0f%% of the picture covered, tilted up to %.0f "
        "degrees\n",
        solved.points, solved.poses.size(), solved.strays, solved.residual, 100 * solved.coverage, solved.tilt);
}

void runCamera(const CameraCommand& command, const CommonOptions& common, Report& report) {
    if (common.dry_run) {
        std::printf("would find a camera from %zu pictures\n", command.shots.size());
        return;
    }
    report.phase("find tags");
    if (const std::string turned = findTurned(command.shots); !turned.empty()) reportWarning("penumbra-fit", turned);
    const FoundShots found = findShots(command, common);
    report.phase("fit");
    const SolvedCamera solved = solveCamera(found.width, found.height, found.shots);
    warnOfShots(found, solved);
    describeCamera(solved, report, common.quiet);
    report.phase("write");
    writeWholeFile(command.output, cameraText(solved.camera));
}

}  // namespace

Verb cameraVerb() {
    return verbOf<CameraCommand, const CameraCommand>(
        "camera", "Find focal length, principal point and lens from pictures of a printed grid of tags.", defineCamera,
        runCamera);
}

}  // namespace penumbra
