#pragma once
/// Options whose value is one of a few words.

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hecaton::services::cli {

/// Anything else is a usage error that names the nearest. The help and the completion learn the choices from here.
CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& value, std::vector<std::string> choices,
                        const std::string& description);

/// The same for several words, separated by commas.
CLI::Option* add_choices(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                         std::vector<std::string> choices, const std::string& description);

/// "'xml' must be table, json or yaml"; empty when it is one of them.
[[nodiscard]] std::string refuse_choice(const std::string& value, std::span<const std::string> choices);

}  // namespace hecaton::services::cli
