#include "services/supervisor/picture.hpp"

#include <tuple>

namespace hecaton::services {
namespace {

bool newer(const bus::Sample<msg::GoalStatus>& sample, const Heard<msg::GoalStatus>& known) {
  // Sequence numbers order one planner's statuses; another planner of the same term took over later.
  if (sample.writer != known.writer && sample.value.term() == known.value.term()) return true;
  return std::make_tuple(sample.value.term(), sample.value.sequence_number()) >=
         std::make_tuple(known.value.term(), known.value.sequence_number());
}

}  // namespace

void Picture::take_goal(const bus::Sample<msg::GoalStatus>& sample) {
  if (sample.disposed) return;  // the planner keeps only its last goals; what became of this one stays true
  const auto known = goals.find(sample.value.arm());
  if (known == goals.end() || newer(sample, known->second)) {
    goals.insert_or_assign(sample.value.arm(), heard(sample));
  }
}

}  // namespace hecaton::services
