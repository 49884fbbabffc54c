#pragma once
/// The newest report of each fault, by its id.

#include <map>
#include <string>
#include <tuple>

#include <idl/health.h>

namespace hecaton::services {

/// Of two reports of one fault the one of the higher term counts; of one term the later. A supervisor that no longer
/// leads still delivers its last reports to late joiners, so the order of arrival does not decide.
class LatestFaults {
 public:
  /// False when the report is not newer than the known one; it is then ignored.
  bool update(const msg::Fault& fault) {
    const auto [entry, is_new] = all_.try_emplace(fault.id(), fault);
    if (is_new) return true;
    if (order_of(fault) <= order_of(entry->second)) return false;
    entry->second = fault;
    return true;
  }
  void erase(const std::string& id) { all_.erase(id); }
  [[nodiscard]] const std::map<std::string, msg::Fault>& all() const { return all_; }

 private:
  static std::tuple<std::uint64_t, std::uint64_t> order_of(const msg::Fault& fault) {
    return {fault.term(), fault.sequence_number()};
  }

  std::map<std::string, msg::Fault> all_;
};

}  // namespace hecaton::services
