#include "services/view/orders.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "services/config/text.hpp"
#include "services/runtime/log.hpp"
#include "services/view/token_file.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;
using client::ModeOrder;
using view::Json;

constexpr std::size_t kMostWaiting = 32;    // orders in a queue
constexpr std::size_t kMostReplies = 4096;  // that no server has taken
constexpr double kOrdersPerSecond = 10.0;   // of one page
constexpr double kOrdersAtOnce = 20.0;      // of one page
constexpr std::size_t kLongestName = 128;   // of a goal or an obstacle [byte]
constexpr Seconds kOrderLimit{3.0};         // for the answer of the cell
constexpr Seconds kDiscoveryLimit{15.0};    // instead, while the view is this young: it may not know the cell yet
constexpr double kFarthestTool = 1000.0;    // of a preview, from the origin [m]

/// The order is not carried out, for this reason: a sentence.
struct Refusal : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string text_in(const Json& message, const char* key) {
  const auto found = message.find(key);
  if (found == message.end() || !found->is_string() || found->get_ref<const std::string&>().size() > kLongestName) {
    throw Refusal(std::string("the order needs '") + key + "', a text of at most " + std::to_string(kLongestName) +
                  " bytes");
  }
  return found->get<std::string>();
}

std::vector<double> numbers_in(const Json& message, const char* key, std::size_t count) {
  std::vector<double> numbers;
  const auto found = message.find(key);
  if (found != message.end() && found->is_array() && found->size() == count) {
    for (const Json& number : *found) {
      if (number.is_number() && std::isfinite(number.get<double>())) numbers.push_back(number.get<double>());
    }
  }
  if (numbers.size() == count) return numbers;
  throw Refusal(std::string("the order needs '") + key + "', a list of " + std::to_string(count) + " numbers");
}

/// Joint positions of an arm [rad | m].
std::vector<double> joints_in(const Json& message, const char* key, const planner::Arm& arm) {
  return numbers_in(message, key, static_cast<std::size_t>(arm.model->joints()));
}

/// As pose_json().
Pose pose_in(const Json& message) {
  const std::vector<double> n = numbers_in(message, "pose", 7);
  const double norm = std::hypot(std::hypot(n[3], n[4]), std::hypot(n[5], n[6]));
  if (!(std::abs(norm - 1.0) < 1e-3)) throw Refusal("the rotation of 'pose' must be a unit quaternion");
  return {{n[0], n[1], n[2]}, {n[6] / norm, n[3] / norm, n[4] / norm, n[5] / norm}};
}

Shape shape_in(const Json& message) {
  const auto shape = message.find("shape");
  if (shape == message.end() || !shape->is_object()) throw Refusal("the order needs 'shape'");
  const std::string kind = text_in(*shape, "kind");
  if (kind == "box") {
    const std::vector<double> size = numbers_in(*shape, "size", 3);
    return Box{size[0], size[1], size[2]};
  }
  if (kind == "sphere") return Sphere{numbers_in(*shape, "size", 1)[0]};
  if (kind == "cylinder") {
    const std::vector<double> size = numbers_in(*shape, "size", 2);
    return Cylinder{size[0], size[1]};
  }
  throw Refusal("'" + config::printable(kind) + "' is no shape that a page can add; use box, sphere or cylinder");
}

std::string listed(const std::vector<std::string>& names) {
  if (names.empty()) return "the cell";
  return config::listed(std::vector<std::string_view>(names.begin(), names.end()));
}

/// Its name in messages of pages.
const char* op_of(ModeOrder order) {
  return order == ModeOrder::kHold ? "hold" : order == ModeOrder::kStop ? "stop" : "resume";
}

const char* done_text(ModeOrder order) {
  return order == ModeOrder::kHold ? " is held" : order == ModeOrder::kStop ? " is stopped" : " may move";
}

