#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "host/core/errors.h"
#include "host/link/device_client.h"
#include "tests/host/local/small_scene.h"

extern char** environ;

namespace stria {
namespace {

namespace fs = std::filesystem;

/// striad-sim as a process of its own; what it prints goes into a file.
class Process {
  public:
    explicit Process(std::vector<std::string> arguments) {
        static int count = 0;
        output_ = (fs::temp_directory_path() /
                   ("striad_sim_" + std::to_string(::getpid()) + "_" + std::to_string(count++)))
                      .string();
        arguments.insert(arguments.begin(), STRIAD_SIM);
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 1, output_.c_str(), O_CREAT | O_WRONLY, 0600);
        posix_spawn_file_actions_adddup2(&actions, 1, 2);
        EXPECT_EQ(::posix_spawn(&pid_, STRIAD_SIM, &actions, nullptr, argv.data(), environ), 0);
        posix_spawn_file_actions_destroy(&actions);
    }
    ~Process() {
        if (pid_ > 0) stop(SIGKILL);
        fs::remove(output_);
    }
    /// Its exit code; 128 + the signal if one ended it.
    int wait() {
        int status = 0;
        ::waitpid(pid_, &status, 0);
        pid_ = 0;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    int stop(int signal) {
        ::kill(pid_, signal);
        return wait();
    }
    std::string output() const {
        std::ifstream in(output_);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    /// What follows "listening on " once it is printed, for each address; waits up to 20 s.
    std::vector<std::string> addresses(std::size_t count) const {
        std::vector<std::string> found;
        for (int i = 0; i < 400 && found.size() < count; ++i) {
            found.clear();
            std::ifstream in(output_);
            std::string line;
            while (std::getline(in, line))
                if (line.starts_with("listening on ")) found.push_back(line.substr(13));
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        EXPECT_EQ(found.size(), count) << output();
        return found;
    }

  private:
    ::pid_t pid_ = 0;
    std::string output_;
};

class StriadSim : public testing::Test {
  protected:
    void SetUp() override {
        const std::string name = "striad_sim_test_" + std::to_string(::getpid());
        folder_ = fs::temp_directory_path() / name;
        fs::create_directories(folder_);
        scene_ = (folder_ / "scene.toml").string();
        std::ofstream(scene_) << format_scene(small_scene());
        socket_ = "unix:" + (folder_ / "a.sock").string();
    }
    void TearDown() override { fs::remove_all(folder_); }
    fs::path folder_;
    std::string scene_, socket_;
};

TEST_F(StriadSim, ServesAScanOnUnixSocketAndLoopbackTcp) {
    Process server({scene_, "--listen", socket_, "--listen", "tcp:127.0.0.1:0"});
    const auto addresses = server.addresses(2);
    ASSERT_EQ(addresses.size(), 2U);
    const auto controller = connect_device(addresses[0]);
    const auto watcher = connect_device(addresses[1], {.control = false});
    EXPECT_TRUE(watcher->info().device.simulated);
    const RecordingContents scan = controller->run(small_sweep(small_scene()));
    ASSERT_TRUE(scan.end);
    EXPECT_TRUE(scan.end->complete) << scan.end->reason;
    ASSERT_EQ(scan.pulse_maps.size(), 1U);
    EXPECT_GT(scan.pulse_maps[0].pulses.size(), 1000U);
    EXPECT_THROW(watcher->run(small_sweep(small_scene())), DeviceError);
    EXPECT_EQ(server.stop(SIGTERM), 0);
    EXPECT_FALSE(fs::exists(folder_ / "a.sock"));
}

TEST_F(StriadSim, KilledItIsAnErrorForItsClientInTime) {
    Process server({scene_, "--listen", socket_});
    const auto device = connect_device(server.addresses(1).at(0));
    EXPECT_EQ(server.stop(SIGKILL), 128 + SIGKILL);
    EXPECT_THROW(device->info(), DeviceError);
    Process next({scene_, "--listen", socket_});  // the dead one's socket file is in its way
    EXPECT_NO_THROW(connect_device(next.addresses(1).at(0))->info());
    EXPECT_EQ(next.stop(SIGINT), 0);
}

TEST_F(StriadSim, StartsWithTheFastAnalysisIfAsked) {
    Process server({scene_, "--listen", socket_, "--fast"});
    const auto device = connect_device(server.addresses(1).at(0));
    EXPECT_EQ(std::get<bool>(device->feature("FastSpacetime").value), true);
    EXPECT_EQ(std::get<bool>(device->set_feature("FastSpacetime", false).value), false);
    EXPECT_EQ(server.stop(SIGTERM), 0);

    Scene deep = small_scene();
    deep.sensor.bits = 12;
    std::ofstream(scene_) << format_scene(deep);
    Process refused({scene_, "--listen", socket_, "--fast"});
    EXPECT_EQ(refused.wait(), 1);
    EXPECT_NE(refused.output().find("the reference analyses this camera's 12"), std::string::npos)
        << refused.output();
}

TEST_F(StriadSim, SaysWhatIsWrongWithItsArguments) {
    Process no_scene({(folder_ / "none.toml").string(), "--listen", socket_});
    EXPECT_EQ(no_scene.wait(), 1);
    EXPECT_NE(no_scene.output().find("none.toml"), std::string::npos);
    Process outside({scene_, "--listen", "tcp:0.0.0.0:7700"});
    EXPECT_EQ(outside.wait(), 1);
    EXPECT_NE(outside.output().find("keys"), std::string::npos);
    Process silent({scene_});
    EXPECT_EQ(silent.wait(), 2);
}

}  // namespace
}  // namespace stria
