#include "host/project/project.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "host/core/errors.h"
#include "host/io/mesh_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

TEST(Project, OpensWhatWasCreated) {
    const TemporaryFolder folder;
    const Project made = create_project(folder / "part/", "Gear \"7\"");
    EXPECT_TRUE(is_project(folder / "part"));
    const Project opened = open_project(folder / "part");
    EXPECT_EQ(opened.name, "Gear \"7\"");
    EXPECT_EQ(opened.stria_version, made.stria_version);
    EXPECT_FALSE(opened.stria_version.empty());
    EXPECT_EQ(opened.scanner(), folder / "part/scanner.toml");
    EXPECT_EQ(open_or_create_project(folder / "part").name, opened.name);
    EXPECT_EQ(open_or_create_project(folder / "other").name, "other");
}

TEST(Project, RefusesFoldersOfOthers) {
    const TemporaryFolder folder;
    write_whole_file(folder / "mine.txt", "x");
    EXPECT_NE(message_of([&] { create_project(folder.path()); }).find("other content"),
              std::string::npos);
    EXPECT_NE(message_of([&] { open_project(folder.path()); }).find("no project.toml"),
              std::string::npos);
    EXPECT_THROW(create_project(folder / "no/parent"), FileError);
    create_project(folder / "part");
    EXPECT_NE(message_of([&] { create_project(folder / "part"); }).find("one that exists"),
              std::string::npos);
    write_whole_file(folder / "part/project.toml", "[project]\nnmae = 'x'\n");
    EXPECT_NE(
        message_of([&] { open_project(folder / "part"); }).find("nearest known key is 'name'"),
        std::string::npos);
}

TEST(Project, NumbersScansOnwards) {
    const TemporaryFolder folder;
    const Project project = create_project(folder / "part");
    EXPECT_TRUE(list_scans(project).empty());
    EXPECT_EQ(make_next_scan(project).name, "0001");
    EXPECT_EQ(make_next_scan(project).name, "0002");
    fs::create_directory(project.scans() + "/9999");
    EXPECT_EQ(make_next_scan(project).name, "10000");
    const auto scans = list_scans(project);
    ASSERT_EQ(scans.size(), 4U);
    EXPECT_EQ(scans[3].name, "10000");  // by number, not by letters
    EXPECT_EQ(scans[0].recording(), folder / "part/scans/0001/recording.stria");
    fs::create_directory(project.scans() + "/left");
    EXPECT_NE(message_of([&] { list_scans(project); }).find("named by numbers"), std::string::npos);
}

/// A project with a recording in scan 1, a range image in scan 2 and both in scan 3.
Project sample(const TemporaryFolder& folder) {
    const Project project = create_project(folder / "part");
    for (int i = 0; i < 3; ++i) {
        const ScanFolder scan = make_next_scan(project);
        if (i != 1) write_whole_file(scan.recording(), "x");
        if (i != 0) write_range_image(scan.range(), make_range_image(1, 1));
    }
    return project;
}

TEST(ResolveScans, TakesEveryKindOfArgument) {
    const TemporaryFolder folder;
    const Project project = sample(folder);
    const auto all = resolve_scans({folder / "part/"});
    ASSERT_EQ(all.size(), 3U);
    EXPECT_EQ(all[0].recording, folder / "part/scans/0001/recording.stria");
    EXPECT_EQ(all[0].range, "");
    EXPECT_EQ(all[1].recording, "");
    EXPECT_EQ(all[2].range, folder / "part/scans/0003/range.ply");
    EXPECT_EQ(all[2].name, folder / "part/scans/0003");

    write_points(folder / "cloud.ply", {});
    write_points(folder / "cloud.XYZ", {});
    const auto some = resolve_scans({folder / "part/scans/0001", all[1].range,
                                     folder / "part/scans/0003/recording.stria",
                                     folder / "cloud.ply", folder / "cloud.XYZ"});
    ASSERT_EQ(some.size(), 5U);
    EXPECT_EQ(some[0].name, folder / "part/scans/0001");
    EXPECT_EQ(some[1].range, all[1].range);
    EXPECT_EQ(some[2].recording, all[2].recording);
    EXPECT_EQ(some[3].points, folder / "cloud.ply");
    EXPECT_EQ(some[4].points, folder / "cloud.XYZ");
}

TEST(ResolveScans, SaysWhatIsWrong) {
    const TemporaryFolder folder;
    const auto message = [&](const std::vector<std::string>& names) {
        std::vector<std::string> paths;
        for (const std::string& name : names) paths.push_back(folder / name);
        return message_of([&] { resolve_scans(paths); });
    };
    EXPECT_NE(message({"none"}).find("no such file or folder"), std::string::npos);
    fs::create_directory(folder / "empty");
    EXPECT_NE(message({"empty"}).find("found neither"), std::string::npos);
    create_project(folder / "bare");
    EXPECT_NE(message({"bare"}).find("found none in its scans folder"), std::string::npos);
    const Project project = sample(folder);
    EXPECT_NE(message({"part", "part/scans/0001"}).find("named twice"), std::string::npos);
    write_whole_file(folder / "a.txt.gz", "x");
    EXPECT_NE(message({"a.txt.gz"}).find("found .gz"), std::string::npos);
    write_whole_file(folder / "bad.ply", "hello");
    EXPECT_NE(message({"bad.ply"}).find("expected 'ply'"), std::string::npos);
    make_next_scan(project);
    EXPECT_NE(message({"part"}).find("scans/0004: expected recording.stria or range.ply"),
              std::string::npos);
}

TEST(RelativeName, StartsAtTheFolderOfTheOtherFile) {
    EXPECT_EQ(relative_name("/a/part/scans/0001/range.ply", "/a/part/poses.toml"),
              "scans/0001/range.ply");
    EXPECT_EQ(relative_name("/a/b.ply", "/a/part/poses.toml"), "../b.ply");
    EXPECT_EQ(relative_name("x/../b.ply", "poses.toml"), "b.ply");
}

}  // namespace
}  // namespace stria
