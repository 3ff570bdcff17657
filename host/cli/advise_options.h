#pragma once
#include <map>
#include <string>
#include <vector>

#include "host/advise/design.h"
#include "host/cli/command.h"

namespace stria {

/// The options of `stria advise`: numbers with units, each for a field of a design or of a scanner
/// that is there.
class AdviseOptions {
  public:
    void declare(Arguments& arguments);
    /// Defaults and named camera, overwritten by what was given. Throws std::invalid_argument.
    ScannerDesign design(const Context& context) const;
    /// The scanner of --scene or --model, overwritten by what was given. Options that it fixes are
    /// refused. Throws std::invalid_argument and what reading the file throws.
    AdvisedScanner existing(const Context& context) const;
    bool has_existing() const { return !scene_.empty() || !model_.empty(); }

  private:
    AdvisedScanner read_existing() const;
    void place_depths(const Context& context, AdvisedScanner& scanner) const;

    std::string scene_, model_, kind_, camera_, pixels_;
    bool perfect_lens_ = false;
    int channel_ = -1;                          ///< of the model; -1: not given
    std::map<std::string, std::string> texts_;  ///< option -> what was given, empty: nothing
};

}  // namespace stria
