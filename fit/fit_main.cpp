#include "fit/fit_verbs.h"
#include "fit/numerics/fixed_blocks.h"
#include "formats/common/program_version.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    useFixedBlocks();
    return runProgram("penumbra-fit", "Fit run-time models: visibility, materials, lights and blockers.",
                      "penumbra.visibility 1, penumbra.poses 1..2, penumbra.fields 1, penumbra.model 2..4, "
                      "penumbra.transfer 1, penumbra.brdf 1, penumbra.light 1, penumbra.blockers 1",
                      {visibilityVerb(), compareVerb(), predictVerb(), transferVerb(), indirectVerb(), brdfVerb(),
                       lightVerb(), blockersVerb(), pageVerb()},
                      argc, argv);
}
