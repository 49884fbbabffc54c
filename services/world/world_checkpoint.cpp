#include "services/world/world_checkpoint.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/bus/message_file.hpp"
#include "services/runtime/kept_file.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/process_info.hpp"
#include "services/runtime/urgency.hpp"
#include "services/world/world_parts.hpp"

namespace hecaton::services {
namespace {

/// A longer gap between two worlds costs the world time instead of making obstacles jump [s].
constexpr double kLongestGap = 0.1;

messages::Converted<world::RefereeReport> report_from(const msg::RefereeReport& message) {
  if (message.kinds().size() != world::kContactKinds) return {{}, "referee: another number of kinds of contacts"};
  world::RefereeReport report;
  for (std::size_t i = 0; i < world::kContactKinds; ++i) {
    const msg::KindSummary& summary = message.kinds()[i];
    world::KindReport& kind = report.kinds[i];
    kind.contacts = summary.contacts();
    kind.judged = summary.judged();
    if (!kind.judged) continue;
    const auto smallest = messages::from_message(summary.smallest(), "referee: smallest");
    if (!smallest) return {{}, smallest.error};
    kind.smallest = *smallest;
  }
  for (const msg::Separation& event : message.events()) {
    const auto contact = messages::from_message(event, "referee: contact");
    if (!contact) return {{}, contact.error};
    report.events.push_back(*contact);
  }
  return {report, {}};
}

/// What a world that died has left. `lost`: gets a sentence when there is something that cannot be used.
std::optional<Continuation> recall(const config::CellFile& file, const std::string& path,
                                   std::optional<std::string>& lost) {
  if (path.empty()) return std::nullopt;
  const bus::ReadMessage read = bus::read_message(path);
  if (!read.error.empty()) lost = read.error;
  if (!read.message) return std::nullopt;
  if (read.message->cell() != file.cell.name) {
    lost = path + " is of cell " + read.message->cell();
    return std::nullopt;
  }
  auto before = continuation(*read.message, file.cell.scene);
  if (!before) lost = path + ": " + before.error;
  return before.value;
}

}  // namespace

msg::WorldMemory memory_of(const world::BulletWorld& world) {
  msg::WorldMemory memory;
  memory.time(world.time());
  memory.edition(world.snapshot().edition);
  for (const world::Obstacle& obstacle : world.obstacles_now()) {
    memory.obstacles().push_back(messages::to_message(obstacle));
  }
  const world::RefereeMemory account = world.referee().remember();
  memory.referee(contact_report(account.report, world.time(), true));
  for (const world::LastingPair& pair : account.lasting) {
    msg::LastingPair& lasting = memory.lasting().emplace_back();
    lasting.a(pair.a);
    lasting.b(pair.b);
    lasting.which(static_cast<std::uint32_t>(pair.which));
    lasting.touching(pair.touching);
    lasting.fresh(pair.fresh);
    lasting.excused(pair.excused);
    lasting.excused_at(pair.excused_at);
  }
  return memory;
}

messages::Converted<Continuation> continuation(const msg::WorldMemory& memory, const world::Scene& scene) {
  if (!std::isfinite(memory.time())) return {{}, "time must be finite"};
  Continuation next;
  next.scene = scene;
  next.scene.obstacles.clear();
  for (const msg::Obstacle& message : memory.obstacles()) {
    const auto obstacle = messages::from_message(message);
    if (!obstacle) return {{}, obstacle.error};
    next.scene.obstacles.push_back(*obstacle);
  }
  const auto report = report_from(memory.referee());
  if (!report) return {{}, report.error};
  next.account.report = *report;
  for (const msg::LastingPair& pair : memory.lasting()) {
    next.account.lasting.push_back({pair.a(), pair.b(), static_cast<int>(pair.which()), pair.touching(), pair.fresh(),
                                    pair.excused(), pair.excused_at()});
  }
  next.time = memory.time();
  next.stamp_ns = memory.stamp_ns();
  next.edition = memory.edition();
  return {next, {}};
}

CheckpointWriter::CheckpointWriter(std::string path) : path_(std::move(path)) {
  if (!path_.empty()) writer_ = std::thread([this] { write(); });
}

CheckpointWriter::~CheckpointWriter() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  if (writer_.joinable()) writer_.join();
}

