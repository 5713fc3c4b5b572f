// penumbra-bake: ray-traced visibility over an animation, and ray-traced pictures to compare results with.
#include "bake/bake_verbs.h"
#include "formats/asset/asset_file.h"
#include "formats/common/program_version.h"
#include "formats/scene/bone_poses.h"
#include "formats/scene/scene_file.h"
#include "formats/stage/blocker_file.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/field_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/lobe_file.h"
#include "formats/stage/model_file.h"
#include "formats/stage/pose_file.h"
#include "formats/stage/transfer_file.h"
#include "formats/stage/visibility_file.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    return runProgram("penumbra-bake", "Ray-traced visibility of animated characters and cloth.",
                      {kVisibilityFormat, kPosesFormat, kBonePosesFormat, kFieldsFormat, kModelFormat, kBrdfFormat,
                       kLightFormat, kBlockersFormat, kTransferFormat, kLobesFormat, kAssetFormat, kSceneFormat},
                      {visibilityVerb(), fieldsVerb(), mergeVerb(), posesVerb(), referenceVerb(), infoVerb()}, argc,
                      argv);
}
