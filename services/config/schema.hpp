#pragma once
/// Every key that a cell file may have, section by section. Readers can only ask for keys that are listed here, and
/// docs/reference/cell-file.md documents each of them.

#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::planner {
class MethodRegistry;
}  // namespace hecaton::planner

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
extern const Section kArmLimits;
extern const Section kArmPoses;
extern const Section kPackages;
extern const Section kDevice;
extern const Section kDamper;
extern const Section kYielding;
extern const Section kRollout;
extern const Section kReplanning;
extern const Section kCoordination;
extern const Section kSensor;
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

/// The sections of arms and defaults, whose keys depend on which motion methods there are.
class ArmSections {
 public:
  /// The registry must outlive this.
  explicit ArmSections(const planner::MethodRegistry& registry);
  ArmSections(const ArmSections&) = delete;
  ArmSections& operator=(const ArmSections&) = delete;

  [[nodiscard]] const planner::MethodRegistry& registry() const { return registry_; }
  [[nodiscard]] const Section& arm() const { return arm_; }
  [[nodiscard]] const Section& defaults() const { return defaults_; }
  /// The parameters that methods have in the arm's map `name`, which one of them must have.
  [[nodiscard]] const Section& of_method(std::string_view name) const;
  [[nodiscard]] std::vector<const Section*> all() const;

 private:
  struct Keys {
    explicit Keys(std::string n) : name(std::move(n)), where("arms[]." + name) {}
    std::string name;
    std::string where;
    std::vector<std::string_view> keys;
    Section section{};
  };

  const planner::MethodRegistry& registry_;
  std::deque<Keys> of_methods_;  ///< sections refer to it
  std::vector<std::string_view> keys_;
  Section arm_;
  Section defaults_;
};

/// All of the above, with Hecaton's own methods.
[[nodiscard]] std::vector<const Section*> all_sections();

}  // namespace hecaton::config
