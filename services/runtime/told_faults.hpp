#pragma once
/// Faults as the bus tells them, by id. A supervisor that no longer leads still hands its last words to whoever joins,
/// so of two words about one fault that of the higher term counts, and of one term the later.

#include <map>
#include <string>
#include <tuple>

#include <idl/health.h>

namespace hecaton::services {

class ToldFaults {
 public:
  /// False: old news.
  bool hear(const msg::Fault& fault) {
    const auto [entry, is_new] = all_.try_emplace(fault.id(), fault);
    if (is_new) return true;
    if (order_of(fault) <= order_of(entry->second)) return false;
    entry->second = fault;
    return true;
  }
  void forget(const std::string& id) { all_.erase(id); }
  [[nodiscard]] const std::map<std::string, msg::Fault>& all() const { return all_; }

 private:
  static std::tuple<std::uint64_t, std::uint64_t> order_of(const msg::Fault& fault) {
    return {fault.term(), fault.sequence_number()};
  }

  std::map<std::string, msg::Fault> all_;
};

}  // namespace hecaton::services
