// BRACKET.json and SHOTS.json: what a photographer can write wrongly is refused with its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/camera/bracket_file.h"
#include "formats/common/errors.h"

namespace penumbra::test_bracket_file {
namespace {

using ::testing::HasSubstr;

const std::string kCamera = R"("camera": {"f": 600, "cx": 319.5, "cy": 239.5, "size": [640, 480]})";
const std::string kPose = R"("R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 2])";

std::string pictures(std::initializer_list<const char*> exposures) {
    std::string out = R"("pictures": [)";
    for (const char* exposure : exposures)
        out += std::string(out.back() == '[' ? "" : ", ") + R"({"file": "a.jpg", "exposure": )" + exposure + "}";
    return out + "]";
}

TEST(BracketFile, HasPathsFromItsOwnFolder) {
    const BracketFile read = parseBracket(
        "{" + kCamera + R"(, "response": "film.json", "tag": "36h11:3:0.7", )" + pictures({"4", "1"}) + "}",
        "shots/b.json");
    EXPECT_EQ(read.pictures.at(1).file, "shots/a.jpg");
    EXPECT_EQ(read.pictures.at(0).exposure, 4);
    EXPECT_EQ(read.response, "shots/film.json");
    EXPECT_EQ(read.tag, "36h11:3:0.7");
    ASSERT_TRUE(read.camera);
    EXPECT_EQ(read.camera->f, 600);
    EXPECT_FALSE(read.pose);
}

TEST(BracketFile, KeepsNamesOfResponsesAndNeedsOnlyPictures) {
    for (const char* name : {"find", "srgb", "linear", "rec709"})
        EXPECT_EQ(
            parseBracket(R"({"response": ")" + std::string(name) + "\", " + pictures({"1", "4"}) + "}", "x/b.json")
                .response,
            name);
    const BracketFile read = parseBracket("{" + kPose + ", " + pictures({"1", "4"}) + "}", "b.json");
    EXPECT_EQ(read.response, "");
    EXPECT_FALSE(read.camera);
    ASSERT_TRUE(read.pose);
    EXPECT_EQ(read.pose->translation.z, 2);
}

TEST(BracketFile, ShotsHaveAPoseEach) {
    const std::string shot = R"({"file": "/p/a.jpg", "exposure": 1, )" + kPose + "}";
    const BracketFile read =
        parseShots("{" + kCamera + R"(, "pictures": [)" + shot + ", " + shot + "]}", "shots/b.json");
    ASSERT_EQ(read.pictures.size(), 2u);  // pictures of a walk around may have the same exposure
    EXPECT_EQ(read.pictures[1].file, "/p/a.jpg");
    ASSERT_TRUE(read.pictures[1].pose);
    EXPECT_EQ(read.pictures[1].pose->translation.z, 2);
}

template <class Parse>
std::string problemOf(const Parse& parse, const std::string& text) {
    try {
        (void)parse(text, "b.json");
    } catch (const InvalidInput& problem) {
        return problem.what();
    }
    return "none";
}

TEST(BracketFile, RefusesWithThePlace) {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"{}", "b.json: /: has no \"pictures\""},
        {R"({"pictures": []})", "b.json: /pictures: has 0 pictures: a bracket has at least 2"},
        {"{" + pictures({"1"}) + "}", "b.json: /pictures: has 1 pictures"},
        {"{" + pictures({"4", "1", "1"}) + "}", "b.json: /pictures/2/exposure: is 1 like the one before"},
        {"{" + pictures({"4", "1", "2"}) + "}", "b.json: /pictures/2/exposure: is 2 after 1: the exposures"},
        {"{" + pictures({"4", "0"}) + "}", "b.json: /pictures/1/exposure: is 0, not in"},
        {"{" + pictures({"4", "-1"}) + "}", "b.json: /pictures/1/exposure: is -1, not in"},
        {"{" + pictures({"4", "null"}) + "}", "b.json: /pictures/1/exposure: must be a number"},
        {"{" + pictures({"4", "NaN"}) + "}", "b.json: not JSON"},
        {R"({"pictures": [{"file": "a.jpg"}]})", "b.json: /pictures/0: has no \"exposure\""},
        {R"({"pictures": [{"file": "", "exposure": 1}]})", "b.json: /pictures/0/file: is empty"},
        {R"({"pictures": [{"exposure": 1}]})", "b.json: /pictures/0: has no \"file\""},
        {R"({"pictures": [{"file": "a", "exposure": 1, )" + kPose + "}]}", "b.json: /pictures/0/R: unknown key"},
        {R"({"tag": "36h11:3:0.7", )" + kPose + ", " + pictures({"4", "1"}) + "}", "has a \"tag\" and a pose"},
        {R"({"R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], )" + pictures({"4", "1"}) + "}", "b.json: /: has no \"t\""},
        {R"({"R": [[2, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 1], )" + pictures({"4", "1"}) + "}",
         "b.json: /: has an R that is not a rotation"},
        {R"({"lens": 1, )" + pictures({"4", "1"}) + "}", "b.json: /lens: unknown key"},
    };
    for (const auto& [text, expected] : cases) EXPECT_THAT(problemOf(parseBracket, text), HasSubstr(expected)) << text;
}

TEST(BracketFile, RefusesShotsWithoutCameraOrPose) {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"{" + pictures({"4", "1"}) + "}", "b.json: /: has no \"camera\""},
        {"{" + kCamera + "}", "b.json: /: has no \"pictures\""},
        {"{" + kCamera + R"(, "pictures": []})", "b.json: /pictures: is empty"},
        {"{" + kCamera + ", " + pictures({"1"}) + "}", "b.json: /pictures/0: has no \"R\""},
        {"{" + kCamera + R"(, "tag": "36h11:3:1"})", "b.json: /tag: unknown key"},
        {"{" + kCamera + R"(, "pictures": [{"file": "a", "exposure": 1, "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],)" +
             R"("t": [0, null, 1]}]})",
         "b.json: /pictures/0/t/1: must be a number"},
    };
    for (const auto& [text, expected] : cases) EXPECT_THAT(problemOf(parseShots, text), HasSubstr(expected)) << text;
}

// A file that is cut short is no JSON, wherever the cut is.
TEST(BracketFile, RefusesEveryTruncation) {
    const std::string whole = "{" + kCamera + ", " + kPose + ", " + pictures({"4", "1"}) + "}";
    ASSERT_NO_THROW((void)parseBracket(whole, "b.json"));
    for (std::size_t n = 0; n < whole.size(); ++n)
        EXPECT_THROW((void)parseBracket(whole.substr(0, n), "b.json"), InvalidInput) << "first " << n << " bytes";
}

}  // namespace
}  // namespace penumbra::test_bracket_file
