#pragma once
/// Random tasks of `simulate` and `up --tasks`, and the report of their outcomes, for programs and for people.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/validate.hpp"
#include "world/sim/contact_monitor.hpp"

namespace hecaton::services::cli {

inline constexpr std::uint64_t kMostTasks = 100'000'000;

/// Throws Failure (bad input) when the cell file has no task area.
void require_tasks(const config::CellFile& file);

/// True if the cell file defines goals, or an area for them could be assumed.
[[nodiscard]] bool has_tasks(const config::CellFile& file);

/// Of times on the machine's clock [µs].
struct Quantiles {
  double p50 = 0.0;
  double p99 = 0.0;
  double max = 0.0;
};

/// Empty without values.
[[nodiscard]] std::optional<Quantiles> quantiles(std::vector<double> values);
/// The smallest value that is not below a fraction `share` of the values; 0 without values.
[[nodiscard]] double quantile(const std::vector<double>& sorted, double share);

struct ArmReport {
  std::string name;
  int tasks = 0;
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
};

/// Velocity reversals of joints while any pair was within its influence distance
/// (planner/simulation/velocity_reversals.hpp).
struct ReversalReport {
  double per_second = 0.0;        ///< per second and joint
  double quick_per_second = 0.0;  ///< of these: within 0.1 s after the joint's last reversal
  double joint_seconds = 0.0;     ///< time near constraints, summed over the joints [s]
};

/// Cost of rollouts.
struct RolloutReport {
  std::uint64_t answers = 0;
  std::uint64_t ticks = 0;   ///< simulated ticks of single arms
  std::optional<double> us;  ///< processor time of all rollouts [µs]; empty: not measured
};

/// A task that was not reached.
struct MissedTask {
  int round = 0;  ///< of goals for all arms, from 1
  std::string arm;
  std::string outcome;  ///< "blocked" or "timed_out"
  std::vector<double> goal;
  std::string reason;  ///< the end of a sentence
};

struct Report {
  std::string cell;
  std::string method;  ///< of all arms, or "as configured"
  std::uint64_t seed = 0;
  int asked = 0;  ///< tasks
  int tasks = 0;  ///< that have ended
  int reached = 0;
  int blocked = 0;
  int timed_out = 0;
  int not_drawn = 0;                          ///< tasks for which no goals were found
  std::uint64_t contacts = 0;                 ///< of the contact monitor
  std::optional<world::Separation> smallest;  ///< of the contact monitor; empty: no pair was checked
  double duration = 0.0;                      ///< on the cell's clock [s]
  std::optional<Quantiles> tick_us;
  std::vector<double> times;  ///< durations of the reached tasks [s]
  std::optional<ReversalReport> reversals;
  std::optional<RolloutReport> rollouts;
  std::vector<ArmReport> arms;
  std::vector<MissedTask> missed;
  std::vector<config::Finding> findings;   ///< about the run, not about its tasks
  std::optional<Interrupted> interrupted;  ///< empty: the run was complete
  Json faults = Json::array();
  Json extra = Json::object();  ///< keys that follow those of every report

  /// Of the tasks that have ended or could not be drawn.
  [[nodiscard]] int wanted() const { return tasks + not_drawn; }
  /// All tasks were reached without contact.
  [[nodiscard]] bool positive() const { return tasks > 0 && reached == asked && contacts == 0; }
  [[nodiscard]] ExitCode exit_code() const;
};

[[nodiscard]] Json to_json(const Report& report);
[[nodiscard]] std::string table_text(const Report& report, const Palette& palette);

/// Writes the report as JSON. Throws Failure (bad input) when the file cannot be written.
void write_report(const std::string& path, const Report& report);
/// Throws Failure (bad input) when the file cannot be opened for writing. Does not change an existing file.
void check_writable(const std::string& path);

}  // namespace hecaton::services::cli
