#pragma once
// The one writer of Penumbra's HTML pages: head, style sheet, contents and tables. A page is one file that loads
// nothing from a network and runs no script; it suits light, dark and paper, keyboards and screen readers.
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

struct PageSection {
    std::string id, title;  // id: its anchor on the page
    std::string html;       // its contents, including the heading
};

struct Page {
    std::string title;
    std::string skip = "Skip to the contents";  // where a keyboard's first link says that it leads
    std::string main_id = "main";
    std::string facts;  // HTML under the title
    std::vector<PageSection> sections;
    std::string footer;     // HTML
    bool pictures = false;  // may show pictures that lie beside it
};

std::string pageHtml(const Page& page);

// <name attributes>content</name> and an end of line. `content` is HTML.
std::string tag(const char* name, const std::string& attributes, const std::string& content);

struct TableColumn {
    std::string name;
    bool words = false;  // to the left; numbers stand to the right
};
struct TableCell {
    std::string html;
    bool words = false;
};
// A table that scrolls by itself where it is wider than the page. `caption` is plain text.
std::string tableHtml(const std::string& caption, const std::vector<TableColumn>& columns,
                      const std::vector<std::vector<TableCell>>& rows);

// Is this text a number, or "-" in place of one?
bool isNumber(const std::string& text);
std::string escapeXml(std::string_view text);

}  // namespace penumbra
