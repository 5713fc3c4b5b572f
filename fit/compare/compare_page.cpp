#include "fit/compare/compare_page.h"

#include <cstdlib>

#include "formats/common/joined.h"

namespace penumbra {

namespace {

// Colours by Okabe and Ito, which the colour-blind can tell apart. They are lighter on a dark page.
constexpr const char* kStyle = R"css(
:root { color-scheme: light dark;
  --paper: #ffffff; --ink: #1d2430; --soft: #5c6675; --line: #d9dee6; --band: #f5f7fa; --link: #0b5cad;
  --c0: #0072b2; --c1: #d55e00; --c2: #a0529b; --c3: #00845c; --c4: #b07d00; --c5: #3b8fc4; --c6: #555e6b; --c7:
  #c03a5b; }
@media (prefers-color-scheme: dark) { :root {
  --paper: #12161c; --ink: #e4e9f0; --soft: #9aa6b6; --line: #2d3643; --band: #1a2029; --link: #7db8f0;
  --c0: #58b0ea; --c1: #f58a3c; --c2: #d894d2; --c3: #3fc79a; --c4: #e0b23c; --c5: #9ad1f5; --c6: #aab4c2; --c7:
  #f0829c; } }
@media print { :root { color-scheme: light;
  --paper: #ffffff; --ink: #000000; --soft: #444444; --line: #cccccc; --band: #f5f5f5; --link: #000000;
  --c0: #0072b2; --c1: #d55e00; --c2: #a0529b; --c3: #00845c; --c4: #b07d00; --c5: #3b8fc4; --c6: #555e6b; --c7:
  #c03a5b; } }
* { box-sizing: border-box; }
html { scroll-behavior: smooth; }
@media (prefers-reduced-motion: reduce) { html { scroll-behavior: auto; } }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main, header, footer { max-width: 1180px; margin: 0 auto; padding: 0 24px; }
header { padding-top: 40px; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 .3em; letter-spacing: -.01em; }
h2 { font-size: 1.35rem; line-height: 1.3; margin: 0; }
a { color: var(--link); text-underline-offset: .15em; }
a:focus-visible, .series:focus-visible, .scroll:focus-visible { outline: 2px solid var(--link); outline-offset: 2px; }
.skip { position: absolute; left: -999px; } .skip:focus { left: 24px; top: 8px; }
nav ol { list-style: none; display: flex; flex-wrap: wrap; gap: 6px 18px; padding: 12px 0; margin: 0 0 8px;
  border-top: 1px solid var(--line); border-bottom: 1px solid var(--line); }
dl.facts { display: grid; grid-template-columns: max-content 1fr; gap: 2px 20px; margin: 0 0 24px; }
dl.facts dt { color: var(--soft); } dl.facts dd { margin: 0; overflow-wrap: anywhere; }
dl.terms dt { font-weight: 600; } dl.terms dd { margin: 0 0 10px; max-width: 85ch; color: var(--soft); }
section { margin: 44px 0; }
.source { color: var(--soft); margin: 0 0 10px; font-size: .9rem; }
.finding { font-size: 1.06rem; margin: 0 0 14px; max-width: 80ch; border-left: 4px solid var(--c0); padding-left:
  14px; }
.method { color: var(--soft); font-size: .92rem; max-width: 85ch; margin: 12px 0; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 430px), 1fr)); gap: 18px 26px; }
.plots.three { grid-template-columns: repeat(auto-fit, minmax(min(100%, 320px), 1fr)); }
.plots > figure:only-child { max-width: 720px; } figure { margin: 0; } figcaption { font-weight: 600; margin: 0 0
  4px; font-size: .95rem; }
svg.plot { width: 100%; height: auto; display: block; overflow: visible; }
svg text { font-size: 12.5px; fill: var(--soft); } svg text.x { text-anchor: middle; } svg text.y { text-anchor: end; }
svg text.label { font-size: 13px; fill: var(--ink); } svg text.rule { text-anchor: end; font-style: italic; }
svg text.value { text-anchor: middle; font-size: 11px; }
svg text.rule, svg text.value { paint-order: stroke; stroke: var(--paper); stroke-width: 4px; stroke-linejoin: round; }
.grid { stroke: var(--line); stroke-width: 1; } .tick, .axis { stroke: var(--soft); fill: none; }
.rule { stroke-dasharray: 2 4; } line.rule { stroke: var(--soft); }
.series { stroke: none; } .series .line { fill: none; stroke: currentColor; stroke-width: 2; stroke-linejoin: round; }
.series > *:not(.line):not(text) { fill: currentColor; } .dashed .line { stroke-dasharray: 7 5; }
.dashed > *:not(.line):not(text) { fill: var(--paper); stroke: currentColor; stroke-width: 2; }
.bars.dashed > rect { fill: currentColor; fill-opacity: .22; stroke-width: 1.5; }
.points { opacity: .6; }
.c0 { color: var(--c0); } .c1 { color: var(--c1); } .c2 { color: var(--c2); } .c3 { color: var(--c3); }
.c4 { color: var(--c4); } .c5 { color: var(--c5); } .c6 { color: var(--c6); } .c7 { color: var(--c7); }
svg:has(.series:hover) .series:not(:hover), svg:has(.series:focus-visible) .series:not(:focus-visible) { opacity: .2; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 4px 22px; padding: 0; margin: 0 0 10px; font-size:
  .92rem; }
.legend svg { width: 30px; height: 12px; margin-right: 7px; overflow: visible; }
.scroll { overflow: auto; max-height: 460px; margin: 14px 0 0; }
thead th { position: sticky; top: 0; background: var(--paper); }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; min-width: 60%; }
caption { text-align: left; color: var(--soft); padding: 0 0 6px; }
th, td { padding: 4px 14px 4px 0; text-align: right; border-bottom: 1px solid var(--line); }
th { max-width: 16ch; } td { white-space: nowrap; } th.word, td.word { text-align: left; }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; }
tbody tr:hover { background: var(--band); }
footer { border-top: 1px solid var(--line); color: var(--soft); font-size: .85rem; padding-top: 16px;
  padding-bottom: 40px; }
footer code { overflow-wrap: anywhere; font-size: .95em; }
@media print { body { font-size: 10.5pt; } nav, .skip { display: none; } section { break-inside: avoid; margin: 24px
  0; }
  main, header, footer { max-width: none; padding: 0; } .scroll { overflow: visible; max-height: none; }
  thead th { position: static; } }
)css";

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

std::string tag(const char* name, const std::string& attributes, const std::string& content) {
    return std::string("<") + name + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + name + ">\n";
}

bool isNumber(const std::string& cell) {
    char* end = nullptr;
    std::strtod(cell.c_str(), &end);
    return cell == "-" || (!cell.empty() && *end == '\0');
}

std::string tableHtml(const Table& table, const std::string& caption) {
    std::string head, body;
    for (std::size_t c = 0; c < table.columns.size(); ++c) {
        const bool words = !table.rows.empty() && !isNumber(table.rows.front()[c]);
        head += tag("th", words ? "scope=\"col\" class=\"word\"" : "scope=\"col\"", escapeXml(table.columns[c]));
    }
    for (const auto& row : table.rows) {
        std::string cells;
        for (const std::string& cell : row) cells += tag("td", isNumber(cell) ? "" : "class=\"word\"", escapeXml(cell));
        body += tag("tr", "", cells);
    }
    const std::string content =
        tag("caption", "", escapeXml(caption)) + tag("thead", "", tag("tr", "", head)) + tag("tbody", "", body);
    return tag("div", "class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"" + escapeXml(caption) + "\"",
               tag("table", "", content));
}

std::string figureHtml(const Figure& figure) {
    std::string html = tag("h2", "", escapeXml(figure.title)) + tag("p", "class=\"source\"", escapeXml(figure.source)) +
                       tag("p", "class=\"finding\"", escapeXml(figure.finding));
    html += legendHtml(figure.plots);
    std::string plots;
    for (const Plot& plot : figure.plots)
        plots += tag("figure", "", tag("figcaption", "", escapeXml(plot.title)) + plotSvg(plot));
    html += tag("div", figure.plots.size() == 3 ? "class=\"plots three\"" : "class=\"plots\"", plots) +
            tag("p", "class=\"method\"", escapeXml(figure.method));
    if (!figure.table.rows.empty()) html += tableHtml(figure.table, figure.title + ": the numbers");
    return tag("section", "id=\"" + figure.id + "\"", html);
}

std::string factsHtml(const Comparison& comparison, const CompareSource& source) {
    const CompareOptions& options = comparison.options;
    std::string html;
    const auto fact = [&](const std::string& name, const std::string& value) {
        html += tag("dt", "", escapeXml(name)) + tag("dd", "", escapeXml(value));
    };
    fact("Character",
         source.file + ": " + grouped(source.vertices) + " vertices, " + std::to_string(source.joints) + " joints");
    fact("Trained on", std::to_string(source.train_frames) + " frames: " + joined(source.train_clips));
    fact("Held out", std::to_string(source.held_out_frames) + " frames: " + joined(source.held_out_clips));
    fact("Reference", std::to_string(options.referenceClusters()) + " clusters, output variance " +
                          shortNumber(options.referenceVariance()) + ", convention " +
                          options.referenceConvention().name());
    return tag("dl", "class=\"facts\"", html);
}

std::string footerHtml(const CompareSource& source) {
    std::string text =
        "<p>Made by " + escapeXml(source.provenance.tool) + " " + escapeXml(source.provenance.version) + ".</p>";
    for (const ProvenanceInput& input : source.provenance.inputs)
        text += "<p>Input " + escapeXml(input.name) + ", SHA-256 <code>" + escapeXml(input.sha256) + "</code></p>";
    return tag("footer", "", text + "<p>Options <code>" + escapeXml(source.provenance.options_json) + "</code></p>");
}

std::string headHtml(const std::string& title) {
    std::string head = "<meta charset=\"utf-8\">\n";
    head += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
    // The page loads nothing from outside, and nothing in it runs.
    head +=
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
        "img-src data:\">\n";
    return head + "<link rel=\"icon\" href=\"data:,\">\n" + tag("title", "", escapeXml(title)) +
           tag("style", "", kStyle);
}

std::string summaryHtml(const Comparison& comparison) {
    return tag("section", "id=\"summary\"",
               tag("h2", "", "Summary") + tag("p", "class=\"finding\"", escapeXml(modelsFinding(comparison))) +
                   tableHtml(summaryTable(comparison), "Every model at the reference"));
}

}  // namespace

std::string comparePage(const Comparison& comparison, const std::vector<Figure>& figures, const CompareSource& source) {
    const std::string title = "Models of visibility compared: " + source.file;
    std::string links = "<li><a href=\"#summary\">Summary</a></li>", sections;
    for (const Figure& figure : figures) {
        links += tag("li", "", "<a href=\"#" + figure.id + "\">" + escapeXml(figure.title) + "</a>");
        sections += figureHtml(figure);
    }
    links += "<li><a href=\"#terms\">Terms</a></li>";
    const std::string header = "<a class=\"skip\" href=\"#main\">Skip to the figures</a>" +
                               tag("h1", "", escapeXml(title)) + factsHtml(comparison, source) +
                               tag("nav", "aria-label=\"Contents\"", tag("ol", "", links));
    return "<!doctype html>\n<html lang=\"en\">\n" + tag("head", "", headHtml(title)) +
           tag("body", "",
               tag("header", "", header) +
                   tag("main", "id=\"main\"",
                       summaryHtml(comparison) + sections + tag("section", "id=\"terms\"", kTerms)) +
                   footerHtml(source)) +
           "</html>\n";
}

}  // namespace penumbra
