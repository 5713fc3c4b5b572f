// Finds a camera's response from pictures of known exposures.
//
// Problem: code z of a place with light E at exposure t obeys g(z) = ln E + ln t, with g = ln of the wanted curve. Both
// g(0..255) and ln E of every place are unknown.
//
// Naive: Debevec and Malik (SIGGRAPH 1997, equation 3) add the squares of g's second difference in z. A bracket whose
// exposures are all two stops apart tells g only up to a function that repeats every two stops, and a penalty in z is
// weak exactly at the steep, dark end: 10% rms are left.
//
// Here: the penalty is that of g as a function of x = ln(z + 4), where every power law is nearly straight. Where the
// places show the shoulder of the curve it is x = ln((z + 4) / (260 - z)), because film goes into its white as slowly
// as into its black, and the scale of the light hangs on the last codes: code 255 is an exposure of 1. A place weighs
// by what one code of noise does to its light; and places that disagree lose weight (Huber). 1 to 2% are left. ln E is
// eliminated: for a sample with weights w and rows a (g's interpolation at each code),
//   sum w (a g - ln t - ln E)^2 is least at ln E = mean_w(a g - ln t), which leaves a quadratic form in g alone.
#include "fit/camera/find_response.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fit/camera/response_samples.h"
#include "fit/numerics/dense_solvers.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr int kCodes = 256, kMaxSamples = 2000, kRounds = 5;
constexpr std::size_t kFewestSamples = 30;
// Weight of the integral of g''(x)^2 against the mean square of ln E's residual.
constexpr double kSmoothness = 4e-6;
// Places up to this code show the shoulder of the curve.
constexpr int kShoulder = 240;
// A residual beyond so many codes counts less.
constexpr double kTrustedCodes = 1.5;
// Slope of g, per code, of a place that has weight 1; steeper ones weigh less.
constexpr double kFullSlope = 0.01;

// The equation that one picture gives for one place: g(code) = ln E + log_exposure.
struct Term {
    int code = 0;         // the lower one
    double fraction = 0;  // weight of the next one
    double log_exposure = 0, weight = 0;
};
using Place = std::vector<Term>;

double value(const Eigen::VectorXd& g, const Term& term) {
    return (1 - term.fraction) * g[term.code] + term.fraction * g[term.code + 1];
}

std::vector<Place> placesOf(const std::vector<ResponseSample>& samples, const std::vector<double>& exposures) {
    std::vector<Place> out;
    for (const ResponseSample& sample : samples) {
        Place& place = out.emplace_back();
        for (std::size_t k = 0; k < exposures.size(); ++k) {
            const double code = double(sample.codes[k]);
            if (code < 0) continue;
            const int low = std::min(int(code), kCodes - 2);
            place.push_back({low, code - low, std::log(exposures[k]), std::min(code, 255 - code) / 127.5});
        }
    }
    return out;
}

// The quadratic form that g makes least: g^T a g - 2 b g.
struct NormalEquations {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(kCodes, kCodes);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(kCodes);
    double weight = 0;
};

void addPlace(const Place& place, NormalEquations& to) {
    double weight = 0, exposure = 0;
    for (const Term& term : place) weight += term.weight, exposure += term.weight * term.log_exposure;
    if (weight <= 0) return;
    to.weight += weight;
    const auto part = [](const Term& term, int end) { return end ? term.fraction : 1 - term.fraction; };
    for (const Term& p : place)
        for (int i = 0; i < 2; ++i) {
            const double row = p.weight * part(p, i);
            to.b[p.code + i] += row * (p.log_exposure - exposure / weight);
            for (int j = 0; j < 2; ++j) to.a(p.code + i, p.code + j) += row * part(p, j);
            for (const Term& q : place)
                for (int j = 0; j < 2; ++j) to.a(p.code + i, q.code + j) -= row * q.weight * part(q, j) / weight;
        }
}

