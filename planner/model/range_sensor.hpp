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

/// Beams of one link that are measured together.
struct RangeSensor {
  std::string name;             ///< unique on its arm
  int link = 0;                 ///< index into RobotModel::links
  std::vector<SensorRay> rays;  ///< at least one
  double range = 0.5;           ///< farther things are not seen [m], > 0
  double noise = 0.0;           ///< standard deviation of a distance [m], ≥ 0; never off by more than three of it
  double period = 0.010;        ///< between two scans [s], > 0
  bool simulated = true;        ///< the world measures; else a real one publishes its scans
};

/// One beam's answer.
struct RangeReading {
  SensorRay ray;
  double distance = 0.0;  ///< [m]; the sensor's range when nothing was hit
  bool hit = false;
};

/// All beams of one sensor at one instant.
struct RangeScan {
  int sensor = 0;  ///< index on the arm
  int link = 0;
  JointVector q;  ///< where the arm's joints were then [rad | m]
  std::vector<RangeReading> readings;
};

}  // namespace hecaton::planner
