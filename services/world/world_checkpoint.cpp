#include "services/world/world_checkpoint.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "services/bus/message_file.hpp"
#include "services/runtime/atomic_file.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/process_info.hpp"
#include "services/runtime/thread_priority.hpp"
#include "services/world/world_topics.hpp"

namespace hecaton::services {
namespace {

/// After a longer gap between two processes the world loses time, so that obstacles do not jump [s].
constexpr double kLongestGap = 0.1;

messages::Converted<world::ContactReport> report_from(const msg::ContactReport& message) {
  if (message.kinds().size() != world::kContactKinds)
    return {{}, "contact_report: kinds must have " + std::to_string(world::kContactKinds) + " entries"};
  world::ContactReport report;
  for (std::size_t i = 0; i < world::kContactKinds; ++i) {
    const msg::KindSummary& summary = message.kinds()[i];
    world::KindReport& kind = report.kinds[i];
    kind.contacts = summary.contacts();
    kind.has_smallest = summary.has_smallest();
    if (!kind.has_smallest) continue;
    const auto smallest = messages::from_message(summary.smallest(), "contact_report: smallest");
    if (!smallest) return {{}, smallest.error};
    kind.smallest = *smallest;
  }
  for (const msg::Separation& event : message.events()) {
    const auto contact = messages::from_message(event, "contact_report: contact");
    if (!contact) return {{}, contact.error};
    report.events.push_back(*contact);
  }
  return {report, {}};
}

/// The checkpoint of an earlier process. `unusable` gets a sentence when there is one that cannot be used.
std::optional<RestoredWorld> recall(const config::CellFile& file, const std::string& path,
                                    std::optional<std::string>& unusable) {
  if (path.empty()) return std::nullopt;
  const bus::ReadMessage read = bus::read_message(path);
  if (read.error) unusable = read.error;
  if (!read.message) return std::nullopt;
  if (read.message->cell() != file.cell.name) {
    unusable = path + " is of cell " + read.message->cell();
    return std::nullopt;
  }
  auto before = restored(*read.message, file.cell.scene);
  if (!before) unusable = path + ": " + before.error;
  return before.value;
}

}  // namespace

msg::WorldCheckpoint checkpoint_of(const world::BulletWorld& world) {
  msg::WorldCheckpoint checkpoint;
  checkpoint.time(world.time());
  checkpoint.edition(world.edition());
  for (const world::Obstacle& obstacle : world.obstacles_now()) {
    checkpoint.obstacles().push_back(messages::to_message(obstacle));
  }
  const world::ContactCheckpoint contacts = world.contact_monitor().checkpoint();
  checkpoint.contact_report(contact_report(contacts.report, world.time(), true));
  for (const world::PairCheckpoint& pair : contacts.pairs) {
    msg::PairCheckpoint& known = checkpoint.contact_pairs().emplace_back();
    known.a(pair.a);
    known.b(pair.b);
    known.occurrence(static_cast<std::uint32_t>(pair.occurrence));
    known.touching(pair.state.touching);
    known.handled(pair.state.handled);
    known.tolerated(pair.state.tolerated);
    known.tolerated_distance(pair.state.tolerated_distance);
  }
  return checkpoint;
}

messages::Converted<RestoredWorld> restored(const msg::WorldCheckpoint& checkpoint, const world::Scene& scene) {
  if (!std::isfinite(checkpoint.time())) return {{}, "time must be finite"};
  RestoredWorld next;
  next.scene = scene;
  next.scene.obstacles.clear();
  for (const msg::Obstacle& message : checkpoint.obstacles()) {
    const auto obstacle = messages::from_message(message);
    if (!obstacle) return {{}, obstacle.error};
    next.scene.obstacles.push_back(*obstacle);
  }
  const auto report = report_from(checkpoint.contact_report());
  if (!report) return {{}, report.error};
  next.contacts.report = *report;
  for (const msg::PairCheckpoint& pair : checkpoint.contact_pairs()) {
    next.contacts.pairs.push_back({pair.a(),
                                   pair.b(),
                                   static_cast<int>(pair.occurrence()),
                                   {pair.touching(), pair.handled(), pair.tolerated(), pair.tolerated_distance()}});
  }
  next.time = checkpoint.time();
  next.stamp_ns = checkpoint.stamp_ns();
  next.edition = checkpoint.edition();
  return {next, {}};
}

CheckpointWriter::CheckpointWriter(std::string path) : path_(std::move(path)) {
  if (!path_.empty()) writer_ = std::thread([this] { run(); });
}

CheckpointWriter::~CheckpointWriter() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  if (writer_.joinable()) writer_.join();
}