std::uint64_t CheckpointWriter::keep(msg::WorldMemory memory) {
  const std::scoped_lock lock(mutex_);
  ++given_;
  if (path_.empty()) {
    tried_ = kept_ = given_;
  } else {
    next_ = std::move(memory);
    wake_.notify_one();
  }
  return given_;
}

CheckpointWriter::Outcome CheckpointWriter::outcome(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  if (number <= kept_) return {true, std::nullopt};
  if (number <= tried_) return {true, failure_};
  auto silent = silence();
  return {silent.has_value(), std::move(silent)};
}

std::optional<std::string> CheckpointWriter::failure() const {
  const std::scoped_lock lock(mutex_);
  auto silent = silence();
  return silent ? silent : failure_;
}

void CheckpointWriter::look(Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  watch_.look(now, tried_ < given_, tried_);
}

std::optional<std::string> CheckpointWriter::silence() const {
  if (watch_.silence() <= kLongestWrite) return std::nullopt;
  return complaint_about("the thread that writes " + path_, watch_.silence(), kLongestWrite);
}

void CheckpointWriter::write() {
  stay_behind_loops();
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ending_ || next_; });
    if (!next_) return;
    const msg::WorldMemory memory = *std::exchange(next_, std::nullopt);
    const std::uint64_t number = given_;
    lock.unlock();
    std::string refusal = keep_in_file(path_, bus::file_contents(memory), '\0');
    lock.lock();
    tried_ = number;
    failure_ = refusal.empty() ? std::nullopt : std::optional(std::move(refusal));
    if (!failure_) kept_ = number;
  }
}

WorldPersistence::WorldPersistence(const config::CellFile& file, const std::string& path)
    : cell_(file.cell.name), before_(recall(file, path, lost_)), writer_(lost_ ? std::string() : path) {
  if (!lost_) return;
  lost_ = "what was edited in the world before it died cannot be recovered (" + *lost_ +
          "): end the cell and start it again";
  log_error("world forgot", {{"reason", *lost_}});
}

// Between the last checkpoint and the end of the world that died lies at most a report's period.
std::optional<std::uint64_t> WorldPersistence::go_on(world::BulletWorld& world) {
  if (!before_) return std::nullopt;
  const double since = 1e-9 * static_cast<double>(stamp_now() - before_->stamp_ns);
  world.go_on(before_->time + std::clamp(since, 0.0, kLongestGap), before_->edition, before_->account);
  const std::uint64_t contacts = world.referee().report().contacts;
  log_info("world goes on",
           {{"time", world.time()}, {"contacts", contacts}, {"remembered_s_ago", std::max(since, 0.0)}});
  before_.reset();
  return contacts;
}

std::uint64_t WorldPersistence::write(const world::BulletWorld& world) {
  msg::WorldMemory memory = memory_of(world);
  memory.cell(cell_);
  memory.stamp_ns(stamp_now());
  return writer_.keep(std::move(memory));
}

void WorldPersistence::look(bus::Clock::time_point now) {
  writer_.look(now);
  auto failure = writer_.failure();
  if (failure.has_value() != failure_.has_value()) {
    if (failure) {
      log_error("edits are not remembered", {{"reason", *failure}});
    } else {
      log_info("edits are remembered again");
    }
  }
  failure_ = std::move(failure);
}

msg::Cause not_persisted(const std::string& what, const std::string& why) {
  return make_cause(msg::CauseKind::CAUSE_NOT_PERSISTED, world_node(),
                    what + "not remembered, and lost with the world's process: " + why);
}

}  // namespace hecaton::services
