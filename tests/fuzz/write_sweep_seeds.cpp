#include <random>
#include <string>

#include "tests/fuzz/write_seed.h"

namespace stria {
namespace {

// The layout of tests/firmware/stripe/byte_sweep.h.
struct Header {
    unsigned char min_snr = 85, min_amplitude = 60, most = 1, longest = 60, history = 12,
                  misfit = 85;
    unsigned char gain = 50, black = 0, read_noise = 40;
    unsigned char width = 9, height = 1, frames = 79, jitter = 110, exposure = 200, seed = 3;
    unsigned char dropped = 0, repeated = 0, late = 0, flicker = 0, flicker_period = 0;
};

struct Pixel {
    unsigned char background = 40, height = 120, width = 40, place = 128;
    unsigned char second = 0, apart = 0, noise = 60, seed = 0;
};

template <typename Part>
void append(std::string& bytes, const Part& part) {
    bytes.append(reinterpret_cast<const char*>(&part), sizeof part);  // bytes alone: no padding
}

/// Twenty pixels, each as `pixel` says of its number.
template <typename PixelOf>
std::string sweep(const Header& header, PixelOf&& pixel_of) {
    std::string bytes;
    append(bytes, header);
    for (int i = 0; i < 20; ++i) {
        Pixel pixel = pixel_of(static_cast<unsigned char>(i));
        pixel.seed = static_cast<unsigned char>(i);
        append(bytes, pixel);
    }
    return bytes;
}

unsigned char times(unsigned char i, int factor, int from) {
    return static_cast<unsigned char>(from + factor * i);
}

}  // namespace

void write_sweep_seeds(const std::filesystem::path& corpus) {
    const std::filesystem::path folder = corpus / "fuzz_fast_spacetime";
    const auto plain = [](unsigned char) { return Pixel{}; };
    const auto clean = [](unsigned char i) { return Pixel{.place = times(i, 5, 60)}; };
    write_seed(folder / "clean", sweep({}, clean));
    write_seed(folder / "clipped",
               sweep({}, [](unsigned char) { return Pixel{.background = 100, .height = 255}; }));
    write_seed(folder / "ends",
               sweep({}, [](unsigned char i) { return Pixel{.place = times(i, 13, 0)}; }));
    write_seed(folder / "narrow",
               sweep({}, [](unsigned char i) { return Pixel{.width = i, .noise = 20}; }));
    write_seed(folder / "one_frame", sweep({.frames = 0}, plain));
    write_seed(folder / "short", sweep({.frames = 6}, plain));
    write_seed(folder / "two", sweep({}, [](unsigned char i) {
                   return Pixel{.place = 80, .second = 150, .apart = times(i, 10, 0)};
               }));
    write_seed(folder / "weak", sweep({.min_snr = 20}, [](unsigned char i) {
                   return Pixel{.height = times(i, 2, 15)};
               }));
    write_seed(folder / "wide", sweep({.longest = 30}, [](unsigned char i) {
                   return Pixel{.width = times(i, 6, 120)};
               }));
    write_seed(folder / "flicker", sweep({.flicker = 120, .flicker_period = 60}, clean));
    write_seed(folder / "dropped", sweep({.dropped = 200}, clean));
    write_seed(folder / "repeated", sweep({.repeated = 200, .late = 200}, clean));
    write_seed(folder / "its_noise", sweep({}, [](unsigned char i) {
                   return Pixel{.place = times(i, 5, 60), .noise = 255};
               }));
    std::string single = sweep({}, [](unsigned char) { return Pixel{.height = 0}; });
    std::mt19937 rng(3);
    for (int i = 0; i < 90; ++i) single += static_cast<char>(rng() & 0xff);
    write_seed(folder / "single_samples", single);
}

}  // namespace stria
