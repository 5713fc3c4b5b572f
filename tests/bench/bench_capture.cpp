// bench_capture BRACKET.json BALL AT LIGHT.exr [COMMIT]: light from a mirror ball by our way, with each of its parts
// left out, and as Nowrouzezahrai 2011 has it, against the true light at AT. BALL is x,y,z,radius,reflectance and AT is
// x,y,z, metres of the marker's frame; the list has "R" and "t", and a response that is known. Relative errors of SH of
// orders 6 and 4, and milliseconds, the best of five. CSV on stdout.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <numeric>

#include "fit/papers/capture/ball_crop.h"
#include "fit/papers/capture/merge_unbounded.h"
#include "formats/camera/bracket_file.h"
#include "formats/camera/camera_file.h"
#include "formats/capture/ball_panorama.h"
#include "formats/capture/shot_pictures.h"
#include "formats/image/project_map.h"

namespace {

using namespace penumbra;

struct Case {
    BracketFile list;
    CameraResponse response;
    std::vector<TexturePicture> pictures;
    std::vector<double> exposures;
    MirrorBall ball;
    Vec3d at;
    std::vector<double> truth;  // [36, 3]
    std::string commit;
};

std::vector<double> numbersIn(const char* text) {
    std::vector<double> out;
    for (char* end = nullptr; *text; text = *end ? end + 1 : end) out.push_back(std::strtod(text, &end));
    return out;
}

Case readCase(int argc, char** argv) {
    Case c;
    c.list = readBracket(argv[1]);
    c.response = readResponse(c.list.response);
    std::vector<std::filesystem::path> files;
    for (const ExposedPicture& picture : c.list.pictures) {
        files.push_back(picture.file);
        c.exposures.push_back(picture.exposure);
    }
    c.pictures = readShotPictures(files, *c.list.camera, 1);
    const std::vector<double> ball = numbersIn(argv[2]), at = numbersIn(argv[3]);
    c.ball = {{ball.at(0), ball.at(1), ball.at(2)}, ball.at(3), ball.at(4)};
    c.at = {at.at(0), at.at(1), at.at(2)};
    c.truth = projectMap(readEnvironmentMap(argv[4], {}), 6, 1).sh;
    c.commit = argc > 5 ? argv[5] : "";
    return c;
}

double errorOf(const std::vector<double>& sh, const std::vector<double>& truth, int order) {
    double difference = 0, all = 0;
    for (std::size_t i = 0; i < std::size_t(3 * order * order); ++i) {
        difference += (sh[i] - truth[i]) * (sh[i] - truth[i]);
        all += truth[i] * truth[i];
    }
    return std::sqrt(difference / all);
}

void row(const Case& c, const char* way, const std::function<std::vector<double>()>& capture) {
    double best = 1e30;
    std::vector<double> sh;
    for (int run = 0; run < 5; ++run) {
        const auto start = std::chrono::steady_clock::now();
        sh = capture();
        const auto end = std::chrono::steady_clock::now();
        best = std::min(best, std::chrono::duration<double, std::milli>(end - start).count());
    }
    std::printf("%s,%s,%.4f,%.4f,%.1f\n", c.commit.c_str(), way, errorOf(sh, c.truth, 6), errorOf(sh, c.truth, 4),
                best);
}

PosedPicture merged(const Case& c, std::size_t first, std::size_t count) {
    return {mergeExposures(std::span(c.pictures).subspan(first, count), std::span(c.exposures).subspan(first, count),
                           c.response),
            *c.list.camera, *c.list.pose};
}

std::vector<double> captured(const Case& c, const PosedPicture& shot, Ground ground) {
    Panorama p = panoramaOfBall(shot, c.ball, {c.at, 512, 2, 1, ground});
    fillHoles(p, ground);
    EnvironmentMap map;
    map.image = {p.width, p.height, std::move(p.radiance), {}};
    return projectMap(map, 6, 1).sh;
}

int run(int argc, char** argv) {
    const Case c = readCase(argc, argv);
    const std::size_t all = c.pictures.size();
    std::printf("commit,way,order_6,order_4,ms\n");
    const PosedPicture shot = merged(c, 0, all);
    row(c, "ours", [&] { return captured(c, merged(c, 0, all), Ground::kLevel); });
    row(c, "not re-projected", [&] { return captured(c, shot, Ground::kNone); });
    row(c, "merge without bounds", [&] {
        return captured(c, {mergeUnbounded(c.pictures, c.exposures, c.response), shot.camera, shot.pose},
                        Ground::kLevel);
    });
    for (std::size_t k = 0; k < all; ++k)
        row(c, ("one exposure " + std::to_string(c.exposures[k])).c_str(),
            [&] { return captured(c, merged(c, k, 1), Ground::kLevel); });
    for (std::size_t missing : {2, 4})  // the shortest exposures stand last
        row(c, (std::to_string(missing) + " shortest missing").c_str(),
            [&] { return captured(c, merged(c, 0, all - missing), Ground::kLevel); });
    row(c, "far-ball formula", [&] { return projectCrop(shot, c.ball, CropFormula::kFarBall, 6); });
    row(c, "equation 6 on the crop", [&] { return projectCrop(shot, c.ball, CropFormula::kEquationSix, 6); });
    Panorama p = panoramaOfBall(shot, c.ball, {c.at, 512, 2, 1, Ground::kLevel});
    EnvironmentMap map;
    map.image = {p.width, p.height, std::move(p.radiance), {}};
    row(c, "projection alone", [&] { return projectMap(map, 6, 1).sh; });
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 5) {
        std::fprintf(stderr, "usage: bench_capture BRACKET.json BALL AT LIGHT.exr [COMMIT]\n");
        return 1;
    }
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_capture: %s\n", error.what());
        return 1;
    }
}