std::uint64_t CheckpointWriter::write(msg::WorldCheckpoint checkpoint) {
  const std::scoped_lock lock(mutex_);
  ++given_;
  if (path_.empty()) {
    tried_ = written_ = given_;
  } else {
    next_ = std::move(checkpoint);
    wake_.notify_one();
  }
  return given_;
}

CheckpointWriter::Outcome CheckpointWriter::outcome(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  if (number <= written_) return {true, std::nullopt};
  if (number <= tried_) return {true, failure_};
  auto silent = silence();
  return {silent.has_value(), std::move(silent)};
}

std::optional<std::string> CheckpointWriter::failure() const {
  const std::scoped_lock lock(mutex_);
  auto silent = silence();
  return silent ? silent : failure_;
}

void CheckpointWriter::update(Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  watchdog_.update(now, tried_ < given_, tried_);
}

std::optional<std::string> CheckpointWriter::silence() const {
  if (watchdog_.silence() <= kLongestWrite) return std::nullopt;
  return stall_text("the thread that writes " + path_, watchdog_.silence(), kLongestWrite);
}

void CheckpointWriter::run() {
  keep_startup_priority();
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ending_ || next_; });
    if (!next_) return;
    const msg::WorldCheckpoint checkpoint = *std::exchange(next_, std::nullopt);
    const std::uint64_t number = given_;
    lock.unlock();
    auto failure = write_atomically(path_, bus::file_contents(checkpoint), '\0');
    lock.lock();
    tried_ = number;
    failure_ = std::move(failure);
    if (!failure_) written_ = number;
  }
}

WorldPersistence::WorldPersistence(const config::CellFile& file, const std::string& path)
    : cell_(file.cell.name), before_(recall(file, path, unusable_)), writer_(unusable_ ? std::string() : path) {
  if (!unusable_) return;
  unusable_ = "the edits before the world's restart cannot be restored (" + *unusable_ +
              "); shut the cell down and start it again";
  log_error("checkpoint unusable", {{"reason", *unusable_}});
}

// The last checkpoint is at most one report period older than the end of the earlier process.
std::optional<std::uint64_t> WorldPersistence::restore(world::BulletWorld& world) {
  if (!before_) return std::nullopt;
  const double since = 1e-9 * static_cast<double>(stamp_now() - before_->stamp_ns);
  world.restore(before_->time + std::clamp(since, 0.0, kLongestGap), before_->edition, before_->contacts);
  const std::uint64_t contacts = world.contact_monitor().report().contacts;
  log_info("world restored",
           {{"time", world.time()}, {"contacts", contacts}, {"checkpoint_age_s", std::max(since, 0.0)}});
  before_.reset();
  return contacts;
}

std::uint64_t WorldPersistence::write(const world::BulletWorld& world) {
  msg::WorldCheckpoint checkpoint = checkpoint_of(world);
  checkpoint.cell(cell_);
  checkpoint.stamp_ns(stamp_now());
  return writer_.write(std::move(checkpoint));
}

void WorldPersistence::update(bus::Clock::time_point now) {
  writer_.update(now);
  auto failure = writer_.failure();
  if (failure.has_value() != failure_.has_value()) {
    if (failure) {
      log_error("edits are not persisted", {{"reason", *failure}});
    } else {
      log_info("edits are persisted again");
    }
  }
  failure_ = std::move(failure);
}

msg::Cause not_persisted(const std::string& what, const std::string& why) {
  return make_cause(msg::CauseKind::CAUSE_NOT_PERSISTED, world_node(),
                    what + "not persisted and will be lost when the world restarts: " + why);
}

}  // namespace hecaton::services
