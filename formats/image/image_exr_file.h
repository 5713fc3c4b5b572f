#pragma once
// OpenEXR files as the readers of this folder open them: bytes, parts and their layers.
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include <span>
#include <string>
#include <vector>

#include "formats/common/errors.h"
#include "formats/image/picture_rows.h"

namespace penumbra {

// A picture in a part: red, green and blue, or luminance.
struct ExrLayer {
    int part = 0;
    std::string prefix;                // before the last dot of its channels' names
    std::string shown;                 // its name in messages and for --layer; "" for R, G, B of the only part
    std::array<std::string, 3> color;  // whole names of channels; Y alone is three times the same
    std::string alpha;                 // "" where there is none
    bool has_chroma = false;           // Y with RY and BY
};

class ExrBytes : public Imf::IStream {
public:
    ExrBytes(const RandomBytes& bytes, const std::string& name)
        : Imf::IStream(name.c_str()), bytes_(bytes, kBuffer), size_(bytes.size) {}
    bool read(char out[], int count) override;
    std::uint64_t tellg() override { return bytes_.position(); }
    void seekg(std::uint64_t position) override;

private:
    static constexpr std::size_t kBuffer = 1 << 16;
    BufferedBytes bytes_;
    std::uint64_t size_;
};

// Sets the largest sizes that OpenEXR accepts; call before a file is opened.
void limitExr();
// Throws Unsupported for a part of more than 256 channels.
void checkExrParts(const Imf::MultiPartInputFile& file, const std::string& name);
// Returns all pictures in a file, in the order of parts and names. Parts of deep pixels have none.
std::vector<ExrLayer> layersOf(const Imf::MultiPartInputFile& file);
// Returns the picture that is meant. Without a wanted name it is R, G, B of the only part that has them, else the only
// layer. Throws InvalidInput, which lists what is in the file, where that is none or several.
ExrLayer chooseLayer(const Imf::MultiPartInputFile& file, const std::string& wanted, const std::string& name);

// Calls read() and gives every failure of OpenEXR the file's name.
auto withExrErrors(const std::string& name, const auto& read) {
    try {
        return read();
    } catch (const Unsupported&) {
        throw;
    } catch (const UsageError&) {
        throw;
    } catch (const IoError&) {
        throw;
    } catch (const InvalidInput& error) {
        const std::string what = error.what();
        throw InvalidInput(what.starts_with(name) ? what : name + ": " + what);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw InvalidInput(name + ": not a readable OpenEXR picture: " + error.what());
    }
}

}  // namespace penumbra
