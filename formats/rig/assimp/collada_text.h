#pragma once
// Collada as assimp reads it right: without blanks around lists, with curves as lines, one clip at a time.
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "formats/rig/rig_file.h"

namespace penumbra {

// A clip of <library_animation_clips>, and the file with its animations alone.
struct ColladaClip {
    std::string name;
    double start = 0, end = std::numeric_limits<double>::infinity();  // seconds
    std::string text;
};

struct ColladaText {
    std::string text;                // the file; unused where it has clips
    std::vector<ColladaClip> clips;  // empty: the file has no clips of its own
    std::vector<RigNote> notes;
};

// Rewrites a file. BEZIER curves are sampled at 60 Hz and their keys, STEP becomes a ramp of 0.1 ms. A skin over morph
// targets becomes one over their mesh, with a note. What is no XML comes back as it is. Throws InvalidInput where a
// curve or clip is damaged, and Unsupported for other kinds of curves; both name it.
ColladaText prepareCollada(std::string_view xml, const std::filesystem::path& path);

// Makes lines of the curves below a <COLLADA> element (collada_curves.cpp).
struct XmlNode;
void straightenCurves(XmlNode& root, const std::filesystem::path& path);

}  // namespace penumbra
