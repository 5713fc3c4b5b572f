#include "formats/common/command_line.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <optional>
#include <set>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/parallel_for.h"
#include "formats/common/program_version.h"
#include "formats/common/sha256.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"

namespace penumbra {
namespace fs = std::filesystem;
using std::chrono::duration;
using std::chrono::steady_clock;

constexpr int kMaxThreads = 1024;
constexpr const char* kCommonGroup = "Options that all programs share";
constexpr Word<std::optional<ProgressStyle>> kProgressStyles[] = {{"auto", {}},
                                                                  {"none", ProgressStyle::kNone},
                                                                  {"bar", ProgressStyle::kBar},
                                                                  {"openjd", ProgressStyle::kOpenJd},
                                                                  {"alf", ProgressStyle::kAlf}};
constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 usage, 2 cannot read or write, 3 input invalid, 4 failed while running or stopped, "
    "5 unsupported";

void Report::phase(const std::string& name) {
    const steady_clock::time_point now = steady_clock::now();
    if (!phases.empty()) phases.back().second = duration<double>(now - phase_start).count();
    phases.emplace_back(name, 0.0);
    phase_start = now;
    if (!log_as.empty() && !name.empty()) logLine(log_as, name);
}

void Report::willWrite(const std::vector<fs::path>& files) {
    if (check_written) check_written(files);
    written.insert(written.end(), files.begin(), files.end());
}

void Report::willRead(const std::vector<fs::path>& files) {
    read.insert(read.end(), files.begin(), files.end());
    if (check_read) check_read(files);
}

// --- Parsing --------------------------------------------------------------------------------------------------------

namespace {

struct CommandLine {
    CLI::App app;
    CommonOptions common;
    std::optional<ProgressStyle> progress;  // unset: a bar on a terminal, else none
    std::vector<CLI::App*> verbs;           // in the order of the program's verbs
    explicit CommandLine(const char* description) : app(description) {}
};

void addCommonOptions(CLI::App& app, CommandLine& line) {
    CommonOptions& common = line.common;
    CLI::Option* quiet = app.add_flag("-q,--quiet", common.quiet, "No messages but errors")->group(kCommonGroup);
    app.add_flag("-v,--verbose", common.verbosity, "More messages; twice for still more")
        ->force_callback(false)  // CLI11 2.4 gives counted flags the value 0, which would exclude --quiet
        ->default_str("")
        ->excludes(quiet)
        ->group(kCommonGroup);
    app.add_option("--threads", common.threads, "Threads; else $PENUMBRA_THREADS, $CUE_THREADS, all cores")
        ->check(within(1, kMaxThreads))
        ->default_str("all cores")
        ->group(kCommonGroup);
    addChoice(app, "--progress", line.progress, kProgressStyles, "How progress is shown; auto: a bar on a terminal")
        ->group(kCommonGroup);
    app.add_option("--report", common.report, "Write what was done, figures and seconds a phase, as JSON")
        ->type_name("FILE")
        ->group(kCommonGroup);
    app.add_option("--depfile", common.depfile, "Write the files that were read as a make rule")
        ->type_name("FILE")
        ->group(kCommonGroup);
    app.add_flag("--no-clobber", common.no_clobber, "Refuse to replace an output that exists")->group(kCommonGroup);
    app.add_flag("--dry-run", common.dry_run, "Check everything, say what would be done, write nothing")
        ->group(kCommonGroup);
}

void defineCommandLine(CommandLine& line, const char* program, const std::string& version,
                       const std::vector<Verb>& verbs) {
    line.app.name(program);
    line.app.set_help_flag("-h,--help", "Print this and exit");
    line.app.set_version_flag("--version", version, "Print the versions of the program and of its formats, and exit");
    line.app.require_subcommand(1);
    line.app.get_formatter()->column_width(38);
    line.app.get_formatter()->label("Subcommands", "Verbs");
    line.app.footer(std::string("Options of a verb: ") + program + " VERB --help\n" + kExitCodes);
    for (const Verb& verb : verbs) {
        CLI::App* sub = line.app.add_subcommand(verb.name, verb.help)->group("Verbs");
        sub->footer(kExitCodes);
        sub->set_version_flag("--version", version, "Print versions and exit");
        sub->option_defaults()->always_capture_default();
        if (verb.define) verb.define(*sub);
        sub->option_defaults()->always_capture_default(false);
        for (CLI::Option* option : sub->get_options())
            if (option->get_default_str() == "[]") option->default_str("");  // an empty list
        addCommonOptions(*sub, line);
        line.verbs.push_back(sub);
    }
}

// Refuses an option that ends the line or stands before another option: CLI11 takes "-o" for the exposure in
// "--exposure -o x.png".
void checkValuesGiven(const CommandLine& line, int argc, char** argv) {
    const auto verb =
        std::ranges::find_if(line.verbs, [&](const CLI::App* v) { return argc > 1 && v->get_name() == argv[1]; });
    if (verb == line.verbs.end()) return;
    for (int i = 2; i < argc; ++i) {
        const CLI::Option* option = argv[i][0] == '-' ? (*verb)->get_option_no_throw(argv[i]) : nullptr;
        if (!option || option->get_items_expected_min() == 0) continue;
        if (i + 1 == argc || (argv[i + 1][0] == '-' && (*verb)->get_option_no_throw(argv[i + 1])))
            throw UsageError(std::string(argv[i]) + " needs a value");
    }
}

// Refuses what CLI11 lets through: empty values, and NaN or infinity where a number is asked for (both pass its range
// check).
void checkValues(const CLI::App& app) {
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_expected_max() == 0) continue;
        for (const std::string& value : option->results()) {
            if (value.empty()) throw UsageError(option->get_name() + ": the value is empty");
            if (option->get_type_name().find("FLOAT") != std::string::npos &&
                !std::isfinite(std::strtod(value.c_str(), nullptr)))
                throw UsageError(option->get_name() + ": " + value + " is not a finite number");
        }
    }
}

