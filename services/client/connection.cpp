#include "services/client/connection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <tuple>
#include <utility>

#include <unistd.h>

#include "services/client/convert.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::client {
namespace {

using namespace std::chrono_literals;

constexpr int kDefaultDomain = 42;
constexpr const char* kAnyCell = "*";  // a pattern that matches all DDS partitions
constexpr const char* kNodeName = "hecaton";
/// A supervisor that has just begun to lead may have missed the request.
constexpr Seconds kAskAgain = 250ms;
/// Time for the replies of other cells when several supervisors read the request.
constexpr Seconds kOtherCells = 50ms;
/// Time for the replies of further recorders, each of which looks for requests every 20 ms at most.
constexpr Seconds kOtherRecorders = 100ms;

Seconds age_of(Clock::time_point heard) {
  return Clock::now() - heard;
}

/// Time limit of the destructor for the planners' answers to goals.
constexpr auto kLastAnswers = 2s;

std::string unique_name() {
  std::random_device device;
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "-%d-%08x", static_cast<int>(getpid()), device());
  return "client/" + services::machine_name() + buffer.data();
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

bus::Participant visit(const config::CellFile& file, int domain, const std::string& host) {
  bus::ParticipantOptions participant = services::participant_options(file, host, services::Role::kOperator);
  participant.announce_departure = false;
  return {domain, kNodeName, participant};
}

// Names that a client chooses.
std::vector<std::string> names_in(const msg::Goal& goal) {
  return {goal.arm(), goal.named()};
}
std::vector<std::string> names_in(const msg::WorldEditRequest& request) {
  return {request.name(), request.obstacle().name(), request.obstacle().attached_to(), request.arm()};
}
std::vector<std::string> names_in(const msg::SupervisorRequest& request) {
  return request.arms();
}
std::vector<std::string> names_in(const msg::DeviceRequest& request) {
  return {request.arm(), request.name()};
}
std::vector<std::string> names_in(const msg::RecorderRequest& /*request*/) {
  return {};
}

/// Throws InvalidArgument when the receivers would refuse the message, or would read another name.
template <class T>
void require_acceptable(const T& message) {
  for (const std::string& name : names_in(message)) {
    if (name.find('\0') == std::string::npos) continue;
    throw InvalidArgument("'" + name.substr(0, name.find('\0')) + "' is followed by a NUL, which ends a text of DDS");
  }
  if (const auto refusal = bus::Writer<T>::refusal_of(message)) {
    throw InvalidArgument(std::string(bus::Topic<T>::kInfo.type) + ": " + *refusal);
  }
}

/// Why the participants that were found may be no help, as a part of a sentence; empty: none was found.
std::string found_instead(const bus::Participant& participant) {
  constexpr std::size_t kMost = 3;
  const auto some = [](std::vector<std::string> names) {
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    const std::size_t all = names.size();
    if (all > kMost) names.resize(kMost);
    return listed(names) + (all > kMost ? " and others" : "");
  };
  std::vector<std::string> others;
  for (const bus::Refused& refused : participant.refused(std::chrono::minutes(1), 64)) {
    if (!refused.node.empty()) others.push_back(refused.node);
  }
  const bool has_keys = participant.identity_expires().has_value();
  if (const auto names = participant.joining(); !names.empty()) {
    if (has_keys) return " (the handshake with " + some(names) + " has not ended: wait longer)";
    return " (it has " + some(names) + " of another cell, or of one with keys, whose cell file names them)";
  }
  if (has_keys && !others.empty()) return " (it has " + some(others) + ", with other keys than this program, or none)";
  return {};
}

}  // namespace

Clock::time_point deadline_of(Seconds limit) {
  constexpr Seconds kYear{365.0 * 86400.0};
  // The comparison is false for NaN, which gives no wait.
  const Seconds bounded = limit > Seconds::zero() ? std::min(limit, kYear) : Seconds::zero();
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(bounded);
}

Membership join(const config::CellFile& file, int domain, const std::string& host) {
  Membership member{visit(file, domain, host),
                    "DDS domain " + std::to_string(domain) + " under the name '" + file.cell.name + "'"};
  for (const services::PlacedNode& supervisor : services::supervisors_of(file)) {
    member.supervisors.push_back(supervisor.node);
  }
  member.arms = planner::names_of(file.cell);
  return member;
}

