#pragma once
// Round trips of files.
#include <gtest/gtest.h>

#include "tests/formats/stage_samples.h"

namespace penumbra::samples {

// Writes `written`, reads it, writes what was read, and expects the same bytes: a field that the reader drops shows.
template <class File, class Write, class Read>
File roundTrip(const File& written, const Write& write, const Read& read) {
    const Folder folder("round_trip");
    write(folder.path / "a", written);
    const File back = read(folder.path / "a");
    write(folder.path / "b", back);
    EXPECT_TRUE(bytesOf(folder.path / "a") == bytesOf(folder.path / "b")) << "what was read is written otherwise";
    EXPECT_EQ(folder.entries(), 2u);
    return back;
}

}  // namespace penumbra::samples
