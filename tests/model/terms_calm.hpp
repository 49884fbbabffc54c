#pragma once
/// Whether a cell is well again once nothing fails any more and the network is quick.

#include <string>
#include <unordered_set>
#include <vector>

#include "tests/model/terms_actors.hpp"

namespace hecaton::services::model {

class Calm {
 public:
  /// The actors must outlive it.
  explicit Calm(Actors& actors);

  /// What is wrong once nothing changes any more, also when a supervisor, a planner or one of each is dead for good, a
  /// sentence; empty: one supervisor leads, one planner is in charge, and the driver follows it.
  [[nodiscard]] std::string wrong(const Processes& processes);

 private:
  /// −1: none of them.
  struct Dead {
    int supervisor;
    int planner;
  };
  struct Case {
    Dead dead;
    std::unordered_set<Processes, Processes::Hash> well;  // on the way to rest, and known to be so then
  };

  [[nodiscard]] std::string wrong_in(Case& one, const Processes& processes);
  [[nodiscard]] std::string wrong_at_rest(const Dead& dead, const Processes& processes) const;
  [[nodiscard]] Processes round(const Dead& dead, const Processes& before);
  void supervise(int i, const Dead& dead, const Processes& before, Processes& after);

  Actors& actors_;
  std::vector<Case> cases_;
};

}  // namespace hecaton::services::model