// Adds kSmoothness times the integral of g''(x)^2, and holds g(128) near 0: the data leave its constant free. `highest`
// is the highest code that the places show.
void addPenalty(int highest, NormalEquations& to) {
    const bool shoulder = highest >= kShoulder;
    const auto x = [=](int code) { return std::log(code + 4.0) - (shoulder ? std::log(260.0 - code) : 0); };
    for (int z = 1; z < kCodes - 1; ++z) {
        const double before = x(z) - x(z - 1), after = x(z + 1) - x(z), both = (before + after) / 2;
        const double row[] = {1 / before / both, -(1 / before + 1 / after) / both, 1 / after / both};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) to.a(z - 1 + i, z - 1 + j) += kSmoothness * to.weight * both * row[i] * row[j];
    }
    to.a(kCodes / 2, kCodes / 2) += to.weight / kCodes;
}

double slopeAt(const Eigen::VectorXd& g, const Term& term) {
    const int low = std::max(term.code - 1, 0), high = std::min(term.code + 2, kCodes - 1);
    return std::max((g[high] - g[low]) / (high - low), 1e-3);
}

// Weighs every term by the noise of its light, less where it disagrees. Returns the weighted rms of the residuals.
double reweigh(const Eigen::VectorXd& g, std::vector<Place>& places) {
    double squares = 0, weights = 0;
    for (Place& place : places) {
        double weight = 0, light = 0;
        for (const Term& term : place)
            weight += term.weight, light += term.weight * (value(g, term) - term.log_exposure);
        if (weight <= 0) continue;
        for (Term& term : place) {
            const double residual = value(g, term) - term.log_exposure - light / weight;
            squares += term.weight * residual * residual;
            weights += term.weight;
            const double slope = slopeAt(g, term), codes = std::abs(residual) / slope;
            const double noise = std::min(1.0, (kFullSlope / slope) * (kFullSlope / slope));
            term.weight = noise * (codes > kTrustedCodes ? kTrustedCodes / codes : 1);
        }
    }
    return weights > 0 ? std::sqrt(squares / weights) : 0;
}

Eigen::VectorXd findCurve(std::vector<Place>& places, int highest, double& rms) {
    Eigen::VectorXd g(kCodes);
    for (int round = 0; round < kRounds; ++round) {
        NormalEquations equations;
        for (const Place& place : places) addPlace(place, equations);
        addPenalty(highest, equations);
        Eigen::MatrixXd solution;
        if (!solvePositive(equations.a, Eigen::MatrixXd(equations.b), solution))
            throw std::runtime_error("the equations of the response have no solution");
        g = solution.col(0);
        rms = reweigh(g, places);
    }
    return g;
}

ResponseQuality qualityOf(const std::vector<Place>& places) {
    ResponseQuality out;
    out.samples = int(places.size());
    for (const Place& place : places)
        for (const Term& term : place) {
            out.lowest = std::min(out.lowest, term.code);
            out.highest = std::max(out.highest, term.code + 1);
        }
    return out;
}

[[noreturn]] void failOfTooFew(const BracketPictures& bracket, const ResponseSamples& samples, std::size_t channel) {
    char text[400];
    std::snprintf(text, sizeof text,
                  ": %zu places show a usable %s in two pictures, and a response needs %zu: %.0f%% of all codes are "
                  "clipped and %.0f%% dark; take exposures that are nearer to one another, of a scene with flat places "
                  "of many brightnesses",
                  samples.channels[channel].size(),
                  channel == 0   ? "red"
                  : channel == 1 ? "green"
                                 : "blue",
                  kFewestSamples, 100 * samples.clipped, 100 * samples.dark);
    throw InvalidInput(bracket.name + text);
}

}  // namespace

FoundResponse findResponse(const BracketPictures& bracket) {
    const ResponseSamples samples = chooseResponseSamples(bracket, kMaxSamples);
    FoundResponse out;
    out.flatness = samples.flatness;
    for (std::size_t c = 0; c < 3; ++c) {
        if (samples.channels[c].size() < kFewestSamples) failOfTooFew(bracket, samples, c);
        std::vector<Place> places = placesOf(samples.channels[c], bracket.exposures);
        out.channels[c] = qualityOf(places);
        const Eigen::VectorXd g = findCurve(places, out.channels[c].highest, out.channels[c].rms);
        double highest = g[0];
        for (int code = 0; code < kCodes; ++code) {
            highest = std::max(highest, g[code]);  // the curve never falls
            out.response.exposure[c][std::size_t(code)] = float(std::exp(highest));
        }
        const float last = out.response.exposure[c][kCodes - 1];
        for (float& value : out.response.exposure[c]) value /= last;
    }
    return out;
}

}  // namespace penumbra
