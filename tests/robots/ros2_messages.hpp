#pragma once
/// Nodes of ROS 2 on Cyclone DDS, for the simulated controllers: endpoints, and what messages are made of.

#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <dds/dds.h>

extern "C" {
#include "ros2_control.h"
}

namespace hecaton::test::ros2 {

using Values = std::vector<double>;
using Names = std::vector<std::string>;

inline dds_entity_t checked(dds_return_t result, const std::string& what) {
  if (result < 0) throw std::runtime_error(what + ": " + dds_strretcode(result));
  return result;
}

inline dds_sequence_double view(Values& values) {
  return {static_cast<std::uint32_t>(values.size()), static_cast<std::uint32_t>(values.size()), values.data(), false};
}
inline Values copy(const dds_sequence_double& values) {
  return {values._buffer, values._buffer + values._length};
}
inline Names copy(const dds_sequence_string& names) {
  return {names._buffer, names._buffer + names._length};
}
inline dds_sequence_string view(std::vector<char*>& names) {
  return {static_cast<std::uint32_t>(names.size()), static_cast<std::uint32_t>(names.size()), names.data(), false};
}
inline std::vector<char*> pointers(Names& names) {
  std::vector<char*> result;
  for (std::string& name : names) result.push_back(name.data());
  return result;
}
inline builtin_interfaces_msg_dds__Time_ time_now() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  return {static_cast<std::int32_t>(ns / 1'000'000'000), static_cast<std::uint32_t>(ns % 1'000'000'000)};
}
inline double seconds(const builtin_interfaces_msg_dds__Duration_& time) {
  return time.sec + 1e-9 * time.nanosec;
}

/// SystemDefaultsQoS: reliable, volatile, the last 10 samples.
class Node {
 public:
  explicit Node(int domain)
      : participant_(checked(dds_create_participant(static_cast<dds_domainid_t>(domain), nullptr, nullptr), "domain")) {
  }
  ~Node() { dds_delete(participant_); }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  dds_entity_t writer(const std::string& topic, const dds_topic_descriptor_t& type, bool latched = false) {
    return endpoint(topic, type, latched, [&](dds_entity_t of, const dds_qos_t* qos) {
      return dds_create_writer(participant_, of, qos, nullptr);
    });
  }
  dds_entity_t reader(const std::string& topic, const dds_topic_descriptor_t& type, bool latched = false) {
    return endpoint(topic, type, latched, [&](dds_entity_t of, const dds_qos_t* qos) {
      return dds_create_reader(participant_, of, qos, nullptr);
    });
  }

 private:
  template <class Create>
  dds_entity_t endpoint(const std::string& topic, const dds_topic_descriptor_t& type, bool latched, Create create) {
    const std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)> qos(dds_create_qos(), dds_delete_qos);
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos.get(), latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, latched ? 1 : 10);
    const std::string name = "rt" + topic;
    const dds_entity_t of = checked(dds_create_topic(participant_, &type, name.c_str(), nullptr, nullptr), name);
    return checked(create(of, qos.get()), name);
  }
  dds_entity_t participant_;
};

template <class T, class Visit>
void take_each(dds_entity_t reader, Visit visit) {
  constexpr std::uint32_t kMost = 20;
  void* samples[kMost] = {};
  dds_sample_info_t infos[kMost];
  const auto count = checked(dds_take(reader, samples, infos, kMost, kMost), "take");
  for (int i = 0; i < count; ++i) {
    if (infos[i].valid_data) visit(*static_cast<const T*>(samples[i]));
  }
  if (count > 0) checked(dds_return_loan(reader, samples, count), "loan");
}

}  // namespace hecaton::test::ros2
