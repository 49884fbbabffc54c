#pragma once
/// Measures which other hosts an agent hears, by their agents' rows, and sends that as the row of its own host
/// (docs/explanation/0003-fault-detection.md).

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include <idl/health.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/process_info.hpp"
#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

class ReachabilityReporter {
 public:
  /// `hosts`: of this agent. `period`: of the rows. `participant` must outlive the reporter. Throws as bus::Reader
  /// does.
  ReachabilityReporter(bus::Participant& participant, std::vector<std::string> hosts, Time period,
                       bus::Clock::time_point now)
      : hosts_(std::move(hosts)),
        period_(period),
        clock_(period, 2 * period + std::chrono::milliseconds(2), now.time_since_epoch()),
        reader_(participant),
        writer_(participant) {}

  /// Call it at least once in each period: it sends one row in each. A stall of this agent counts as one period, so
  /// that it does not look like silence of other hosts.
  void report(bus::Clock::time_point now) {
    if (now - reported_ < period_ * 3 / 4) return;
    reported_ = now;
    clock_.advance(now.time_since_epoch());
    for (const auto& sample : reader_.take()) {
      if (sample.disposed) continue;
      Time& newest = newest_[sample.value.host()];
      newest = std::max(newest, clock_.at(std::min(sample.received, now).time_since_epoch()));
    }
    row_.sequence_number(row_.sequence_number() + 1);
    row_.stamp_ns(stamp_now());
    for (const std::string& host : hosts_) {
      row_.host(host);
      row_.heard().clear();
      for (const auto& [other, newest] : newest_) {
        if (other == host) continue;
        msg::HostAge& heard = row_.heard().emplace_back();
        heard.host(other);
        heard.age(std::chrono::duration<float>(clock_.now() - newest).count());
      }
      static_cast<void>(writer_.write(row_));  // the bus logs a refusal
    }
  }

 private:
  std::vector<std::string> hosts_;
  Time period_;
  bus::Clock::time_point reported_{};  // when the last row was sent
  StallCompensatedClock clock_;
  bus::Reader<msg::Reachability> reader_;
  bus::Writer<msg::Reachability> writer_;
  msg::Reachability row_;
  std::map<std::string, Time> newest_;  // of each other host, on the clock
};

}  // namespace hecaton::services
