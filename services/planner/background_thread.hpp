#pragma once
/// How the planner's other threads stand back.

#include <sys/resource.h>
#include <unistd.h>

namespace hecaton::services {

/// For the first line of a thread that works for the control loop: the loop goes first when processors are short.
inline void give_way_to_control_loop() {
  constexpr int kNiceness = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);
}

}  // namespace hecaton::services
