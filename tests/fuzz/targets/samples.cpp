// A serialised sample of a topic: the wire's check, the decoder, and what the services make of an accepted sample. The
// first byte chooses the topic.

#include <array>
#include <vector>

#include "services/bus/recorded_sample.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/client/convert.hpp"
#include "services/messages/convert.hpp"
#include "services/recorder/cdr_columns.hpp"
#include "services/tick_log/tick_reader.hpp"
#include "services/view/motion_json.hpp"
#include "services/view/state_json.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/support/cdr.hpp"
#include "world/model/obstacle_motion.hpp"

namespace {

using namespace hecaton;

/// The page of a cell, at a fixed time.
class FixedFeed : public services::CellFeed {
 public:
  explicit FixedFeed(const services::CellState& state) : state_(state) {}
  [[nodiscard]] const services::CellState& state() const override { return state_; }
  [[nodiscard]] bus::Clock::time_point now() const override { return bus::Clock::time_point(std::chrono::hours(1)); }
  [[nodiscard]] std::chrono::milliseconds unix_time() const override { return {}; }
  [[nodiscard]] double rate() const override { return 1.0; }
  [[nodiscard]] std::uint64_t leaps() const override { return 0; }

 private:
  const services::CellState& state_;
};

void convert(const msg::Obstacle& obstacle) {
  const auto value = messages::from_message(obstacle);
  fuzz::require(value || !value.error.empty(), "a conversion gives a value or a sentence");
  if (value) {
    fuzz::require(bool(messages::from_message(messages::to_message(*value))), "a converted obstacle converts again");
    for (const double time : {0.0, 12.5, 1e6}) {
      fuzz::require(world::motion_at(*value, time).X_WO.matrix().allFinite(),
                    "an obstacle has a finite pose at any time");
    }
    static_cast<void>(world::script_breaks(*value));
  }
}
void convert(const msg::ObstacleShapes& shapes) {
  convert(shapes.obstacle());
}
void convert(const msg::WorldEditRequest& request) {
  convert(request.obstacle());
}
void convert(const msg::ObstacleStates& states) {
  static_cast<void>(messages::from_message(states, 0.01));
}
void convert(const msg::RangeScan& scan) {
  static_cast<void>(messages::from_message(scan));
}
void convert(const msg::Goal& goal) {
  static_cast<void>(messages::from_message(goal.tool(), "goal"));
  static_cast<void>(messages::joints_from_message(goal.q(), "q"));
}
void convert(const msg::GoalStatus& status) {
  static_cast<void>(client::to_public(status));
}
void convert(const msg::Fault& fault) {
  static_cast<void>(client::to_public(fault));
}
void convert(const msg::ArmState& state) {
  static_cast<void>(client::to_public(state, Seconds{0.1}));
}
void convert(const msg::ToolState& state) {
  static_cast<void>(client::to_public(state, Seconds{0.1}));
}
void convert(const msg::SupervisorReply& reply) {
  static_cast<void>(client::to_public(reply.status()));
}
void convert(const msg::ContactReport& report) {
  static_cast<void>(messages::from_message(report.smallest(), "smallest"));
}
void convert(const msg::PlannerTick& tick) {
  static const config::CellFile kCell = config::load_cell_file(fuzz::source("deploy/cells/three_puma.yaml"));
  services::TickReader reader(kCell.cell, 0);
  const auto error = reader.take(tick);
  fuzz::require(!error || !error->empty(), "a tick gives inputs or a sentence");
  if (!error && tick.snapshot()) static_cast<void>(reader.planner(tick));
}
template <class T>
void convert(const T&) {}

template <class T>
void show(const T& value) {
  static const config::CellFile kCell = config::load_cell_file(fuzz::source("deploy/cells/three_puma.yaml"));
  services::CellState state(kCell, {});
  bus::Sample<T> sample{value, bus::key_of(value), bus::Clock::time_point(std::chrono::minutes(59)), {}, false};
  if constexpr (requires { state.apply(sample); }) {
    state.apply(sample);
    const FixedFeed feed(state);
    for (const auto& json : {services::view::frame_json(feed, {}), services::view::status_json(feed, {}),
                             services::view::obstacles_json(state), services::view::motions_json(feed)}) {
      fuzz::require(!json.dump().empty(), "the page shows each state");
    }
  }
}

template <class T>
void check_sample(fuzz::View bytes) {
  const bus::TopicRule& rule = *bus::topic_rule(bus::Topic<T>::kInfo.type);
  const bus::CheckedSample checked = bus::check_sample(rule, bytes);
  const auto decoded = bus::decode_recorded<T>(bytes);
  if (checked.other_schema || checked.refusal) {
    if (checked.refusal) fuzz::require_sentence(*checked.refusal);
    fuzz::require(!decoded.value, "what the check refuses is not decoded");
    return;
  }
  fuzz::require(decoded.value.has_value(), "what the check accepts can be decoded");
  const T& value = *decoded.value;
  const auto again = bus::decode_recorded<T>(test::cdr_of(value));
  fuzz::require(again.value && *again.value == value, "a decoded sample survives another way over the wire");
  services::recorder::CdrColumns columns(rule);
  fuzz::require(!columns.measure(bytes), "an accepted sample has a row");
  fuzz::require(columns.row(bytes).size() == columns.header().size(), "a row has a value for each column");
  convert(value);
  show(value);
}

}  // namespace

extern "C" int HECATON_FUZZ_TARGET(samples)(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  using Check = void (*)(fuzz::View);
#define HECATON_CHECK(Type, ...) check_sample<msg::Type>,
  static constexpr std::array<Check, bus::kTopics.size()> kChecks{HECATON_TOPICS(HECATON_CHECK)};
#undef HECATON_CHECK
  kChecks[input.byte() % kChecks.size()](input.rest());
  return 0;
}
