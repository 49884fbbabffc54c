#include "tests/cell/motion/motion_cell.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "services/runtime/cause.hpp"

namespace hecaton::test {
namespace {

constexpr auto kSupervisorPeriod = 20ms;
constexpr const char* kCellName = "motion_test";

std::string write_cell(int arms, const std::string& obstacles, const std::string& defaults) {
  const auto path = std::filesystem::temp_directory_path() / ("hecaton-motion-" + std::to_string(getpid()) + ".yaml");
  std::ofstream file(path);
  file << "name: " << kCellName << "\n"
       << "network: {interface: 127.0.0.1}\n"
       << "defaults:\n";
  if (defaults.find("urdf: ") == std::string::npos) {
    file << "  urdf: " << HECATON_SOURCE_DIR << "/deploy/cells/urdf/puma560.urdf\n"
         << "  limits: {velocity: 1.5, acceleration: 10}\n"
         << "  poses:\n"
         << "    home: [0, -1.9, 2.6, 0, 0.6, 0]\n"
         << "    ready: [-0.3, -1.25, 3.5, 0, 0.89, 0]\n";
  }
  file << defaults << "arms:\n";
  for (int i = 1; i <= arms; ++i) {
    file << "  - {name: arm" << i << ", base: {xyz: [0, " << 1.2 * (i - 1) << ", 0]}}\n";
  }
  if (!obstacles.empty()) file << "obstacles:\n" << obstacles;
  return path.string();
}

bus::ParticipantOptions local(bus::Mailbox* mailbox) {
  bus::ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  options.partition = kCellName;
  options.mailbox = mailbox;
  return options;
}

bus::ReaderOptions every_sample() {
  bus::ReaderOptions options;
  options.conflate = false;
  return options;
}

}  // namespace

const std::vector<double> MotionCell::kHome{0, -1.9, 2.6, 0, 0.6, 0};
const std::vector<double> MotionCell::kReady{-0.3, -1.25, 3.5, 0, 0.89, 0};

MotionCell::MotionCell(int arms, const std::string& obstacles, const std::string& defaults)
    : path_(write_cell(arms, obstacles, defaults)),
      participant_(domain_.number(), "test", local(&mailbox_)),
      modes_(participant_),
      goals_(participant_),
      requests_(participant_),
      replies_(participant_, &mailbox_),
      states_(participant_, &mailbox_, every_sample()),
      statuses_(participant_, &mailbox_),
      shapes_(participant_, &mailbox_),
      reports_(participant_, &mailbox_),
      heartbeats_(participant_, &mailbox_),
      arm_count_(arms) {
  processes_.reserve(32);  // references to processes stay valid
  mode_.node("test");
  set_mode(msg::Mode::MODE_RUN, 1);
}

MotionCell::~MotionCell() {
  processes_.clear();
  std::filesystem::remove(path_);
}

ChildProcess& MotionCell::start(const std::string& program, const std::string& arm, const std::string& checkpoint) {
  std::vector<std::string> arguments{path_, "--domain", std::to_string(domain_.number()), "--log-level", "debug"};
  if (!arm.empty()) arguments.insert(arguments.end(), {"--arm", arm});
  if (!checkpoint.empty()) arguments.insert(arguments.end(), {"--checkpoint", checkpoint});
  return processes_.emplace_back(program, arguments);
}

ChildProcess& MotionCell::start_driver(const std::string& arm, const std::string& checkpoint) {
  return start("hecaton-arm-driver", arm, checkpoint);
}
ChildProcess& MotionCell::start_planner(const std::string& arm, const std::string& checkpoint) {
  return start("hecaton-planner", arm, checkpoint);
}
ChildProcess& MotionCell::start_world() {
  return start("hecaton-world", "");
}

void MotionCell::start_all() {
  start_world();
  for (int i = 1; i <= arm_count_; ++i) {
    start_driver("arm" + std::to_string(i));
    start_planner("arm" + std::to_string(i));
  }
  ASSERT_TRUE(await([this] {
    for (int i = 1; i <= arm_count_; ++i) {
      const auto* state = arm("arm" + std::to_string(i));
      if (state == nullptr || state->mode() != msg::ArmMode::ARM_RUNNING) return false;
    }
    return true;
  })) << "the cell does not start";
}

bool MotionCell::await(const std::function<bool()>& event) {
  const auto until = bus::Clock::now() + kLimit;
  auto due = bus::Clock::now();
  while (bus::Clock::now() < until) {
    read_all();
    if (event()) return true;
    if (bus::Clock::now() >= due) {
      set_mode(mode_.mode(), mode_.term(), mode_.cause().text());
      due = bus::Clock::now() + kSupervisorPeriod;
    }
    (void)mailbox_.wait(kSupervisorPeriod);
  }
  return false;
}

void MotionCell::read_all() {
  (void)mailbox_.take_events();
  for (auto& sample : states_.take()) {
    if (!sample.disposed) history_.push_back(std::move(sample.value));
  }
  for (const auto& sample : statuses_.take()) {
    if (!sample.disposed) statuses_of_[sample.value.goal()].push_back(sample.value);
  }
  for (const auto& sample : heartbeats_.take()) {
    if (!sample.disposed) alive_[sample.key] = sample.value;
  }
}

void MotionCell::set_mode(msg::Mode mode, std::uint64_t term, const std::string& reason) {
  mode_.mode(mode);
  mode_.term(term);
  mode_.cause(reason.empty() ? msg::Cause() : services::make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, {}, reason));
  mode_.sequence_number(mode_.sequence_number() + 1);
  EXPECT_TRUE(modes_.write(mode_));
}

