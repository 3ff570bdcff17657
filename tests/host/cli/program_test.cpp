#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "host/cli/command.h"
#include "host/core/errors.h"
#include "host/io/whole_file.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

using test_support::Ended;
using test_support::has;
using test_support::run_stria;

TEST(Program, HelpAndVersionEndWithZero) {
    const Ended version = run_stria({"--version"});
    EXPECT_EQ(version.code, 0);
    EXPECT_EQ(version.out.find("stria "), 0U);
    const Ended help = run_stria({"--help"});
    EXPECT_EQ(help.code, 0);
    for (const char* verb : {"mesh", "register", "fuse"}) EXPECT_TRUE(has(help.out, verb)) << verb;
    const Ended nested = run_stria({"mesh", "convert", "--help"});
    EXPECT_EQ(nested.code, 0);
    for (const char* option : {"--out", "--json", "--force", "--unit", "--threads"})
        EXPECT_TRUE(has(nested.out, option)) << option;
}

TEST(Program, UsageErrorsEndWithTwo) {
    EXPECT_EQ(run_stria({}).code, 2);
    EXPECT_EQ(run_stria({"nonsense"}).code, 2);
    EXPECT_EQ(run_stria({"mesh"}).code, 2);
    EXPECT_EQ(run_stria({"mesh", "info"}).code, 2);
    EXPECT_EQ(run_stria({"mesh", "info", "a.ply", "--nonsense"}).code, 2);
    EXPECT_EQ(run_stria({"mesh", "info", "a.ply", "--unit", "ft"}).code, 2);
    EXPECT_EQ(run_stria({"mesh", "info", "a.ply", "--threads", "-1"}).code, 2);
}

TEST(Program, FailuresEndWithOneAndSayWhy) {
    const Ended ended = run_stria({"mesh", "info", "/nowhere/a.ply", "--json"});
    EXPECT_EQ(ended.code, 1);
    EXPECT_EQ(ended.out, "");
    EXPECT_TRUE(has(ended.err, "stria mesh info: /nowhere/a.ply: cannot open")) << ended.err;
}

TEST(Program, JsonStandsAloneOnStdout) {
    const TemporaryFolder folder;
    write_whole_file(folder / "a.obj", "v 0 0 0\nv 3 0 0\nv 0 4 0\nf 1 2 3\n");
    const Ended ended = run_stria({"mesh", "info", folder / "a.obj", "--json"});
    EXPECT_EQ(ended.code, 0);
    EXPECT_EQ(ended.out.front(), '{');
    EXPECT_EQ(ended.out.substr(ended.out.size() - 2), "}\n");
    EXPECT_TRUE(has(ended.out, "\"area_mm2\": 6.0"));
    EXPECT_TRUE(has(ended.out, "\"boundary_edges\": 3"));
}

TEST(Verbs, HaveDifferentNamesAndSummaries) {
    std::set<std::string> names;
    for (const auto& verb : all_verbs()) {
        EXPECT_TRUE(names.insert(verb->name()).second) << verb->name();
        EXPECT_FALSE(verb->summary().empty()) << verb->name();
    }
}

TEST(JsonResult, KeepsOrderAndTurnsWhatIsNotFiniteIntoNull) {
    JsonResult inner;
    inner.set("b", 2).set("a", 1.5);
    JsonResult result;
    result.set("z", true)
        .set("text", "quote \" and \xFF")  // not UTF-8: replaced, never thrown
        .set("list", std::vector<double>{1, std::nan(""), 0.1})
        .set("inf", std::numeric_limits<double>::infinity())
        .set("count", std::size_t{7})
        .set("inner", inner)
        .set("many", std::vector<JsonResult>{inner, inner});
    EXPECT_EQ(
        result.text(-1),
        "{\"z\":true,\"text\":\"quote \\\" and \xEF\xBF\xBD\",\"list\":[1.0,null,0.1],"
        "\"inf\":null,\"count\":7,\"inner\":{\"b\":2,\"a\":1.5},\"many\":[{\"b\":2,\"a\":1.5},"
        "{\"b\":2,\"a\":1.5}]}");
}

TEST(Context, KeepsOutputsUnlessForced) {
    const TemporaryFolder folder;
    write_whole_file(folder / "there", "x");
    Context context;
    EXPECT_NO_THROW(context.check_output(folder / "new"));
    EXPECT_NE(message_of([&] { context.check_output(folder / "there"); }).find("--force"),
              std::string::npos);
    context.force = true;
    EXPECT_NO_THROW(context.check_output(folder / "there"));
    EXPECT_EQ(context.mm_per_unit(), 1.0);
    context.unit = "m";
    EXPECT_EQ(context.mm_per_unit(), 1000.0);
}

}  // namespace
}  // namespace stria