Membership join(const ConnectOptions& options) {
  if (options.domain && (*options.domain < 0 || *options.domain > services::kHighestDomain)) {
    throw InvalidArgument("domain = " + std::to_string(*options.domain) + " must be a whole number from 0 to " +
                          std::to_string(services::kHighestDomain));
  }
  try {
    services::ServiceOptions service;
    service.domain = options.domain;
    if (options.cell_file) {
      const config::CellFile file = config::load_cell_file(*options.cell_file);
      return join(file, services::choose_domain(service, file.network.domain));
    }
    bus::ParticipantOptions participant;
    participant.partition = kAnyCell;
    participant.announce_departure = false;
    const int domain = services::choose_domain(service, kDefaultDomain);
    return {{domain, kNodeName, participant}, "DDS domain " + std::to_string(domain)};
  } catch (const std::runtime_error& error) {
    throw InvalidArgument(error.what());
  }
}

bool is_later(const msg::GoalStatus& a, const msg::GoalStatus& b) {
  // Stamps of one term have one clock, also when the planner was restarted and its sequence numbers begin again.
  return std::tuple(a.term(), a.stamp_ns(), a.sequence_number()) >
         std::tuple(b.term(), b.stamp_ns(), b.sequence_number());
}

Connection::GoalTopics::GoalTopics(Connection& owner)
    : goals(owner.participant_), statuses(owner.participant_, &owner.mailbox_) {}

Connection::Connection(Membership membership)
    : where_(std::move(membership.where)),
      supervisors_(std::move(membership.supervisors)),
      name_(unique_name()),
      participant_(std::move(membership.participant)),
      arms_(std::move(membership.arms)) {
  endpoints_.supervisor.emplace(participant_, mailbox_);
  thread_ = std::thread([this] { run(); });
}

Connection::~Connection() {
  // A goal that no planner has read is lost with its writer.
  Clock::time_point last{};
  {
    const Lock lock(mutex_);
    for (const auto& [name, record] : goals_) {
      if (!record->status) last = std::max(last, record->sent + kLastAnswers);
    }
  }
  const auto all_answered = [this] {
    const Lock lock(mutex_);
    return std::all_of(goals_.begin(), goals_.end(), [](const auto& entry) { return entry.second->status; });
  };
  static_cast<void>(wait_until(all_answered, last - Clock::now()));
  stop_ = true;
  mailbox_.notify();
  thread_.join();
}

std::shared_ptr<Connection> Connection::make(Membership membership) {
  // A callback may have held the last handle. Its thread cannot join itself.
  const auto remove = [](Connection* connection) {
    if (std::this_thread::get_id() != connection->thread_.get_id()) {
      delete connection;
    } else {
      std::thread([connection] { delete connection; }).detach();
    }
  };
  return {new Connection(std::move(membership)), remove};
}

void Connection::run() {
  while (!stop_) {
    static_cast<void>(mailbox_.wait(1s));
    std::vector<std::pair<std::function<void(const Progress&)>, Progress>> goal_calls;
    std::vector<msg::Fault> fault_calls;
    std::function<void(const Fault&)> on_fault;
    {
      const Lock lock(mutex_);
      listen();
      for (auto entry = goals_.begin(); entry != goals_.end();) {
        GoalRecord& record = *entry->second;
        if (std::exchange(record.news, false) && record.callback) {
          goal_calls.emplace_back(record.callback, to_public(*record.status, age_of(record.heard)));
        }
        const bool over = record.status && is_final(static_cast<GoalState>(record.status->state()));
        // Without a planner a goal may never get an answer. Nothing but this list knows it.
        const bool forgotten = entry->second.use_count() == 1 && !record.callback && !record.status &&
                               Clock::now() > record.sent + kLastAnswers;
        entry = over || forgotten ? goals_.erase(entry) : std::next(entry);
      }
      on_fault = on_fault_;
      fault_calls = std::exchange(fault_news_, {});
      ++news_;
    }
    arrived_.notify_all();
    for (const auto& [call, progress] : goal_calls) call(progress);
    for (const msg::Fault& fault : fault_calls) {
      if (on_fault) on_fault(to_public(fault));
    }
  }
}

