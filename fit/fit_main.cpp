#include "fit/fit_verbs.h"
#include "fit/numerics/fixed_blocks.h"
#include "formats/common/program_version.h"
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
    useFixedBlocks();
    return runProgram("penumbra-fit", "Fit run-time models: visibility, materials, lights and blockers.",
                      {{"penumbra.visibility", 1, kVisibilityVersion},
                       {"penumbra.poses", kPlainPosesVersion, kPosesVersion},
                       {"penumbra.fields", kStillFieldsVersion, kFieldsVersion},
                       {"penumbra.model", kSkinnedModelVersion, kModelVersion},
                       {"penumbra.transfer", kTransferVersion, kTransferVersion},
                       {"penumbra.lobes", 1, kLobesVersion},
                       {"penumbra.brdf", 1, kBrdfVersion},
                       {"penumbra.light", kPlainLightVersion, kLightVersion},
                       {"penumbra.blockers", 1, kBlockersVersion}},
                      {visibilityVerb(), compareVerb(), predictVerb(), transferVerb(), indirectVerb(), brdfVerb(),
                       lightVerb(), blockersVerb(), pageVerb()},
                      argc, argv);
}
