#pragma once
// The largest principal components of a matrix that does not have to fit into memory.
#include <functional>
#include <vector>

#include "fit/numerics/matrix.h"

namespace penumbra {

// A matrix that is read some columns at a time. Block 0 has the first columns. Each call of read() must return the same
// numbers.
struct ColumnBlocks {
    std::size_t rows = 0, columns = 0;
    std::size_t count = 0;                           // blocks
    std::function<MatrixF(std::size_t block)> read;  // [rows, columns of the block]
};

// The span of the leading principal components of the matrix less the mean of each column.
struct LeadingSpace {
    std::vector<double> energies;  // [k] descending: the squared singular values
    double total = 0;              // sum of all energies, of those that are not kept too
    MatrixF u;                     // [rows, k] left singular vectors
};

struct LeadingComponents {
    std::vector<float> mean;  // [columns]
    MatrixF basis;            // [k, columns], orthonormal rows
    Matrix scores;            // [rows, k], (matrix - mean) basis^T
};

// Returns the `count` leading components, or fewer where the rank is smaller. The captured energy is within 1e-5 of the
// total of the largest possible. The result does not depend on the number of threads.
LeadingSpace leadingSpace(const ColumnBlocks& matrix, std::size_t count, int threads);
// Returns basis and scores of the space. It reads the matrix once more.
LeadingComponents componentsIn(const LeadingSpace& space, const ColumnBlocks& matrix, int threads);

}  // namespace penumbra
