// penumbra-bake: ray-traced visibility over an animation, and ray-traced pictures to compare results with.
#include "bake/bake_verbs.h"
#include "formats/asset/asset_file.h"
#include "formats/common/program_version.h"
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
                      {{"penumbra.visibility", 1, kVisibilityVersion},
                       {"penumbra.poses", kPlainPosesVersion, kPosesVersion},
                       {"penumbra.fields", kStillFieldsVersion, kFieldsVersion},
                       {"penumbra.model", kSkinnedModelVersion, kModelVersion},
                       {"penumbra.brdf", 1, kBrdfVersion},
                       {"penumbra.light", kPlainLightVersion, kLightVersion},
                       {"penumbra.blockers", 1, kBlockersVersion},
                       {"penumbra.transfer", kTransferVersion, kTransferVersion},
                       {"penumbra.lobes", 1, kLobesVersion},
                       {"penumbra.asset", kOldestAssetVersion, kAssetVersion},
                       {"penumbra.scene", 1, kSceneVersion}},
                      {visibilityVerb(), fieldsVerb(), mergeVerb(), posesVerb(), referenceVerb(), infoVerb()}, argc,
                      argv);
}
