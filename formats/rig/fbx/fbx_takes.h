#pragma once
// Clips of FBX files: which seconds of the timeline they are, and the cut to these.
#include <optional>
#include <string_view>
#include <vector>

#include "formats/rig/fbx/fbx_scan.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

struct FbxSpan {
    double first = 0, last = 0;  // seconds of the timeline
};

// Returns the span of all keys of a take, or of those of the first curve of every property alone, which is what
// FBX2glTF 0.9.7 takes for the clip. Nothing where there is no key.
enum class FbxCurves : std::uint8_t { kAll, kFirstOfEach };
std::optional<FbxSpan> spanOfKeys(const FbxScan& scan, int take, FbxCurves curves);

// Returns the span that the clip of a take shows: from LocalStart to LocalStop where the file says so, as far as there
// are keys. Still poses before and behind them are left out.
std::optional<FbxSpan> spanOfClip(const FbxScan& scan, int take);

// Cuts a clip, whose channels are linear or steps, to the seconds from `first` to `last` of its own time and lets it
// begin at 0. Its ends are interpolated.
void cutClip(RigSource& source, std::size_t clip, double first, double last);

// The samples a second of a file's own timeline that FBX2glTF can be asked for: 24, 30 or 60.
int framesASecond(const FbxScan& scan);
// Tells whether frames of the file lie between those that the converter makes.
bool hasOtherRate(const FbxScan& scan);

}  // namespace penumbra
