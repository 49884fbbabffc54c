#pragma once
/// Numbers as people write them on the command line and read them in tables. A value that cannot be is bad input (a
/// Failure that names option, value and what is allowed), not wrong usage.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "services/config/bounds.hpp"
#include "world/model/pose.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace hecaton::services::cli {

/// An option for one number within the bounds; without any, `set` gets every number, also one that is not finite.
CLI::Option* add_number(CLI::App& app, const std::string& name, std::function<void(double)> set,
                        const std::string& description, const std::optional<config::Bounds>& bounds = {});

/// An option for a whole number from `low` to `high`.
CLI::Option* add_whole_number(CLI::App& app, const std::string& name, std::function<void(std::uint64_t)> set,
                              const std::string& description, std::uint64_t low, std::uint64_t high);

/// --seed S
CLI::Option* add_seed(CLI::App& app, std::uint64_t& seed, const std::string& description);

/// An option for a duration with its unit ("20ms"), kept in seconds within [low, high].
CLI::Option* add_duration(CLI::App& app, const std::string& name, double& seconds, const std::string& description,
                          double low, double high);

/// An option for numbers: in one word separated by blanks or commas, or in several words. Exactly `count` of them
/// (0: at least one), all finite and within the bounds.
CLI::Option* add_numbers(CLI::App& app, const std::string& name, std::vector<double>& numbers, std::size_t count,
                         const std::string& description, const std::optional<config::Bounds>& bounds = {});

/// An option for a pose, six numbers x y z [m] roll pitch yaw [rad] within the bounds of the cell file's poses.
CLI::Option* add_pose(CLI::App& app, const std::string& name, std::vector<double>& xyz_rpy,
                      const std::string& description);

/// The numbers in `words`, or the sentence that says why not.
struct ParsedNumbers {
  std::vector<double> numbers;
  std::string error;
};
[[nodiscard]] ParsedNumbers parse_numbers(const std::vector<std::string>& words, std::size_t count);

/// Six numbers: x y z [m], roll pitch yaw [rad] about the fixed axes x, y, z.
[[nodiscard]] world::Pose pose_of(const std::vector<double>& xyz_rpy);
/// The same six numbers; pitch within ±π/2.
[[nodiscard]] std::vector<double> xyz_rpy_of(const world::Pose& pose);

/// "850 µs", "17 ms", "0.42 s", "2 min 5 s"; "never" when negative: an age of what was never heard of.
[[nodiscard]] std::string duration_text(double seconds);
/// "18 mm", "0.418 m", "-3.2 mm"
[[nodiscard]] std::string distance_text(double metres);
/// Fixed point.
[[nodiscard]] std::string decimal_text(double value, int digits);
/// "12.5 MB" (10⁶ bytes)
[[nodiscard]] std::string bytes_text(double bytes);
/// "97.3 %"; "–" when the whole is 0
[[nodiscard]] std::string percent_text(double part, double whole);

}  // namespace hecaton::services::cli
