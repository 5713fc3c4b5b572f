#pragma once
// Reports the light that `penumbra-fit capture` found: its properties, and how certain they are.
#include <optional>
#include <string>

#include "formats/capture/panorama.h"
#include "formats/capture/paper_meter.h"
#include "formats/common/command_line.h"
#include "sh/camera_response.h"

namespace penumbra {

struct CaptureSummary {
    std::string name;  // name of the file that is written
    std::size_t pictures = 0;
    double shortest = 0, longest = 0;  // exposures
    double step = 0;                   // stops from the shortest exposure to the next
    double dark_stops = 0;             // stops from kDarkCode to a code that tells something
    HoleReport holes;
    double clipped = 0, dark = 0;  // parts of the sphere
    Vec3d irradiance, uncertain;   // on the ground, and the part that is a lower bound
    PaperMeasure paper;
    double reflectance = 0;  // reflectance of the paper; 0 if it was not asked for
    std::optional<RaiseReport> raised;
};

// Measures a panorama whose holes are filled. Call it before clipped pixels are raised.
void measurePanorama(const Panorama& panorama, CaptureSummary& summary);
// Stops from kDarkCode to code 16, the mean of the channels.
double darkStops(const CameraResponse& response);
// Stops that the shortest exposure is too long, at least; 0 if none is missing. The same of the longest.
double missingShorter(const CaptureSummary& summary);
double missingLonger(const CaptureSummary& summary);

// Returns the uncertain share of the irradiance on the ground.
double uncertainShare(const CaptureSummary& summary);
// How much of the irradiance that the paper has is missing in the light, if white paper reflects 0.8; 0 where no paper
// was measured, where nothing is clipped, or where nothing is missing.
double missingShare(const CaptureSummary& summary);

// Fills the report, and warns on stderr of what may be wrong.
void describeCapture(const CaptureSummary& summary, Report& report);
// Prints the lines for a reader.
void printCapture(const CaptureSummary& summary);

}  // namespace penumbra
