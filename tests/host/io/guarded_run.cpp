#include "tests/host/io/guarded_run.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>

#include "host/core/errors.h"
#include "host/io/image_io.h"
#include "host/io/mesh_io.h"
#include "host/io/model_io.h"

namespace stria {
namespace {

[[noreturn]] void run_child(const std::function<std::string()>& work, double limit_s, int pipe) {
    alarm(static_cast<unsigned>(limit_s) + 1);
    char verdict = 'o';
    std::string message;
    try {
        message = work();
    } catch (const Error& error) {
        verdict = 'r';
        message = error.what();
    } catch (const std::exception& error) {
        verdict = 'x';
        message = std::string("not a stria::Error: ") + error.what();
    }
    message.insert(message.begin(), verdict);
    const bool sent = write(pipe, message.data(), message.size()) >= 0;
    _exit(sent && verdict != 'x' ? 0 : 3);
}

}  // namespace

GuardedResult run_guarded(const std::function<std::string()>& work, double limit_s) {
    GuardedResult result;
    int ends[2];
    if (pipe(ends) != 0) throw Error("cannot make a pipe");
    const auto begin = std::chrono::steady_clock::now();
    const pid_t child = fork();
    if (child == 0) run_child(work, limit_s, ends[1]);
    close(ends[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
        text.append(buffer, static_cast<std::size_t>(n));
    close(ends[0]);
    int status = 0;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    result.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    result.peak_mb = static_cast<double>(usage.ru_maxrss) / 1024.0;
    result.crashed = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
    if (!text.empty()) {
        result.refused = text[0] == 'r';
        result.message = text.substr(1);
    } else if (WIFSIGNALED(status)) {
        result.message = std::string("killed by signal ") + std::to_string(WTERMSIG(status));
    }
    return result;
}

std::string describe_image(const std::string& path) {
    const LoadedImage image = read_image(path);
    return std::to_string(image.pixels.width) + " x " + std::to_string(image.pixels.height) +
           " px, " + std::to_string(image.pixels.channels) + " channels of " +
           std::to_string(image.bits) + " bits";
}

std::string describe_file(const std::string& path) {
    const std::string ending = path.substr(std::min(path.rfind('.'), path.size()));
    for (const char* image : {".png", ".jpg", ".jpeg", ".tif", ".tiff"})
        if (ending == image) return describe_image(path);
    if (ending == ".conf") return std::to_string(read_poses(path).size()) + " poses";
    const auto names = [](const std::vector<VertexAttribute>& attributes) {
        std::string text;
        for (const VertexAttribute& attribute : attributes) text += ", " + attribute.name;
        return text;
    };
    if (is_points_only_path(path)) {
        const PointCloud cloud = read_points(path);
        return std::to_string(cloud.positions.size()) + " points, " +
               std::to_string(cloud.dropped) + " dropped" + names(cloud.attributes);
    }
    const TriMesh mesh = read_mesh(path);
    return std::to_string(mesh.positions.size()) + " vertices, " +
           std::to_string(mesh.triangles.size()) + " triangles" + names(mesh.attributes);
}

}  // namespace stria