void Connection::listen() {
  static_cast<void>(mailbox_.take_events());
  take(*endpoints_.supervisor);
  if (endpoints_.world) take(*endpoints_.world);
  if (endpoints_.devices) take(*endpoints_.devices);
  if (endpoints_.recorders) take(*endpoints_.recorders);
  if (endpoints_.goals) {
    for (const auto& sample : endpoints_.goals->statuses.take()) {
      if (!sample.disposed) note(sample.value);
    }
  }
  if (endpoints_.faults) {
    for (const auto& sample : endpoints_.faults->take()) {
      if (sample.disposed) {
        faults_.erase(sample.key);
      } else if (faults_.update(sample.value)) {
        fault_news_.push_back(sample.value);
      }
    }
  }
}

template <class Request, class Reply>
void Connection::take(Channel<Request, Reply>& channel) {
  for (auto& sample : channel.replies.take()) {
    if (sample.value.client() != name_) continue;
    const auto awaited = channel.awaited.find(sample.value.request_id());
    if (awaited != channel.awaited.end()) awaited->second.push_back(std::move(sample.value));
  }
}

void Connection::note(const msg::GoalStatus& status) {
  const Clock::time_point now = Clock::now();
  if (const auto own = goals_.find(status.goal()); own != goals_.end() && own->second->goal.arm() == status.arm()) {
    GoalRecord& record = *own->second;
    if (!record.status || is_later(status, *record.status)) {
      record.status = status;
      record.heard = now;
      record.news = true;
    }
  }
  // The statuses of the replaced goal and of the new one may arrive in either order.
  if (status.state() == msg::GoalState::GOAL_REPLACED) return;
  const auto [newest, first] = newest_.try_emplace(status.arm(), Newest{status, now});
  if (!first && is_later(status, newest->second.status)) newest->second = {status, now};
}

void Connection::note(const msg::CellStatus& status) {
  const Lock lock(mutex_);
  if (!status.arms().empty()) arms_.clear();
  for (const msg::ArmStatus& arm : status.arms()) arms_.push_back(arm.arm());
  for (const msg::ArmStatus& arm : status.arms()) {
    if (arm.has_goal()) note(arm.goal());
  }
  for (const msg::Fault& fault : status.faults()) {
    if (faults_.update(fault)) fault_news_.push_back(fault);
  }
}

void Connection::refuse_in_callback() const {
  if (std::this_thread::get_id() == thread_.get_id()) {
    throw std::logic_error(
        "a callback of the client library must not wait: messages arrive in the thread that runs it");
  }
}

bool Connection::wait_until(const std::function<bool()>& condition, const Wait& wait) {
  refuse_in_callback();
  const auto until = deadline_of(wait.limit);
  while (true) {
    std::uint64_t seen = 0;
    {
      const Lock lock(mutex_);
      seen = news_;
    }
    if (condition()) return true;
    Lock lock(mutex_);
    if (!arrived_.wait_until(lock, wait.stop, until, [&] { return news_ != seen; })) return false;
  }
}

Unreachable Connection::unreachable() const {
  const Lock lock(mutex_);
  std::string looked_for = "the supervisor of any cell";
  if (!supervisors_.empty()) {
    looked_for = (supervisors_.size() == 1 ? "the node " : "the nodes ") + listed(supervisors_);
  }
  if (endpoints_.supervisor->requests.matched() > 0) {
    return Unreachable({"the supervisor in " + where_ + " does not answer", {}, looked_for});
  }
  if (endpoints_.world && endpoints_.world->requests.matched() > 0) {
    return Unreachable({"the cell in " + where_ + " has no supervisor that answers", {}, looked_for});
  }
  return Unreachable({"no cell answers in " + where_ + found_instead(participant_),
                      "start one with 'hecaton up CELL', or select it by its domain or its cell file", looked_for,
                      true});
}

void Connection::wait_for_cell(const Wait& wait) {
  auto& edits = world();
  const auto found = [&] { return endpoints_.supervisor->requests.matched() > 0 || edits.requests.matched() > 0; };
  if (wait_until(found, wait)) return;
  if (wait.stop.stop_requested()) throw Interrupted("connecting to " + where_ + " was interrupted");
  throw unreachable();
}

