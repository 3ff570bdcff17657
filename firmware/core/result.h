#pragma once
#include <cassert>
#include <cstddef>
#include <string>
#include <utility>
#include <variant>

namespace stria {

/// Why something could not be done: a sentence for people, and the byte where decoding stopped.
struct Failure {
    std::string message;  ///< what, where, expected and found
    std::size_t byte_offset =
        0;  ///< of the first byte that could not be used; 0 if not about bytes
};

/// A value, or why there is none. Bytes from outside and devices answer with it; nothing throws.
template <typename T>
class [[nodiscard]] Result {
  public:
    Result(T value) : content_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
    Result(Failure failure)
        : content_(std::move(failure)) {}  // NOLINT(google-explicit-constructor)

    bool ok() const { return content_.index() == 0; }
    explicit operator bool() const { return ok(); }

    /// The value; ok() must hold.
    const T& value() const& {
        assert(ok());
        return *std::get_if<0>(&content_);
    }
    T& value() & {
        assert(ok());
        return *std::get_if<0>(&content_);
    }
    T&& value() && {
        assert(ok());
        return std::move(*std::get_if<0>(&content_));
    }
    const T& operator*() const& { return value(); }
    T& operator*() & { return value(); }
    const T* operator->() const { return &value(); }
    T* operator->() { return &value(); }

    /// The failure; ok() must not hold.
    const Failure& failure() const {
        assert(!ok());
        return *std::get_if<1>(&content_);
    }

  private:
    std::variant<T, Failure> content_;
};

/// Done, or why not.
template <>
class [[nodiscard]] Result<void> {
  public:
    Result() = default;
    Result(Failure failure) : failure_(std::move(failure)), ok_(false) {}  // NOLINT

    bool ok() const { return ok_; }
    explicit operator bool() const { return ok_; }
    const Failure& failure() const {
        assert(!ok_);
        return failure_;
    }

  private:
    Failure failure_;
    bool ok_ = true;
};

using Status = Result<void>;

}  // namespace stria
