#include "services/arm_driver/devices/universal_robots/rtde_client.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hecaton::device::universal_robots {
namespace {

constexpr int kRtdePort = 30004;
/// From the beginning of the connection to the first data.
constexpr std::chrono::seconds kHandshake{3};
/// A robot that sends no data for this long is not connected any more.
constexpr std::chrono::milliseconds kSilence{500};
constexpr double kDrift = 200e-6;  // of the clocks [s/s]
/// No robot's clock shows more. Ages of data fit into nanoseconds of 64 bits [s].
constexpr double kLongestUptime = 1e9;

struct Field {
  std::string_view name;
  std::string_view type;
  bool required;
  bool (*read)(ByteReader& reader, RobotData& data);
};

template <class Value, class Member>
bool store(const std::optional<Value>& value, Member& member) {
  if (value) member = *value;
  return value.has_value();
}

bool read_joints(ByteReader& reader, std::array<double, 6>& joints) {
  return std::all_of(joints.begin(), joints.end(), [&](double& joint) { return store(reader.f64(), joint); });
}

const std::array<Field, 8> kFields{{
    {"timestamp", "DOUBLE", true, [](ByteReader& from, RobotData& to) { return store(from.f64(), to.timestamp); }},
    {"actual_q", "VECTOR6D", true, [](ByteReader& from, RobotData& to) { return read_joints(from, to.q); }},
    {"actual_qd", "VECTOR6D", true, [](ByteReader& from, RobotData& to) { return read_joints(from, to.qd); }},
    {"robot_mode", "INT32", true, [](ByteReader& from, RobotData& to) { return store(from.i32(), to.robot_mode); }},
    {"safety_mode", "INT32", true, [](ByteReader& from, RobotData& to) { return store(from.i32(), to.safety_mode); }},
    {"runtime_state", "UINT32", true,
     [](ByteReader& from, RobotData& to) { return store(from.u32(), to.runtime_state); }},
    {"speed_scaling", "DOUBLE", true,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.speed_scaling); }},
    {"target_speed_fraction", "DOUBLE", false,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.target_speed_fraction); }},
}};

constexpr std::string_view kInputs = "speed_slider_mask,speed_slider_fraction";
constexpr std::string_view kNotFound = "NOT_FOUND";
constexpr std::string_view kInUse = "IN_USE";

bool is_finite(const RobotData& data) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::all_of(data.q.begin(), data.q.end(), finite) && std::all_of(data.qd.begin(), data.qd.end(), finite) &&
         finite(data.timestamp) && finite(data.speed_scaling) && finite(data.target_speed_fraction);
}

}  // namespace

double ClockOffset::age(Clock::time_point now, double timestamp) {
  const double arrived = std::chrono::duration<double>(now.time_since_epoch()).count();
  const double difference = arrived - timestamp;
  offset_ = offset_ ? std::min(*offset_ + kDrift * std::max(0.0, arrived - updated_), difference) : difference;
  updated_ = arrived;
  return difference - *offset_;
}

void RtdeClient::open(Clock::time_point now) {
  close();
  connection_.connect(setup_.address, kRtdePort);
  step_ = Step::kConnecting;
  deadline_ = now + kHandshake;
}

void RtdeClient::close() {
  connection_.close();
  step_ = Step::kClosed;
  error_.clear();
  version_ = 1;
  outputs_ = {};
  data_.reset();
  offset_ = {};
}

void RtdeClient::fail(std::string sentence) {
  connection_.close();
  step_ = Step::kFailed;
  error_ = "the robot at " + setup_.address + " " + std::move(sentence);
}

void RtdeClient::update(Clock::time_point now) {
  if (step_ == Step::kClosed || step_ == Step::kFailed) return;
  connection_.update();
  if (step_ == Step::kConnecting && connection_.is_open()) ask_version(2);
  while (step_ != Step::kFailed) {
    const Framing next = next_package(connection_.received());
    if (next.broken) return fail("sends bytes on port 30004 that are not RTDE: is robot_ip right?");
    if (!next.package) break;
    take(*next.package, now);
    // A failure has dropped the bytes.
    if (step_ != Step::kFailed) connection_.received().erase(0, next.size);
  }
  if (step_ == Step::kFailed) return;
  if (connection_.state() == TcpConnection::State::kClosed) {
    const bool once = step_ != Step::kConnecting;
    return fail(once
                    ? "has closed the RTDE connection: " + connection_.error()
                    : "cannot be reached on port 30004: " + connection_.error() + "; is it on, and is robot_ip right?");
  }
  if (now < deadline_) return;
  if (step_ == Step::kData) return fail("has sent no data for 500 ms: is its cable out?");
  fail(step_ == Step::kConnecting ? "does not answer on port 30004: is it on, and is robot_ip right?"
                                  : "does not complete the RTDE handshake within 3 s");
}

// A message for people may come at any time, also within the handshake.
void RtdeClient::take(const Package& package, Clock::time_point now) {
  if (package.type == PackageType::kText) {
    const auto text = text_message(package.payload, version_);
    if (text && log_) log_("robot says", readable(text->source + ": " + text->message));
    return;
  }
  if (package.type == PackageType::kData) {
    if (step_ == Step::kData) take_data(package.payload, now);
    return;
  }
  const bool expected = (step_ == Step::kVersion && package.type == PackageType::kProtocolVersion) ||
                        (step_ == Step::kController && package.type == PackageType::kControllerVersion) ||
                        (step_ == Step::kOutputs && package.type == PackageType::kOutputs) ||
                        (step_ == Step::kInputs && package.type == PackageType::kInputs) ||
                        (step_ == Step::kStart && package.type == PackageType::kStart);
  if (!expected) return;
  switch (step_) {
    case Step::kVersion:
      return take_version(package.payload);
    case Step::kController:
      return take_controller(package.payload);
    case Step::kOutputs:
      return take_outputs(package.payload);
    case Step::kInputs:
      return take_inputs(package.payload);
    default:
      return take_start(package.payload);
  }
}