int threadsFromEnvironment() {
    for (const char* name : {"PENUMBRA_THREADS", "CUE_THREADS"}) {
        const char* text = std::getenv(name);
        if (!text || !*text) continue;
        char* end = nullptr;
        errno = 0;
        const long value = std::strtol(text, &end, 10);
        if (*end != '\0' || errno != 0 || value < 1 || value > kMaxThreads)
            throw UsageError(std::string(name) + ": " + text + " is not a number in [1 - " +
                             std::to_string(kMaxThreads) + "]");
        return int(value);
    }
    return hardwareThreads();
}

// Parses the command line. Returns the exit code if that was all (--help, --version).
std::optional<int> parse(CommandLine& line, const char* program, int argc, char** argv) {
    checkValuesGiven(line, argc, argv);
    try {
        line.app.parse(argc, argv);
    } catch (const CLI::Success& done) {
        line.app.exit(done, std::cout, std::cerr);
        return kExitOk;
    } catch (const CLI::ParseError& error) {
        const auto parsed = line.app.get_subcommands();
        const std::string name = std::string(program) + (parsed.empty() ? "" : " " + parsed.front()->get_name());
        std::string what = error.what();
        if (const std::size_t at = what.find(": must "); at != what.npos) what.erase(at, 1);
        if (parsed.empty())
            what = argc < 2 ? "a verb is required" : "\"" + std::string(argv[1]) + "\" is neither a verb nor an option";
        throw UsageError(what + " (see " + name + " --help)");
    }
    checkValues(*line.app.get_subcommands().front());
    if (line.common.threads == 0) line.common.threads = threadsFromEnvironment();
    const ProgressStyle automatic = ::isatty(STDERR_FILENO) ? ProgressStyle::kBar : ProgressStyle::kNone;
    line.common.progress = line.common.quiet ? ProgressStyle::kNone : line.progress.value_or(automatic);
    return std::nullopt;
}

struct Run {
    const char* program;
    const Verb& verb;
    const CLI::App& options;
    const CommonOptions& common;
    Report report;
    steady_clock::time_point start = steady_clock::now();
    bool report_checked = false;  // --report may be written

    std::vector<fs::path> inputs() const {
        std::vector<fs::path> all = verb.inputs ? verb.inputs() : std::vector<fs::path>{};
        all.insert(all.end(), report.read.begin(), report.read.end());
        return all;
    }
    fs::path output() const { return verb.output ? verb.output() : fs::path(); }
    std::vector<fs::path> outputs() const {
        std::vector<fs::path> all = report.written;
        if (const fs::path first = output(); !first.empty()) all.insert(all.begin(), first);
        return all;
    }
};

// --- Files: everything that can fail fails before the work ----------------------------------------------------------

void checkWritable(const fs::path& path, bool dry_run) {
    if (!dry_run) {
        const PartialFile probe(path);
        return;
    }
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        throw IoError(path.string() + ": cannot write here: " + std::strerror(errno));
}

