#pragma once
#include "fit/numerics/matrix.h"
#include "tests/sh/golden.h"

namespace penumbra {

inline Matrix toMatrix(const nlohmann::json& rows) {
    Matrix m(rows.size(), rows[0].size());
    for (std::size_t r = 0; r < m.rows; ++r)
        for (std::size_t c = 0; c < m.columns; ++c) m(r, c) = rows[r][c];
    return m;
}

}  // namespace penumbra
