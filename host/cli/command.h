#pragma once
#include <memory>
#include <string>
#include <vector>

#include "host/cli/json_result.h"

namespace stria {

/// Declares a verb's arguments; CLI11 stays behind it. Targets must outlive the parse.
class Arguments {
  public:
    virtual ~Arguments() = default;
    virtual void positional(const std::string& name, std::string& value, const std::string& help,
                            bool required = true) = 0;
    virtual void positional(const std::string& name, std::vector<std::string>& values,
                            const std::string& help, bool required = true) = 0;
    /// name with its dashes: "--out".
    virtual void option(const std::string& name, std::string& value, const std::string& help,
                        bool required = false) = 0;
    virtual void option(const std::string& name, double& value, const std::string& help) = 0;
    virtual void option(const std::string& name, int& value, const std::string& help) = 0;
    /// Takes all that follow up to the next option.
    virtual void option(const std::string& name, std::vector<std::string>& values,
                        const std::string& help) = 0;
    /// One of `choices`, anything else is a usage error.
    virtual void choice(const std::string& name, std::string& value,
                        const std::vector<std::string>& choices, const std::string& help) = 0;
    virtual void flag(const std::string& name, bool& value, const std::string& help) = 0;
};

/// What every verb has: the common options and where results go.
struct Context {
    bool json = false;  ///< --json: one result on stdout, nothing else there
    bool quiet = false;
    bool force = false;  ///< overwrite outputs that exist
    int threads = 0;
    unsigned seed = 1;
    std::string unit;  ///< empty: not given; mm

    double mm_per_unit() const;  ///< of --unit, 1 when not given
    /// A line for people: stdout, or stderr with --json; nothing with --quiet.
    void say(const std::string& line) const;
    /// Throws stria::Error if `path` exists and --force was not given.
    void check_output(const std::string& path) const;
    /// The verb's result: printed as JSON with --json.
    void finish(const JsonResult& result) const;
};

/// One subcommand. Its options are its members; run() does the work and returns the exit code.
class Verb {
  public:
    virtual ~Verb() = default;
    virtual std::string name() const = 0;     ///< "fuse", "mesh info"
    virtual std::string summary() const = 0;  ///< one line for --help
    virtual void declare(Arguments& arguments) = 0;
    virtual int run(const Context& context) = 0;
};

/// Every verb of the program, in the order --help shows.
std::vector<std::unique_ptr<Verb>> all_verbs();

}  // namespace stria
