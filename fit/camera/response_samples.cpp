// Chooses the places of a bracket that find a camera's response.
//
// Problem: JPEG keeps colour at half the size. Beside an edge, a channel has the code of its neighbours' colour and not
// that of its own light, so a place that is picked blindly compares different lights at different exposures.
//
// Here: the mean of 5 x 5 codes stands for a place, and only where all three channels are flat there. The places are
// taken at equal steps of their code, summed over the bracket, so that a large wall does not outweigh a lamp.
#include "fit/camera/response_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sh/camera_response.h"

namespace penumbra {

namespace {

constexpr int kRadius = 2, kEnough = 200;
constexpr int kMaxCenters = 100000;
constexpr float kNone = -1;

// The window around one pixel of one picture.
struct Window {
    std::array<float, 3> mean, deviation;
    std::array<std::uint8_t, 3> highest{};
};

Window windowAt(const TexturePicture& picture, int x, int y) {
    std::array<long, 3> sum{}, squares{};
    Window out;
    for (int j = y - kRadius; j <= y + kRadius; ++j) {
        const std::uint8_t* at =
            &picture.rgb[3 * (std::size_t(j) * std::size_t(picture.width) + std::size_t(x - kRadius))];
        for (int i = 0; i < 3 * (2 * kRadius + 1); ++i, ++at) {
            sum[std::size_t(i % 3)] += *at;
            squares[std::size_t(i % 3)] += *at * *at;
            out.highest[std::size_t(i % 3)] = std::max(out.highest[std::size_t(i % 3)], *at);
        }
    }
    constexpr double kCount = (2 * kRadius + 1) * (2 * kRadius + 1);
    for (std::size_t c = 0; c < 3; ++c) {
        const double mean = double(sum[c]) / kCount;
        out.mean[c] = float(mean);
        out.deviation[c] = float(std::sqrt(std::max(double(squares[c]) / kCount - mean * mean, 0.0)));
    }
    return out;
}

// Windows of all pictures, [center, picture].
std::vector<Window> windowsOf(const BracketPictures& bracket) {
    const int width = bracket.pictures[0].width, height = bracket.pictures[0].height;
    const double pixels = double(width) * height;
    const int step = std::max(1, int(std::ceil(std::sqrt(pixels / kMaxCenters))));
    std::vector<Window> out;
    for (int y = kRadius; y < height - kRadius; y += step)
        for (int x = kRadius; x < width - kRadius; x += step)
            for (const TexturePicture& picture : bracket.pictures) out.push_back(windowAt(picture, x, y));
    return out;
}

// The other channels may vary three times as much: they only blur into this one.
bool isUsable(const Window& window, std::size_t channel, double flatness) {
    const float most = *std::ranges::max_element(window.deviation);
    return window.mean[channel] > kMinCode + 1 && window.highest[channel] < 255 &&
           window.deviation[channel] < flatness && most < 3 * flatness;
}

// A place and its brightness: the sum of its codes.
struct Candidate {
    std::size_t center = 0;
    float brightness = 0;
};

std::vector<Candidate> candidatesOf(const std::vector<Window>& windows, std::size_t pictures, std::size_t channel,
                                    double flatness) {
    std::vector<Candidate> out;
    for (std::size_t center = 0; center * pictures < windows.size(); ++center) {
        int usable = 0;
        float brightness = 0;
        for (std::size_t k = 0; k < pictures; ++k) {
            const Window& window = windows[center * pictures + k];
            usable += isUsable(window, channel, flatness);
            brightness += window.mean[channel];
        }
        if (usable >= 2) out.push_back({center, brightness});
    }
    std::ranges::stable_sort(out, {}, &Candidate::brightness);
    return out;
}

// Keeps the candidates that lie next to `most` equal steps of brightness.
std::vector<Candidate> spread(const std::vector<Candidate>& sorted, int most) {
    std::vector<Candidate> out;
    if (sorted.empty()) return out;
    const float first = sorted.front().brightness, range = sorted.back().brightness - first;
    std::size_t at = 0;
    for (int i = 0; i < most && at < sorted.size(); ++i) {
        const float wanted = first + range * float(i) / float(most - 1);
        while (at < sorted.size() && sorted[at].brightness < wanted) ++at;
        if (at < sorted.size()) out.push_back(sorted[at++]);
    }
    return out;
}

void measureEnds(const BracketPictures& bracket, ResponseSamples& out) {
    double clipped = 0, dark = 0, all = 0;
    for (const TexturePicture& picture : bracket.pictures) {
        for (const std::uint8_t code : picture.rgb) {
            clipped += code >= kMaxCode;
            dark += code <= kMinCode;
        }
        all += double(picture.rgb.size());
    }
    out.clipped = clipped / all;
    out.dark = dark / all;
}

}  // namespace

ResponseSamples chooseResponseSamples(const BracketPictures& bracket, int most) {
    ResponseSamples out;
    measureEnds(bracket, out);
    const std::size_t pictures = bracket.pictures.size();
    const std::vector<Window> windows = windowsOf(bracket);
    const auto fewest = [&] {
        return std::ranges::min(out.channels, {}, [](const auto& samples) { return samples.size(); }).size();
    };
    for (out.flatness = 4; out.flatness <= 16; out.flatness *= 2) {
        for (std::size_t c = 0; c < 3; ++c) {
            out.channels[c].clear();
            for (const Candidate& one : spread(candidatesOf(windows, pictures, c, out.flatness), most)) {
                ResponseSample sample;
                for (std::size_t k = 0; k < pictures; ++k) {
                    const Window& window = windows[one.center * pictures + k];
                    sample.codes.push_back(isUsable(window, c, out.flatness) ? window.mean[c] : kNone);
                }
                out.channels[c].push_back(std::move(sample));
            }
        }
        if (fewest() >= kEnough) return out;
    }
    out.flatness = 16;
    return out;
}

}  // namespace penumbra
