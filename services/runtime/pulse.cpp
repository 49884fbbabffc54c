#include "services/runtime/pulse.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// Statistics and memory change slowly: summarising them every beat would cost more than the beat.
constexpr auto kRefresh = 250ms;

bus::WriterOptions writer_options(const PulseTiming& timing) {
  bus::WriterOptions options;
  options.deadline = timing.deadline;
  options.lease = timing.lease;
  return options;
}

}  // namespace

struct Pulse::Impl {
  Impl(bus::Participant& participant, PulseIdentity identity, const PulseTiming& timing)
      : period(timing.period), alive_fd(timing.alive_fd), writer(participant, writer_options(timing)) {
    sample.node(identity.node);
    sample.kind(identity.kind);
    sample.subject(identity.subject);
    sample.host(identity.host.empty() ? machine_name() : identity.host);
    sample.pid(static_cast<std::int32_t>(getpid()));
  }

  /// Also the sign of life for the agent, whose patience is longer than a second.
  void refresh(Clock::time_point now, const LoopStatistics& loop) {
    if (now < refreshed + kRefresh) return;
    refreshed = now;
    const LoopSummary summary = loop.summary();
    sample.tick_p50_us(summary.tick_p50_us);
    sample.tick_p99_us(summary.tick_p99_us);
    sample.tick_max_us(summary.tick_max_us);
    sample.rss_bytes(resident_bytes());
    if (alive_fd < 0) return;
    static_cast<void>(send(alive_fd, "", 1, MSG_NOSIGNAL | MSG_DONTWAIT));  // a full socket says it, too
  }

  std::chrono::nanoseconds period;
  int alive_fd;
  bus::Writer<msg::Heartbeat> writer;
  msg::Heartbeat sample;
  Clock::time_point last{};
  Clock::time_point refreshed{};
  bool complained = false;
};

Pulse::Pulse(bus::Participant& participant, PulseIdentity identity, const PulseTiming& timing)
    : impl_(std::make_unique<Impl>(participant, std::move(identity), timing)) {}
Pulse::~Pulse() = default;

bool Pulse::due(Clock::time_point now, std::chrono::nanoseconds slack) const {
  return now + slack >= impl_->last + impl_->period;
}

void Pulse::beat(Clock::time_point now, const Vital& vital, const LoopStatistics& loop) {
  Impl& pulse = *impl_;
  pulse.last = now;
  pulse.refresh(now, loop);
  msg::Heartbeat& sample = pulse.sample;
  sample.state(vital.state);
  sample.cause(vital.cause);
  sample.term(vital.term);
  sample.lease(lease_message({}, vital.lease));
  sample.heard_mode(vital.heard_mode);
  sample.newest_event(vital.newest_event);
  sample.sequence_number(sample.sequence_number() + 1);
  sample.stamp_ns(stamp_now());
  sample.ticks(loop.ticks());
  sample.lateness_max_us(loop.lateness_max_us());
  sample.oldest_input_age(vital.oldest_input_age);
  sample.oldest_input(vital.oldest_input);
  const bus::WriteResult written = pulse.writer.write(sample);
  if (!written && !pulse.complained) {
    pulse.complained = true;
    log_warning("heartbeat refused", {{"reason", written.reason}});
  }
}

}  // namespace hecaton::services
