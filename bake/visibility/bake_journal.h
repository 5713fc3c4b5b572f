#pragma once
// Keeps OUTPUT.journal, which holds the coefficients and local moments that a bake has traced so far. A bake that was
// killed goes on from it with --resume. Nobody can read an HDF5 file whose writer was killed, but a journal can be read
// up to its last whole frame.
//
// Layout: "PNBJRNL1", u64 number of bytes of the key, the key (JSON: provenance, number of frames, bytes a frame),
// the key's checksum. Then every traced frame follows in order: its coefficients, its local moments and its
// indirect transfer with the hit shares, where it has these, as they will be stored, and a checksum over the frame's
// number and all of them. A frame with a wrong checksum ends the
// journal. The bake poses positions, bones and the like again.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/stage/visibility_file.h"

namespace penumbra {

// Whether a bake resumes from the journal of an earlier one that was stopped, or starts again.
enum class Journal { kResume, kFresh };

class BakeJournal {
public:
    // With kResume, takes over the journal beside `output` when it has the same inputs, options and version. Otherwise
    // starts an empty journal. Another bake may be writing the same journal: with kResume that is an IoError;
    // otherwise this bake has no journal, and the other's stays.
    BakeJournal(const std::filesystem::path& output, const VisibilityHeader& header, Precision precision, Journal use);
    // Without finish(), keeps the journal with kResume, because its frames can still be used, and removes it
    // otherwise. A hard stop by a signal does the same; SIGKILL leaves the file.
    ~BakeJournal();
    BakeJournal(const BakeJournal&) = delete;
    BakeJournal& operator=(const BakeJournal&) = delete;

    std::size_t framesKept() const { return kept_; }   // frames that an earlier bake traced
    const std::string& note() const { return note_; }  // a sentence that the user should see; or ""
    // Fills in the coefficients and local moments of `out`, which have their sizes. frame < framesKept(); throws
    // IoError.
    void read(std::size_t frame, VisibilityFrame& out) const;
    // Adds the next frame. On a full disk the journal ends, but the bake goes on.
    void append(const VisibilityFrame& frame);
    void finish();  // call it when the output is whole; it removes the journal

private:
    std::filesystem::path path_;
    Precision precision_;
    std::size_t frame_bytes_ = 0;
    std::uint64_t records_begin_ = 0;
    std::size_t kept_ = 0, frames_ = 0;
    bool keep_ = false;  // keep the file when we stop before the end
    bool full_ = false;  // a write failed, so no more frames are written
    int file_ = -1;      // locked while it is ours; -1: no journal
    std::string note_;
    std::vector<std::byte> record_;

    void open(Journal use);
    std::string adopt(const std::string& key);
    void start(const std::string& key);
    bool readRecord(std::size_t frame, std::vector<std::byte>& record) const;
    void drop() noexcept;
};

}  // namespace penumbra
