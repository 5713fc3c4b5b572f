// SPDX-License-Identifier: Apache-2.0
#include "fit/fit_verbs.h"

int main(int argc, char** argv) {
    using namespace penumbra;
    return runProgram("penumbra-fit", "Fit run-time models to baked visibility.",
                      "penumbra.visibility 1, penumbra.model 1", {visibilityVerb(), predictVerb()}, argc, argv);
}
