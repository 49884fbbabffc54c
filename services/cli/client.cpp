#include "services/cli/client.hpp"

#include <array>
#include <cstdio>
#include <random>
#include <utility>

#include <unistd.h>

#include "services/bus/ask.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;

constexpr int kDefaultDomain = 42;
constexpr const char* kAnyCell = "*";  // DDS partitions are matched as file names are
constexpr const char* kNodeName = "hecaton";
/// A supervisor that has just begun to lead may not have heard the question.
constexpr auto kAskAgain = 250ms;
/// More than one reader of requests was found: how long to listen for another cell's answer.
constexpr auto kOtherCells = 50ms;

std::string unique_name() {
  std::random_device device;
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "-%d-%08x", static_cast<int>(getpid()), device());
  return "cli/" + machine_name() + buffer.data();
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text.empty() ? "none" : text;
}

[[noreturn]] void refuse_both(const std::string& first, const std::string& second, const std::string& where) {
  throw Failure(ExitCode::kBadInput, "the cells '" + first + "' and '" + second + "' both answer in " + where +
                                         ": choose one with --cell FILE or --domain N");
}

}  // namespace

bus::Participant visit(const config::CellFile& file, int domain) {
  bus::ParticipantOptions participant = participant_options(file);
  participant.farewell = false;
  return {domain, kNodeName, participant};
}

Membership join(const Settings& settings) {
  ServiceOptions options;
  options.domain = settings.domain;
  if (settings.cell_file.empty()) {
    bus::ParticipantOptions participant;
    participant.partition = kAnyCell;
    participant.farewell = false;
    const int domain = choose_domain(options, kDefaultDomain);
    return {{domain, kNodeName, participant}, "DDS domain " + std::to_string(domain)};
  }
  const config::CellFile file = config::load_cell_file(settings.cell_file);
  const int domain = choose_domain(options, file.network.domain);
  Membership member{visit(file, domain),
                    "DDS domain " + std::to_string(domain) + " under the name '" + file.cell.name + "'"};
  for (const PlacedNode& supervisor : supervisors_of(file)) member.supervisors.push_back(supervisor.node);
  return member;
}

bus::Clock::duration seconds(double s) {
  return std::chrono::duration_cast<bus::Clock::duration>(std::chrono::duration<double>(s));
}

Client::Client(const Settings& settings) : Client(join(settings), seconds(settings.connect_timeout)) {}

Client::Client(Membership membership, bus::Clock::duration timeout)
    : where_(std::move(membership.where)),
      supervisors_(std::move(membership.supervisors)),
      timeout_(timeout),
      name_(unique_name()),
      participant_(std::move(membership.participant)),
      requests_(participant_),
      replies_(participant_, &mailbox_) {}

Failure Client::unreachable() const {
  if (requests_.matched() > 0) {
    return {ExitCode::kUnreachable, "the supervisor in " + where_ + " does not answer"};
  }
  return {ExitCode::kUnreachable, "no cell answers in " + where_ +
                                      ": start one with 'hecaton up CELL', or say where it is with --domain or --cell"};
}

std::string Client::looked_for() const {
  if (supervisors_.empty()) return "the supervisor of any cell";
  return (supervisors_.size() == 1 ? "the node " : "the nodes ") + listed(supervisors_);
}

msg::CellStatus Client::status() {
  msg::SupervisorReply reply = order(msg::RequestKind::REQUEST_STATUS, {});
  refuse_several_cells(reply.status().cell());
  return std::move(reply.status());
}

bool Client::poll_status(msg::CellStatus& status, bus::Clock::duration timeout) {
  msg::SupervisorRequest request;
  request.client(name_);
  request.request_id(next_request_++);
  request.kind(msg::RequestKind::REQUEST_STATUS);
  auto answer = bus::ask(requests_, replies_, request, timeout);
  if (!answer.reply) return false;
  status = std::move(answer.reply->status());
  return true;
}

msg::SupervisorReply Client::order(msg::RequestKind kind, const std::vector<std::string>& arms) {
  // An order is written once, when the supervisor that leads is known to hear it: written again it might undo what
  // somebody else has ordered since.
  const bool question = kind == msg::RequestKind::REQUEST_STATUS;
  if (!question) static_cast<void>(order(msg::RequestKind::REQUEST_STATUS, {}));
  msg::SupervisorRequest request;
  request.client(name_);
  request.request_id(next_request_++);
  request.kind(kind);
  request.arms(arms);
  auto answer = bus::ask(requests_, replies_, request, timeout_, question ? kAskAgain : bus::Clock::duration::max());
  if (!answer.reply) throw unreachable();
  return std::move(*answer.reply);
}

void Client::refuse_several_cells(const std::string& first) {
  if (requests_.matched() < 2) return;
  const auto until = bus::Clock::now() + kOtherCells;
  for (auto left = kOtherCells + 0ns; left > 0ns; left = until - bus::Clock::now()) {
    [[maybe_unused]] const bool arrived = replies_.wait_for_data(left);
    for (const auto& sample : replies_.take()) {
      const std::string& cell = sample.value.status().cell();
      if (sample.value.client() != name_ || cell == first) continue;
      refuse_both(first, cell, where_);
    }
  }
}

msg::WorldEditReply Client::edit(msg::WorldEditRequest request) {
  bus::Writer<msg::WorldEditRequest> requests(participant_);
  bus::Reader<msg::WorldEditReply> replies(participant_, &mailbox_);
  request.client(name_);
  request.request_id(next_request_++);
  auto answer = bus::ask(requests, replies, request, timeout_);
  if (answer.outcome == bus::AskOutcome::kNobody) {
    throw Failure(ExitCode::kUnreachable, "the cell in " + where_ + " has no world service that answers");
  }
  if (!answer.reply) throw Failure(ExitCode::kTimeOut, "the world service in " + where_ + " does not answer");
  return std::move(*answer.reply);
}

const msg::ArmStatus& require_arm(const msg::CellStatus& status, std::string_view arm) {
  std::vector<std::string> names;
  for (const msg::ArmStatus& known : status.arms()) {
    if (known.arm() == arm) return known;
    names.push_back(known.arm());
  }
  throw Failure(ExitCode::kBadInput,
                "cell '" + status.cell() + "' has no arm '" + std::string(arm) + "'; its arms: " + listed(names));
}

void require_arms(const msg::CellStatus& status, const std::vector<std::string>& arms) {
  for (const std::string& arm : arms) static_cast<void>(require_arm(status, arm));
}

void require_obstacle(const msg::CellStatus& status, std::string_view name) {
  std::vector<std::string> names;
  for (const msg::ObstacleStatus& known : status.obstacles()) {
    if (known.name() == name) return;
    names.push_back(known.name());
  }
  throw Failure(ExitCode::kBadInput, "cell '" + status.cell() + "' has no obstacle '" + std::string(name) +
                                         "'; its obstacles: " + listed(names));
}

void require_carried(const msg::CellStatus& status, std::string_view arm, std::string_view object) {
  for (const msg::ObstacleStatus& known : status.obstacles()) {
    if (known.name() != object || known.attached_to() == arm) continue;
    throw Failure(ExitCode::kBadInput, "arm '" + std::string(arm) + "' does not carry '" + std::string(object) + "'; " +
                                           (known.attached_to().empty() ? "nobody" : known.attached_to()) + " does");
  }
}

}  // namespace hecaton::services::cli
