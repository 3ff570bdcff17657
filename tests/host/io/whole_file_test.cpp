#include "host/io/whole_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "host/core/errors.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

TEST(WholeFile, ReadsWhatWasWritten) {
    const TemporaryFolder folder;
    std::string bytes;
    for (int i = 0; i < 100000; ++i) bytes.push_back(static_cast<char>(i * 7));
    for (std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{4096}, bytes.size()}) {
        write_whole_file(folder / "f", bytes.substr(0, size));
        EXPECT_EQ(read_whole_file(folder / "f"), bytes.substr(0, size));
    }
}

TEST(WholeFile, LeavesNoTemporaryFile) {
    const TemporaryFolder folder;
    write_whole_file(folder / "f", "one");
    write_whole_file(folder / "f", "two");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
    EXPECT_EQ(read_whole_file(folder / "f"), "two");
}

TEST(WholeFile, KeepsTheOldFileWhenWritingFails) {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder / "target");
    write_whole_file(folder / "target/kept", "old");  // rename() onto a full folder fails
    EXPECT_THROW(write_whole_file(folder / "target", "new"), FileError);
    EXPECT_EQ(read_whole_file(folder / "target/kept"), "old");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(WholeFile, RefusesMoreThanTheBound) {
    const TemporaryFolder folder;
    write_whole_file(folder / "f", "0123456789");
    EXPECT_EQ(read_whole_file(folder / "f", 10).size(), 10U);
    EXPECT_NE(message_of([&] { (void)read_whole_file(folder / "f", 9); }).find("at most 9 bytes"),
              std::string::npos);
    EXPECT_THROW((void)read_whole_file("/dev/zero", 1 << 16), FileError);  // endless
}

TEST(WholeFile, SaysWhatIsWrong) {
    const TemporaryFolder folder;
    EXPECT_NE(message_of([&] { (void)read_whole_file(folder / "none"); }).find("No such file"),
              std::string::npos);
    EXPECT_NE(message_of([&] { (void)read_whole_file(folder.path()); }).find("found a folder"),
              std::string::npos);
    EXPECT_NE(message_of([&] { write_whole_file(folder / "no/where", ""); }).find("cannot create"),
              std::string::npos);
}

}  // namespace
}  // namespace stria
