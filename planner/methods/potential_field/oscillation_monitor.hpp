#pragma once
/// Recognises that an arm gets nowhere: back and forth before a local minimum [Cardenas10, "Examples": "vibrations"].

#include "planner/model/limits.hpp"

namespace hecaton::planner::potential {

/// A plain value. Time is whatever the caller counts in: seconds, or steps.
struct OscillationMonitor {
  JointVector anchor;        ///< where the window began [rad | m]
  JointVector last;          ///< where it was seen last
  double travelled = 0.0;    ///< since the window began [rad | m]
  double time = 0.0;         ///< since then
  bool oscillating = false;  ///< as of the last complete window

  /// Begins anew.
  void reset() { *this = {}; }
  /// The arm is at `q`, `dt` after the last call. A window of `window` is one in which it oscillates when it got no
  /// farther from where that began than a third of the way that it went, and went more than `least`.
  void observe(const JointVector& q, double dt, double window, double least);
};

}  // namespace hecaton::planner::potential
