#pragma once

namespace penumbra {

// Makes Eigen divide products of matrices as for one size of caches. Left alone it asks the processor, and then the
// order of sums, and with it the last bits of results, depends on the machine. Call it before any other thread starts.
void useFixedBlocks();

}  // namespace penumbra
