#include "services/ros2/node_graph.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "services/ros2_messages/cdr.hpp"

namespace hecaton::ros2 {
namespace {

/// rmw_dds_common/msg/Gid: a GUID and zeros.
template <std::size_t Size>
struct Gid {
  std::array<std::uint8_t, Size> data{};
  static void fields(auto& self, auto& visit) { visit(self.data); }
};

template <std::size_t Size>
struct NodeEntities {
  std::string node_namespace;
  std::string node_name;
  std::vector<Gid<Size>> readers;
  std::vector<Gid<Size>> writers;
  static void fields(auto& self, auto& visit) {
    visit(self.node_namespace, self.node_name, self.readers, self.writers);
  }
};

template <std::size_t Size>
struct ParticipantEntities {
  Gid<Size> gid;
  std::vector<NodeEntities<Size>> nodes;
  static void fields(auto& self, auto& visit) { visit(self.gid, self.nodes); }
};

template <std::size_t Size>
Gid<Size> gid_of(const bus::EndpointId& id) {
  Gid<Size> gid;
  std::copy(id.bytes.begin(), id.bytes.end(), gid.data.begin());
  return gid;
}

/// The participant of an endpoint: its own entity has a number that RTPS fixes (2.2, section 9.3.1.2).
bus::EndpointId participant_of(bus::EndpointId endpoint) {
  constexpr std::array<std::uint8_t, 4> kParticipant{0, 0, 1, 0xC1};
  std::copy(kParticipant.begin(), kParticipant.end(), endpoint.bytes.begin() + 12);
  return endpoint;
}

template <std::size_t Size>
Bytes announcement_of(const NodeGraph::Node& node, const NodeEndpoints& endpoints) {
  ParticipantEntities<Size> message;
  message.gid = gid_of<Size>(participant_of(endpoints.writers.front()));
  NodeEntities<Size>& entities = message.nodes.emplace_back();
  entities.node_namespace = node.ns;
  entities.node_name = node.name;
  for (const auto& id : endpoints.readers) entities.readers.push_back(gid_of<Size>(id));
  for (const auto& id : endpoints.writers) entities.writers.push_back(gid_of<Size>(id));
  return encoded(message);
}

bus::ros2::Topic discovery_topic() {
  bus::ros2::Topic topic;
  topic.name = "ros_discovery_info";
  topic.type = "rmw_dds_common/msg/ParticipantEntitiesInfo";
  topic.transient_local = true;
  topic.depth = 1;
  topic.plain = true;
  return topic;
}

bus::ros2::Topic others_topic() {
  bus::ros2::Topic topic = discovery_topic();
  topic.depth = 64;  // one sample of each participant
  return topic;
}

}  // namespace

NodeGraph::NodeGraph(bus::Participant& participant, config::Ros2Distribution distribution, Node node,
                     NodeEndpoints endpoints, bus::Mailbox& mailbox)
    : participant_(participant),
      distribution_(distribution),
      node_(std::move(node)),
      endpoints_(std::move(endpoints)),
      others_(participant, others_topic(), mailbox),
      begin_(Clock::now()) {}

void NodeGraph::update(Clock::time_point now) {
  for (const bus::ros2::Sample& sample : others_.take()) {
    if (!conflicting_ && is_of_other(distribution_, sample.bytes)) {
      conflicting_ = true;
      announced_ = false;
      writer_.reset();  // late joiners must not get its sample
    }
  }
  if (conflicting_ || announced_ || now < begin_ + kLook) return;
  writer_.emplace(participant_, discovery_topic());
  writer_->write(announcement(distribution_, node_, endpoints_));
  announced_ = true;
}

Bytes announcement(config::Ros2Distribution distribution, const NodeGraph::Node& node, const NodeEndpoints& endpoints) {
  return distribution == config::Ros2Distribution::kHumble ? announcement_of<24>(node, endpoints)
                                                           : announcement_of<16>(node, endpoints);
}

bool is_of_other(config::Ros2Distribution distribution, const Bytes& bytes) {
  const bool humble = decoded<ParticipantEntities<24>>(bytes).has_value();
  const bool later = decoded<ParticipantEntities<16>>(bytes).has_value();
  return distribution == config::Ros2Distribution::kHumble ? later && !humble : humble && !later;
}

}  // namespace hecaton::ros2
