// Tests the options that verbs share: what they take, and that a refusal names the option, the range and the value.
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/slot_choice.h"

namespace penumbra::test_options {
namespace {

enum class Fruit { kApple, kPear };
constexpr Word<Fruit> kFruits[] = {{"apple", Fruit::kApple}, {"pear", Fruit::kPear}};

struct Values {
    Fruit fruit = Fruit::kPear;
    std::vector<Fruit> basket;
    std::optional<FrameRange> frames;
    std::optional<Vec3> background;
    std::uint64_t seed = 1;
    double share = 1, factor = 1, part = 0.1;
    int rays = 16, width = 1, height = 1;
    std::string file, words;
};

// Parses one line of options into `values`. Returns what was refused, or "".
std::string parse(const std::string& line, Values& values) {
    CLI::App app;
    addChoice(app, "--fruit", values.fruit, kFruits, "");
    addChoices(app, "--basket", values.basket, kFruits, "");
    addFrames(app, values.frames, "");
    addParsed(app, "--background", values.background, readBackground, "");
    addSeed(app, values.seed, "");
    addSize(app, values.width, values.height);
    app.add_option("--share", values.share)->check(aShare());
    app.add_option("--factor", values.factor)->check(aboveZero());
    app.add_option("--rays", values.rays)->check(within(16, 1 << 16, "directions"));
    app.add_option("--part", values.part)->check(within(0.01, 0.3));
    app.add_option("--file", values.file)->check(endsIn({".png", ".exr"}));
    app.add_option("--frames-as-text", values.words)->check(readableBy(parseFrameRange));
    try {
        app.parse(line);
    } catch (const CLI::ParseError& error) {
        return error.what();
    }
    return "";
}

std::string refusal(const std::string& line) {
    Values values;
    return parse(line, values);
}

TEST(Options, AreReadAsTheirTypes) {
    Values values;
    EXPECT_EQ(parse("--fruit apple --basket pear,apple --basket pear --frames 2:10:3 --background 0.5/1/2e-1 --seed "
                    "18 --size 640x480 --share 1 --factor 1e9 --rays 65536 --file a.exr --frames-as-text 1:2",
                    values),
              "");
    EXPECT_EQ(values.fruit, Fruit::kApple);
    EXPECT_EQ(values.basket, (std::vector{Fruit::kPear, Fruit::kApple, Fruit::kPear}));
    EXPECT_EQ(values.frames->step, 3u);
    EXPECT_EQ(values.background, (Vec3{0.5f, 1, 0.2f}));
    EXPECT_EQ(values.seed, 18u);
    EXPECT_EQ(values.width * 1000 + values.height, 640480);
    EXPECT_EQ(parse("--background transparent", values), "");
    EXPECT_EQ(values.background, std::nullopt);
}

// The double 0.01 lies above the real number of that text, and the double 0.3 below; both still count as in range.
TEST(Options, BothEndsOfARangeAreInIt) {
    for (const char* value : {"0.01", ".01", "1e-2", "0.3", "0.1"})
        EXPECT_EQ(refusal(std::string("--part ") + value), "") << value;
    for (const char* value : {"0.0099999999", "0.3000000001", "nan", "x"})
        EXPECT_EQ(refusal(std::string("--part ") + value), std::string("--part: must be 0.01..0.3, not ") + value);
}

TEST(Options, ABackslashMakesACommaPartOfAName) {
    using Names = std::vector<std::string>;
    EXPECT_EQ(splitNames("walk,run"), (Names{"walk", "run"}));
    EXPECT_EQ(splitNames("walk\\, slow,run"), (Names{"walk, slow", "run"}));
    EXPECT_EQ(splitNames("a\\\\,b\\c"), (Names{"a\\", "b\\c"}));
    EXPECT_EQ(splitNames(",a"), (Names{"", "a"}));
}

TEST(Options, ABackslashMakesAnEqualsSignPartOfASlot) {
    const SlotChoice plain = parseSlotChoice("body/skin=lambert:color=1/1/1");
    EXPECT_EQ(plain.slot, "body/skin");
    EXPECT_EQ(plain.material, "lambert:color=1/1/1");
    const SlotChoice escaped = parseSlotChoice("a\\=b\\c=m.h5");
    EXPECT_EQ(escaped.slot, "a=b\\c");
    EXPECT_EQ(escaped.material, "m.h5");
    for (const char* wrong : {"", "=m", "a=", "a\\=m", "a"}) EXPECT_THROW(parseSlotChoice(wrong), BadOption) << wrong;
}

TEST(Options, ARefusalNamesOptionRangeAndValue) {
    EXPECT_EQ(refusal("--fruit plum"), "--fruit: must be one of apple, pear, not 'plum'");
    EXPECT_EQ(refusal("--basket pear,plum"), "--basket: must be one of apple, pear, not 'plum'");
    EXPECT_EQ(refusal("--basket pear,"), "--basket: an empty name in 'pear,'");
    EXPECT_EQ(refusal("--seed -1"), "--seed: must be 0..9223372036854775807, not -1");
    EXPECT_EQ(refusal("--seed 9223372036854775808"), "--seed: must be 0..9223372036854775807, not 9223372036854775808");
    for (const char* value : {"15", "65537", "20.5", "x"})
        EXPECT_EQ(refusal(std::string("--rays ") + value),
                  std::string("--rays: must be 16..65536 directions, not ") + value);
    EXPECT_EQ(refusal("--file a.jpg"), "--file: must end in .png or .exr, not a.jpg");
    EXPECT_EQ(refusal("--frames-as-text 2:1").substr(0, 30), "--frames-as-text: must be A:B ");
    for (const char* value : {"0", "-1", "nan", "1e", "1.001"})
        EXPECT_EQ(refusal(std::string("--share ") + value), std::string("--share: must lie in (0, 1], not ") + value);
    for (const char* value : {"0", "-0.5", "nan", "inf", "x"})
        EXPECT_EQ(refusal(std::string("--factor ") + value),
                  std::string("--factor: must be a finite number above 0, not ") + value);
    for (const char* value : {"640", "640x", "x480", "640x480x", "640*480", "99999999999x1", "1.5x2", "0x1", "1x16385"})
        EXPECT_EQ(refusal(std::string("--size ") + value).substr(0, 33), "--size: must be WIDTHxHEIGHT in p") << value;
    for (const char* value : {"1/1", "1/1/1/1", "a/b/c", "-1/0/0", "nan/0/0", "inf/0/0"})
        EXPECT_EQ(refusal(std::string("--background=") + value).substr(0, 22), "--background: must be ") << value;
}

}  // namespace
}  // namespace penumbra::test_options
