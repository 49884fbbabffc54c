#pragma once
/// One question, one answer, over a request topic and a reply topic.

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
/// caller has set and which no other request may have. Include the types' idl header.
template <class Request, class Reply>
[[nodiscard]] Answer<Reply> ask(Writer<Request>& requests, Reader<Reply>& replies, const Request& request,
                                Clock::duration timeout) {
  const auto until = Clock::now() + timeout;
  if (!requests.wait_matched(1, timeout)) return {AskOutcome::kNobody, {}};
  if (!requests.write(request)) return {AskOutcome::kRefused, {}};
  while (true) {
    for (auto& sample : replies.take()) {
      if (sample.value.client() == request.client() && sample.value.request_id() == request.request_id()) {
        return {AskOutcome::kAnswered, std::move(sample.value)};
      }
    }
    const auto left = until - Clock::now();
    if (left <= Clock::duration::zero()) return {AskOutcome::kTimeout, {}};
    // Another reader may share the mailbox: a time-out is only known from the clock.
    [[maybe_unused]] const bool arrived = replies.wait_for_data(left);
  }
}

}  // namespace hecaton::bus
