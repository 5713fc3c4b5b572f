// Feeds BRACKET.json and SHOTS.json; see fuzz_visibility_file.cpp.
#include <string>

#include "formats/camera/bracket_file.h"
#include "formats/common/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(reinterpret_cast<const char*>(data), size);
    for (auto* parse : {penumbra::parseBracket, penumbra::parseShots}) {
        try {
            (void)parse(text, "bracket.json");
        } catch (const penumbra::InvalidInput&) {
        } catch (const penumbra::IoError&) {  // a camera or poses that the text names and nobody has
        }
    }
    return 0;
}
