#include "host/cli/temperature_option.h"

#include "host/core/errors.h"
#include "host/io/number_text.h"

namespace stria {

std::optional<double> TemperatureOption::value() const {
    if (text_.empty()) return {};
    const std::optional<double> celsius = parse_number(text_);
    if (!celsius || !(*celsius >= -100 && *celsius <= 200))
        throw Error("--temperature " + text_ + ": expected -100 to 200 degrees Celsius");
    return celsius;
}

}  // namespace stria
