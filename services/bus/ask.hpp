#pragma once
/// One question, one answer, over a request topic and a reply topic.

#include <algorithm>
#include <optional>

#include "services/bus/endpoint.hpp"

namespace hecaton::bus {

enum class AskOutcome : std::uint8_t {
  kAnswered,
  kNobody,   ///< no service reads the request topic
  kTimeout,  ///< somebody does, and has not answered
  kRefused,  ///< the request could not be written
};

template <class Reply>
struct Answer {
  AskOutcome outcome = AskOutcome::kNobody;
  std::optional<Reply> reply;
};

/// Waits until somebody reads the request, writes it, and waits for the reply with its client and request_id, which the
/// caller has set and which no other request may have. `again`: after so long without an answer it is written once
/// more, for whoever was not there yet, or was not the one to answer; never for what must not be done twice. Include
/// the types' idl header.
template <class Request, class Reply>
[[nodiscard]] Answer<Reply> ask(Writer<Request>& requests, Reader<Reply>& replies, const Request& request,
                                Clock::duration timeout, Clock::duration again = Clock::duration::max()) {
  const auto until = Clock::now() + timeout;
  if (!requests.wait_matched(1, timeout)) return {AskOutcome::kNobody, {}};
  auto written = Clock::now();
  if (!requests.write(request)) return {AskOutcome::kRefused, {}};
  while (true) {
    for (auto& sample : replies.take()) {
      if (sample.value.client() == request.client() && sample.value.request_id() == request.request_id()) {
        return {AskOutcome::kAnswered, std::move(sample.value)};
      }
    }
    const auto now = Clock::now();
    if (now >= until) return {AskOutcome::kTimeout, {}};
    if (now - written >= again) {
      written = now;
      if (!requests.write(request)) return {AskOutcome::kRefused, {}};
    }
    // Another reader may share the mailbox: a time-out is only known from the clock.
    [[maybe_unused]] const bool arrived = replies.wait_for_data(std::min(until - now, again - (now - written)));
  }
}

}  // namespace hecaton::bus