template <class Request, class Reply>
std::vector<Reply> Connection::call(Channel<Request, Reply>& channel, Request request, const Wait& wait,
                                    const CallOptions& options) {
  const auto until = deadline_of(wait.limit);
  {
    const Lock lock(mutex_);
    request.request_id(++numbers_);
    channel.awaited[request.request_id()];
  }
  request.client(name_);
  require_acceptable(request);
  const auto replies = [&] {
    const Lock lock(mutex_);
    return channel.awaited.at(request.request_id());
  };
  const auto answered = [&] { return !replies().empty(); };
  const auto left = [&] { return Seconds(until - Clock::now()); };
  if (wait_until([&] { return channel.requests.matched() > 0; }, wait)) {
    do {
      if (!channel.requests.write(request)) break;
    } while (!wait_until(answered, {std::min(left(), options.again), wait.stop}) && left() > Seconds::zero() &&
             !wait.stop.stop_requested());
    if (answered() && channel.requests.matched() > 1) {
      static_cast<void>(wait_until([] { return false; }, {options.others, wait.stop}));
    }
  }
  std::vector<Reply> all;
  {
    const Lock lock(mutex_);
    all = std::move(channel.awaited.at(request.request_id()));
    channel.awaited.erase(request.request_id());
  }
  if (all.empty() && wait.stop.stop_requested()) {
    throw Interrupted("a request to the cell in " + where_ + " was interrupted");
  }
  return all;
}

msg::CellStatus Connection::status(const Wait& wait) {
  msg::SupervisorRequest request;
  request.kind(msg::RequestKind::REQUEST_STATUS);
  const bool any_cell = supervisors_.empty();
  auto replies = call(*endpoints_.supervisor, request, wait, {kAskAgain, any_cell ? kOtherCells : Seconds::zero()});
  if (replies.empty()) throw unreachable();
  const std::string& cell = replies.front().status().cell();
  for (const msg::SupervisorReply& other : replies) {
    if (other.status().cell() == cell) continue;
    throw InvalidArgument("the cells '" + cell + "' and '" + other.status().cell() + "' both answer in " + where_ +
                          ": choose one by its cell file or its domain");
  }
  note(replies.front().status());
  return std::move(replies.front().status());
}

std::optional<msg::CellStatus> Connection::poll_status(Seconds limit) {
  msg::SupervisorRequest request;
  request.kind(msg::RequestKind::REQUEST_STATUS);
  auto replies = call(*endpoints_.supervisor, request, limit, {});
  if (replies.empty()) return std::nullopt;
  note(replies.front().status());
  return std::move(replies.front().status());
}

msg::SupervisorReply Connection::order(msg::RequestKind kind, const std::vector<std::string>& arms, const Wait& wait) {
  msg::SupervisorRequest request;
  request.kind(kind);
  request.arms(arms);
  return order(std::move(request), wait);
}

msg::SupervisorReply Connection::order(msg::SupervisorRequest request, const Wait& wait) {
  static_cast<void>(status(wait));
  auto replies = call(*endpoints_.supervisor, std::move(request), wait, {});
  if (replies.empty()) throw unreachable();
  note(replies.front().status());
  return std::move(replies.front());
}

Connection::Channel<msg::WorldEditRequest, msg::WorldEditReply>& Connection::world() {
  const Lock lock(mutex_);
  if (!endpoints_.world) endpoints_.world.emplace(participant_, mailbox_);
  return *endpoints_.world;
}

msg::WorldEditReply Connection::edit(msg::WorldEditRequest request, const Wait& wait) {
  auto& edits = world();
  if (wait_until([&] { return edits.requests.matched() > 0; }, wait)) {
    // Several world services would all make the edit. The status throws when they belong to several cells.
    if (edits.requests.matched() > 1 && supervisors_.empty()) static_cast<void>(status(wait));
    auto replies = call(edits, std::move(request), wait, {kAskAgain, Seconds::zero()});
    if (!replies.empty()) return std::move(replies.front());
  } else if (wait.stop.stop_requested()) {
    throw Interrupted("an edit of the world in " + where_ + " was interrupted");
  }
  if (edits.requests.matched() > 0) throw NoAnswer("the world service in " + where_ + " does not answer");
  if (endpoints_.supervisor->requests.matched() == 0) throw unreachable();
  throw Unreachable({"the cell in " + where_ + " has no world service that answers", {}, "the node world"});
}

msg::DeviceReply Connection::order_device(const std::string& arm, msg::DeviceOrder order, const Wait& wait) {
  msg::DeviceRequest request;
  request.arm(arm);
  request.order(order);
  return order_device(std::move(request), wait);
}

