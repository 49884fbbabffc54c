/// A program of another DDS vendor beside a cell: Cyclone DDS, with types that idlc makes from idl/. It shares no code
/// with Hecaton.
///
/// usage: cyclone_peer watch DOMAIN PARTITION FILE TOPIC,TYPE,DELIVERY,COUNT…
///        cyclone_peer goal DOMAIN PARTITION ARM Q…
///        cyclone_peer latency DOMAIN PARTITION ARM ROS_DOMAIN TOPIC COUNT
///
/// `watch` writes one JSON object a line into FILE for each sample: {topic, type, cdr, value}, with the bytes as they
/// came and as Cyclone DDS has decoded them, and the user data of its writer on stderr. It ends when each topic has
/// COUNT samples. DELIVERY is `latched`,
/// `reliable` or `best_effort`. PARTITION may be empty. `goal` sends the arm to joint positions and ends when it is
/// there. `latency` takes the time from a state of a moving arm to the joint states of ROS 2 with its positions.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <deque>
#include <fstream>
#include <map>
#include <mutex>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <unistd.h>

#include "tests/cell/interop/cyclone_json.hpp"

namespace {

using Clock = std::chrono::steady_clock;

/// Longest wait for anything; a busy machine may need it.
constexpr std::chrono::seconds kLong{100};

dds_entity_t checked(dds_return_t result, const std::string& what) {
  if (result < 0) throw std::runtime_error(what + ": " + dds_strretcode(result));
  return result;
}

template <class T>
Json decode(const dds_topic_descriptor_t& type, const ddsi_serdata& data) {
  T value;
  std::memset(&value, 0, sizeof value);
  if (!ddsi_serdata_to_sample(&data, &value, nullptr, nullptr)) throw std::runtime_error("a sample cannot be decoded");
  Json json = value;
  dds_sample_free(&value, &type, DDS_FREE_CONTENTS);
  return json;
}

/// A type, and how its samples become JSON.
struct Type {
  const dds_topic_descriptor_t* descriptor;
  Json (*decode)(const dds_topic_descriptor_t& type, const ddsi_serdata& data);
};
#define TYPE(name) \
  { &name##_desc, decode<name> }

const std::map<std::string, Type> kTypes{
    {"hecaton::msg::ArmState", TYPE(hecaton_msg_ArmState)},
    {"hecaton::msg::GoalStatus", TYPE(hecaton_msg_GoalStatus)},
    {"std_msgs::msg::String", TYPE(std_msgs_msg_String)},
    {"rosgraph_msgs::msg::Clock", TYPE(rosgraph_msgs_msg_Clock)},
    {"tf2_msgs::msg::TFMessage", TYPE(tf2_msgs_msg_TFMessage)},
    {"sensor_msgs::msg::JointState", TYPE(sensor_msgs_msg_JointState)},
    {"diagnostic_msgs::msg::DiagnosticArray", TYPE(diagnostic_msgs_msg_DiagnosticArray)},
    {"diagnostic_msgs::msg::DiagnosticStatus", TYPE(diagnostic_msgs_msg_DiagnosticStatus)},
    {"visualization_msgs::msg::MarkerArray", TYPE(visualization_msgs_msg_MarkerArray)},
    {"std_srvs::srv::Trigger_Response", TYPE(std_srvs_srv_Trigger_Response)},
    {"action_msgs::msg::GoalStatusArray", TYPE(action_msgs_msg_GoalStatusArray)},
    {"action_msgs::srv::CancelGoal_Response", TYPE(action_msgs_srv_CancelGoal_Response)},
    {"control_msgs::action::FollowJointTrajectory_SendGoal_Response",
     TYPE(control_msgs_action_FollowJointTrajectory_SendGoal_Response)},
    {"control_msgs::action::FollowJointTrajectory_GetResult_Response",
     TYPE(control_msgs_action_FollowJointTrajectory_GetResult_Response)},
    {"control_msgs::action::FollowJointTrajectory_FeedbackMessage",
     TYPE(control_msgs_action_FollowJointTrajectory_FeedbackMessage)},
    {"rmw_dds_common::msg::ParticipantEntitiesInfo", TYPE(rmw_dds_common_msg_ParticipantEntitiesInfo)},
    {"rmw_dds_common::humble::ParticipantEntitiesInfo", TYPE(rmw_dds_common_humble_ParticipantEntitiesInfo)}};

/// The name of a type on the wire: ROS 2 puts "dds_::" before it and "_" behind it.
std::string wire_name(const std::string& type) {
  if (type.starts_with("hecaton::")) return type;
  const auto last = type.rfind("::") + 2;
  return type.substr(0, last) + "dds_::" + type.substr(last) + "_";
}

class Peer {
 public:
  Peer(int domain, const std::string& partition)
      : participant_(
            checked(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr), "participant")) {
    dds_qos_t* qos = dds_create_qos();
    const std::string of_arms = partition + "/*";  // states and commands of each arm have a partition of their own
    std::array partitions{partition.c_str(), of_arms.c_str()};
    if (!partition.empty()) dds_qset_partition(qos, partitions.size(), partitions.data());
    publisher_ = checked(dds_create_publisher(participant_, qos, nullptr), "publisher");
    subscriber_ = checked(dds_create_subscriber(participant_, qos, nullptr), "subscriber");
    dds_delete_qos(qos);
    waiting_ = checked(dds_create_waitset(participant_), "waitset");
  }
  ~Peer() { dds_delete(participant_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  dds_entity_t reader(const std::string& topic, const std::string& type, const std::string& delivery) const {
    dds_topic_descriptor_t descriptor = *kTypes.at(type).descriptor;
    const std::string name = wire_name(type);
    descriptor.m_typename = name.c_str();
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, delivery == "best_effort" ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
                         DDS_SECS(1));
    dds_qset_durability(qos, delivery == "latched" ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1000);
    const dds_entity_t of =
        checked(dds_create_topic(participant_, &descriptor, topic.c_str(), nullptr, nullptr), topic);
    const dds_entity_t reader = checked(dds_create_reader(subscriber_, of, qos, nullptr), "reader of " + topic);
    dds_delete_qos(qos);
    checked(dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS), "status mask");
    checked(dds_waitset_attach(waiting_, reader, reader), "waitset");
    return reader;
  }
  dds_entity_t goal_writer() const {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    const dds_entity_t topic =
        checked(dds_create_topic(participant_, &hecaton_msg_Goal_desc, "hecaton/Goal", nullptr, nullptr), "topic");
    const dds_entity_t writer = checked(dds_create_writer(publisher_, topic, qos, nullptr), "writer of goals");
    dds_delete_qos(qos);
    return writer;
  }
  /// Returns when anything has arrived, or throws at `until`.
  void wait(Clock::time_point until) const {
    const auto left = std::chrono::nanoseconds(until - Clock::now()).count();
    if (left <= 0) throw std::runtime_error("the time limit has passed");
    checked(dds_waitset_wait(waiting_, nullptr, 0, left), "wait");
  }

 private:
  dds_entity_t participant_;
  dds_entity_t publisher_ = 0;
  dds_entity_t subscriber_ = 0;
  dds_entity_t waiting_ = 0;
};

/// The samples of a topic until enough have come.
struct Watch {
  std::string topic;
  std::string type;
  std::size_t wanted;
  dds_entity_t reader = 0;
  std::size_t seen = 0;

