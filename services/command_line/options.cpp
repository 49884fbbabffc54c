#include "services/command_line/options.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include <CLI/CLI.hpp>

#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

std::vector<std::string> split(const std::vector<std::string>& words) {
  std::vector<std::string> pieces;
  for (const std::string& word : words) {
    std::string piece;
    for (const char c : word + " ") {
      if (c != ' ' && c != ',' && c != '\t' && c != '\n') {
        piece += c;
      } else if (!piece.empty()) {
        pieces.push_back(std::move(piece));
        piece.clear();
      }
    }
  }
  return pieces;
}

[[noreturn]] void refuse(const std::string& name, const std::string& text, const std::string& must_be) {
  throw Failure(ExitCode::kBadInput, name + " = '" + config::printable(text) + "' must be " + must_be);
}

/// Throws a usage error that suggests the nearest choice.
void require_choice(const std::string& name, const std::string& value, const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), value) != choices.end()) return;
  const std::vector<std::string_view> words(choices.begin(), choices.end());
  throw CLI::ValidationError(name + " = '" + config::printable(value) + "' must be " + config::alternatives(words));
}

}  // namespace

CLI::Option* add_number(CLI::App& app, const std::string& name, std::function<void(double)> set,
                        const std::string& description, const std::optional<config::Bounds>& bounds) {
  const auto read = [name, set = std::move(set), bounds](const std::string& text) {
    const auto value = config::parse_number(text);
    if (!value || (bounds && !bounds->allow(*value))) {
      refuse(name, text, bounds ? "a number " + bounds->text() : "a number");
    }
    set(*value);
  };
  return app.add_option_function<std::string>(name, read, description)->type_name("X");
}

CLI::Option* add_whole_number(CLI::App& app, const std::string& name, std::function<void(std::uint64_t)> set,
                              const std::string& description, std::uint64_t low, std::uint64_t high) {
  const auto read = [name, set = std::move(set), low, high](const std::string& text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || value < low || value > high) {
      refuse(name, text, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    set(value);
  };
  return app.add_option_function<std::string>(name, read, description)->type_name("N");
}

CLI::Option* add_seed(CLI::App& app, std::uint64_t& seed, const std::string& description) {
  return add_whole_number(
             app, "--seed", [&seed](std::uint64_t value) { seed = value; }, description, 0,
             std::numeric_limits<std::uint64_t>::max())
      ->type_name("S");
}

CLI::Option* add_duration(CLI::App& app, const std::string& name, double& seconds, const std::string& description,
                          double low, double high) {
  const auto set = [name, &seconds, low, high](const std::string& text) {
    const auto value = config::parse_duration(text);
    if (!value || !(*value >= low && *value <= high)) {
      refuse(name, text,
             "a number with its unit (" + std::string(config::kDurationUnits) + ") from " + duration_text(low) +
                 " to " + duration_text(high));
    }
    seconds = *value;
  };
  return app.add_option_function<std::string>(name, set, description)->type_name("DURATION");
}

CLI::Option* add_numbers(CLI::App& app, const std::string& name, std::vector<double>& numbers, std::size_t count,
                         const std::string& description, const std::optional<config::Bounds>& bounds) {
  const auto set = [name, &numbers, count, bounds](const std::vector<std::string>& words) {
    ParsedNumbers parsed = parse_numbers(words, count);
    if (parsed.error) throw Failure(ExitCode::kBadInput, name + ": " + *parsed.error);
    for (const double number : parsed.numbers) {
      if (!bounds || bounds->allow(number)) continue;
      refuse(name, config::number_text(number), "a number " + bounds->text());
    }
    numbers = std::move(parsed.numbers);
  };
  return app.add_option_function<std::vector<std::string>>(name, set, description)
      ->expected(1, -1)
      ->type_name("NUMBERS");
}

CLI::Option* add_pose(CLI::App& app, const std::string& name, std::vector<double>& xyz_rpy,
                      const std::string& description) {
  const auto set = [name, &xyz_rpy](const std::vector<std::string>& words) {
    constexpr std::array kParts = {" x", " y", " z", " roll", " pitch", " yaw"};
    ParsedNumbers parsed = parse_numbers(words, kParts.size());
    if (parsed.error) throw Failure(ExitCode::kBadInput, name + ": " + *parsed.error);
    for (std::size_t i = 0; i < kParts.size(); ++i) {
      const config::Bounds& bounds = i < 3 ? config::kCoordinate : config::kAngle;
      if (bounds.allow(parsed.numbers[i])) continue;
      refuse(name + kParts[i], config::number_text(parsed.numbers[i]), bounds.text());
    }
    xyz_rpy = std::move(parsed.numbers);
  };
  return app.add_option_function<std::vector<std::string>>(name, set, description)
      ->expected(1, -1)
      ->type_name("NUMBERS");
}

ParsedNumbers parse_numbers(const std::vector<std::string>& words, std::size_t count) {
  ParsedNumbers parsed;
  for (const std::string& piece : split(words)) {
    const auto number = config::parse_number(piece);
    if (!number || !std::isfinite(*number)) {
      parsed.error = "'" + config::printable(piece) + "' must be a finite number";
      return parsed;
    }
    parsed.numbers.push_back(*number);
  }
  const std::size_t given = parsed.numbers.size();
  if (count > 0 && given != count) {
    parsed.error = std::to_string(given) + " numbers given, must be " + std::to_string(count);
  } else if (given == 0) {
    parsed.error = "no number given, must be at least one";
  }
  return parsed;
}

world::Pose pose_of(const std::vector<double>& xyz_rpy) {
  return world::pose_from_xyz_rpy({xyz_rpy.at(0), xyz_rpy.at(1), xyz_rpy.at(2)},
                                  {xyz_rpy.at(3), xyz_rpy.at(4), xyz_rpy.at(5)});
}

std::vector<double> xyz_rpy_of(const world::Pose& pose) {
  const Eigen::Vector3d p = pose.translation();
  const Eigen::Vector3d rpy = world::rpy_of(pose.linear());
  return {p.x(), p.y(), p.z(), rpy.x(), rpy.y(), rpy.z()};
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
