#pragma once
/// Every key that a cell file may have, section by section. Readers can only ask for keys that are listed here, and
/// docs/cell-file.md documents each of them.

#include <span>
#include <string_view>

namespace hecaton::config {

/// One kind of map in a cell file.
struct Section {
  std::string_view where;  ///< its key path, "[]" for any item of a list
  std::span<const std::string_view> keys;
  bool free_names = false;  ///< the file's author chooses the keys; `keys` is empty
};

namespace section {
extern const Section kRoot;
extern const Section kNetwork;
extern const Section kHosts;
extern const Section kWorld;
extern const Section kSupervision;
extern const Section kRecovery;
extern const Section kTiming;
extern const Section kTasks;
extern const Section kTaskAreas;
extern const Section kClutter;
extern const Section kPose;
extern const Section kDefaults;
extern const Section kArm;
extern const Section kArmLimits;
extern const Section kArmPoses;
extern const Section kPackages;
extern const Section kDevice;
extern const Section kDamper;
extern const Section kFollower;
extern const Section kYielding;
extern const Section kRollout;
extern const Section kRoute;
extern const Section kSensor;
extern const Section kSensed;
extern const Section kPotential;
extern const Section kStrategy;
extern const Section kObstacle;
extern const Section kAttachment;
extern const Section kBox;
extern const Section kSphere;
extern const Section kCapsule;
extern const Section kCylinder;
extern const Section kMesh;
extern const Section kStatic;
extern const Section kWaypoints;
extern const Section kCircle;
extern const Section kSine;
extern const Section kConveyor;
extern const Section kDynamic;
}  // namespace section

/// All of the above.
[[nodiscard]] std::span<const Section* const> all_sections();

}  // namespace hecaton::config
