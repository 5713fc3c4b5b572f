#include <gtest/gtest.h>

#include "fit/page/page_json.h"
#include "formats/common/errors.h"

namespace penumbra::test_page {
namespace {

std::string pageWith(const std::string& sections) {
    return R"({"schema": "penumbra.page", "schema_version": 1, "title": "Rigs & <lights>", "facts": ["2 rigs"], "sections": [)" +
           sections + "]}";
}

std::string sectionWith(const std::string& block) {
    return pageWith(R"({"id": "a", "title": "A", "blocks": [)" + block + "]}");
}

std::string tableWith(const std::string& rows) {
    return sectionWith(R"({"table": {"caption": "c", "columns": ["file", "s"], "rows": [)" + rows + "]}}");
}

std::string refusal(const std::string& json) {
    try {
        parsePage(json, "p.json");
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "accepted";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(PageJson, EveryBlockIsOnThePage) {
    const std::string html = pageHtml(parsePage(
        pageWith(
            R"({"id": "arm", "title": "Arm", "blocks": [{"paragraph": "Source: a<b"}, {"picture": {"file": "arm/s%20t.png", "alt": "\"truth\""}},
               {"table": {"caption": "Jobs & times", "columns": ["file", "s"],
                          "rows": [[{"text": "x", "link": "#arm"}, "1.5"], [{"text": "failed, 3", "bad": true}, "-"]]}}]})"),
        "p.json"));
    for (const char* part :
         {"<title>Rigs &amp; &lt;lights&gt;</title>", "<p class=\"source\">2 rigs</p>", "<a href=\"#arm\">Arm</a>",
          "<section id=\"arm\"><h2>Arm</h2>", "Source: a&lt;b",
          "<a href=\"arm/s%20t.png\"><img src=\"arm/s%20t.png\" alt=\"&quot;truth&quot;\"></a>",
          "aria-label=\"Jobs &amp; times\"", "<th scope=\"col\" class=\"word\">file</th>", "<th scope=\"col\">s</th>",
          "<td class=\"word\"><a href=\"#arm\">x</a></td>", "<td>1.5</td>", "<span class=\"bad\">failed, 3</span>",
          "default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data: file:", "href=\"#_main\"",
          "<main id=\"_main\">"})
        EXPECT_TRUE(contains(html, part)) << part << "\n" << html;
    EXPECT_FALSE(contains(html, "<script"));
}

TEST(PageJson, RefusalsNameThePlace) {
    EXPECT_EQ(refusal("[]"), "p.json: the file: takes an object");
    EXPECT_TRUE(contains(refusal("{\"schema\""), "p.json: no JSON: "));
    EXPECT_TRUE(contains(refusal(std::string(1000, '[')), "nested too deep"));
    EXPECT_EQ(refusal("{}"), "p.json: schema: missing");
    EXPECT_EQ(refusal(R"({"schema": "penumbra.page", "schema_version": 2})"), "p.json: schema_version: is not 1");
    EXPECT_EQ(refusal(pageWith("7")), "p.json: sections[0]: takes an object");
    EXPECT_EQ(refusal(sectionWith("{}")),
              "p.json: sections[0].blocks[0]: takes exactly one of paragraph, table, picture");
    EXPECT_EQ(refusal(sectionWith(R"({"plot": 1})")),
              "p.json: sections[0].blocks[0]: has the key 'plot'; it takes paragraph, table, picture");
    EXPECT_EQ(refusal(sectionWith(R"({"paragraph": 1})")), "p.json: sections[0].blocks[0].paragraph: takes text");
    EXPECT_EQ(refusal(tableWith(R"(["a", "1"], ["b"])")),
              "p.json: sections[0].blocks[0].table.rows[1]: has 1 cells, the table 2 columns");
    EXPECT_EQ(refusal(tableWith(R"(["a", {"text": "b", "bad": 1}])")),
              "p.json: sections[0].blocks[0].table.rows[0][1].bad: takes true or false");
    EXPECT_TRUE(contains(
        refusal(pageWith(R"({"id": "a", "title": "A", "blocks": []}, {"id": "a", "title": "B", "blocks": []})")),
        "p.json: sections[1].id: 'a' is the id of an earlier section too"));
    EXPECT_TRUE(
        contains(refusal(pageWith(R"({"id": "_main", "title": "A", "blocks": []})")), "p.json: sections[0].id: "));
}

TEST(PageJson, LinksStayBesideThePage) {
    for (const char* link :
         {"", "https://example.org/a", "javascript:alert(1)", "//example.org/a", "a b", "a\\\\b", "data:x"})
        EXPECT_TRUE(contains(refusal(tableWith(R"([{"text": "t", "link": ")" + std::string(link) + R"("}, "1"])")),
                             "table.rows[0][0].link: takes a relative, percent-encoded link"))
            << link;
    for (const char* link : {"a/b.h5", "#arm", "a%3Ab", "a/b:c"})
        EXPECT_EQ(refusal(tableWith(R"([{"text": "t", "link": ")" + std::string(link) + R"("}, "1"])")), "accepted")
            << link;
}

}  // namespace
}  // namespace penumbra::test_page
