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

/// The fields from here on are inputs and outputs, which are asked for only if the cell file names signals.
constexpr std::size_t kFirstIo = 8;

const std::array<Field, 16> kFields{{
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
    {"actual_digital_input_bits", "UINT64", false,
     [](ByteReader& from, RobotData& to) { return store(from.u64(), to.digital_inputs); }},
    {"actual_digital_output_bits", "UINT64", false,
     [](ByteReader& from, RobotData& to) { return store(from.u64(), to.digital_outputs); }},
    {"standard_analog_input0", "DOUBLE", false,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.analog_inputs[0]); }},
    {"standard_analog_input1", "DOUBLE", false,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.analog_inputs[1]); }},
    {"standard_analog_output0", "DOUBLE", false,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.analog_outputs[0]); }},
    {"standard_analog_output1", "DOUBLE", false,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.analog_outputs[1]); }},
    {"tool_analog_input0", "DOUBLE", false,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.tool_analog_inputs[0]); }},
    {"tool_analog_input1", "DOUBLE", false,
     [](ByteReader& from, RobotData& to) { return store(from.f64(), to.tool_analog_inputs[1]); }},
}};

/// An input of RTDE and its size on the wire.
struct Input {
  std::string_view name;
  enum class Type { kUint8, kUint32, kDouble } type;
};
constexpr std::array<Input, 12> kRobotInputs{{
    {"speed_slider_mask", Input::Type::kUint32},
    {"speed_slider_fraction", Input::Type::kDouble},
    {"standard_digital_output_mask", Input::Type::kUint8},
    {"standard_digital_output", Input::Type::kUint8},
    {"configurable_digital_output_mask", Input::Type::kUint8},
    {"configurable_digital_output", Input::Type::kUint8},
    {"tool_digital_output_mask", Input::Type::kUint8},
    {"tool_digital_output", Input::Type::kUint8},
    {"standard_analog_output_mask", Input::Type::kUint8},
    {"standard_analog_output_type", Input::Type::kUint8},
    {"standard_analog_output_0", Input::Type::kDouble},
    {"standard_analog_output_1", Input::Type::kDouble},
}};

/// Inputs with such names set the outputs of a bank; empty: the bank has no outputs.
std::string_view input_of(IoBank bank) {
  switch (bank) {
    case IoBank::kDigitalOutput:
      return "standard_digital_output";
    case IoBank::kConfigurableOutput:
      return "configurable_digital_output";
    case IoBank::kToolOutput:
      return "tool_digital_output";
    case IoBank::kAnalogOutput:
      return "standard_analog_output";
    default:
      return {};
  }
}

constexpr std::string_view kNotFound = "NOT_FOUND";
constexpr std::string_view kInUse = "IN_USE";

bool all_finite(const std::array<std::optional<double>, 2>& values) {
  return std::all_of(values.begin(), values.end(),
                     [](const auto& value) { return std::isfinite(value.value_or(0.0)); });
}

bool is_finite(const RobotData& data) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::all_of(data.q.begin(), data.q.end(), finite) && std::all_of(data.qd.begin(), data.qd.end(), finite) &&
         finite(data.timestamp) && finite(data.speed_scaling) && finite(data.target_speed_fraction) &&
         all_finite(data.analog_inputs) && all_finite(data.tool_analog_inputs) && all_finite(data.analog_outputs);
}

}  // namespace

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
  clock_ = services::SenderClock(kClockWindow);
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
    return fail(once ? "has closed the RTDE connection: " + connection_.error()
                     : "cannot be reached on port 30004: " + connection_.error() + "; " + advice());
  }
  if (now < deadline_) return;
  if (step_ == Step::kData) return fail("has sent no data for 500 ms: " + advice());
  fail(step_ == Step::kConnecting ? "does not answer on port 30004: " + advice()
                                  : "does not complete the RTDE handshake within 3 s: " + advice());
}

