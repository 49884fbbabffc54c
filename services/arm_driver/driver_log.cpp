#include "services/arm_driver/driver_log.hpp"

#include <chrono>

#include "services/messages/names.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

Commander commander_of(const bus::Sample<msg::ArmCommand>& sample) {
  return {{sample.value.node(), sample.value.term()}, sample.writer};
}

}  // namespace

// "planner changed" means another planner, whose gap is the cost of a failover; "planner continues" means another
// process or term of the same planner.
void DriverLog::accepted(const bus::Sample<msg::ArmCommand>& sample) {
  const std::chrono::duration<double, std::milli> gap = sample.received - std::exchange(accepted_at_, sample.received);
  const Commander commander = commander_of(sample);
  const auto before = record_.accepted(commander);
  if (!before) return;
  const bool replaced = commander.lease.planner != before->lease.planner;
  log_info(replaced ? "planner changed" : "planner continues",
           {{"planner", commander.lease.planner},
            {"term", commander.lease.term},
            {"process", commander.writer.text()},
            {"instead_of_term", before->lease.term},
            {"instead_of", before->lease.planner},
            {"gap_ms", before->lease.term > 0 ? gap.count() : 0.0}});
}

void DriverLog::refused(const bus::Sample<msg::ArmCommand>& sample, const Judgement& judgement) {
  const std::uint64_t times = record_.refused(commander_of(sample), static_cast<int>(judgement.verdict));
  if (times == 0) return;
  log_warning("command refused", {{"from", sample.value.node()},
                                  {"term", sample.value.term()},
                                  {"process", sample.writer.text()},
                                  {"refused", times},
                                  {"reason", judgement.cause.text()}});
}

void DriverLog::lease(const ArmLease& newest) {
  log_info("arm lease", {{"planner", newest.planner}, {"term", newest.term}, {"instead_of_term", lease_.term}});
  lease_ = newest;
}

void DriverLog::state(const msg::ArmState& state) {
  if (mode_ == state.mode()) return;
  mode_ = state.mode();
  log_info("arm mode",
           {{"mode", text(mode_)}, {"reason", state.cause().text()}, {"command_age_ms", state.command_age() * 1e3}});
}

}  // namespace hecaton::services
