#pragma once
// OUTPUT.journal: the coefficients that a bake has traced so far, so that a killed one goes on where it stopped
// (--resume). An HDF5 file whose writer was killed cannot be read; this can, up to the last whole frame.
//
// Layout: "PNBJRNL1", u64 bytes of the key, the key (JSON: provenance, number of frames, bytes a frame), its checksum;
// then for every traced frame in order its coefficients as they will be stored and a checksum over frame and
// coefficients. A frame with a wrong checksum ends the journal. Positions, bones and the like are posed again.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/stage/visibility_file.h"

namespace penumbra {

class BakeJournal {
public:
    // Takes over the journal that lies beside `output` if `resume` and it is of the same inputs, options and version;
    // else starts an empty one. IoError when `resume` and another bake is writing it; without `resume` this one then
    // has none: the other's stays.
    BakeJournal(const std::filesystem::path& output, const VisibilityHeader& header, Precision precision, bool resume);
    // Without finish(): kept when `resume` (its frames can still be used), else removed. A hard stop by a signal does
    // the same; SIGKILL leaves it.
    ~BakeJournal();
    BakeJournal(const BakeJournal&) = delete;
    BakeJournal& operator=(const BakeJournal&) = delete;

    std::size_t framesKept() const { return kept_; }                    // traced by a bake before
    const std::string& note() const { return note_; }                   // what the user should know, a sentence; or ""
    void read(std::size_t frame, std::span<float> coefficients) const;  // frame < framesKept(); IoError
    // The next frame. A full disk takes the journal away, not the bake.
    void append(std::span<const float> coefficients);
    void finish();  // the output is whole: removes it

private:
    std::filesystem::path path_;
    Precision precision_;
    std::size_t frame_bytes_ = 0;
    std::uint64_t records_begin_ = 0;
    std::size_t kept_ = 0, frames_ = 0;
    bool keep_ = false;  // when we stop before the end
    bool full_ = false;  // a write failed: no more frames
    int file_ = -1;      // locked while it is ours
    std::string note_;
    std::vector<std::byte> record_;

    void open(bool resume);
    std::string adopt(const std::string& key);
    void start(const std::string& key);
    bool readRecord(std::size_t frame, std::vector<std::byte>& record) const;
    void drop() noexcept;
};

}  // namespace penumbra
