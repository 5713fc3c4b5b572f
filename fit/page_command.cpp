// penumbra-fit page PAGE.json -o PAGE.html: a page of tables and pictures, as the farm describes it.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>

#include "fit/fit_verbs.h"
#include "fit/page/page_json.h"
#include "formats/common/errors.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

struct PageCommand {
    std::string input, output;

    std::vector<std::filesystem::path> inputs() const { return {input}; }
};

void define(CLI::App& app, PageCommand& command) {
    app.add_option("page", command.input, "what the page shows, penumbra.page JSON")->required();
    app.add_option("-o,--output", command.output, "page to write, NAME.html")->required();
}

void run(const PageCommand& command, const CommonOptions& common, Report& report) {
    report.phase("read");
    std::ifstream file(command.input, std::ios::binary);
    const std::string json{std::istreambuf_iterator<char>(file), {}};
    if (!file) throw IoError(command.input + ": cannot read");
    const Page page = parsePage(json, command.input);
    report.figures["sections"] = page.sections.size();
    if (common.dry_run) {
        std::printf("%zu sections; would write %s\n", page.sections.size(), command.output.c_str());
        return;
    }
    report.phase("write");
    writeWholeFile(command.output, pageHtml(page));
}

}  // namespace

Verb pageVerb() {
    return verbOf<PageCommand, const PageCommand>(
        "page", "A page of tables and pictures from JSON, in the style of compare.", define, run);
}

}  // namespace penumbra
