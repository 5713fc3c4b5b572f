// penumbra-pack: packs models, materials and lights into the run-time asset, and compares the asset with baked truth.
#include "formats/common/program_version.h"
#include "pack/pack_verbs.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    return runProgram(
        "penumbra-pack", "The run-time asset: packed, and held against truth.",
        "penumbra.asset 2..5, penumbra.visibility 1, penumbra.model 2..4, penumbra.brdf 1, penumbra.light 1, "
        "penumbra.blockers 1",
        {assetVerb(), truthVerb(), checkVerb()}, argc, argv);
}
