#include "host/io/toml_file.h"

#include <gtest/gtest.h>

#include "host/core/errors.h"
#include "host/io/nearest_word.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

TEST(EditDistance, AgreesWithKnownDistances) {
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
    EXPECT_EQ(edit_distance("", "abc"), 3U);
    EXPECT_EQ(edit_distance("width", "widht"), 2U);
    EXPECT_EQ(edit_distance("same", "same"), 0U);
    EXPECT_EQ(nearest_word("heigth", {"width", "height", "fx"}), "height");
    EXPECT_EQ(nearest_word("x", {}), "");
}

TEST(TomlTable, ReadsEveryKindOfValue) {
    TomlTable top = parse_toml(
        "a = 1.5\nb = 2\nc = true\nd = 'text'\ne = [1, 2.5]\nf = ['x', 'y']\n[g]\nh = 3\n"
        "[[i]]\nj = 1\n[[i]]\nj = 2\n",
        "test.toml");
    EXPECT_EQ(top.number("a"), 1.5);
    EXPECT_EQ(top.number("b"), 2.0);
    EXPECT_EQ(top.integer("b"), 2);
    EXPECT_TRUE(top.boolean("c", false));
    EXPECT_EQ(top.text("d"), "text");
    EXPECT_EQ(top.numbers("e"), (std::vector<double>{1, 2.5}));
    EXPECT_EQ(top.texts("f"), (std::vector<std::string>{"x", "y"}));
    EXPECT_EQ(top.table("g").integer("h"), 3);
    std::vector<TomlTable> i = top.tables("i");
    ASSERT_EQ(i.size(), 2U);
    EXPECT_EQ(i[0].integer("j"), 1);
    EXPECT_EQ(i[1].integer("j"), 2);
    EXPECT_NO_THROW(top.finish());
}

TEST(TomlTable, GivesTheDefaultOfWhatIsMissing) {
    TomlTable top = parse_toml("", "test.toml");
    EXPECT_EQ(top.number("a", 7.0), 7.0);
    EXPECT_EQ(top.integer("a", 7), 7);
    EXPECT_TRUE(top.boolean("a", true));
    EXPECT_EQ(top.text("a", "t"), "t");
    EXPECT_FALSE(top.find_table("a"));
    EXPECT_TRUE(top.tables("a").empty());
    EXPECT_FALSE(top.has("a"));
}

TEST(TomlTable, NamesTheNearestKeyAndTheLineOfAnUnknownOne) {
    TomlTable top = parse_toml("[camera]\nwidth = 3\nheigth = 4\n", "c.toml");
    TomlTable camera = top.table("camera");
    camera.integer("width");
    camera.integer("height", 0);
    const std::string message = message_of([&] { top.finish(); });
    EXPECT_EQ(message,
              "c.toml: line 3: unknown key 'heigth' in [camera]: the nearest known key is "
              "'height'");
}

TEST(TomlTable, PointsOutAMisspelledRequiredKey) {
    TomlTable top = parse_toml("widht = 3\n", "c.toml");
    EXPECT_EQ(message_of([&] { top.integer("width"); }),
              "c.toml: line 1: missing key 'width' in the top of the file: found 'widht' here");
}

TEST(TomlTable, NamesAMissingKeyAndItsNestedTable) {
    TomlTable top = parse_toml("[[channel]]\n[channel.camera]\nfx = 1\n", "c.toml");
    std::vector<TomlTable> channels = top.tables("channel");
    TomlTable camera = channels.at(0).table("camera");
    EXPECT_EQ(message_of([&] { camera.number("width"); }),
              "c.toml: line 2: missing key 'width' in [channel.camera]");
}

TEST(TomlTable, RefusesWrongTypesAndCounts) {
    TomlTable top = parse_toml("a = 'x'\nb = 1.5\nc = [1, 2]\nd = nan\ne = [1, 'x']\n", "c.toml");
    EXPECT_NE(message_of([&] { top.number("a"); }).find("expected a number, found a text"),
              std::string::npos);
    EXPECT_NE(message_of([&] { top.integer("b"); }).find("expected an integer"), std::string::npos);
    EXPECT_NE(message_of([&] { top.numbers("c", 3); }).find("expected 3 numbers, found 2"),
              std::string::npos);
    EXPECT_NE(message_of([&] { top.number("d"); }).find("expected a finite number, found nan"),
              std::string::npos);
    EXPECT_NE(message_of([&] { top.numbers("e"); }).find("line 5"), std::string::npos);
    EXPECT_NE(message_of([&] { top.table("a"); }).find("expected a table [a]"), std::string::npos);
    EXPECT_NE(message_of([&] { top.tables("a"); }).find("[[a]]"), std::string::npos);
}

TEST(TomlTable, GivesTheLineOfASyntaxError) {
    const std::string message = message_of([] { parse_toml("a = 1\nb = \n", "c.toml"); });
    EXPECT_NE(message.find("c.toml: line 2: "), std::string::npos) << message;
}

TEST(TomlTable, SurvivesDeepNesting) {
    EXPECT_THROW(parse_toml("a = " + std::string(100000, '['), "deep"), FileError);
    std::string dotted = "[a";
    for (int i = 0; i < 20000; ++i) dotted += ".a";
    (void)message_of([&] { parse_toml(dotted + "]\n", "dotted").finish(); });
    std::string inline_tables;
    for (int i = 0; i < 20000; ++i) inline_tables += "{a=";
    EXPECT_THROW(parse_toml("a = " + inline_tables, "deep"), FileError);
}

}  // namespace
}  // namespace stria
