#include "host/cli/run.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <new>
#include <sstream>

#include "host/cli/command.h"
#include "host/cli/version.h"
#include "host/core/errors.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

/// Arguments on top of one CLI11 subcommand.
class CliArguments final : public Arguments {
  public:
    explicit CliArguments(CLI::App& app) : app_(app) {}

    void positional(const std::string& name, std::string& value, const std::string& help,
                    bool required) override {
        app_.add_option(name, value, help)->required(required)->type_name("");
    }
    void positional(const std::string& name, std::vector<std::string>& values,
                    const std::string& help, bool required) override {
        app_.add_option(name, values, help)->required(required)->type_name("");
    }
    void option(const std::string& name, std::string& value, const std::string& help,
                bool required) override {
        app_.add_option(name, value, help)->required(required)->capture_default_str();
    }
    void option(const std::string& name, double& value, const std::string& help) override {
        app_.add_option(name, value, help)->capture_default_str();
    }
    void option(const std::string& name, int& value, const std::string& help) override {
        app_.add_option(name, value, help)->capture_default_str();
    }
    void option(const std::string& name, std::vector<std::string>& values,
                const std::string& help) override {
        app_.add_option(name, values, help);
    }
    void choice(const std::string& name, std::string& value,
                const std::vector<std::string>& choices, const std::string& help) override {
        app_.add_option(name, value, help)
            ->check(CLI::IsMember(choices))
            ->type_name("")
            ->capture_default_str();
    }
    void flag(const std::string& name, bool& value, const std::string& help) override {
        app_.add_flag(name, value, help);
    }

  private:
    CLI::App& app_;
};

void declare_common(CLI::App& app, Context& context) {
    app.add_flag("--json", context.json, "print one machine-readable result on stdout");
    app.add_flag("--quiet", context.quiet, "say nothing but errors and results");
    app.add_flag("--force", context.force, "overwrite outputs that exist");
    app.add_option("--threads", context.threads, "threads to use; 0: one a core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    app.add_option("--seed", context.seed, "seed of every random choice")->capture_default_str();
    app.add_option("--unit", context.unit, "unit of lengths in input files without one")
        ->check(CLI::IsMember({"mm", "m", "um", "in"}))
        ->type_name("");
}

/// The app of "calibrate camera" is a child of the app of "calibrate".
CLI::App& nested_app(CLI::App& root, const std::string& name, const std::string& summary) {
    CLI::App* at = &root;
    std::istringstream words(name);
    std::vector<std::string> parts;
    for (std::string word; words >> word;) parts.push_back(word);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const bool last = i + 1 == parts.size();
        const auto named = at->get_subcommands(
            [&](const CLI::App* candidate) { return candidate->get_name() == parts[i]; });
        CLI::App* child = named.empty() ? nullptr : named.front();
        if (!child) {
            child =
                at->add_subcommand(parts[i], last ? summary : "see stria " + parts[i] + " --help");
            if (!last) child->require_subcommand(1);
        }
        at = child;
    }
    return *at;
}

int run_verb(Verb& verb, const Context& context) {
    set_thread_count(context.threads);
    try {
        return verb.run(context);
    } catch (const Error& error) {
        std::fprintf(stderr, "stria %s: %s\n", verb.name().c_str(), error.what());
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "stria %s: out of memory\n", verb.name().c_str());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "stria %s: %s\n", verb.name().c_str(), error.what());
    }
    return 1;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
    CLI::App app("stria: the software of a laser-stripe scanner, from calibration to the mesh",
                 "stria");
    app.set_version_flag("--version", std::string("stria ") + kVersion);
    app.require_subcommand(1);
    app.fallthrough(false);

    Context context;
    auto verbs = all_verbs();
    std::map<const CLI::App*, Verb*> verb_of;
    for (auto& verb : verbs) {
        CLI::App& sub = nested_app(app, verb->name(), verb->summary());
        CliArguments arguments(sub);
        verb->declare(arguments);
        declare_common(sub, context);
        verb_of[&sub] = verb.get();
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    const CLI::App* chosen = &app;
    while (!chosen->get_subcommands().empty()) chosen = chosen->get_subcommands().front();
    return run_verb(*verb_of.at(chosen), context);
}

}  // namespace stria
