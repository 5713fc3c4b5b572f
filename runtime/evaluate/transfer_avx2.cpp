// This file is compiled with -mavx2 -mfma, and may contract a * b + c. Its functions are called only where the
// processor has these.
#include "runtime/evaluate/transfer_kernel.h"

#ifdef __AVX2__
#include "runtime/evaluate/transfer_lanes.h"

namespace penumbra {
namespace {

const TransferPath kPath{"avx2", addTransferRows};

}  // namespace
const TransferPath* const kTransferAvx2 = &kPath;
}  // namespace penumbra

#else

namespace penumbra {
const TransferPath* const kTransferAvx2 = nullptr;
}

#endif
