#include "fit/fit_verbs.h"
#include "formats/common/program_version.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    return runProgram(
        "penumbra-fit", "Fit run-time models: visibility, materials and lights.",
        "penumbra.visibility 1, penumbra.poses 1..2, penumbra.model 2..3, penumbra.brdf 1, penumbra.light 1",
        {visibilityVerb(), compareVerb(), predictVerb(), brdfVerb(), lightVerb(), pageVerb()}, argc, argv);
}