  void take(std::ostream& out) {
    constexpr std::size_t kMost = 100;
    ddsi_serdata* data[kMost] = {};
    dds_sample_info_t infos[kMost];
    const auto count = checked(dds_takecdr(reader, data, kMost, infos, DDS_ANY_STATE), topic);
    for (int i = 0; i < count; ++i) {
      if (infos[i].valid_data && seen == 0) tell_user_data(infos[i].publication_handle);
      if (infos[i].valid_data) write(*data[i], out);
      ddsi_serdata_unref(data[i]);
    }
  }

 private:
  /// ROS 2 puts the hash of the type there.
  void tell_user_data(dds_instance_handle_t writer) const {
    dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
    if (endpoint == nullptr) return;
    void* bytes = nullptr;
    std::size_t size = 0;
    if (dds_qget_userdata(endpoint->qos, &bytes, &size) && size > 0) {
      std::fprintf(stderr, "%s: user data %.*s\n", topic.c_str(), static_cast<int>(size), static_cast<char*>(bytes));
    }
    dds_free(bytes);
    dds_builtintopic_free_endpoint(endpoint);
  }
  void write(const ddsi_serdata& data, std::ostream& out) {
    std::vector<unsigned char> bytes(ddsi_serdata_size(&data));
    ddsi_serdata_to_ser(&data, 0, bytes.size(), bytes.data());
    std::string hex;
    for (const unsigned char byte : bytes) {
      constexpr const char* kDigits = "0123456789abcdef";
      hex.append({kDigits[byte >> 4U], kDigits[byte & 15U]});
    }
    const Type& of = kTypes.at(type);
    out << Json{{"topic", topic}, {"type", type}, {"cdr", hex}, {"value", of.decode(*of.descriptor, data)}} << '\n';
    constexpr std::size_t kTold = 100;
    if (++seen % kTold == 0) std::fprintf(stderr, "%s: %zu samples\n", topic.c_str(), seen);  // a test waits for a sign
  }
};

int watch(const Peer& peer, const std::string& path, std::span<const std::string> wanted) {
  std::ofstream out(path);
  std::vector<Watch> watches;
  for (const std::string& one : wanted) {
    std::istringstream parts(one);
    std::string topic;
    std::string type;
    std::string delivery;
    std::string count;
    std::getline(std::getline(std::getline(std::getline(parts, topic, ','), type, ','), delivery, ','), count);
    watches.push_back({topic, type, std::stoul(count), peer.reader(topic, type, delivery)});
  }
  std::size_t most = 0;
  for (const Watch& one : watches) most = std::max(most, one.wanted);
  const auto until = Clock::now() + kLong + std::chrono::milliseconds(100) * most;
  const auto complete = [](const Watch& one) { return one.seen >= one.wanted; };
  while (!std::all_of(watches.begin(), watches.end(), complete)) {
    for (const Watch& one : watches) {
      if (Clock::now() > until && !complete(one)) throw std::runtime_error(one.topic + ": the time limit has passed");
    }
    peer.wait(until + std::chrono::seconds(1));
    for (Watch& one : watches) one.take(out);
  }
  return 0;
}

/// Calls `visit` with each sample that has arrived.
template <class T, class Visit>
void take_each(dds_entity_t reader, Visit visit) {
  void* samples[100] = {};
  dds_sample_info_t infos[100];
  const auto count = checked(dds_take(reader, samples, infos, 100, 100), "take");
  for (int i = 0; i < count; ++i) {
    if (infos[i].valid_data) visit(*static_cast<const T*>(samples[i]));
  }
  if (count > 0) checked(dds_return_loan(reader, samples, count), "loan");
}

int send_goal(const Peer& peer, std::string arm, std::vector<double> q) {
  const auto until = Clock::now() + kLong;
  const dds_entity_t states = peer.reader("hecaton/ArmState", "hecaton::msg::ArmState", "best_effort");
  const dds_entity_t statuses = peer.reader("hecaton/GoalStatus", "hecaton::msg::GoalStatus", "latched");
  const dds_entity_t goals = peer.goal_writer();

  std::string id = "cyclone-" + std::to_string(getpid());
  std::string client = "cyclone_peer/" + std::to_string(getpid());
  std::string none;
  hecaton_msg_Goal goal{};  // a default of the IDL file is not in effect
  goal.schema = hecaton_msg_SCHEMA_VERSION;
  goal.arm = arm.data();
  goal.goal = id.data();
  goal.sequence_number = 1;
  goal.client = client.data();
  goal.kind = hecaton_msg_GOAL_JOINTS;
  goal.q._length = goal.q._maximum = static_cast<std::uint32_t>(q.size());
  goal.q._buffer = q.data();
  goal.named = none.data();
  goal.tool.X_WT.qw = 1.0;
  checked(dds_write(goals, &goal), "goal");

  std::vector<double> measured;
  bool reached = false;
  while (!reached || measured.empty()) {
    peer.wait(until);
    take_each<hecaton_msg_GoalStatus>(statuses, [&](const hecaton_msg_GoalStatus& status) {
      if (status.arm != arm || status.goal != id) return;
      std::fprintf(stderr, "goal %s: state %d: %s\n", status.goal, static_cast<int>(status.state), status.cause.text);
      if (status.state == hecaton_msg_GOAL_REJECTED) throw std::runtime_error("the planner has rejected the goal");
      if (status.state == hecaton_msg_GOAL_REACHED && !reached) measured.clear();  // a later state is wanted
      reached = reached || status.state == hecaton_msg_GOAL_REACHED;
    });
    take_each<hecaton_msg_ArmState>(states, [&](const hecaton_msg_ArmState& state) {
      if (state.arm == arm) measured.assign(state.q._buffer, state.q._buffer + state.q._length);
    });
  }
  std::printf("%s\n", Json{{"arm", arm}, {"q", measured}}.dump().c_str());
  return 0;
}

/// Arrivals of the states of one arm, and how much later its positions arrive as joint states of ROS 2.
struct Latency {
  struct State {
    std::vector<double> q;
    Clock::time_point arrived;
  };
  std::string arm;
  std::deque<State> states{};
  std::vector<double> before{};
  std::vector<double> measured{};  // [s]
  std::mutex mutex{};

