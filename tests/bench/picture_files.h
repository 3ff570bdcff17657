#pragma once
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include "host/io/whole_file.h"
#include "host/render/plot.h"

/// What the programs that draw pictures share.
namespace stria::test {

/// Writes the plot as an SVG file of its own and prints the file's name.
inline void write_plot(const std::string& file, const LinePlot& plot) {
    std::string svg = line_plot_svg(plot);
    if (svg.find("xmlns=") == std::string::npos)
        svg.insert(svg.find("<svg") + 4, " xmlns=\"http://www.w3.org/2000/svg\"");
    write_whole_file(file, svg);
    std::printf("%s\n", file.c_str());
}

/// main() of a program with one argument, the folder to draw into, which is made.
inline int draw_into_folder(int argc, char** argv,
                            const std::function<void(const std::string& folder)>& draw_all) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: %s FOLDER\n", argc > 0 ? argv[0] : "pictures");
        return 2;
    }
    std::filesystem::create_directories(argv[1]);
    draw_all(argv[1]);
    return 0;
}

}  // namespace stria::test
