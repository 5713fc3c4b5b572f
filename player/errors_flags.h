#pragma once
// The flags that measure frames against the truth: the table, the contact sheet and the gate.
#include "formats/common/options.h"
#include "player/render/error_gate.h"
#include "player/render/render_sheet.h"

namespace penumbra {

constexpr const char* kErrorsGroup = "Errors of many frames";

struct ErrorsFlags {
    std::filesystem::path csv;
    bool flip = false;
    SheetOptions sheet;
    std::optional<double> fail_above;
    ErrorGate gate;  // only with fail_above
};

inline void addSheetFlags(CLI::App& app, SheetOptions& sheet) {
    CLI::Option* file = app.add_option("--sheet", sheet.file, "write all frames on one PNG, each with its figures")
                            ->type_name("FILE")
                            ->check(endsIn({".png"}))
                            ->group(kErrorsGroup);
    addChoices(app, "--panels", sheet.panels, kPanelWords,
               "model,truth,error side by side on --sheet (default: all that there are)")
        ->needs(file)
        ->group(kErrorsGroup);
    app.add_option("--columns", sheet.columns, "frames beside one another on --sheet (default: as fits)")
        ->check(within(1, kMaxSheetSide))
        ->default_str("")
        ->needs(file)
        ->group(kErrorsGroup);
    app.add_option("--shrink", sheet.shrink, "pixels of a picture, each way, that make one of --sheet")
        ->check(within(1, kMaxSheetSide))
        ->needs(file)
        ->group(kErrorsGroup);
}

inline void addGateFlags(CLI::App& app, ErrorsFlags& flags) {
    static constexpr Word<bool> kPerWords[] = {{"frame", false}, {"run", true}};
    CLI::Option* above =
        app.add_option("--fail-above", flags.fail_above,
                       "exit with 4, after everything is written, when an error is above this or cannot be measured")
            ->check(within(0.0, 1e9))
            ->group(kErrorsGroup);
    addChoice(app, "--fail-metric", flags.gate.figure, kFigureWords, "the error")->needs(above)->group(kErrorsGroup);
    addChoice(app, "--fail-per", flags.gate.over_run, kPerWords,
              "frame: each frame's error counts; run: one error over all frames")
        ->needs(above)
        ->group(kErrorsGroup);
    app.add_option("--fail-percent", flags.gate.percent,
                   "percentage of the frames that may be above the bound, below 100")
        ->check(within(0.0, 99.999))
        ->needs(above)
        ->group(kErrorsGroup);
}

inline void addErrorsFlags(CLI::App& app, ErrorsFlags& flags, CLI::Option* truth) {
    app.add_option("--csv", flags.csv, "write the figures of every frame, a row each")
        ->type_name("FILE")
        ->group(kErrorsGroup);
    app.add_flag("--flip", flags.flip, "measure FLIP between pictures of model and truth, too")
        ->needs(truth)
        ->group(kErrorsGroup);
    addSheetFlags(app, flags.sheet);
    addGateFlags(app, flags);
}

}  // namespace penumbra
