#pragma once
#include <nlohmann/json_fwd.hpp>

#include "player/bench/bench.h"

namespace penumbra {

void printBench(const BenchResult& result);
nlohmann::ordered_json figuresOf(const BenchResult& result);  // all figures that the report prints

}  // namespace penumbra