  void note(const hecaton_msg_ArmState& state) {
    const auto now = Clock::now();
    if (state.arm != arm) return;
    const std::scoped_lock lock(mutex);
    std::vector<double> q(state.q._buffer, state.q._buffer + state.q._length);
    if (states.empty() || states.back().q != q) states.push_back({std::move(q), now});
    if (states.size() > 1000) states.pop_front();
  }
  void note(const sensor_msgs_msg_JointState& message) {
    const auto now = Clock::now();
    const std::string prefix = arm + "_";
    std::vector<double> q;
    for (std::uint32_t i = 0; i < message.name._length; ++i) {
      if (std::string(message.name._buffer[i]).starts_with(prefix)) q.push_back(message.position._buffer[i]);
    }
    const std::scoped_lock lock(mutex);
    if (q == before) return;  // the arm stands
    before = q;
    const auto state = std::find_if(states.rbegin(), states.rend(), [&](const State& one) { return one.q == q; });
    if (state != states.rend()) measured.push_back(std::chrono::duration<double>(now - state->arrived).count());
  }
};

template <class T>
void on_data(dds_entity_t reader, void* latency) {
  take_each<T>(reader, [&](const T& value) { static_cast<Latency*>(latency)->note(value); });
}

int measure_latency(const Peer& cell, const std::string& arm, std::span<const std::string> words) {
  const Peer ros(std::stoi(words[0]), "");
  const std::size_t wanted = std::stoul(words[2]);
  Latency latency{arm};
  std::vector<dds_entity_t> readers;
  const auto listen = [&](dds_entity_t reader, dds_on_data_available_fn call) {
    readers.push_back(reader);
    dds_listener_t* listener = dds_create_listener(&latency);
    dds_lset_data_available(listener, call);
    checked(dds_set_listener(reader, listener), "listener");
    dds_delete_listener(listener);
  };
  listen(cell.reader("hecaton/ArmState", "hecaton::msg::ArmState", "best_effort"), on_data<hecaton_msg_ArmState>);
  listen(ros.reader(words[1], "sensor_msgs::msg::JointState", "reliable"), on_data<sensor_msgs_msg_JointState>);
  const auto until = Clock::now() + kLong;
  std::vector<double> measured;
  while (measured.size() < wanted) {
    if (Clock::now() > until) throw std::runtime_error("the arm has moved too little within the time limit");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const std::scoped_lock lock(latency.mutex);
    measured = latency.measured;
  }
  for (const dds_entity_t reader : readers) checked(dds_set_listener(reader, nullptr), "listener");  // latency ends
  std::sort(measured.begin(), measured.end());
  const auto at = [&](double share) {
    return 1e3 * measured[static_cast<std::size_t>(share * static_cast<double>(measured.size() - 1))];
  };
  std::printf("%s\n", Json{{"samples", measured.size()}, {"p50_ms", at(0.5)}, {"p99_ms", at(0.99)}}.dump().c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() < 5)
      throw std::runtime_error("usage: cyclone_peer watch|goal|latency DOMAIN PARTITION FILE|ARM …");
    const Peer peer(std::stoi(words[1]), words[2]);
    const std::span<const std::string> rest(words.begin() + 4, words.end());
    if (words[0] == "watch") return watch(peer, words[3], rest);
    if (words[0] == "latency") return measure_latency(peer, words[3], rest);
    std::vector<double> q;
    for (const std::string& value : rest) q.push_back(std::stod(value));
    return send_goal(peer, words[3], q);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cyclone_peer: %s\n", error.what());
    return 1;
  }
}
