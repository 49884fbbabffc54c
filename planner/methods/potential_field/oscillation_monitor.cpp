#include "planner/methods/potential_field/oscillation_monitor.hpp"

namespace hecaton::planner::potential {
namespace {

constexpr double kNetShare = 1.0 / 3.0;

}  // namespace

void OscillationMonitor::observe(const JointVector& q, double dt, double window, double least) {
  if (anchor.size() != q.size()) {
    anchor = last = q;
    return;
  }
  travelled += (q - last).norm();
  last = q;
  time += dt;
  if (time < window) return;
  oscillating = travelled > least && (q - anchor).norm() < kNetShare * travelled;
  anchor = q;
  travelled = time = 0.0;
}

}  // namespace hecaton::planner::potential
