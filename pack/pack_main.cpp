// penumbra-pack: packs models, materials and lights into the run-time asset, and compares the asset with baked truth.
#include <Eigen/Core>

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
    // Left alone, Eigen divides products of matrices as the processor's caches ask for. The order of sums, and with it
    // the last bits of results, would depend on the machine.
    Eigen::setCpuCacheSizes(48 << 10, 2 << 20, 32 << 20);
    return runProgram(
        "penumbra-pack", "Run-time assets: pack them, and compare them with the truth.",
        {kAssetFormat, kVisibilityFormat, kTransferFormat, kModelFormat, kBrdfFormat, kLightFormat, kBlockersFormat},
        {assetVerb(), truthVerb(), checkVerb(), exportVerb(), embedVerb()}, argc, argv);
}
