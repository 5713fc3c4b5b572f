#pragma once
// All that the main path knows of what only reproduces the papers (docs/papers.md): two verbs, and one branch
// each of `visibility`, of `predict` and of `brdf`.
#include "fit/papers/operators/brdf_operators.h"
#include "fit/report/run_report.h"

namespace penumbra {

Verb transferVerb();  // linear models of transfer (Nowrouzezahrai 2007)
Verb compareVerb();   // the papers' figures on the user's own data

// Reads --components of both, "8,22": those of the angles and of the vertices. Throws UsageError.
std::pair<std::size_t, std::size_t> parseComponents(const std::string& text);

// `penumbra-fit visibility --model zh-lobes` (Nowrouzezahrai 2008).
constexpr const char* kZhLobes = "zh-lobes";
struct LobesCommand {
    const CLI::App* app = nullptr;  // the verb's options, to tell which were given
    std::string input, output;
    std::vector<std::filesystem::path> inputs;  // all files that are read
    int lobes = 0;                              // --lobes
};
void addLobesOption(CLI::App& app, int& lobes);
// `shared` has the options that all models of visibility share. Throws UsageError for options that lobes do not have.
void runLobes(const LobesCommand& command, const FitOptions& shared, const CommonOptions& common, Report& report);

// `penumbra-fit brdf --operators K`: reflection product operators (Nowrouzezahrai 2009).
struct OperatorsCommand {
    int count = 0;  // k; 0 means none
    OperatorSource from = OperatorSource::kSlices;
};
void addOperatorOptions(CLI::App& app, OperatorsCommand& command);
// Fits and measures the operators of a material whose slices are in `brdf`, and puts them there.
void addOperators(const OperatorsCommand& command, const ShadingTruth& truth, const RgbBrdf& source, BrdfFile& brdf,
                  const CommonOptions& common, Report& report);
void describeOperators(const BrdfFile& brdf);

// Runs `penumbra-fit predict` with X.lobes.h5 or X.transfer.h5. Returns false where the file is of another kind.
bool predictWithPaperModel(const PredictCommand& command, const CommonOptions& common, Report& report);

}  // namespace penumbra
