#pragma once
// The part of the command line that all programs share, on CLI11 (docs/commands.md). The files of the verbs and
// *_main.cpp include this; libraries do not.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/progress.h"

namespace penumbra {

struct CommonOptions {
    bool quiet = false;
    int verbosity = 0;
    int threads = 0;  // 0: --threads, else PENUMBRA_THREADS, else CUE_THREADS, else all cores; resolved by runProgram
    std::string report;  // JSON file, "" = none
    ProgressStyle progress = ProgressStyle::kNone;
    std::string depfile;  // make rule, "" = none
    bool no_clobber = false;
    bool dry_run = false;
};

// Collects what a verb did, for --report, together with the time of each phase. Every printed figure is also put
// here.
struct Report {
    nlohmann::ordered_json figures = nlohmann::ordered_json::object();
    // ends the phase before and starts this one; the report has the wall seconds of each
    void phase(const std::string& name);
    // Names the files that the run writes beside Verb::output, when their names depend on its inputs. Call it before
    // the work: the files then get the checks of every output, and go into the report and the depfile.
    void willWrite(const std::vector<std::filesystem::path>& files);
    // Names the files that the run reads beside Verb::inputs, when their names stand in its inputs. The same rules
    // hold.
    void willRead(const std::vector<std::filesystem::path>& files);
    std::vector<std::filesystem::path> written, read;
    std::function<void(const std::vector<std::filesystem::path>&)> check_written, check_read;  // set by runProgram
    std::vector<std::pair<std::string, double>> phases;                                        // seconds
    std::chrono::steady_clock::time_point phase_start = std::chrono::steady_clock::now();
    std::string log_as;  // "penumbra-bake merge": logs phases with a time stamp under this name; "": does not log
};

// One verb of a program. `define` adds the verb's own options to its subcommand. `inputs` and `output` are called
// after parsing (for --depfile and --no-clobber). `run` does the work and throws on failure. With --dry-run, `run`
// gets options.dry_run, prints what it would do, and writes nothing.
struct Verb {
    std::string name, help;
    std::function<void(CLI::App&)> define;
    std::function<std::vector<std::filesystem::path>()> inputs;
    std::function<std::filesystem::path()> output;  // "" = none
    std::function<void(const CommonOptions&, Report&)> run;
    bool names_outputs = false;  // `run` calls Report::willWrite()
    bool checks_inputs = false;  // `run` reports every input that cannot be read, not only the first
};

// Returns those of the names that are set.
inline std::vector<std::filesystem::path> namedFiles(std::vector<std::filesystem::path> files) {
    std::erase(files, std::filesystem::path());
    return files;
}

// Makes a verb of a struct that holds its options. inputs() of it tells what the run reads, and `output`, if it has
// one, what the run writes. Read is Command, or const where the run only reads it.
template <class Command, class Read = Command>
Verb verbOf(const char* name, const char* help, void (*define)(CLI::App&, Command&),
            void (*run)(Read&, const CommonOptions&, Report&)) {
    const auto command = std::make_shared<Command>();
    Verb verb{name,
              help,
              [=](CLI::App& app) { define(app, *command); },
              [=] { return command->inputs(); },
              {},
              [=](const CommonOptions& common, Report& report) { run(*command, common, report); }};
    if constexpr (requires { command->output; }) verb.output = [=] { return std::filesystem::path(command->output); };
    return verb;
}

// Parses the command line, runs one verb, writes report and depfile, and turns exceptions into one line and an exit
// code. --version prints the formats after the tool's own version ("penumbra.visibility 1, penumbra.poses 1, ...").
int runProgram(const char* program, const char* description, const std::vector<FileFormat>& formats,
               std::vector<Verb> verbs, int argc, char** argv);

}  // namespace penumbra