void RtdeClient::ask_version(std::uint16_t version) {
  std::string payload;
  put_u16(payload, version);
  connection_.send(package(PackageType::kProtocolVersion, payload));
  version_ = version;
  step_ = Step::kVersion;
}

// Until the answer, both sides speak version 1; the answer is the same in both.
void RtdeClient::take_version(std::string_view payload) {
  const bool accepted = ByteReader(payload).u8().value_or(0) != 0;
  if (!accepted && version_ > 1) return ask_version(1);
  if (!accepted) return fail("speaks no version of RTDE that Hecaton knows");
  connection_.send(package(PackageType::kControllerVersion, {}));
  step_ = Step::kController;
}

void RtdeClient::take_controller(std::string_view payload) {
  ByteReader reader(payload);
  const auto major = reader.u32();
  const auto minor = reader.u32();
  const auto bugfix = reader.u32();
  if (!bugfix) return fail("sends a malformed version of its controller");
  major_version_ = *major;
  if (log_) {
    log_("robot connected", setup_.address + ", controller " + std::to_string(*major) + "." + std::to_string(*minor) +
                                "." + std::to_string(*bugfix) + ", RTDE version " + std::to_string(version_));
  }
  outputs_.fields.clear();
  for (std::size_t i = 0; i < kFields.size(); ++i) outputs_.fields.push_back(i);
  ask_outputs();
}

void RtdeClient::ask_outputs() {
  std::string payload;
  if (version_ > 1) put_f64(payload, std::min(setup_.frequency, major_version_ < 5 ? 125.0 : 500.0));
  for (const std::size_t field : outputs_.fields) {
    if (field != outputs_.fields.front()) payload += ',';
    payload += kFields[field].name;
  }
  connection_.send(package(PackageType::kOutputs, payload));
  step_ = Step::kOutputs;
}

void RtdeClient::take_outputs(std::string_view payload) {
  ByteReader reader(payload);
  if (version_ > 1) outputs_.id = reader.u8().value_or(0);
  const std::vector<std::string> types = split(reader.rest());
  if (types.size() != outputs_.fields.size()) return fail("answers the list of RTDE outputs with another length");
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const Field& field = kFields[outputs_.fields[i]];
    const std::string name(field.name);
    if (types[i] == field.type) {
      found.push_back(outputs_.fields[i]);
    } else if (types[i] != kNotFound) {
      return fail("gives the RTDE output " + name + " as " + readable(types[i]) + ", not as " +
                  std::string(field.type));
    } else if (field.required) {
      return fail("does not have the RTDE output " + name + ": update its software");
    }
  }
  const bool complete = found.size() == outputs_.fields.size();
  outputs_.fields = std::move(found);
  if (!complete) return ask_outputs();
  ask_inputs_or_start();
}

void RtdeClient::ask_inputs_or_start() {
  const bool writes = setup_.speed_slider.has_value() && step_ == Step::kOutputs;
  connection_.send(writes ? package(PackageType::kInputs, kInputs) : package(PackageType::kStart, {}));
  step_ = writes ? Step::kInputs : Step::kStart;
}

void RtdeClient::take_inputs(std::string_view payload) {
  ByteReader reader(payload);
  const std::uint8_t recipe = version_ > 1 ? reader.u8().value_or(0) : 0;
  const std::vector<std::string> types = split(reader.rest());
  const auto has = [&](std::string_view word) { return std::find(types.begin(), types.end(), word) != types.end(); };
  if (has(kInUse)) {
    return fail("has a speed slider that another program sets (IN_USE): end that program, or remove speed_slider");
  }
  if (has(kNotFound) || types.size() != 2) return fail("has no speed slider on RTDE: remove speed_slider");
  write_speed_slider(recipe);
  ask_inputs_or_start();
}

void RtdeClient::write_speed_slider(std::uint8_t recipe) {
  std::string payload;
  if (version_ > 1) put_u8(payload, recipe);
  put_u32(payload, 1);  // mask: the fraction counts
  put_f64(payload, *setup_.speed_slider);
  connection_.send(package(PackageType::kData, payload));
}

void RtdeClient::take_start(std::string_view payload) {
  if (ByteReader(payload).u8().value_or(0) == 0) return fail("refuses to send data on RTDE");
  step_ = Step::kData;
}

void RtdeClient::take_data(std::string_view payload, Clock::time_point now) {
  ByteReader reader(payload);
  if (version_ > 1 && reader.u8() != outputs_.id) return;
  RobotData data;
  const bool complete = std::all_of(outputs_.fields.begin(), outputs_.fields.end(),
                                    [&](std::size_t field) { return kFields[field].read(reader, data); });
  if (!complete || !reader.rest().empty()) return fail("sends RTDE data of another length than agreed");
  if (!is_finite(data)) return fail("sends RTDE data that are not finite");
  if (std::abs(data.timestamp) > kLongestUptime) return fail("sends RTDE data whose timestamp is beyond 1e9 s");
  measured_at_ = now - std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double>(offset_.age(now, data.timestamp)));
  data_ = data;
  deadline_ = now + kSilence;
}

}  // namespace hecaton::device::universal_robots
