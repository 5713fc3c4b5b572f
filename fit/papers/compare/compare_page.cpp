#include <map>

#include "fit/page/page_html.h"
#include "fit/papers/compare/compare_output.h"
#include "formats/common/joined.h"

namespace penumbra {

namespace {

constexpr const char* kTransferTerms = R"html(<h2>Terms</h2>
<dl class="terms">
<dt>E_transfer</dt><dd>The squared difference of predicted and baked transfer, integrated over the visible hemisphere
(Nowrouzezahrai 2007, section 6), mean over vertices and frames. It knows no light.</dd>
<dt>Relative E_transfer</dt><dd>Root of the summed E_transfer over the same sum of the baked transfer itself.</dd>
<dt>Relative error</dt><dd>Root of the summed squared difference of the coefficients over the summed squared deviation of
the baked ones from their mean over training frames. In the model frame that deviation holds what a turn of the body
changes; in local frames (the normal, and a tangent that the joint of the largest weight carries) it does not. The
difference is the same in both.</dd>
<dt>Models of visibility</dt><dd>Their predictions, multiplied by the cosine and integrated, are transfer of the same
order. The truth follows exactly from baked visibility of one order more.</dd>
<dt>Held out</dt><dd>Clips that no step of a fit has seen.</dd>
</dl>
)html";

constexpr const char* kTerms = R"html(<h2>Terms</h2>
<dl class="terms">
<dt>Relative error</dt><dd>Root of the summed squared error over the summed squared deviation from the training
mean, over frames,
vertices and numbers. 1 is no better than a static bake.</dd>
<dt>rms V</dt><dd>Root of the mean over frames and vertices of the squared error of the visibility function, mean
over the sphere.
The unit is that of V: 0 blocked, 1 open.</dd>
<dt>Ambient error</dt><dd>Mean over frames and vertices of the absolute error of E, the cosine-weighted open share
of the
hemisphere, 0 to 1.</dd>
<dt>Clamped</dt><dd>Each vertex' predicted numbers are moved the shortest way to where E lies in 0 to 1, as at run time,
before errors are taken. Figures that follow the papers without it say so.</dd>
<dt>Held out</dt><dd>Clips that no training step, no cross-validation and no choice of option has seen.</dd>
<dt>Composed</dt><dd>What the parts near a vertex in the skeleton block is learned (the local model), what each other
part blocks is looked up in a field of that part (--fields), and both are multiplied. Its convention is a mirrored one,
D.</dd>
<dt>Reference</dt><dd>Each figure varies one thing and holds the others at the reference: the middle value of each
list of
numbers, the first convention.</dd>
</dl>
)html";

// Returns a number with a comma at thousands, such as 13,380.
std::string grouped(std::size_t number) {
    std::string text = std::to_string(number);
    for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
    return text;
}

std::string tableHtml(const Table& table, const std::string& caption) {
    std::vector<TableColumn> columns;
    for (std::size_t c = 0; c < table.columns.size(); ++c)
        columns.push_back({table.columns[c], !table.rows.empty() && !isNumber(table.rows.front()[c])});
    std::vector<std::vector<TableCell>> rows;
    for (const auto& row : table.rows) {
        std::vector<TableCell>& cells = rows.emplace_back();
        for (const std::string& cell : row) cells.push_back({escapeXml(cell), !isNumber(cell)});
    }
    return tableHtml(caption, columns, rows);
}

// `picture` is the name of a file beside the page, or empty.
PageSection figureSection(const Figure& figure, const std::string& picture) {
    std::string html = tag("h2", "", escapeXml(figure.title)) + tag("p", "class=\"source\"", escapeXml(figure.source)) +
                       tag("p", "class=\"finding\"", escapeXml(figure.finding));
    html += figure.pictures + legendHtml(figure.plots);
    std::string plots;
    for (const Plot& plot : figure.plots)
        plots += tag("figure", "", tag("figcaption", "", escapeXml(plot.title)) + plotSvg(plot));
    html += tag("div", figure.plots.size() == 3 ? "class=\"plots three\"" : "class=\"plots\"", plots) +
            tag("p", "class=\"method\"", escapeXml(figure.method));
    if (!figure.table.rows.empty()) html += tableHtml(figure.table, figure.title + ": the numbers");
    if (!picture.empty())
        html += tag("p", "", "<img src=\"" + escapeXml(picture) + "\" alt=\"" + escapeXml(figure.finding) + "\">");
    return {figure.id, figure.title, html};
}

