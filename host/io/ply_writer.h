#pragma once
#include <cstdint>
#include <cstring>
#include <string>

namespace stria {

/// Appends numbers to the body of a binary little endian PLY.
class LittleEndianBytes {
  public:
    explicit LittleEndianBytes(std::string& bytes) : bytes_(bytes) {}

    template <typename T>
    void put(T value) {
        char raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        if constexpr (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__)
            for (std::size_t i = 0; i < sizeof(T) / 2; ++i)
                std::swap(raw[i], raw[sizeof(T) - 1 - i]);
        bytes_.append(raw, sizeof(T));
    }
    void put_float(double value) { put(static_cast<float>(value)); }

  private:
    std::string& bytes_;
};

}  // namespace stria
