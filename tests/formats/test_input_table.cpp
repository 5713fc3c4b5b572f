#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "formats/common/errors.h"
#include "formats/stage/input_table.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_input_table {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

InputTable tableOf(const std::string& text) {
    static const samples::Folder folder("inputs");  // one for all: some tests read thousands of tables
    samples::writeBytes(folder.path / "x.csv", text);
    return readInputTable(folder.path / "x.csv");
}

std::string refusal(const std::string& text) {
    try {
        tableOf(text);
    } catch (const InvalidInput& error) {
        EXPECT_THAT(error.what(), HasSubstr("x.csv: "));
        return error.what();
    }
    return "accepted";
}

TEST(InputTable, FramesAndPoints) {
    const InputTable table = tableOf("frame,ball.x,ball.y,ball.z,wind\n0,1,2,3,-4e-1\n\n7,+1.5,2,3,4\n");
    EXPECT_TRUE(table.by_frame);
    EXPECT_THAT(table.names, ElementsAre("ball.x", "ball.y", "ball.z", "wind"));
    EXPECT_THAT(table.keys, ElementsAre(0, 7));
    EXPECT_THAT(table.values, ElementsAre(1, 2, 3, -0.4, 1.5, 2, 3, 4));
    EXPECT_THAT(table.lines, ElementsAre(2, 4));
    EXPECT_TRUE(table.clips.empty());
}

// Spreadsheets write a byte order mark, CRLF, quotes, blanks, and no end of the last line.
TEST(InputTable, WhatSpreadsheetsWrite) {
    const InputTable table =
        tableOf("\xef\xbb\xbf\"time\", clip ,\"wind, \"\"gusts\"\"\"\r\n0.5,\"a,b\",2\r\n1,c d, 3 ");
    EXPECT_FALSE(table.by_frame);
    EXPECT_THAT(table.names, ElementsAre("wind, \"gusts\""));
    EXPECT_THAT(table.clips, ElementsAre("a,b", "c d"));
    EXPECT_THAT(table.keys, ElementsAre(0.5, 1));
    EXPECT_THAT(table.values, ElementsAre(2, 3));
}

TEST(InputTable, WhatIsWrongIsNamed) {
    const std::pair<const char*, const char*> wrong[] = {
        {"", "no line of numbers"},
        {"frame,a\n", "no line of numbers"},
        {"a,frame\n1,2\n", "line 1: the first column"},
        {"frame\n1\n", "line 1: no column of an input"},
        {"frame,clip\n1,2\n", "line 1: no column of an input"},
        {"frame,a,a\n0,1,2\n", "'a' occurs twice"},
        {"frame,a,time\n0,1,2\n", "'time'"},
        {"frame,clip,a,clip\n0,b,1,c\n", "'clip'"},
        {"frame,,a\n0,1,2\n", "no name"},
        {"frame,b.x,b.y\n0,1,2\n", "b.x, b.y and b.z"},
        {"frame,b.y,b.x,b.z\n0,1,2,3\n", "b.x, b.y and b.z"},
        {"frame,b.x,c,b.y,b.z\n0,1,2,3,4\n", "b.x, b.y and b.z"},
        {"frame,b.z\n0,1\n", "b.x, b.y and b.z"},
        {"frame,a\n0,1,2\n", "line 2: 3 fields, not 2"},
        {"frame,a\n0\n", "line 2: 1 fields, not 2"},
        {"frame,a\n0,\n", "line 2: a: ''"},
        {"frame,a\n0,1e\n", "line 2: a: '1e'"},
        {"frame,a\n0,nan\n", "'nan'"},
        {"frame,a\n0,inf\n", "'inf'"},
        {"frame,a\n0,1e39\n", "'1e39'"},
        {"frame,a\n0,1e400\n", "'1e400'"},
        {"frame,a\n0.5,1\n", "line 2: frame: '0.5' is not a number of a frame"},
        {"frame,a\n-1,1\n", "frame: '-1'"},
        {"frame,a\n1e12,1\n", "frame: '1e12'"},
        {"time,a\n-0.1,1\n", "time: '-0.1' is not a time in seconds"},
        {"time,\"a\n0,1\n", "line 1: a quotation mark"},
        {"time,\"a\"b\n0,1\n", "line 1: text after"},
    };
    for (const auto& [text, part] : wrong) EXPECT_THAT(refusal(text), HasSubstr(part)) << text;
    EXPECT_THAT(refusal(std::string("frame,a\n0,1\0\n", 12)), HasSubstr("line 2"));
    EXPECT_THROW(readInputTable("/nowhere/x.csv"), IoError);
    EXPECT_THROW(readInputTable("/"), IoError);
}

TEST(InputTable, AnyBytesAreReadOrRefused) {
    const std::string whole = "time,clip,b.x,b.y,b.z,\"q\"\"\"\r\n0,walk,1,2,3,4\n0.25,\"ru,n\",1e-3,-2,3,4.5\n";
    for (std::size_t n = 0; n < whole.size(); ++n) (void)refusal(whole.substr(0, n));
    std::mt19937 random(5);
    for (int trial = 0; trial < 3000; ++trial) {
        std::string changed = whole;
        for (int flips = 1 + int(random() % 4); flips > 0; --flips) changed[random() % changed.size()] = char(random());
        (void)refusal(changed);
    }
}

}  // namespace
}  // namespace penumbra::test_input_table