msg::Goal MotionCell::joint_goal(const std::string& goal, const std::vector<double>& q, const std::string& arm) {
  msg::Goal message;
  message.arm(arm);
  message.goal(goal);
  message.client("test");
  message.sequence_number(++goal_count_);
  message.kind(msg::GoalKind::GOAL_JOINTS);
  message.q(q);
  return message;
}

void MotionCell::send(const msg::Goal& goal) {
  EXPECT_TRUE(goals_.write(goal));
}

msg::WorldEditReply MotionCell::edit(msg::WorldEditRequest request) {
  request.client("test");
  request.request_id(++request_count_);
  EXPECT_TRUE(requests_.wait_matched(1, kLimit));
  EXPECT_TRUE(requests_.write(request));
  msg::WorldEditReply reply;
  EXPECT_TRUE(await([&] {
    for (auto& sample : replies_.take()) {
      if (sample.value.request_id() != request.request_id()) continue;
      reply = sample.value;
      return true;
    }
    return false;
  })) << "no reply to edit "
      << request.request_id();
  return reply;
}

msg::Obstacle MotionCell::box(const std::string& name, double x, double y, double z) const {
  msg::Obstacle obstacle;
  obstacle.name(name);
  msg::PlacedShape& shape = obstacle.shapes().emplace_back();
  shape.kind(msg::ShapeKind::SHAPE_BOX);
  shape.dimensions().x(0.05);
  shape.dimensions().y(0.05);
  shape.dimensions().z(0.05);
  shape.X_OS().qw(1.0);
  obstacle.X_WO().qw(1.0);
  obstacle.X_WO().position().x(x);
  obstacle.X_WO().position().y(y);
  obstacle.X_WO().position().z(z);
  obstacle.X_TO().qw(1.0);
  return obstacle;
}

const msg::ArmState* MotionCell::arm(const std::string& name) const {
  const auto found =
      std::find_if(history_.rbegin(), history_.rend(), [&](const msg::ArmState& state) { return state.arm() == name; });
  return found == history_.rend() ? nullptr : &*found;
}

const msg::GoalStatus* MotionCell::status(const std::string& goal, const std::string& arm) const {
  const auto* sample = const_cast<bus::Reader<msg::GoalStatus>&>(statuses_).latest(arm + "/" + goal);
  return sample == nullptr ? nullptr : &sample->value;
}

bool MotionCell::is(const std::string& goal, msg::GoalState state, const std::string& arm) const {
  const auto* found = status(goal, arm);
  return found != nullptr && found->state() == state;
}

bool MotionCell::ever(const std::string& goal, msg::GoalState state) const {
  const auto found = statuses_of_.find(goal);
  return found != statuses_of_.end() &&
         std::any_of(found->second.begin(), found->second.end(),
                     [&](const msg::GoalStatus& status) { return status.state() == state; });
}

bool MotionCell::moves(const std::string& name) const {
  const auto* state = arm(name);
  return state != nullptr &&
         std::any_of(state->qd().begin(), state->qd().end(), [](double speed) { return std::abs(speed) > 0.2; });
}

}  // namespace hecaton::test
