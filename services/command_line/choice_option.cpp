#include "services/command_line/choice_option.hpp"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

void require_choice(const std::string& name, const std::string& value, std::span<const std::string> choices) {
  const std::string refusal = refuse_choice(value, choices);
  if (!refusal.empty()) throw CLI::ValidationError(name + " = " + refusal);
}

}  // namespace

std::string refuse_choice(const std::string& value, std::span<const std::string> choices) {
  if (std::find(choices.begin(), choices.end(), value) != choices.end()) return {};
  const std::vector<std::string_view> words(choices.begin(), choices.end());
  return "'" + config::printable(value) + "' must be " + config::alternatives(words);
}

CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& value, std::vector<std::string> choices,
                        const std::string& description) {
  const std::string type = CLI::detail::join(choices, "|");
  const auto set = [name, &value, choices = std::move(choices)](const std::string& word) {
    require_choice(name, word, choices);
    value = word;
  };
  return app.add_option_function<std::string>(name, set, description)->type_name(type);
}

CLI::Option* add_choices(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                         std::vector<std::string> choices, const std::string& description) {
  const std::string type = CLI::detail::join(choices, "|");
  const auto set = [name, &values, choices = std::move(choices)](const std::vector<std::string>& words) {
    for (const std::string& word : words) require_choice(name, word, choices);
    values = words;
  };
  return app.add_option_function<std::vector<std::string>>(name, set, description)->delimiter(',')->type_name(type);
}

}  // namespace hecaton::services::cli