msg::DeviceReply Connection::order_device(msg::DeviceRequest request, const Wait& wait) {
  {
    const Lock lock(mutex_);
    if (!endpoints_.devices) endpoints_.devices.emplace(participant_, mailbox_);
  }
  const std::string arm = request.arm();
  // The first driver that is found may be that of another arm.
  auto replies = call(*endpoints_.devices, std::move(request), wait, {kAskAgain, Seconds::zero()});
  if (!replies.empty()) return std::move(replies.front());
  throw Unreachable({"the driver of arm '" + arm + "' in " + where_ + " does not answer", {}, "driver/" + arm});
}

std::vector<msg::RecorderReply> Connection::order_recorders(const Wait& wait) {
  {
    const Lock lock(mutex_);
    if (!endpoints_.recorders) endpoints_.recorders.emplace(participant_, mailbox_);
  }
  // Recorders that keep everything read the request, too, and do not reply.
  auto replies = call(*endpoints_.recorders, msg::RecorderRequest(), wait, {kAskAgain, kOtherRecorders});
  if (!replies.empty()) return replies;
  throw Unreachable({"no recorder in " + where_ + " saves by order",
                     "give the cell file the key record, or start 'hecaton record' with --keep", "the node recorder"});
}

Connection::GoalTopics& Connection::goal_topics() {
  if (!endpoints_.goals) endpoints_.goals.emplace(*this);
  return *endpoints_.goals;
}

std::shared_ptr<GoalRecord> Connection::record_of(msg::Goal goal) {
  const Lock lock(mutex_);
  goal.client(name_);
  goal.goal(name_ + "/" + std::to_string(++numbers_));
  goal.sequence_number(++numbers_);
  goal.stamp_ns(services::stamp_now());
  require_acceptable(goal);
  auto record = std::make_shared<GoalRecord>();
  record->goal = std::move(goal);
  record->sent = Clock::now();
  return record;
}

void Connection::write(const std::shared_ptr<GoalRecord>& record) {
  const Lock lock(mutex_);
  const msg::Goal& goal = record->goal;
  if (const auto result = goal_topics().goals.write(goal); !result) {
    throw Unreachable({"the goal could not be sent: " + result.reason, {}, "the planner of arm '" + goal.arm() + "'"});
  }
  goals_[goal.goal()] = record;
}

std::shared_ptr<GoalRecord> Connection::send(msg::Goal goal) {
  auto record = record_of(std::move(goal));
  write(record);
  return record;
}

Goal Connection::prepare(const std::shared_ptr<Connection>& connection, msg::Goal goal) {
  return {connection, connection->record_of(std::move(goal))};
}

void Connection::send_prepared(const Goal& goal) {
  write(goal.record_);
}

Goal Connection::adopt(const std::shared_ptr<Connection>& connection, const std::string& arm, const std::string& goal) {
  auto record = std::make_shared<GoalRecord>();
  record->goal.arm(arm);
  record->goal.goal(goal);
  record->goal.client(connection->name_);
  {
    const Lock lock(connection->mutex_);
    static_cast<void>(connection->goal_topics());
    const auto newest = connection->newest_.find(arm);
    if (newest != connection->newest_.end() && newest->second.status.goal() == goal) {
      record->status = newest->second.status;
      record->heard = newest->second.heard;
    }
    connection->goals_[goal] = record;
  }
  return {connection, record};
}

void Connection::cancel(const GoalRecord& record) {
  const Lock lock(mutex_);
  msg::Goal goal = record.goal;
  goal.cancel(true);
  goal.sequence_number(++numbers_);
  goal.stamp_ns(services::stamp_now());
  if (const auto result = goal_topics().goals.write(goal); !result) {
    throw Unreachable(
        {"the cancellation could not be sent: " + result.reason, {}, "the planner of '" + goal.arm() + "'"});
  }
}

std::optional<msg::GoalStatus> Connection::status_of(const GoalRecord& record) const {
  const Lock lock(mutex_);
  return record.status;
}

std::optional<Progress> Connection::progress_of(const GoalRecord& record) const {
  const Lock lock(mutex_);
  return record.status ? std::optional(to_public(*record.status, age_of(record.heard))) : std::nullopt;
}

void Connection::set_callback(const std::shared_ptr<GoalRecord>& record,
                              std::function<void(const Progress&)> callback) {
  const Lock lock(mutex_);
  record->callback = std::move(callback);
  record->news = record->status.has_value();
  goals_[record->goal.goal()] = record;  // also a goal that has ended: the callback gets its last progress
  mailbox_.notify();
}

std::size_t Connection::open_goals() const {
  const Lock lock(mutex_);
  return goals_.size();
}

