// penumbra-bake: ray-traced visibility over an animation, and ray-traced pictures to compare results with.
#include "bake/bake_verbs.h"
#include "formats/common/program_version.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    return runProgram(
        "penumbra-bake", "Ray-traced visibility of animated characters and cloth.",
        "penumbra.visibility 1, penumbra.poses 1..2, penumbra.fields 1, penumbra.model 2..4, penumbra.brdf 1, "
        "penumbra.light 1, penumbra.blockers 1, penumbra.transfer 1, "
        "penumbra.asset 2..5",
        {visibilityVerb(), fieldsVerb(), mergeVerb(), posesVerb(), referenceVerb(), infoVerb()}, argc, argv);
}