// Tells whether two names mean one file, even if the file does not exist yet.
bool sameFile(const fs::path& first, const fs::path& second) {
    if (first.empty() || second.empty()) return false;
    const fs::path a = fs::absolute(first).lexically_normal(), b = fs::absolute(second).lexically_normal();
    std::error_code error;
    return a == b || fs::equivalent(a, b, error) ||
           (a.filename() == b.filename() && fs::equivalent(a.parent_path(), b.parent_path(), error));
}

void checkReplaceable(const fs::path& path, const Run& run) {
    if (path == "-") throw UsageError("-: nothing is written to standard output: name a file (./- names one, too)");
    for (const fs::path& input : run.inputs())
        if (sameFile(input, path)) throw UsageError(path.string() + ": is input and output");
    std::error_code error;
    if (run.common.no_clobber && fs::exists(path, error))
        throw IoError(path.string() + ": exists, and --no-clobber was given");
}

// Checks one of the files that a run writes.
void checkWritten(const fs::path& path, const Run& run) {
    if (path.empty()) return;
    int same = 0;
    for (const fs::path& written : {run.output(), fs::path(run.common.report), fs::path(run.common.depfile)})
        same += sameFile(written, path);
    if (same > 1) throw UsageError(path.string() + ": output, --report and --depfile must be different files");
    checkReplaceable(path, run);
    checkWritable(path, run.common.dry_run);
}

// Checks the files of Report::willWrite(). There may be thousands of them, so it tries to write one in each folder;
// the others must not be devices.
void checkManyWritten(const std::vector<fs::path>& files, const Run& run) {
    std::set<fs::path> names, folders;
    for (const fs::path& file : files) {
        if (!names.insert(fs::absolute(file).lexically_normal()).second)
            throw UsageError(file.string() + ": written twice");
        for (const fs::path& other : {run.output(), fs::path(run.common.report), fs::path(run.common.depfile)})
            if (sameFile(other, file))
                throw UsageError(file.string() + ": output, --report and --depfile must be different files");
        std::error_code error;
        const fs::file_status status = fs::status(file, error);
        if (fs::exists(status) && !fs::is_regular_file(status)) throw IoError(file.string() + ": not a regular file");
        if (folders.insert(file.parent_path()).second)
            checkWritten(file, run);
        else
            checkReplaceable(file, run);
    }
}

// Checks the files of Report::willRead().
void checkManyRead(const std::vector<fs::path>& files, const Run& run) {
    for (const fs::path& file : files) {
        checkReadable(file);
        for (const fs::path& output : {run.output(), fs::path(run.common.report), fs::path(run.common.depfile)})
            if (sameFile(file, output)) throw UsageError(output.string() + ": is input and output");
    }
}

// Checks the report first, because it is written for a failure too, but only when its own name may be written.
void checkFiles(Run& run) {
    checkWritten(run.common.report, run);
    run.report_checked = true;
    if (!run.common.depfile.empty() && run.output().empty() && !run.verb.names_outputs)
        throw UsageError("--depfile: this verb has no output to depend on");
    if (!run.verb.checks_inputs)
        for (const fs::path& input : run.inputs()) checkReadable(input);
    checkWritten(run.output(), run);
    checkWritten(run.common.depfile, run);
}

// Writes a name for a make rule: blanks and # take a backslash, and $ is doubled.
std::string makeName(const fs::path& path) {
    std::string name;
    for (char c : path.string()) {
        if (c == ' ' || c == '\t' || c == '#') name += '\\';
        if (c == '$') name += '$';
        name += c;
    }
    return name;
}

void writeDepfile(const std::string& path, const std::vector<fs::path>& outputs, const std::vector<fs::path>& inputs) {
    std::string rule;
    for (const fs::path& output : outputs) rule += (rule.empty() ? "" : " \\\n") + makeName(output);
    rule += ":";
    for (const fs::path& input : inputs) rule += " \\\n  " + makeName(input);
    writeWholeFile(path, rule + "\n");
}

// --- Running --------------------------------------------------------------------------------------------------------

// Returns the hashes of every file read and of the outputs, by path.
nlohmann::ordered_json hashesOf(const Run& run) {
    std::vector<fs::path> files = run.inputs();
    for (const fs::path& output : run.outputs()) files.push_back(output);
    nlohmann::ordered_json hashes = nlohmann::ordered_json::object();
    for (const fs::path& file : files) hashes[file.string()] = sha256OfFile(file);
    return hashes;
}

