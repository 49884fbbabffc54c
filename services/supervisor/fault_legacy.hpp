#pragma once
/// What a supervisor told while it led and nobody who led after it has told again yet. While there is any of it, it
/// stays on the bus under the old term, so that who leads now adopts it, however late it hears it: faults that were
/// told on the other side of a partition would be lost otherwise.

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include <idl/health.h>

#include "services/supervisor/messages.hpp"

namespace hecaton::services {

class FaultLegacy {
 public:
  /// We lead no more. `term`: the last under which we did.
  void leave(FaultHistory account, std::uint64_t term) {
    term_ = term;
    left_.clear();
    for (auto& [cause, record] : account.open) left_.insert_or_assign(fault_id(record), ToldRecord{cause, record});
    for (FaultRecord& record : account.over) {
      std::string id = fault_id(record);
      left_.insert_or_assign(std::move(id), ToldRecord{{}, std::move(record)});
    }
  }
  /// Strikes out what another told under a later term, or under the same if it is another's that we remember. True when
  /// nothing is left of what there was.
  bool strike_out(const std::map<std::string, msg::Fault>& told) {
    if (left_.empty()) return false;
    std::erase_if(left_, [&](const auto& entry) {
      const auto found = told.find(entry.first);
      return found != told.end() && found->second.term() >= term_;
    });
    return left_.empty();
  }
  void clear() { left_.clear(); }
  /// By id. The cause of those that were over is empty: none can be open of them.
  [[nodiscard]] const std::map<std::string, ToldRecord>& left() const { return left_; }

 private:
  std::uint64_t term_ = 0;
  std::map<std::string, ToldRecord> left_;
};

}  // namespace hecaton::services
