// penumbra-pack: packs models, materials and lights into the run-time asset, and compares the asset with baked truth.
#include "formats/asset/asset_file.h"
#include "formats/common/program_version.h"
#include "formats/stage/blocker_file.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/model_file.h"
#include "formats/stage/transfer_file.h"
#include "formats/stage/visibility_file.h"
#include "pack/pack_verbs.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    setSourceHash(kSourceHash);
    return runProgram(
        "penumbra-pack", "The run-time asset: packed, and held against truth.",
        {kAssetFormat, kVisibilityFormat, kTransferFormat, kModelFormat, kBrdfFormat, kLightFormat, kBlockersFormat},
        {assetVerb(), truthVerb(), checkVerb()}, argc, argv);
}
