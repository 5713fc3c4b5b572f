#include "fit/fit_verbs.h"
#include "fit/numerics/dense_solvers.h"
#include "fit/papers/papers.h"
#include "formats/camera/camera_file.h"
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
    return runProgram(
        "penumbra-fit", "Fit run-time models: visibility, materials, lights and blockers.",
        {kVisibilityFormat, kPosesFormat, kFieldsFormat, kModelFormat, kTransferFormat, kLobesFormat, kBrdfFormat,
         kLightFormat, kBlockersFormat, kCameraPosesFormat, kCameraFormat, kResponseFormat},
        {visibilityVerb(), compareVerb(), predictVerb(), transferVerb(), indirectVerb(), brdfVerb(), lightVerb(),
         captureVerb(), blockersVerb(), pageVerb(), posesVerb(), cameraVerb(), responseVerb(), alignVerb()},
        argc, argv);
}
