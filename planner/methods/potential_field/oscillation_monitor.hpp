#pragma once
/// Detection of oscillation near a local minimum [Cardenas10, "Examples": "vibrations"].

#include "planner/model/limits.hpp"
#include "planner/model/memory_archive.hpp"

namespace hecaton::planner::potential {

/// A value. The caller chooses the unit of time: seconds or steps.
struct OscillationMonitor {
  JointVector anchor;        ///< position at the start of the window [rad | m]
  JointVector last;          ///< last observed position [rad | m]
  double travelled = 0.0;    ///< path length in the window [rad | m]
  double time = 0.0;         ///< elapsed time in the window
  bool oscillating = false;  ///< as of the last complete window

  /// Observes the arm at `q`, `dt` after the last call. The arm oscillates in a window of length `window` if its path
  /// is longer than `least` and its net displacement is below a third of the path.
  void observe(const JointVector& q, double dt, double window, double least) {
    if (anchor.size() != q.size()) {
      anchor = last = q;
      return;
    }
    travelled += (q - last).norm();
    last = q;
    time += dt;
    if (time < window) return;
    oscillating = travelled > least && (q - anchor).norm() < 1.0 / 3.0 * travelled;
    anchor = q;
    travelled = time = 0.0;
  }

  void describe(MemoryArchive& archive) { archive(anchor, last, travelled, time, oscillating); }
};

}  // namespace hecaton::planner::potential
