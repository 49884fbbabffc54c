#pragma once
/// The newest of everything that a cell has sent until one instant. It knows no network and no file.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/planner.h>
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/cell_mode.hpp"
#include "services/runtime/latest_faults.hpp"

namespace hecaton::services {

/// A value: a copy is a checkpoint, which shares the obstacles with its original. For one thread.
class CellState {
 public:
  /// The newest sample of each key.
  template <class T>
  using Newest = std::map<std::string, bus::Sample<T>, std::less<>>;
  using Obstacles = std::map<std::string, msg::Obstacle>;

  /// `file` must outlive it. `began`: since when samples arrive.
  CellState(const config::CellFile& file, bus::Clock::time_point began)
      : file_(&file), began_(began), obstacles_(std::make_shared<const Obstacles>()) {}

  // Takes a sample, or the withdrawal of its key. The samples of a topic come in the order of their arrival.
  void apply(const bus::Sample<msg::ArmState>& sample) { keep(states_, sample); }
  void apply(const bus::Sample<msg::ObstacleStates>& sample) { keep(obstacle_states_, sample); }
  void apply(const bus::Sample<msg::ContactReport>& sample) { keep(contacts_, sample); }
  void apply(const bus::Sample<msg::Heartbeat>& sample) { keep(heartbeats_, sample); }
  void apply(const bus::Sample<msg::CoupledPlan>& sample) { keep(plans_, sample); }
  void apply(const bus::Sample<msg::ToolState>& sample) { keep(tools_, sample); }
  void apply(const bus::Sample<msg::PlannedMotion>& sample) { keep(motions_, sample); }
  void apply(const bus::Sample<msg::GoalStatus>& sample);
  void apply(const bus::Sample<msg::ObstacleShapes>& sample);
  void apply(const bus::Sample<msg::Fault>& sample);
  void apply(const bus::Sample<msg::CellMode>& sample);
  /// See CellModeView::forget_order().
  void forget_order() { modes_.forget_order(); }
  /// Forgets all samples. They arrive again since `began`.
  void begin_anew(bus::Clock::time_point began);

  // References and pointers are valid until the next apply().
  [[nodiscard]] const config::CellFile& file() const { return *file_; }
  [[nodiscard]] const CellModeView& mode() const { return modes_; }
  /// Grows by one when the shapes of an obstacle arrive or an obstacle is removed.
  [[nodiscard]] std::uint64_t obstacle_edition() const { return obstacle_edition_; }
  [[nodiscard]] const Obstacles& obstacles() const { return *obstacles_; }
  /// The same for another thread; never changed.
  [[nodiscard]] const std::shared_ptr<const Obstacles>& shared_obstacles() const { return obstacles_; }
  [[nodiscard]] const LatestFaults& faults() const { return faults_; }
  [[nodiscard]] const Newest<msg::Heartbeat>& heartbeats() const { return heartbeats_; }
  /// By the arm that proposes.
  [[nodiscard]] const Newest<msg::CoupledPlan>& plans() const { return plans_; }
  /// The newest goal of each arm.
  [[nodiscard]] const Newest<msg::GoalStatus>& goals() const { return goals_; }

  // The newest sample of an arm, node or cell; null: none was received.
  [[nodiscard]] const bus::Sample<msg::ArmState>* state(std::string_view arm) const { return newest(states_, arm); }
  [[nodiscard]] const bus::Sample<msg::GoalStatus>* goal(std::string_view arm) const { return newest(goals_, arm); }
  [[nodiscard]] const bus::Sample<msg::ToolState>* tool(std::string_view arm) const { return newest(tools_, arm); }
  [[nodiscard]] const bus::Sample<msg::PlannedMotion>* motion(std::string_view arm) const {
    return newest(motions_, arm);
  }
  [[nodiscard]] const bus::Sample<msg::Heartbeat>* heartbeat(std::string_view node) const {
    return newest(heartbeats_, node);
  }
  [[nodiscard]] const bus::Sample<msg::ObstacleStates>* obstacle_states() const { return newest(obstacle_states_, ""); }
  [[nodiscard]] const bus::Sample<msg::ContactReport>* contacts() const { return newest(contacts_, ""); }

  /// A node is alive while its heartbeats arrive within the host lease of the cell file.
  [[nodiscard]] bool alive(const bus::Sample<msg::Heartbeat>& heartbeat, bus::Clock::time_point now) const;
  /// The planner that commands the arm.
  [[nodiscard]] std::string planner_of(std::string_view arm) const;
  /// Why an arm stands still: the strictest reason, as `hecaton status` shows it. CAUSE_NONE while it moves.
  [[nodiscard]] msg::Cause waiting_for(const std::string& arm, bus::Clock::time_point now) const;

 private:
  template <class T>
  static void keep(Newest<T>& samples, const bus::Sample<T>& sample) {
    if (sample.disposed) {
      samples.erase(sample.key);
    } else {
      samples.insert_or_assign(sample.key, sample);
    }
  }
  template <class T>
  [[nodiscard]] static const bus::Sample<T>* newest(const Newest<T>& samples, std::string_view key) {
    const auto found = samples.find(key);
    return found == samples.end() ? nullptr : &found->second;
  }
  [[nodiscard]] msg::Cause first_awaited(const std::string& arm, bus::Clock::time_point now) const;

  const config::CellFile* file_;
  bus::Clock::time_point began_;
  CellModeView modes_;
  Newest<msg::ArmState> states_;
  Newest<msg::GoalStatus> goals_;
  Newest<msg::ObstacleStates> obstacle_states_;
  Newest<msg::ContactReport> contacts_;
  Newest<msg::Heartbeat> heartbeats_;
  Newest<msg::CoupledPlan> plans_;
  Newest<msg::ToolState> tools_;
  Newest<msg::PlannedMotion> motions_;
  LatestFaults faults_;
  std::shared_ptr<const Obstacles> obstacles_;  ///< never changed: copies of the state share it
  std::uint64_t obstacle_edition_ = 1;
};

}  // namespace hecaton::services