// A robot that has sent data has the right address.
std::string RtdeClient::advice() const {
  return has_worked_ ? "is its cable out, or is its controller off?" : "is it on, and is robot_ip right?";
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
  for (std::size_t i = 0; i < kFields.size(); ++i) {
    if (wants(i)) outputs_.fields.push_back(i);
  }
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

bool RtdeClient::wants(std::size_t field) const {
  return field < kFirstIo || !setup_.ports.empty();
}

/// The inputs that this client writes. A controller gives each to one client only.
std::vector<std::string> RtdeClient::inputs() const {
  std::vector<std::string> names;
  for (const Input& input : kRobotInputs) {
    const bool slider = setup_.speed_slider && input.name.starts_with("speed_slider");
    const bool of_port = std::any_of(setup_.ports.begin(), setup_.ports.end(), [&](const IoPort& port) {
      const std::string_view begin = input_of(port.bank);
      return !begin.empty() && input.name.starts_with(begin);
    });
    if (slider || of_port) names.emplace_back(input.name);
  }
  return names;
}

void RtdeClient::ask_inputs_or_start() {
  const std::vector<std::string> names = inputs();
  const bool writes = !names.empty() && step_ == Step::kOutputs;
  std::string payload;
  for (const std::string& name : names) payload += (payload.empty() ? "" : ",") + name;
  connection_.send(writes ? package(PackageType::kInputs, payload) : package(PackageType::kStart, {}));
  step_ = writes ? Step::kInputs : Step::kStart;
}

void RtdeClient::take_inputs(std::string_view payload) {
  ByteReader reader(payload);
  inputs_id_ = version_ > 1 ? reader.u8().value_or(0) : 0;
  const std::vector<std::string> types = split(reader.rest());
  const std::vector<std::string> names = inputs();
  const std::size_t count = std::min(types.size(), names.size());
  for (std::size_t i = 0; i < count; ++i) {
    const bool slider = names[i].starts_with("speed_slider");
    const std::string what = slider ? "a speed slider" : "the output " + names[i];
    const std::string remedy = slider ? "remove speed_slider" : "remove its signals";
    if (types[i] == kInUse) {
      // The robot of a cut connection keeps it, and its inputs, for some time.
      return fail("has " + what + " that another program sets (IN_USE): end that program, or " + remedy +
                  (has_worked_ ? "; after a cut the robot may keep the old connection for a minute" : ""));
    }
    if (types[i] == kNotFound) return fail("has no " + (slider ? "speed slider" : names[i]) + " on RTDE: " + remedy);
  }
  if (types.size() != names.size()) return fail("answers the list of RTDE inputs with another length");
  if (setup_.speed_slider) {
    write_inputs({{"speed_slider_mask", 1.0}, {"speed_slider_fraction", *setup_.speed_slider}});
  }
  ask_inputs_or_start();
}

// A mask of 0, as in all inputs without a value, leaves the robot's output as it is.
void RtdeClient::write_inputs(const std::map<std::string, double, std::less<>>& values) {
  std::string payload;
  if (version_ > 1) put_u8(payload, inputs_id_);
  for (const std::string& name : inputs()) {
    const auto found = values.find(name);
    const double value = found == values.end() ? 0.0 : found->second;
    const auto* input =
        std::find_if(kRobotInputs.begin(), kRobotInputs.end(), [&](const Input& one) { return one.name == name; });
    switch (input->type) {
      case Input::Type::kUint8:
        put_u8(payload, static_cast<std::uint8_t>(value));
        break;
      case Input::Type::kUint32:
        put_u32(payload, static_cast<std::uint32_t>(value));
        break;
      case Input::Type::kDouble:
        put_f64(payload, value);
        break;
    }
  }
  connection_.send(package(PackageType::kData, payload));
}

DeviceResult RtdeClient::set_output(const IoPort& port, double value) {
  const std::string name(input_of(port.bank));
  if (name.empty()) return DeviceFailure{"an input of its robot cannot be set"};
  if (step_ != Step::kData) return DeviceFailure{"its robot at " + setup_.address + " is not connected"};
  const double mask = 1 << port.pin;
  if (port.bank == IoBank::kAnalogOutput) {
    if (!(value >= 0.0 && value <= kMostVolts)) return DeviceFailure{"an analog output must be 0 to 10 V"};
    // The type has a bit for each output: 1 is a voltage. The value is a share of its range.
    write_inputs(
        {{name + "_mask", mask}, {name + "_type", mask}, {name + "_" + std::to_string(port.pin), value / kMostVolts}});
  } else {
    write_inputs({{name + "_mask", mask}, {name, value != 0.0 ? mask : 0.0}});
  }
  return {};
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
  const std::chrono::duration<double> stamp(data.timestamp);
  measured_at_ = clock_.sent(std::chrono::duration_cast<std::chrono::nanoseconds>(stamp).count(), now);
  data_ = data;
  has_worked_ = true;
  deadline_ = now + kSilence;
}

}  // namespace hecaton::device::universal_robots
