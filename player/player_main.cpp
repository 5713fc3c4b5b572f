// penumbra-player: shows an asset as pictures. It links neither HDF5 nor Embree nor Ceres.
#include "formats/asset/asset_file.h"
#include "formats/common/program_version.h"
#include "formats/scene/bone_poses.h"
#include "formats/scene/scene_file.h"
#include "player/player_verbs.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    return runProgram("penumbra-player", "Soft self-shadowed pictures of animated characters from packed assets.",
                      {kAssetFormat, kSceneFormat, kBonePosesFormat},
                      {viewVerb(), renderVerb(), measureVerb(), benchVerb(), probeVerb(), compositeVerb()}, argc, argv);
}
