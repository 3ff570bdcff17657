#pragma once
#include <stdexcept>
#include <string>

namespace stria {

/// A file, device or link failed. The message says what, where, what was expected and found, and
/// if there is one, what to do next. Caught once per command.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A file that cannot be read or written: "PATH:PLACE: expected X, found Y".
class FileError : public Error {
  public:
    /// @param place  "line 12", "byte 340", "element vertex"; may be empty
    FileError(const std::string& path, const std::string& place, const std::string& what)
        : Error(place.empty() ? path + ": " + what : path + ": " + place + ": " + what) {}
};

/// A device or link that does not do what was asked.
class DeviceError : public Error {
  public:
    using Error::Error;
};

}  // namespace stria
