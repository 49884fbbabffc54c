#pragma once
/// Checks that a cell recovers once nothing fails any more and the network delivers every message.

#include <string>
#include <unordered_set>
#include <vector>

#include "tests/model/terms_actors.hpp"

namespace hecaton::services::model {

class Recovery {
 public:
  /// The actors must outlive it.
  explicit Recovery(Actors& actors);

  /// What is wrong in the final state, as a sentence; also if a supervisor, a planner or one of each stays dead. Empty:
  /// one supervisor leads, one planner is in charge, and the driver follows it.
  [[nodiscard]] std::string wrong(const Processes& processes);

 private:
  /// −1: none.
  struct Dead {
    int supervisor;
    int planner;
  };
  struct Case {
    Dead dead;
    std::unordered_set<Processes, Processes::Hash> recovering;  // known to reach a correct final state
  };

  [[nodiscard]] std::string failure_in(Case& one, const Processes& processes);
  [[nodiscard]] std::string failure_at_rest(const Dead& dead, const Processes& processes) const;
  [[nodiscard]] Processes round(const Dead& dead, const Processes& before);
  void supervise(int i, const Dead& dead, const Processes& before, Processes& after);

  Actors& actors_;
  std::vector<Case> cases_;
};

}  // namespace hecaton::services::model
