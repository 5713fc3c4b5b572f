// Feeds journals of killed bakes. The first byte tells how far a good one reaches before the bytes of the case begin.
// So these meet the key, the records and their checksums, and not only the magic.
#include "bake/visibility/bake_journal.h"
#include "formats/common/errors.h"
#include "tests/formats/stage_samples.h"

namespace {

const penumbra::VisibilityHeader& header() {
    static const penumbra::VisibilityHeader one = penumbra::samples::localHeader(1, 3);
    return one;
}

std::string goodJournal(const std::filesystem::path& output, const std::filesystem::path& journal) {
    {
        penumbra::BakeJournal out(output, header(), penumbra::Precision::kFloat32, penumbra::Journal::kResume);
        for (std::size_t f = 0; f < 3; ++f) out.append(penumbra::samples::visibilityFrame(header(), f));
    }
    return penumbra::samples::bytesOf(journal);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path output = "/dev/shm/penumbra_fuzz_bake" + std::to_string(::getpid());
    static const std::filesystem::path journal = output.string() + ".journal";
    static const std::string good = goodJournal(output, journal);
    if (size == 0) return 0;
    const std::size_t kept = good.size() * data[0] / 255;
    std::ofstream(journal, std::ios::binary | std::ios::trunc)
        << good.substr(0, kept) << std::string(reinterpret_cast<const char*>(data) + 1, size - 1);
    const penumbra::BakeJournal found(output, header(), penumbra::Precision::kFloat32, penumbra::Journal::kResume);
    penumbra::VisibilityFrame frame = penumbra::samples::visibilityFrame(header(), 0);
    for (std::size_t f = 0; f < found.framesKept(); ++f) found.read(f, frame);
    return 0;
}
