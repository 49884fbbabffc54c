#pragma once
/// The cell's obstacles as their messages tell them: what they are (ObstacleShapes) joined with where they are
/// (ObstacleStates), in one order, with their age on this process's clock.

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <idl/world.h>

#include "services/bus/mailbox.hpp"
#include "services/planner/sender_clock.hpp"
#include "world/model/scene.hpp"
#include "world/model/snapshot.hpp"

namespace hecaton::services {

class ObstacleView {
 public:
  using Clock = std::chrono::steady_clock;
  using Obstacles = std::shared_ptr<const std::vector<world::Obstacle>>;

  /// `arms`: the names that an attachment may name.
  explicit ObstacleView(std::vector<std::string> arms);

  /// Each returns a sentence when the message cannot be used.
  std::optional<std::string> apply(const msg::ObstacleShapes& shapes);
  std::optional<std::string> apply(const msg::ObstacleStates& states, const bus::EndpointId& writer,
                                   Clock::time_point received);
  /// The obstacle was withdrawn; its shapes serve until the states no longer name it.
  void withdraw(const std::string& name);

  /// Joins the newest states with the shapes; call after the messages of a period. True when obstacles() is another
  /// list than before. States that name an obstacle of unknown shape wait for it, and the older ones age.
  bool join();

  /// False until states and all their shapes have come.
  [[nodiscard]] bool known() const { return joined_at_.has_value(); }
  /// In the order of states().
  [[nodiscard]] const Obstacles& obstacles() const { return obstacles_; }
  /// As they were when they were sent, with their ages at `now`. Valid until the next call.
  [[nodiscard]] std::span<const world::ObstacleState> states(Clock::time_point now);
  /// Of the states in use [s]; 0 before any.
  [[nodiscard]] double age(Clock::time_point now) const;
  /// What is missing, a sentence; only until all is known.
  [[nodiscard]] const std::string& missing() const { return missing_; }

 private:
  struct Known {
    world::Obstacle obstacle;
    bool withdrawn = false;
  };
  struct Arrived {
    world::ObstacleSnapshot snapshot;
    std::vector<std::string> names;
    bus::EndpointId writer;
    Clock::time_point at;  ///< when they were true, on this process's clock
    SenderClock clock;     ///< of their writer
  };

  void forget_withdrawn();

  std::vector<std::string> arms_;
  std::map<std::string, Known> shapes_;
  bool shapes_changed_ = false;
  std::optional<Arrived> newest_;
  bool waiting_ = false;  ///< newest_ is not joined yet
  Obstacles obstacles_;
  std::vector<std::string> names_;
  std::vector<world::ObstacleState> states_;
  std::optional<Clock::time_point> joined_at_;
  std::string missing_ = "no world was heard yet";
};

}  // namespace hecaton::services