std::string footerHtml(const CompareSource& source) {
    std::string text =
        "<p>Made by " + escapeXml(source.provenance.tool) + " " + escapeXml(source.provenance.version) + ".</p>";
    for (const ProvenanceInput& input : source.provenance.inputs)
        text += "<p>Input " + escapeXml(input.name) + ", SHA-256 <code>" + escapeXml(input.sha256) + "</code></p>";
    return text + "<p>Options <code>" + escapeXml(source.provenance.options_json) + "</code></p>";
}

std::string fact(const std::string& name, const std::string& value) {
    return tag("dt", "", escapeXml(name)) + tag("dd", "", escapeXml(value));
}

// The parts in which the pages of the two kinds of comparison differ.
struct PageParts {
    std::string title, counts;                 // "Models of visibility compared", and what is counted beside vertices
    std::pair<std::string, std::string> fact;  // name and value of the last fact
    std::string finding, caption;              // texts of the summary and of its table
    Table summary;
    const char* terms;
    std::map<std::string, std::string> pictures{};  // file names beside the page, by the ids of figures
};

std::string pageOf(const PageParts& parts, const std::vector<Figure>& figures, const CompareSource& source) {
    Page page;
    page.title = parts.title + ": " + source.file;
    page.skip = "Skip to the figures";
    page.pictures = !parts.pictures.empty();
    page.facts =
        tag("dl", "class=\"facts\"",
            fact("Character", source.file + ": " + grouped(source.vertices) + " vertices, " + parts.counts) +
                fact("Trained on", std::to_string(source.train_frames) + " frames: " + joined(source.train_clips)) +
                fact("Held out", std::to_string(source.held_out_frames) + " frames: " + joined(source.held_out_clips)) +
                fact(parts.fact.first, parts.fact.second));
    page.sections.push_back({"summary", "Summary",
                             tag("h2", "", "Summary") + tag("p", "class=\"finding\"", escapeXml(parts.finding)) +
                                 tableHtml(parts.summary, parts.caption)});
    for (const Figure& figure : figures) {
        const auto picture = parts.pictures.find(figure.id);
        page.sections.push_back(figureSection(figure, picture == parts.pictures.end() ? "" : picture->second));
    }
    page.sections.push_back({"terms", "Terms", parts.terms});
    page.footer = footerHtml(source);
    return pageHtml(page);
}

}  // namespace

std::string comparePage(const Comparison& comparison, const std::vector<Figure>& figures, const CompareSource& source) {
    const CompareOptions& options = comparison.options;
    return pageOf({"Models of visibility compared",
                   std::to_string(source.joints) + " joints",
                   {"Reference", std::to_string(options.referenceClusters()) + " clusters, output variance " +
                                     shortNumber(options.referenceVariance()) + ", convention " +
                                     options.referenceConvention().name()},
                   modelsFinding(comparison),
                   "Every model at the reference",
                   summaryTable(comparison),
                   kTerms},
                  figures, source);
}

std::string transferPage(const TransferComparison& comparison, const std::vector<Figure>& figures,
                         const CompareSource& source, const std::string& picture, const std::string& bounces) {
    return pageOf({"Models of transfer compared",
                   std::to_string(comparison.angles) + " numbers of the pose",
                   {"Transfer", "order " + std::to_string(comparison.options.order)},
                   transferFinding(comparison),
                   "Every model, in a common measure",
                   transferSummary(comparison),
                   kTransferTerms,
                   {{"pictures", picture}, {"bounces", bounces}}},
                  figures, source);
}

}  // namespace penumbra
