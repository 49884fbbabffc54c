#pragma once
/// Orders of people to save what a recorder keeps: RecorderRequest and its reply.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include <idl/recorder.h>

#include "services/bus/endpoint.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services::recorder {

/// For one thread. Clients repeat a request until it is answered; a repetition of an answered one is ignored.
class SaveOrders {
 public:
  /// `participant` must outlive it, and be none of RawReaders. `host`: of the recorder, for people.
  SaveOrders(bus::Participant& participant, std::string host)
      : host_(std::move(host)), requests_(participant), replies_(participant) {}

  /// Takes the orders since the last call. True: there are some. reply() must follow.
  [[nodiscard]] bool take() {
    for (auto& sample : requests_.take()) {
      if (sample.disposed) continue;
      std::pair id(sample.value.client(), sample.value.request_id());
      if (std::find(known_.begin(), known_.end(), id) != known_.end()) continue;
      known_.push_back(std::move(id));
      if (known_.size() > kMostKnown) known_.pop_front();
      open_.push_back(std::move(sample.value));
    }
    return !open_.empty();
  }

  /// Answers the orders of take(). `file`: the newest saved one. `refusal`: why nothing is saved; empty: it is.
  void reply(const std::string& file, const std::string& refusal) {
    for (const msg::RecorderRequest& request : std::exchange(open_, {})) {
      msg::RecorderReply reply;
      reply.client(request.client());
      reply.request_id(request.request_id());
      reply.host(host_);
      reply.done(refusal.empty());
      reply.file(file);
      if (!refusal.empty()) {
        reply.cause(make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, recorder_node(), refusal));
      }
      static_cast<void>(replies_.write(reply));
    }
  }

 private:
  static constexpr std::size_t kMostKnown = 64;

  std::string host_;
  bus::Reader<msg::RecorderRequest> requests_;
  bus::Writer<msg::RecorderReply> replies_;
  std::vector<msg::RecorderRequest> open_;
  std::deque<std::pair<std::string, std::uint64_t>> known_;  ///< clients and numbers of the last requests
};

}  // namespace hecaton::services::recorder
