#include "services/runtime/heartbeat_publisher.hpp"

#include <fstream>

#include <sys/socket.h>
#include <unistd.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

/// Statistics and memory change slowly, and a summary costs more than a heartbeat.
constexpr auto kRefresh = 250ms;

/// A refusal stays in the heartbeats for this long, so that losses hide none.
constexpr auto kRefusalsTold = 2s;
constexpr std::size_t kMostRefusals = 4;

/// A sender without a name is named by its participant's GUID.
msg::Refusal refusal_message(const bus::Refused& refused) {
  const bool second = refused.kind == bus::RefusalKind::kSecondWriter;
  const std::string sender = refused.node.empty() ? refused.sender.text().substr(0, 24) : refused.node;
  msg::Refusal message;
  message.cause(make_cause(second ? msg::CauseKind::CAUSE_SECOND_WRITER : msg::CauseKind::CAUSE_INPUT_REFUSED,
                           second ? refused.topic + (refused.key.empty() ? "" : "/" + refused.key) : sender,
                           second ? sender + " writes it, too: " + refused.text : refused.text));
  message.topic(refused.topic);
  message.sender(refused.sender.text());
  message.address(refused.address);
  message.count(refused.count);
  return message;
}

/// Resident memory of this process [byte]; 0 when the kernel does not tell.
std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0;
  std::uint64_t resident = 0;
  statm >> pages >> resident;
  return statm ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

struct HeartbeatPublisher::Impl {
  Impl(bus::Participant& its_participant, NodeIdentity identity, const HeartbeatTiming& timing)
      : participant(its_participant), period(timing.period), heartbeat_fd(timing.heartbeat_fd), writer(participant) {
    sample.node(identity.node);
    sample.kind(identity.kind);
    sample.subject(identity.subject);
    sample.host(identity.host.empty() ? machine_name() : identity.host);
    sample.pid(static_cast<std::int32_t>(getpid()));
    if (const auto expires = participant.identity_expires()) {
      sample.keys_expire_unix_ms(
          std::chrono::duration_cast<std::chrono::milliseconds>(expires->time_since_epoch()).count());
    }
  }

  void refresh(Clock::time_point now, const LoopStatistics& loop) {
    if (now < refreshed + kRefresh) return;
    refreshed = now;
    const LoopSummary summary = loop.summary();
    sample.tick_p50_us(summary.tick_p50_us);
    sample.tick_p99_us(summary.tick_p99_us);
    sample.tick_max_us(summary.tick_max_us);
    sample.rss_bytes(resident_bytes());
    sample.refusals().clear();
    for (const bus::Refused& refused : participant.refused(kRefusalsTold, kMostRefusals)) {
      sample.refusals().push_back(refusal_message(refused));
    }
    if (heartbeat_fd < 0) return;
    // The agent's limit is longer than a second, and a full socket shows that the process lives, too.
    static_cast<void>(send(heartbeat_fd, "", 1, MSG_NOSIGNAL | MSG_DONTWAIT));
  }

  bus::Participant& participant;
  std::chrono::nanoseconds period;
  int heartbeat_fd;
  bus::Writer<msg::Heartbeat> writer;
  msg::Heartbeat sample;
  Clock::time_point last{};
  Clock::time_point refreshed{};
  bool refusal_logged = false;
};

HeartbeatPublisher::HeartbeatPublisher(bus::Participant& participant, NodeIdentity identity,
                                       const HeartbeatTiming& timing)
    : impl_(std::make_unique<Impl>(participant, std::move(identity), timing)) {}
HeartbeatPublisher::~HeartbeatPublisher() = default;

bool HeartbeatPublisher::due(Clock::time_point now, std::chrono::nanoseconds slack) const {
  return now + slack >= impl_->last + impl_->period;
}

void HeartbeatPublisher::publish(Clock::time_point now, const HealthReport& report, const LoopStatistics& loop) {
  impl_->last = now;
  impl_->refresh(now, loop);
  msg::Heartbeat& sample = impl_->sample;
  sample.state(report.state);
  sample.cause(report.cause);
  sample.term(report.term);
  sample.lease(lease_message({}, report.lease));
  sample.acknowledged_mode(report.acknowledged_mode);
  sample.newest_event(report.newest_event);
  sample.sequence_number(sample.sequence_number() + 1);
  sample.stamp_ns(stamp_now());
  sample.ticks(loop.ticks());
  sample.lateness_max_us(loop.lateness_max_us());
  sample.oldest_input_age(report.oldest_input_age);
  sample.oldest_input(report.oldest_input);
  const bus::WriteResult written = impl_->writer.write(sample);
  if (!written && !impl_->refusal_logged) {
    impl_->refusal_logged = true;
    log_warning("heartbeat not written", {{"reason", written.reason}});
  }
}

}  // namespace hecaton::services
