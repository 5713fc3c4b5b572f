// penumbra-fit response BRACKET.json -o cam.response.json: the curve of a camera, from pictures of known exposures.
#include <cmath>
#include <cstdio>

#include "fit/camera/find_response.h"
#include "fit/fit_verbs.h"
#include "formats/camera/camera_file.h"
#include "formats/capture/shot_pictures.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

// Above this rms the exposures are hardly what the file says, or the light changed; codes beyond these ends are only
// extrapolated.
constexpr double kDoubtfulResponse = 0.1;
constexpr int kLowEnd = 16, kHighEnd = 235;

struct ResponseCommand {
    std::filesystem::path bracket, output;

    std::vector<std::filesystem::path> inputs() const { return {bracket}; }
};

void defineResponse(CLI::App& app, ResponseCommand& command) {
    app.add_option("bracket", command.bracket,
                   "BRACKET.json: pictures of one place with their exposures (formats/README.md)")
        ->required();
    app.add_option("-o,--output", command.output, "cam.response.json to write")->required();
}

void describeChannel(const char* name, const ResponseQuality& channel, Report& report, bool quiet) {
    report.figures["channels"].push_back({{"channel", name},
                                          {"samples", channel.samples},
                                          {"lowest_code", channel.lowest},
                                          {"highest_code", channel.highest},
                                          {"rms", channel.rms}});
    if (quiet) return;
    std::printf("%s: %d places, codes %d to %d, pictures agree within %.1f%% rms\n", name, channel.samples,
                channel.lowest, channel.highest, 100 * channel.rms);
    const auto warn = [name](const std::string& what) { reportWarning("penumbra-fit", name + (": " + what)); };
    if (channel.rms > kDoubtfulResponse)
        warn(
            "the pictures disagree on the light: are their exposures as the file says, and did camera and light stand "
            "still?");
    if (channel.lowest > kLowEnd || channel.highest < kHighEnd)
        warn("no flat place shows codes below " + std::to_string(channel.lowest) + " or above " +
             std::to_string(channel.highest) + ": the curve is extrapolated there");
}

void runResponse(const ResponseCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    const BracketFile bracket = readBracket(command.bracket);
    std::vector<std::filesystem::path> files;
    for (const ExposedPicture& picture : bracket.pictures) files.push_back(picture.file);
    report.willRead(files);
    if (common.dry_run) {
        std::printf("would find the response from %zu pictures\n", files.size());
        return;
    }
    const BracketPictures pictures = readPictures(bracket);
    if (const std::string problem = findProblem(ExposureSet{pictures.pictures, pictures.exposures, files});
        !problem.empty())
        throw InvalidInput(problem);
    report.phase("fit");
    const FoundResponse found = findResponse(pictures);
    report.figures["pictures"] = files.size();
    report.figures["flatness_codes"] = found.flatness;
    const char* names[] = {"red", "green", "blue"};
    for (std::size_t c = 0; c < 3; ++c) describeChannel(names[c], found.channels[c], report, common.quiet);
    report.phase("write");
    writeWholeFile(command.output, responseText(found.response));
}

}  // namespace

Verb responseVerb() {
    return verbOf<ResponseCommand, const ResponseCommand>(
        "response", "Find the response of a camera from a bracket of exposures.", defineResponse, runResponse);
}

}  // namespace penumbra
