#pragma once
// The command line that all programs share (README.md), on CLI11: only *_main.cpp files include this.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/common/progress.h"

namespace penumbra {

struct CommonOptions {
    bool quiet = false;
    int verbosity = 0;
    int threads = 0;  // 0: --threads, else PENUMBRA_THREADS, else CUE_THREADS, else all cores; resolved by runProgram
    std::string report;  // JSON file, "" = none
    std::string progress = "auto";
    std::string depfile;  // make rule, "" = none
    bool no_clobber = false;
    bool dry_run = false;
};

// What a verb did; goes into --report together with times per phase. Every figure printed is also put here.
struct Report {
    nlohmann::ordered_json figures = nlohmann::ordered_json::object();
    void phase(const std::string& name);  // ends the phase before, starts this one; wall seconds per phase are reported
    // Files that the run writes beside Verb::output, whose names depend on its inputs. Called before the work: they get
    // the checks of every output now, and go into the report and the depfile.
    void willWrite(const std::vector<std::filesystem::path>& files);
    std::vector<std::filesystem::path> written;
    std::function<void(const std::vector<std::filesystem::path>&)> check_written;  // set by runProgram
    std::vector<std::pair<std::string, double>> phases;                            // seconds
    std::chrono::steady_clock::time_point phase_start = std::chrono::steady_clock::now();
    std::string log_as;  // "penumbra-bake merge": phases are logged with a time stamp under this name; "" = are not
};

// One verb of a program. `define` adds the verb's own options to its subcommand; `inputs`/`output` are asked for after
// the parse (for --depfile, --no-clobber); `run` does the work and throws on failure. With --dry-run, `run` is called
// with options.dry_run set, prints what it would do and writes nothing.
struct Verb {
    std::string name, help;
    std::function<void(CLI::App&)> define;
    std::function<std::vector<std::filesystem::path>()> inputs;
    std::function<std::filesystem::path()> output;  // "" = none
    std::function<void(const CommonOptions&, Report&)> run;
    bool names_outputs = false;  // `run` calls Report::willWrite()
    bool checks_inputs = false;  // `run` says of every input that it cannot be read, not of the first alone
};

// Parses, runs one verb, writes report and depfile, turns exceptions into one line and an exit code. `format_versions`
// is printed by --version after the tool's own ("penumbra.visibility 1, ...").
int runProgram(const char* program, const char* description, const char* format_versions, std::vector<Verb> verbs,
               int argc, char** argv);

}  // namespace penumbra