std::string saved_text(const std::vector<SavedRecording>& saved) {
  std::string text;
  for (const SavedRecording& one : saved) {
    text += (text.empty() ? "" : "; ") + ("the recorder on " + one.host) + " saves what it keeps, up to " + one.file;
  }
  return text;
}

std::optional<ModeOrder> mode_order(const std::string& op) {
  for (const ModeOrder order : {ModeOrder::kStop, ModeOrder::kHold, ModeOrder::kResume}) {
    if (op == op_of(order)) return order;
  }
  return std::nullopt;
}

/// What follows the answer to an order.
std::string with_warning(const std::string& sentence, const Receipt& receipt) {
  return receipt.warning ? sentence + "; " + receipt.warning.text : sentence;
}

}  // namespace

Orders::Orders(const config::CellFile& file, OrderOptions options, std::shared_ptr<client::Connection> connection)
    : file_(file), options_(std::move(options)), connection_(std::move(connection)) {
  if (!connection_) return;
  modes_.emplace([this](ModeOrder order, const std::vector<std::string>& arms, const std::stop_token& stop) {
    const Cell cell(connection_);
    switch (order) {
      case ModeOrder::kHold:
        return cell.hold(arms, patience(stop));
      case ModeOrder::kResume:
        return cell.resume(arms, patience(stop));
      case ModeOrder::kStop:
        break;
    }
    return cell.stop(arms, patience(stop));
  });
  worker_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

Orders::~Orders() {
  worker_ = {};
  modes_.reset();
  connection_.reset();  // ends the callbacks of goals, which use the other members
}

// --- messages of pages

void Orders::received(const WebClient& page, std::string_view message, Clock::time_point now) {
  const Json json = Json::parse(message, nullptr, false);
  if (!json.is_object()) return;
  Sender from{page, 0};
  if (const auto id = json.find("id"); id != json.end() && id->is_number_integer()) from.id = id->get<std::int64_t>();
  const std::lock_guard lock(mutex_);
  try {
    accept(from, json, now);
  } catch (const Refusal& refusal) {
    const auto op = json.find("op");
    answer(from, op != json.end() && op->is_string() ? op->get<std::string>().substr(0, kLongestName) : "", false, true,
           refusal.what());
  }
}

void Orders::give(const WebClient& program, ModeOrder order, const std::vector<std::string>& arms, Told told,
                  Clock::time_point now) {
  const Sender from{program, 0, std::move(told)};
  const std::lock_guard lock(mutex_);
  try {
    if (!may_send(program, now)) throw Refusal("this program sends too many orders");
    // What makes arms stand is never refused.
    if (order == ModeOrder::kResume && controller_) throw Refusal(controlled_elsewhere());
    give_mode(from, order, arms);
  } catch (const Refusal& refusal) {
    answer(from, op_of(order), false, true, refusal.what());
  }
}

void Orders::accept(const Sender& from, const Json& message, Clock::time_point now) {
  const std::string op = text_in(message, "op");
  if (controls(from.page)) controller_->heard = now;
  if (op == "alive") return;
  // Only the newest is kept, and the answers have a limit: no orders are used up by a drag.
  if (op == "preview") {
    if (!controls(from.page)) throw Refusal("this page does not control the cell");
    preview_ = preview_of(from, message);
    return;
  }
  // The stop of the cell has no limit: those that wait are one.
  if (op == "stop" && arms_in(message).empty()) {
    if (!options_.stop && !controls(from.page)) throw Refusal("this view was started with --no-stop");
    return give_mode(from, ModeOrder::kStop, {});
  }
  if (!may_send(from.page, now)) throw Refusal("this page sends too many orders");
  if (op == "take") return take_control(from, message, now);
  if (op == "release") {
    if (controls(from.page)) end_control("released");
    return answer(from, op, true, true, "released");
  }
  if (!controls(from.page)) throw Refusal("this page does not control the cell");
  if (op != op_of(ModeOrder::kHold) && op != op_of(ModeOrder::kStop)) require_fresh(message, now);
  if (const auto order = mode_order(op)) return give_mode(from, *order, arms_in(message));
  enqueue(order_of(from, op, message));
}

/// Other programs than the page show no state, and name none.
void Orders::require_fresh(const Json& message, Clock::time_point now) const {
  const auto seen = message.find("seen");
  if (seen == message.end()) return;
  if (!seen->is_number()) throw Refusal("the order needs 'seen', a number of milliseconds");
  const std::chrono::duration<double, std::milli> sent(seen->get<double>());
  const std::chrono::duration<double> delay = now - began_ - sent;
  if (std::abs(delay.count()) <= std::chrono::duration<double>(kLongestDelay).count()) return;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", delay.count());
  throw Refusal(std::string("the order came ") + text.data() + " s after the state that its page showed (limit " +
                std::to_string(kLongestDelay.count()) + " s): look at the cell, and order again");
}

void Orders::take_control(const Sender& from, const Json& message, Clock::time_point now) {
  if (options_.token.empty()) throw Refusal("this view was started without --control: its pages only stop the cell");
  if (!connection_) throw Refusal(options_.refused_as);
  if (!same_token(text_in(message, "token"), options_.token)) {
    log_warning("wrong token of a page", {{"page", from.page.address}});
    throw Refusal("the token is wrong: open the address that 'hecaton view --control' has printed");
  }
  if (controller_ && !controls(from.page)) {
    throw Refusal(controlled_elsewhere());
  }
  if (!controller_) log_info("a page takes control", {{"page", from.page.address}});
  controller_ = Controller{from.page, now};
  control_changed_ = true;
  answer(from, "take", true, true, "this page controls the cell");
}

std::string Orders::controlled_elsewhere() const {
  return "the page at " + controller_->page.address + " controls the cell, until it releases it or is closed";
}

void Orders::end_control(const char* reason) {
  log_info("a page no longer controls", {{"page", controller_->page.address}, {"reason", reason}});
  controller_.reset();
  preview_.reset();
  control_changed_ = true;
}

void Orders::enqueue(Order order) {
  if (!connection_) throw Refusal(options_.refused_as);
  if (waiting_.size() >= kMostWaiting) throw Refusal("too many orders wait for the cell");
  waiting_.push_back(std::move(order));
  arrived_.notify_one();
}

void Orders::give_mode(const Sender& from, ModeOrder order, const std::vector<std::string>& arms) {
  if (!connection_) throw Refusal(options_.refused_as);
  modes_->give(order, arms, from.page.number,
               [this, from, order, subject = listed(arms)](const client::ModeOutcome& outcome) {
                 std::string text = outcome.text;
                 if (outcome.done) text = subject + done_text(order) + (text.empty() ? "" : "; " + text);
                 log(from, op_of(order), subject, outcome.done, text);
                 answer(from, op_of(order), outcome.done, true, text);
               });
}

Orders::Order Orders::order_of(const Sender& from, const std::string& op, const Json& message) {
  Order order{from, op, {}, {}};
  if (op == "goal") {
    order.action = goal_of(from, message, order.subject);
    order.final = false;
  } else if (op == "cancel") {
    // The goal that the page shows, of any client.
    auto record = std::make_shared<client::GoalRecord>();
    record->goal.arm(arm_in(message).name);
    record->goal.goal(text_in(message, "goal"));
    if (connection_) record->goal.client(connection_->name());
    order.subject = record->goal.arm();
    order.action = [this, record](const Cell&, const Wait&) {
      connection_->cancel(*record);
      return "cancels goal " + record->goal.goal() + " of " + record->goal.arm();
    };
  } else if (op == "obstacle_add" || op == "obstacle_move") {
    const std::string name = order.subject = text_in(message, "name");
    const Pose pose = pose_in(message);
    if (op == "obstacle_move") {
      order.action = [name, pose](const Cell& cell, const Wait& wait) {
        return with_warning(name + " is moved", cell.world().move(name, pose, wait));
      };
    } else {
      order.action = [name, pose, shape = shape_in(message)](const Cell& cell, const Wait& wait) {
        return with_warning(name + " is added", cell.world().add(name, shape, pose, Static{}, wait));
      };
    }
  } else if (op == "obstacle_remove") {
    order.subject = text_in(message, "name");
    order.action = [name = order.subject](const Cell& cell, const Wait& wait) {
      return with_warning(name + " is removed", cell.world().remove(name, wait));
    };
  } else if (op == "save") {
    order.subject = "recordings";
    order.action = [](const Cell& cell, const Wait& wait) { return saved_text(cell.save_recordings(wait)); };
  } else {
    throw Refusal("'" + config::printable(op) + "' is no order that a page can give");
  }
  return order;
}

Orders::Action Orders::goal_of(const Sender& from, const Json& message, std::string& subject) {
  const planner::Arm& arm = arm_in(message);
  std::function<Goal(const hecaton::Arm&)> send;
  if (message.contains("q")) {
    subject = arm.name + " to joint positions";
    send = [q = joints_in(message, "q", arm)](const hecaton::Arm& to) { return to.go_to(q); };
  } else {
    const std::string named = text_in(message, "named");
    if (!arm.named.contains(named)) {
      throw Refusal("arm '" + arm.name + "' has no pose '" + config::printable(named) + "'");
    }
    subject = arm.name + " to " + named;
    send = [named](const hecaton::Arm& to) { return to.go_to(named); };
  }
  return [this, from, name = arm.name, what = subject, send](const Cell& cell, const Wait&) {
    const auto told = std::make_shared<GoalState>(GoalState::kAccepted);
    send(cell.arm(name)).on_progress([this, from, what, told](const Progress& progress) {
      if (*told == progress.state) return;
      *told = progress.state;
      const bool ended = is_final(progress.state);
      std::string text = what + ": " + std::string(name_of(progress.state));
      if (progress.cause) text += ", " + progress.cause.text;
      answer(from, "goal", !ended || progress.state == GoalState::kReached, ended, text);
      if (ended) log_info("goal of a page ended", {{"subject", what}, {"page", from.page.address}, {"outcome", text}});
    });
    return what + ": sent";
  };
}

PreviewQuestion Orders::preview_of(const Sender& from, const Json& message) const {
  PreviewQuestion question;
  question.page = from.page.number;
  question.id = from.id;
  question.arm = arm_index_in(message);
  const planner::Arm& arm = file_.cell.arms[static_cast<std::size_t>(question.arm)].arm;
  const Pose pose = pose_in(message);
  const auto& [w, x, y, z] = pose.rotation;
  question.X_WT.linear() = Eigen::Quaterniond(w, x, y, z).toRotationMatrix();
  question.X_WT.translation() << pose.position.x, pose.position.y, pose.position.z;
  if (!(question.X_WT.translation().cwiseAbs().maxCoeff() <= kFarthestTool)) {
    throw Refusal("the position of 'pose' must be within 1000 m of the origin");
  }
  if (message.contains("start")) {
    const std::vector<double> start = joints_in(message, "start", arm);
    question.start = Eigen::Map<const Eigen::VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
    question.start = question.start.cwiseMax(arm.limits.lower).cwiseMin(arm.limits.upper);
  }
  return question;
}

std::vector<std::string> Orders::arms_in(const Json& message) const {
  const auto found = message.find("arms");
  if (found == message.end()) return {};
  if (!found->is_array() || found->size() > file_.cell.arms.size()) {
    throw Refusal("'arms' must be a list of arms; without it the order is for the cell");
  }
  std::vector<std::string> names;
  for (const Json& name : *found) names.push_back(arm_in(Json::object({{"arm", name}})).name);
  return names;
}

int Orders::arm_index_in(const Json& message) const {
  const std::string name = text_in(message, "arm");
  const auto& arms = file_.cell.arms;
  const auto found =
      std::find_if(arms.begin(), arms.end(), [&](const auto& planned) { return planned.arm.name == name; });
  if (found == arms.end()) throw Refusal("'" + config::printable(name) + "' is no arm of the cell");
  return static_cast<int>(found - arms.begin());
}

const planner::Arm& Orders::arm_in(const Json& message) const {
  return file_.cell.arms[static_cast<std::size_t>(arm_index_in(message))].arm;
}

bool Orders::controls(const WebClient& page) const {
  return controller_ && controller_->page.number == page.number;
}

bool Orders::may_send(const WebClient& page, Clock::time_point now) {
  Bucket& bucket = buckets_.try_emplace(page.number, Bucket{kOrdersAtOnce, now}).first->second;
  const double earned = std::chrono::duration<double>(now - bucket.at).count() * kOrdersPerSecond;
  bucket = {std::min(kOrdersAtOnce, bucket.left + std::max(0.0, earned)), now};
  if (bucket.left < 1.0) return false;
  bucket.left -= 1.0;
  return true;
}

void Orders::left(const WebClient& page) {
  const std::lock_guard lock(mutex_);
  buckets_.erase(page.number);
  withdraw(page);
  if (controls(page)) end_control("its connection is closed");
}

void Orders::withdraw(const WebClient& page) {
  std::erase_if(waiting_, [&](const Order& order) { return order.sender.page.number == page.number; });
  if (modes_) modes_->withdraw(page.number);
}

void Orders::update(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  if (!controller_ || now - controller_->heard <= kControlLease) return;
  withdraw(controller_->page);
  end_control("it is silent");
}

Orders::Replies Orders::take_replies() {
  const std::lock_guard lock(replies_mutex_);
  return std::exchange(replies_, {});
}

std::optional<Json> Orders::take_control_change() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(control_changed_, false)) return std::nullopt;
  Json json{{"type", "control"},
            {"stop", options_.stop && connection_},
            {"control", !options_.token.empty() && connection_},
            {"refusal", connection_ ? "" : options_.refused_as},
            {"controller", nullptr}};
  if (controller_) json["controller"] = {{"number", controller_->page.number}, {"address", controller_->page.address}};
  return json;
}

