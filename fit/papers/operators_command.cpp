// The part of `penumbra-fit brdf --operators K`.
#include <cstdio>

#include "fit/papers/papers.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"

namespace penumbra {

namespace {

// The budget at run time: bytes of M^b and w for a colour channel, with light and visibility of order 4.
constexpr std::size_t kMaxOperatorBytes = 10240;

std::size_t operatorBytes(const BrdfOperators& operators) {
    const Convention a4{BelowHorizon::kOpen, 4};
    return expandedBytes(operators, a4.order, a4) / 3;
}

void warnOfOperators(const BrdfFile& brdf) {
    const std::size_t bytes = operatorBytes(brdf.operators),
                      most = kMaxOperatorBytes / (bytes / std::size_t(brdf.operators.count));
    if (bytes > kMaxOperatorBytes)
        reportWarning("penumbra-fit", brdf.name + ": " + std::to_string(brdf.operators.count) + " operators are " +
                                          std::to_string(bytes) + " bytes a channel, more than " +
                                          std::to_string(kMaxOperatorBytes) + "; --operators " + std::to_string(most) +
                                          " is the most that fits");
    if (brdf.operators.source == nameOf(OperatorSource::kLiteral))
        reportWarning("penumbra-fit",
                      brdf.name + ": operators from \"literal\" are for comparisons only: penumbra-pack refuses them");
}

}  // namespace

void addOperatorOptions(CLI::App& app, OperatorsCommand& command) {
    CLI::Option* operators = app.add_option("--operators", command.count,
                                            "also K reflection product operators (Nowrouzezahrai 2009), 1..16; one "
                                            "more or less where K would cut a pair")
                                 ->check(within(1, kMaxOperators));
    addChoice(app, "--operators-from", command.from, kOperatorSourceWords,
              "slices, table (SVD of the BRDF itself), literal (the paper as printed, for comparisons)")
        ->needs(operators);
}

void addOperators(const OperatorsCommand& command, const ShadingTruth& truth, const RgbBrdf& source, BrdfFile& brdf,
                  const CommonOptions& common, Report& report) {
    report.phase("operators");
    brdf.operators = fitOperators(source, brdf, command.from, command.count, common.threads);
    measureOperators(truth, brdf);
    report.figures["operators"] = brdf.operators.count;
    report.figures["operators_asked"] = command.count;
    report.figures["operators_from"] = nameOf(command.from);
    report.figures["operators_bytes_per_channel"] = operatorBytes(brdf.operators);
    warnOfOperators(brdf);
    if (brdf.operators.count != command.count && !common.quiet)
        std::printf("%d operators instead of %d: %s\n", brdf.operators.count, command.count,
                    brdf.operators.count < command.count - 1 ? "the BRDF has no more terms"
                                                             : "no pair of equal singular values is cut");
}

void describeOperators(const BrdfFile& brdf) {
    std::printf("%d operators from %s: shading error %.4f (A4), %.4f (D5), %zu bytes a channel\n", brdf.operators.count,
                brdf.operators.source.c_str(), brdf.errors.at("shading_operators"),
                brdf.errors.at("shading_operators_d5"), operatorBytes(brdf.operators));
}

}  // namespace penumbra
