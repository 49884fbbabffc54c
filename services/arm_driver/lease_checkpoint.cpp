#include "services/arm_driver/lease_checkpoint.hpp"

#include <algorithm>

namespace hecaton::services {

LeaseCheckpoint::LeaseCheckpoint(const std::string& path) : record_(path, 0, "the driver's lease") {}

std::optional<ArmLease> LeaseCheckpoint::recall() const {
  const auto kept = record_.recall();
  if (!kept || kept->planner.back() != 0) return std::nullopt;
  return ArmLease{kept->planner.data(), kept->term};
}

void LeaseCheckpoint::remember(const ArmLease& lease) {
  Kept kept{lease.term, {}};
  if (lease.planner.size() < kept.planner.size()) std::ranges::copy(lease.planner, kept.planner.begin());
  record_.remember(kept);
}

}  // namespace hecaton::services