void Orders::announce_control() {
  const std::lock_guard lock(mutex_);
  control_changed_ = true;
}

std::optional<PreviewQuestion> Orders::take_preview() {
  const std::lock_guard lock(mutex_);
  return std::exchange(preview_, std::nullopt);
}

// --- the thread

Wait Orders::patience(const std::stop_token& stop) const {
  const Seconds still_young = began_ + kDiscoveryLimit - Clock::now();
  return {std::max(kOrderLimit, still_young), stop};
}

void Orders::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (arrived_.wait(lock, stop, [&] { return !waiting_.empty(); })) {
    const Order order = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    carry_out(stop, order);
    lock.lock();
  }
}

void Orders::carry_out(const std::stop_token& stop, const Order& order) {
  std::string text;
  bool done = false;
  try {
    text = order.action(Cell(connection_), patience(stop));
    done = true;
  } catch (const std::exception& error) {
    text = error.what();
  }
  log(order.sender, order.op, order.subject, done, text);
  answer(order.sender, order.op, done, order.final || !done, text);
}

void Orders::log(const Sender& from, const std::string& op, const std::string& subject, bool done,
                 const std::string& text) {
  log_info("order of a page", {{"order", op},
                               {"subject", subject},
                               {"page", from.page.address},
                               {"client", connection_->name()},
                               {"done", done},
                               {"answer", text}});
}

void Orders::answer(const Sender& to, const std::string& op, bool done, bool final, const std::string& text) {
  if (to.told) return to.told(done, text);
  Json json{{"type", "reply"}, {"id", to.id}, {"op", op}, {"done", done}, {"final", final}, {"text", text}};
  if (op == "take") json["number"] = to.page.number;
  const std::lock_guard lock(replies_mutex_);
  if (replies_.size() >= kMostReplies) return;
  replies_.emplace_back(to.page.number, std::move(json));
}

}  // namespace hecaton::services