void writeReport(Run& run, int exit_code, const std::string& error) {
    if (!run.report_checked || run.common.report.empty() || run.common.dry_run) return;
    nlohmann::ordered_json json;
    json["schema"] = "penumbra.report";
    json["schema_version"] = 1;
    json["tool"] = run.program;
    json["version"] = programVersion();
    json["verb"] = run.verb.name;
    json["exit_code"] = exit_code;
    if (!error.empty()) json["error"] = error;
    json["threads"] = run.common.threads;
    json["inputs"] = nlohmann::ordered_json::array();
    for (const fs::path& input : run.inputs()) json["inputs"].push_back(input.string());
    json["output"] = run.output().string();
    if (run.verb.names_outputs) {
        json["outputs"] = nlohmann::ordered_json::array();
        for (const fs::path& output : run.outputs()) json["outputs"].push_back(output.string());
    }
    if (exit_code == kExitOk) json["sha256"] = hashesOf(run);
    json["seconds"] = duration<double>(steady_clock::now() - run.start).count();
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    json["peak_memory_bytes"] = std::int64_t(usage.ru_maxrss) * 1024;
    json["phases"] = nlohmann::ordered_json::array();
    if (!run.report.phases.empty()) {
        run.report.phase("");  // ends the last one
        run.report.phases.pop_back();
    }
    for (const auto& [name, seconds] : run.report.phases)
        json["phases"].push_back(nlohmann::ordered_json{{"name", name}, {"seconds", seconds}});
    json["figures"] = run.report.figures;
    writeWholeFile(run.common.report, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

// Fails when results did not reach the reader. The output stays, because it is whole. A reader that went away
// (| head) is no failure.
void flushResults() {
    std::cout.flush();
    errno = 0;
    if ((std::fflush(stdout) != 0 || std::ferror(stdout)) && errno != EPIPE)
        throw IoError("standard output: cannot write" + (errno ? std::string(": ") + std::strerror(errno) : ""));
}

// Runs the verb, and gives the option that a library complains about the name of its flag.
void callVerb(Run& run) try { run.verb.run(run.common, run.report); } catch (const BadOption& error) {
    std::string flag = "--" + error.option;
    std::ranges::replace(flag, '_', '-');
    if (!run.options.get_option_no_throw(flag)) throw;
    throw UsageError(flag + (error.problem.starts_with("must ") ? " " : ": ") + error.problem);
}

int runVerb(Run& run) {
    try {
        checkFiles(run);
        throwIfInterrupted();
        run.report.check_written = [&run](const std::vector<fs::path>& files) { checkManyWritten(files, run); };
        run.report.check_read = [&run](const std::vector<fs::path>& files) { checkManyRead(files, run); };
        if (run.common.verbosity > 0) run.report.log_as = run.program + (" " + run.verb.name);
        callVerb(run);
        flushResults();
        if (run.common.verbosity > 0)
            logLine(run.report.log_as,
                    "done after " + std::to_string(duration<double>(steady_clock::now() - run.start).count()) + " s");
        if (!run.common.depfile.empty() && !run.common.dry_run)
            writeDepfile(run.common.depfile, run.outputs(), run.inputs());
        writeReport(run, kExitOk, "");
        return kExitOk;
    } catch (const std::exception& error) {
        const int code = reportFailure(run.program, error);
        try {
            writeReport(run, code, error.what());
        } catch (const std::exception&) {  // the first failure is the one to tell
        }
        return code;
    }
}

std::string textOf(const std::vector<FileFormat>& formats) {
    std::string text;
    for (const FileFormat& format : formats)
        text += (text.empty() ? "" : ", ") + std::string(format.name) + " " + std::to_string(format.version);
    return text;
}

}  // namespace

int runProgram(const char* program, const char* description, const std::vector<FileFormat>& formats,
               std::vector<Verb> verbs, int argc, char** argv) try {
    catchSignals(program);
    const std::string version = std::string(program) + " " + programVersion() + "\nformats: " + textOf(formats);
    CommandLine line(description);
    defineCommandLine(line, program, version, verbs);
    if (const std::optional<int> done = parse(line, program, argc, argv)) {
        flushResults();
        return *done;
    }
    for (std::size_t i = 0; i < verbs.size(); ++i) {
        if (!line.verbs[i]->parsed()) continue;
        Run run{program, verbs[i], *line.verbs[i], line.common, {}};
        return runVerb(run);
    }
    return kExitUsage;
} catch (const std::exception& error) {
    return reportFailure(program, error);
}

}  // namespace penumbra
