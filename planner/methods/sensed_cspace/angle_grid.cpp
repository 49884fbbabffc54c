#include "planner/methods/sensed_cspace/angle_grid.hpp"

#include <cmath>

namespace hecaton::planner::cspace {

int AngleGrid::cell_at(double angle) const {
  return wrapped(static_cast<int>(std::floor(place(std::remainder(angle, 2.0 * kPi)) + 0.5)));
}

}  // namespace hecaton::planner::cspace