std::vector<std::string> Connection::arms() const {
  const Lock lock(mutex_);
  return arms_;
}

std::optional<msg::GoalStatus> Connection::newest_goal(const std::string& arm) {
  const Lock lock(mutex_);
  static_cast<void>(goal_topics());
  const auto newest = newest_.find(arm);
  return newest == newest_.end() ? std::nullopt : std::optional(newest->second.status);
}

std::optional<Progress> Connection::newest_progress(const std::string& arm) {
  const Lock lock(mutex_);
  static_cast<void>(goal_topics());
  const auto newest = newest_.find(arm);
  if (newest == newest_.end()) return std::nullopt;
  return to_public(newest->second.status, age_of(newest->second.heard));
}

bus::Reader<msg::Fault>& Connection::fault_topic() {
  if (!endpoints_.faults) endpoints_.faults.emplace(participant_, &mailbox_);
  return *endpoints_.faults;
}

std::vector<msg::Fault> Connection::faults() {
  const Lock lock(mutex_);
  static_cast<void>(fault_topic());
  std::vector<msg::Fault> faults;
  for (const auto& [id, fault] : faults_.all()) faults.push_back(fault);
  return faults;
}

void Connection::set_fault_callback(std::function<void(const Fault&)> callback) {
  const Lock lock(mutex_);
  static_cast<void>(fault_topic());
  on_fault_ = std::move(callback);
  fault_news_.clear();
  for (const auto& [id, fault] : faults_.all()) {
    if (!fault.cleared()) fault_news_.push_back(fault);
  }
  mailbox_.notify();
}

// States arrive in every period of every arm. Their readers have their own mailbox, so that they wake no other wait.
template <class Look>
auto Connection::wait_for_state(const Look& look, const Wait& wait) {
  constexpr Clock::duration kTurn = 100ms;  // another thread may have taken the notification
  refuse_in_callback();
  const auto until = deadline_of(wait.limit);
  const std::stop_callback wake(wait.stop, [this] { state_mailbox_.notify(); });
  while (true) {
    {
      const Lock lock(mutex_);
      if (auto seen = look()) return seen;
    }
    const auto left = until - Clock::now();
    if (left <= Clock::duration::zero() || wait.stop.stop_requested()) return decltype(look()){};
    static_cast<void>(state_mailbox_.wait(std::min(left, kTurn)));
  }
}

std::optional<Connection::Heard<msg::ArmState>> Connection::arm_state(const std::string& arm, const Wait& wait) {
  const auto look = [&]() -> std::optional<Heard<msg::ArmState>> {
    if (!endpoints_.arms) endpoints_.arms.emplace(participant_, &state_mailbox_);
    const auto* sample = endpoints_.arms->latest(arm);
    if (sample == nullptr) return std::nullopt;
    return Heard<msg::ArmState>{sample->value, sample->age()};
  };
  return wait_for_state(look, wait);
}

std::optional<Connection::Heard<msg::ToolState>> Connection::tool_state(
    const std::string& arm, const Wait& wait, const std::function<bool(const msg::ToolState&)>& fits) {
  const auto look = [&]() -> std::optional<Heard<msg::ToolState>> {
    if (!endpoints_.tools) endpoints_.tools.emplace(participant_, &state_mailbox_);
    const auto* sample = endpoints_.tools->latest(arm);
    if (sample == nullptr || (fits && !fits(sample->value))) return std::nullopt;
    return Heard<msg::ToolState>{sample->value, sample->age()};
  };
  return wait_for_state(look, wait);
}

std::optional<Connection::Scene> Connection::scene(const Wait& wait) {
  const auto look = [&]() -> std::optional<Scene> {
    if (!endpoints_.scene) endpoints_.scene.emplace(participant_, state_mailbox_);
    const auto* states = endpoints_.scene->states.latest("");
    if (states == nullptr) return std::nullopt;
    Scene scene{{states->value, states->age()}, {}};
    for (const auto& [name, sample] : endpoints_.scene->shapes.latest()) scene.shapes[name] = sample.value;
    // Shapes and states arrive separately: a scene is complete when each state has its shape.
    const bool whole = std::all_of(states->value.states().begin(), states->value.states().end(),
                                   [&](const auto& state) { return scene.shapes.contains(state.name()); });
    return whole ? std::optional(std::move(scene)) : std::nullopt;
  };
  return wait_for_state(look, wait);
}

}  // namespace hecaton::client
