#pragma once
/// Distance sensors along an arm's links, and what they measure.

#include <string>
#include <vector>

#include "planner/model/limits.hpp"

namespace hecaton::planner {

/// One beam, fixed to a link L.
struct SensorRay {
  Eigen::Vector3d origin_L = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Vector3d direction_L = Eigen::Vector3d::UnitX();  ///< unit
};

/// The beams of one sensor, all fixed to one link and measured together.
struct RangeSensor {
  std::string name;             ///< unique on its arm
  int link = 0;                 ///< index into RobotModel::links
  std::vector<SensorRay> rays;  ///< at least one
  double range = 0.5;           ///< the sensor does not detect anything beyond [m], > 0
  double noise = 0.0;           ///< standard deviation of a distance [m], ≥ 0; errors are at most three of it
  double period = 0.010;        ///< of scans [s], > 0
  bool simulated = true;        ///< the world simulates it; else a real sensor publishes its scans
};

/// The measurement of one beam.
struct RangeReading {
  SensorRay ray;          ///< as mounted
  double distance = 0.0;  ///< [m]; the sensor's range when nothing was hit
  bool hit = false;       ///< something reflected it within the range
};

/// All beams of one sensor at one instant.
struct RangeScan {
  int sensor = 0;                      ///< index on the arm
  int link = 0;                        ///< of the sensor
  JointVector q;                       ///< joint positions of the arm at that instant [rad | m]
  std::vector<RangeReading> readings;  ///< one for each beam
};

}  // namespace hecaton::planner
