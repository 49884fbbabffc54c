#include "tests/model/terms_messages.hpp"

#include <algorithm>
#include <stdexcept>

namespace hecaton::services::model {
namespace {

const std::array<std::string, 3> kPlanners{"p", "q", ""};

}  // namespace

const std::string& planner_name(std::size_t index) {
  return kPlanners.at(index);
}

std::uint8_t planner_index(const std::string& name) {
  const auto found = std::find(kPlanners.begin(), kPlanners.end(), name);
  if (found == kPlanners.end()) throw std::out_of_range("the model has no planner " + name);
  return static_cast<std::uint8_t>(found - kPlanners.begin());
}

Message message_about(Message::Kind kind, const ArmLease& lease) {
  return {kind, 0, 0, static_cast<std::uint8_t>(lease.term), planner_index(lease.planner)};
}

std::string text(const Message& message) {
  const std::string lease = planner_name(message.planner) + ":" + std::to_string(message.granted);
  switch (message.kind) {
    case Message::Kind::kMode:
      return "mode " + std::to_string(message.term) + " of supervisor " + std::to_string(message.sender) +
             " granting " + lease;
    case Message::Kind::kCommand:
      return "command " + lease;
    case Message::Kind::kState:
      return "state with " + lease;
    case Message::Kind::kHeartbeat:
      return "heartbeat of term " + std::to_string(message.term);
    case Message::Kind::kKnownLease:
      break;
  }
  return "heartbeat with " + lease;
}

std::size_t MessageTable::number_of(const Message& message) {
  const auto known = numbers_.find(message);
  if (known != numbers_.end()) return known->second;
  const bool within = std::max(message.term, message.granted) <= highest_term_;
  std::vector<Message>& messages = within ? within_ : beyond_;
  if (within && messages.size() == MessageSet::kMost) throw std::length_error("the model has too many messages");
  const std::size_t number = messages.size() + (within ? 0 : MessageSet::kMost);
  messages.push_back(message);
  numbers_.emplace(message, number);
  return number;
}

const Message& MessageTable::message(std::size_t number) const {
  return number < MessageSet::kMost ? within_.at(number) : beyond_.at(number - MessageSet::kMost);
}

}  // namespace hecaton::services::model
