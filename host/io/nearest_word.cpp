#include "host/io/nearest_word.h"

#include <algorithm>
#include <numeric>

namespace stria {

std::size_t edit_distance(const std::string& a, const std::string& b) {
    constexpr std::size_t kLongest = 256;
    const std::size_t rows = std::min(a.size(), kLongest), columns = std::min(b.size(), kLongest);
    std::vector<std::size_t> distance(columns + 1);
    std::iota(distance.begin(), distance.end(), std::size_t{0});
    for (std::size_t i = 1; i <= rows; ++i) {
        std::size_t diagonal = distance[0];
        distance[0] = i;
        for (std::size_t j = 1; j <= columns; ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = distance[j];
            distance[j] = std::min({replaced, distance[j] + 1, distance[j - 1] + 1});
        }
    }
    return distance[columns];
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates) {
    std::string best;
    std::size_t least = static_cast<std::size_t>(-1);
    for (const std::string& candidate : candidates) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance < least) {
            least = distance;
            best = candidate;
        }
    }
    return best;
}

}  // namespace stria
