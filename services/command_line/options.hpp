#pragma once
/// Options with checked values: numbers, durations, poses and choices. A number that is malformed or out of bounds is
/// bad input. Parsing then throws a Failure with the option, the value and the allowed values. A word that is no choice
/// is a usage error.
///
/// All functions add an option `name` with `description` to `app` and store or pass on the parsed value. References
/// and captured objects must outlive the parsing of `app`.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "services/config/text.hpp"
#include "world/model/pose.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hecaton::services::cli {

/// A number within `bounds`. Without bounds `set` also receives numbers that are not finite.
CLI::Option* add_number(CLI::App& app, const std::string& name, std::function<void(double)> set,
                        const std::string& description, const std::optional<config::Bounds>& bounds = {});

/// A whole number in [low, high].
CLI::Option* add_whole_number(CLI::App& app, const std::string& name, std::function<void(std::uint64_t)> set,
                              const std::string& description, std::uint64_t low, std::uint64_t high);

/// Option --seed.
CLI::Option* add_seed(CLI::App& app, std::uint64_t& seed, const std::string& description);

/// A duration with its unit ("20ms"); stored in seconds, within [low, high].
CLI::Option* add_duration(CLI::App& app, const std::string& name, double& seconds, const std::string& description,
                          double low, double high);

/// Finite numbers within `bounds`, in one word separated by blanks or commas, or in several words. There must be
/// `count` numbers, or at least one when `count` is 0.
CLI::Option* add_numbers(CLI::App& app, const std::string& name, std::vector<double>& numbers, std::size_t count,
                         const std::string& description, const std::optional<config::Bounds>& bounds = {});

/// A pose: six numbers x y z [m] roll pitch yaw [rad] within the bounds of poses in cell files.
CLI::Option* add_pose(CLI::App& app, const std::string& name, std::vector<double>& xyz_rpy,
                      const std::string& description);

/// One of `choices`. Help and completion list the choices; the usage error suggests the nearest.
CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& value, std::vector<std::string> choices,
                        const std::string& description);

/// Several of `choices`, separated by commas.
CLI::Option* add_choices(CLI::App& app, const std::string& name, std::vector<std::string>& values,
                         std::vector<std::string> choices, const std::string& description);

struct ParsedNumbers {
  std::vector<double> numbers;
  std::optional<std::string> error;  ///< a sentence; nothing: `numbers` is valid
};
/// The finite numbers in `words`: `count` of them, or at least one when `count` is 0.
[[nodiscard]] ParsedNumbers parse_numbers(const std::vector<std::string>& words, std::size_t count);

/// From x y z [m], roll pitch yaw [rad] about the fixed axes x, y, z in this order.
[[nodiscard]] world::Pose pose_of(const std::vector<double>& xyz_rpy);
/// The inverse of pose_of; pitch within ±π/2.
[[nodiscard]] std::vector<double> xyz_rpy_of(const world::Pose& pose);

}  // namespace hecaton::services::cli
