// Feeds bytes to the scan of FBX files, binary and ASCII, and asks for the faults of what it accepts.
#include <cstddef>
#include <cstdint>

#include "formats/common/errors.h"
#include "formats/rig/fbx/fbx_faults.h"
#include "formats/rig/fbx/fbx_takes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace penumbra;
    try {
        const FbxScan scan = scanOf(parseFbxTree({reinterpret_cast<const char*>(data), size}, "fuzz.fbx"), "fuzz.fbx");
        assimpFaults(scan);
        converterFaults(scan);
        fbxNotes(scan);
        converterNotes(scan);
        for (int take = 0; take < int(scan.takes.size()); ++take) hasKeys(scan, take);
    } catch (const InvalidInput&) {
    }
    return 0;
}
