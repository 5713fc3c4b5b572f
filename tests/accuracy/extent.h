#pragma once
// The tables of docs/formulas.md and docs/accuracy.md as tests. The unit tests run the rows that show that the code
// works; the program `accuracy` (tests/bench/accuracy.cpp) runs and prints every row.
namespace penumbra {

inline bool every_row = false;

}  // namespace penumbra
