#pragma once
/// What came of a number of tasks: the report of `simulate` and of `up --tasks`, for programs and for people.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/command_line/document.hpp"
#include "services/command_line/terminal.hpp"
#include "world/sim/contact_referee.hpp"

namespace hecaton::services::cli {

/// Times on the machine's clock [µs].
struct Quantiles {
  double p50 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// Nothing without values.
[[nodiscard]] std::optional<Quantiles> quantiles(std::vector<double> values);
/// The smallest value that at least `share` of the values do not exceed; 0 without values.
[[nodiscard]] double quantile(const std::vector<double>& sorted, double share);

struct ArmReport {
  std::string name;
  int tasks = 0;
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
};

/// How often joints turned back while some pair was within its influence distance (planner/simulation/chatter.hpp).
struct ChatterReport {
  double turns_per_second = 0.0;  ///< and joint
  double quick_per_second = 0.0;  ///< of these: within 0.1 s after the joint's last turn
  double joint_seconds = 0.0;     ///< near constraints, summed over the joints [s]
};

/// What looking ahead cost.
struct RolloutReport {
  std::uint64_t answers = 0;
  std::uint64_t ticks = 0;   ///< of single arms, played for them
  std::optional<double> us;  ///< processor time for all of them [µs]; nothing: not measured
};

struct Report {
  std::string cell;
  std::string method;  ///< of all arms, or "as configured"
  std::uint64_t seed = 0;
  int tasks = 0;
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
  int not_drawn = 0;                          ///< asked for, but the cell did not admit them
  std::uint64_t contacts = 0;                 ///< the referee's
  std::optional<world::Separation> smallest;  ///< the referee's; nothing: it judged nothing
  double duration = 0.0;                      ///< [s], of the cell's own time
  std::optional<Quantiles> tick_us;
  std::vector<double> times;  ///< of the tasks that were reached [s]
  std::optional<ChatterReport> chatter;
  std::optional<RolloutReport> rollouts;
  std::vector<ArmReport> arms;
  Json faults = Json::array();
  Json extra = Json::object();  ///< more keys, behind those that every report has

  /// All tasks that were asked for.
  [[nodiscard]] int wanted() const { return tasks + not_drawn; }
  /// All of them reached, nothing touched.
  [[nodiscard]] bool positive() const { return tasks > 0 && reached == wanted() && contacts == 0; }
};

[[nodiscard]] Json to_json(const Report& report);
[[nodiscard]] std::string table_text(const Report& report, const Palette& palette);

/// Writes the report as JSON; throws Failure (bad input) when the file cannot be written.
void write_report(const std::string& path, const Report& report);
/// Throws Failure (bad input) when the file could not be written later. Leaves what is there as it is.
void check_writable(const std::string& path);

}  // namespace hecaton::services::cli
