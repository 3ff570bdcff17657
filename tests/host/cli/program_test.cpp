#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "host/cli/command.h"
#include "host/cli/run.h"
#include "host/core/errors.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

/// Exit code and what was printed.
struct Ended {
    int code;
    std::string out, err;
};

Ended run(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int code = run_program(static_cast<int>(argv.size()), argv.data());
    return {code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(Program, HelpAndVersionEndWithZero) {
    const Ended version = run({"--version"});
    EXPECT_EQ(version.code, 0);
    EXPECT_EQ(version.out.find("stria "), 0U);
    const Ended help = run({"--help"});
    EXPECT_EQ(help.code, 0);
    for (const char* verb : {"mesh", "register", "fuse"}) EXPECT_TRUE(has(help.out, verb)) << verb;
    const Ended nested = run({"mesh", "convert", "--help"});
    EXPECT_EQ(nested.code, 0);
    for (const char* option : {"--out", "--json", "--force", "--unit", "--threads"})
        EXPECT_TRUE(has(nested.out, option)) << option;
}

TEST(Program, UsageErrorsEndWithTwo) {
    EXPECT_EQ(run({}).code, 2);
    EXPECT_EQ(run({"nonsense"}).code, 2);
    EXPECT_EQ(run({"mesh"}).code, 2);
    EXPECT_EQ(run({"mesh", "info"}).code, 2);
    EXPECT_EQ(run({"mesh", "info", "a.ply", "--nonsense"}).code, 2);
    EXPECT_EQ(run({"mesh", "info", "a.ply", "--unit", "ft"}).code, 2);
    EXPECT_EQ(run({"mesh", "info", "a.ply", "--threads", "-1"}).code, 2);
}

TEST(Program, FailuresEndWithOneAndSayWhy) {
    const Ended ended = run({"mesh", "info", "/nowhere/a.ply", "--json"});
    EXPECT_EQ(ended.code, 1);
    EXPECT_EQ(ended.out, "");
    EXPECT_TRUE(has(ended.err, "stria mesh info: /nowhere/a.ply: cannot open")) << ended.err;
}

TEST(Program, JsonStandsAloneOnStdout) {
    const TemporaryFolder folder;
    write_whole_file(folder / "a.obj", "v 0 0 0\nv 3 0 0\nv 0 4 0\nf 1 2 3\n");
    const Ended ended = run({"mesh", "info", folder / "a.obj", "--json"});
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
