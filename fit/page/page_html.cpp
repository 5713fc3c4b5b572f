#include "fit/page/page_html.h"

#include <cstdlib>

namespace penumbra {

namespace {

// Colours by Okabe and Ito, which the colour-blind can tell apart. They are lighter on a dark page.
constexpr const char* kPageStyle = R"css(
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
.series > path.spread { fill: none; stroke: var(--ink); stroke-width: 1.5; }
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

// Pages that show pictures.
constexpr const char* kPictureStyle = R"css(
img { max-width: 100%; height: auto; display: block; margin: 12px 0; }
.bad { color: var(--c7); font-weight: 600; }
)css";

std::string headHtml(const Page& page) {
    std::string head = "<meta charset=\"utf-8\">\n";
    head += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
    // The page loads nothing from outside, and nothing in it runs.
    head +=
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
        "img-src ";
    head += page.pictures ? "'self' data: file:" : "data:";
    return head + "\">\n<link rel=\"icon\" href=\"data:,\">\n" + tag("title", "", escapeXml(page.title)) +
           tag("style", "", std::string(kPageStyle) + (page.pictures ? kPictureStyle : ""));
}

}  // namespace

std::string tag(const char* name, const std::string& attributes, const std::string& content) {
    return std::string("<") + name + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + name + ">\n";
}

bool isNumber(const std::string& text) {
    char* end = nullptr;
    std::strtod(text.c_str(), &end);
    return text == "-" || (!text.empty() && *end == '\0');
}

std::string escapeXml(std::string_view text) {
    std::string out;
    for (char c : text) {
        if (c == '&')
            out += "&amp;";
        else if (c == '<')
            out += "&lt;";
        else if (c == '>')
            out += "&gt;";
        else if (c == '"')
            out += "&quot;";
        else
            out += c;
    }
    return out;
}

std::string tableHtml(const std::string& caption, const std::vector<TableColumn>& columns,
                      const std::vector<std::vector<TableCell>>& rows) {
    std::string head, body;
    for (const TableColumn& column : columns)
        head += tag("th", column.words ? "scope=\"col\" class=\"word\"" : "scope=\"col\"", escapeXml(column.name));
    for (const auto& row : rows) {
        std::string cells;
        for (const TableCell& cell : row) cells += tag("td", cell.words ? "class=\"word\"" : "", cell.html);
        body += tag("tr", "", cells);
    }
    const std::string content =
        tag("caption", "", escapeXml(caption)) + tag("thead", "", tag("tr", "", head)) + tag("tbody", "", body);
    return tag("div", "class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"" + escapeXml(caption) + "\"",
               tag("table", "", content));
}

std::string pageHtml(const Page& page) {
    std::string links, sections;
    for (const PageSection& section : page.sections) {
        links += tag("li", "", "<a href=\"#" + section.id + "\">" + escapeXml(section.title) + "</a>");
        sections += tag("section", "id=\"" + section.id + "\"", section.html);
    }
    const std::string header = "<a class=\"skip\" href=\"#" + page.main_id + "\">" + escapeXml(page.skip) + "</a>" +
                               tag("h1", "", escapeXml(page.title)) + page.facts +
                               tag("nav", "aria-label=\"Contents\"", tag("ol", "", links));
    return "<!doctype html>\n<html lang=\"en\">\n" + tag("head", "", headHtml(page)) +
           tag("body", "",
               tag("header", "", header) + tag("main", "id=\"" + page.main_id + "\"", sections) +
                   (page.footer.empty() ? "" : tag("footer", "", page.footer))) +
           "</html>\n";
}

}  // namespace penumbra
