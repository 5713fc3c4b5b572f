// Tests the journal of a killed bake: it gives back what was put in, whatever happened to the file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bake/visibility/bake_journal.h"
#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_bake_journal {
namespace {
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

constexpr std::size_t kFrames = 5;

VisibilityHeader header() { return samples::visibilityHeader(2, kFrames); }

std::vector<float> coefficients(std::size_t frame) { return samples::visibilityFrame(header(), frame).coefficients; }

// Leaves the journal of a bake that was killed after `frames` frames.
void leaveJournal(const fs::path& output, std::size_t frames, Precision precision = Precision::kFloat32) {
    BakeJournal journal(output, header(), precision, Journal::kResume);
    for (std::size_t f = journal.framesKept(); f < frames; ++f) journal.append(samples::visibilityFrame(header(), f));
}

// Returns the number of frames kept, each of which must be the one that was put in.
std::size_t framesIn(const BakeJournal& journal) {
    VisibilityFrame found = samples::visibilityFrame(header(), kFrames);
    for (std::size_t f = 0; f < journal.framesKept(); ++f) {
        journal.read(f, found);
        EXPECT_EQ(found.coefficients, coefficients(f)) << f;
    }
    return journal.framesKept();
}

std::size_t framesIn(const fs::path& output) {
    return framesIn(BakeJournal(output, header(), Precision::kFloat32, Journal::kResume));
}

void write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

TEST(BakeJournal, GoesOnWhereItStopped) {
    const samples::Folder folder("journal");
    const fs::path output = folder.path / "x.vis.h5";
    leaveJournal(output, 2);
    EXPECT_EQ(framesIn(output), 2u);
    leaveJournal(output, 4);
    BakeJournal journal(output, header(), Precision::kFloat32, Journal::kResume);
    EXPECT_EQ(framesIn(journal), 4u);
    EXPECT_EQ(journal.note(), "");
    journal.finish();
    EXPECT_EQ(folder.entries(), 0u);
}

TEST(BakeJournal, KeepsHalvesAsTheFileWill) {
    const samples::Folder folder("journal_f16");
    const fs::path output = folder.path / "x.vis.h5";
    leaveJournal(output, 3, Precision::kFloat16);
    const BakeJournal journal(output, header(), Precision::kFloat16, Journal::kResume);
    ASSERT_EQ(journal.framesKept(), 3u);
    VisibilityFrame found = samples::visibilityFrame(header(), 0);
    journal.read(2, found);
    for (std::size_t i = 0; i < found.coefficients.size(); ++i)
        EXPECT_EQ(found.coefficients[i], halfToFloat(floatToHalf(coefficients(2)[i])));
}

TEST(BakeJournal, KeepsLocalMoments) {
    const samples::Folder folder("journal_local");
    const fs::path output = folder.path / "x.vis.h5";
    const VisibilityHeader with_local = samples::localHeader(2, kFrames);
    for (const Precision precision : {Precision::kFloat32, Precision::kFloat16}) {
        {
            BakeJournal journal(output, with_local, precision, Journal::kResume);
            for (std::size_t f = 0; f < 3; ++f) journal.append(samples::visibilityFrame(with_local, f));
        }
        BakeJournal journal(output, with_local, precision, Journal::kResume);
        ASSERT_EQ(journal.framesKept(), 3u);
        VisibilityFrame found = samples::visibilityFrame(with_local, 0);
        const VisibilityFrame expected = samples::visibilityFrame(with_local, 2);
        journal.read(2, found);
        const bool half = precision == Precision::kFloat16;
        const auto stored = [&](float value) { return half ? halfToFloat(floatToHalf(value)) : value; };
        for (std::size_t i = 0; i < found.coefficients.size(); ++i)
            ASSERT_EQ(found.coefficients[i], stored(expected.coefficients[i])) << i;
        for (std::size_t i = 0; i < found.local_coefficients.size(); ++i)
            ASSERT_EQ(found.local_coefficients[i], stored(expected.local_coefficients[i])) << i;
        journal.finish();
    }
    // A bake without local moments cannot go on from one with them.
    {
        BakeJournal(output, with_local, Precision::kFloat32, Journal::kResume)
            .append(samples::visibilityFrame(with_local, 0));
    }
    EXPECT_EQ(framesIn(output), 0u);
}

TEST(BakeJournal, CutAnywhereItKeepsTheWholeFrames) {
    const samples::Folder folder("journal_cut", samples::memoryFolder());
    const fs::path output = folder.path / "x.vis.h5", path = folder.path / "x.vis.h5.journal";
    leaveJournal(output, kFrames);
    const std::string whole = samples::bytesOf(path);
    const std::size_t record = coefficients(0).size() * 4 + 8, begin = whole.size() - kFrames * record;
    for (std::size_t size = 0; size <= whole.size(); ++size) {
        write(path, whole.substr(0, size));
        EXPECT_EQ(framesIn(output), size < begin ? 0 : (size - begin) / record) << size;
    }
}

TEST(BakeJournal, AFlippedBitCostsFramesButIsNeverRead) {
    const samples::Folder folder("journal_flip", samples::memoryFolder());
    const fs::path output = folder.path / "x.vis.h5", path = folder.path / "x.vis.h5.journal";
    leaveJournal(output, kFrames);
    const std::string whole = samples::bytesOf(path);
    for (std::size_t at = 0; at < whole.size(); ++at) {
        std::string changed = whole;
        changed[at] ^= char(1u << at % 8);
        write(path, changed);
        EXPECT_LT(framesIn(output), kFrames) << at;
    }
}

TEST(BakeJournal, AnotherBakesIsNamedAndNotUsed) {
    const samples::Folder folder("journal_foreign");
    const fs::path output = folder.path / "x.vis.h5", path = folder.path / "x.vis.h5.journal";
    VisibilityHeader other = header();
    other.provenance.options_json = R"({"order":3,"rays":128})";
    {
        BakeJournal journal(output, other, Precision::kFloat32, Journal::kResume);
        journal.append(samples::visibilityFrame(header(), 0));
    }
    {
        const BakeJournal journal(output, header(), Precision::kFloat32, Journal::kResume);
        EXPECT_EQ(journal.framesKept(), 0u);
        EXPECT_THAT(journal.note(), HasSubstr("rays 128, not 64"));
    }
    write(path, "PNBJRNL2 is of a later day, or of somebody else");
    EXPECT_THAT(BakeJournal(output, header(), Precision::kFloat32, Journal::kResume).note(),
                HasSubstr("is not the journal"));
    leaveJournal(output, 2);
    EXPECT_THAT(BakeJournal(output, header(), Precision::kFloat32, Journal::kFresh).note(), HasSubstr("discarded"));
    EXPECT_EQ(folder.entries(), 0u);
}

TEST(BakeJournal, BelongsToOneBakeAtATime) {
    const samples::Folder folder("journal_lock");
    const fs::path output = folder.path / "x.vis.h5";
    BakeJournal first(output, header(), Precision::kFloat32, Journal::kResume);
    first.append(samples::visibilityFrame(header(), 0));
    EXPECT_THROW(BakeJournal(output, header(), Precision::kFloat32, Journal::kResume), IoError);
    const BakeJournal second(output, header(), Precision::kFloat32, Journal::kFresh);
    EXPECT_THAT(second.note(), HasSubstr("another bake"));
    EXPECT_THROW(BakeJournal(folder.path / "no/x.vis.h5", header(), Precision::kFloat32, Journal::kFresh), IoError);
    fs::create_directory(folder.path / "y.journal");
    EXPECT_THROW(BakeJournal(folder.path / "y", header(), Precision::kFloat32, Journal::kResume), IoError);
}

// The key nests deeper than a stack is long.
TEST(BakeJournal, ADeepKeyIsOnlyForeign) {
    const samples::Folder folder("journal_deep");
    const fs::path output = folder.path / "x.vis.h5";
    VisibilityHeader deep = header();
    deep.provenance.options_json = R"({"a":)" + std::string(1000, '[') + std::string(1000, ']') + "}";
    { BakeJournal(output, deep, Precision::kFloat32, Journal::kResume).append(samples::visibilityFrame(header(), 0)); }
    const BakeJournal journal(output, header(), Precision::kFloat32, Journal::kResume);
    EXPECT_THAT(journal.note(), AllOf(HasSubstr("of another bake"), Not(HasSubstr("("))));  // nobody looked into it
}

}  // namespace
}  // namespace penumbra::test_bake_journal
