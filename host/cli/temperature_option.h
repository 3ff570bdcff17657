#pragma once
#include <optional>
#include <string>

#include "host/cli/command.h"

namespace stria {

/// --temperature of the scanner, degrees Celsius.
class TemperatureOption {
  public:
    void declare(Arguments& arguments, const std::string& help) {
        arguments.option("--temperature", text_, help);
    }
    /// Empty: not given. Throws stria::Error for what is no number, or outside -100 to 200.
    std::optional<double> value() const;

  private:
    std::string text_;
};

}  // namespace stria
