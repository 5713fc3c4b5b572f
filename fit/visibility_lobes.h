#pragma once
// The run of `penumbra-fit visibility --model zh-lobes`, whose flags are with those of other models.
#include "fit/lobes/fit_lobe_model.h"
#include "formats/common/command_line.h"

namespace penumbra {

struct LobesCommand {
    std::string input, output;
    std::vector<std::filesystem::path> inputs;  // all files that are read
    LobeFitOptions options;
};
void runLobes(const LobesCommand& command, const CommonOptions& common, Report& report);

}  // namespace penumbra
