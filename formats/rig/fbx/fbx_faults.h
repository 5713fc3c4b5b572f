#pragma once
// Tells from a scan of an FBX file what each reader would get wrong. A fault is a clause such as "clip 'walk' has 2
// layers" that a message about the reader goes on with. No fault: the reader is right, as far as was measured over 459
// files of FBX 7 (docs/fbx.md).
#include <string>
#include <vector>

#include "formats/rig/fbx/fbx_scan.h"
#include "formats/rig/rig_file.h"

namespace penumbra {

std::vector<std::string> assimpFaults(const FbxScan& scan);     // faults of assimp 5.2
std::vector<std::string> converterFaults(const FbxScan& scan);  // faults of FBX2glTF 0.9.7

// The first lists deviations from the file that both readers have, the second those of the converter alone.
std::vector<RigNote> fbxNotes(const FbxScan& scan);
std::vector<RigNote> converterNotes(const FbxScan& scan);

// A mesh of which some vertices have more influences than the 4 that the converter keeps.
struct FbxCutWeights {
    std::string mesh;
    std::size_t vertices = 0;  // vertices that lose some
    double most = 0;           // the largest share of a vertex' weight that is lost
};
std::vector<FbxCutWeights> cutWeights(const FbxScan& scan);

// Tells whether a mesh is drawn that is not hidden, whether one of these has a skin, and whether a clip of that take
// moves something.
bool hasVisibleMesh(const FbxScan& scan);
bool hasVisibleSkin(const FbxScan& scan);
bool hasKeys(const FbxScan& scan, int take);

}  // namespace penumbra
