#pragma once
// Pages that other programs describe as JSON (formats/README.md, penumbra.page).
#include "fit/page/page_html.h"

namespace penumbra {

// `name` starts every message. InvalidInput names the place in the JSON, as in "sections[2].blocks[0].table.rows[1]".
Page parsePage(std::string_view json, const std::string& name);

}  // namespace penumbra
