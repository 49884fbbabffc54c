#include "services/security/permissions.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <set>

#include "services/bus/topics.hpp"

namespace hecaton::services {
namespace {

using Time = std::chrono::system_clock::time_point;

/// The words of the table of topics that mean this role.
std::vector<std::string_view> words_of(Role role) {
  if (role == Role::kOperator) return {"all", "cli", "clients", "perception"};
  if (role == Role::kViewer) return {"all", "recorder"};  // a recorder answers orders to save
  return {"all", role_name(role)};
}

/// `kinds`: of the table of topics, separated by spaces.
bool has_any(std::string_view kinds, const std::vector<std::string_view>& words) {
  while (!kinds.empty()) {
    const std::string_view one = kinds.substr(0, kinds.find(' '));
    if (std::find(words.begin(), words.end(), one) != words.end()) return true;
    kinds.remove_prefix(std::min(kinds.size(), one.size() + 1));
  }
  return false;
}

/// A partition of one arm in any cell: its name is CELL/ARM (Participant::Impl::partition_of).
constexpr std::string_view kArmPartition = "<partition>*/";

/// Names of topics.
struct Topics {
  std::vector<std::string> published;
  std::vector<std::string> subscribed;
};

/// "write hecaton/Fault", "read hecaton/Goal" of a document of permissions_xml().
std::set<std::string> allowed_in(const std::string& document) {
  constexpr std::string_view kTopic = "<topic>";
  std::set<std::string> allowed;
  for (std::size_t at = document.find(kTopic); at != std::string::npos; at = document.find(kTopic, at + 1)) {
    const std::size_t begin = at + kTopic.size();
    const std::size_t publish = document.rfind("<publish>", at);
    const std::size_t subscribe = document.rfind("<subscribe>", at);
    const bool writes = publish != std::string::npos && (subscribe == std::string::npos || publish > subscribe);
    allowed.insert((writes ? "write " : "read ") + document.substr(begin, document.find('<', begin) - begin));
  }
  return allowed;
}

std::string criteria_xml(const std::string& element, const std::vector<std::string>& topics,
                         const std::vector<std::string>& partitions) {
  if (topics.empty()) return {};
  std::string text = "        <" + element + ">\n          <topics>\n";
  for (const std::string& topic : topics) text += "            <topic>" + topic + "</topic>\n";
  text += "          </topics>\n          <partitions>";
  for (const std::string& partition : partitions) text += "<partition>" + partition + "</partition>";
  return text + "</partitions>\n        </" + element + ">\n";
}

/// Fast DDS takes a partition that any topic of a rule has as one of all its topics. So a rule has one set of them.
std::string rule_xml(const Topics& topics, const std::vector<std::string>& partitions) {
  if (topics.published.empty() && topics.subscribed.empty()) return {};
  return "      <allow_rule>\n        <domains><id_range><min>0</min><max>230</max></id_range></domains>\n" +
         criteria_xml("publish", topics.published, partitions) +
         criteria_xml("subscribe", topics.subscribed, partitions) + "      </allow_rule>\n";
}

/// Streams of states, which all but a few roles read. They are most of a cell's datagrams, and each further encryption
/// costs each of their readers as much again.
bool is_state(const bus::Qos& qos) {
  return !qos.reliable && !qos.partition_per_key;
}

/// Datagrams are encrypted with a key of their sender, which all participants have. `data`: the kind of protection of
/// samples, with a key of their writer, which its readers have.
std::string topic_rule_xml(std::string_view expression, std::string_view data) {
  std::string text = "        <topic_rule>\n          <topic_expression>";
  text.append(expression).append(R"(</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>NONE</metadata_protection_kind>
          <data_protection_kind>)");
  return text.append(data).append("</data_protection_kind>\n        </topic_rule>\n");
}

}  // namespace

std::string_view role_name(Role role) {
  constexpr std::array<std::string_view, kRoles.size()> kNames{"agent",   "supervisor", "world", "driver",
                                                               "planner", "operator",   "viewer"};
  return kNames[static_cast<std::size_t>(role)];
}

std::vector<Duty> all_duties(const std::vector<std::string>& arms) {
  std::vector<Duty> duties;
  for (const Role role : kRoles) {
    const bool of_arms = role == Role::kPlanner || role == Role::kDriver;
    duties.push_back({role, of_arms ? arms : std::vector<std::string>()});
  }
  return duties;
}

std::string governance_xml() {
  std::string text = R"(<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>ENCRYPT</rtps_protection_kind>
      <topic_access_rules>
)";
  for (const bus::TopicInfo& topic : bus::kTopics) {
    if (is_state(topic.qos)) text += topic_rule_xml(topic.name, "NONE");
  }
  return text + topic_rule_xml("*", "ENCRYPT") + R"(      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";
}

std::string permissions_xml(Role role, const std::string& subject, Time from, Time until,
                            const std::vector<std::string>& arms) {
  Topics topics;
  Topics of_arms;
  const bool reads_all = role == Role::kOperator || role == Role::kViewer;
  for (const bus::TopicInfo& topic : bus::kTopics) {
    const bool reads = reads_all || has_any(topic.readers, words_of(role));
    const bool own_arms_only = topic.qos.partition_per_key && !arms.empty() && !reads_all;
    if (has_any(topic.writers, words_of(role))) (own_arms_only ? of_arms : topics).published.emplace_back(topic.name);
    if (reads) {
      (own_arms_only && !topic.qos.other_arms_read ? of_arms : topics).subscribed.emplace_back(topic.name);
    }
  }
  std::vector<std::string> partitions;
  for (const std::string& arm : arms) partitions.push_back("*/" + arm);
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <permissions>
    <grant name=")" +
         std::string(role_name(role)) + R"(">
      <subject_name>)" +
         subject + R"(</subject_name>
      <validity><not_before>)" +
         xml_time(from) + "</not_before><not_after>" + xml_time(until) + "</not_after></validity>\n" +
         rule_xml(of_arms, partitions) + rule_xml(topics, {"*"}) + R"(      <default>DENY</default>
    </grant>
  </permissions>
</dds>
)";
}

std::optional<Time> permissions_expiry(const std::string& document) {
  constexpr std::string_view kElement = "<not_after>";
  std::optional<Time> first;
  for (std::size_t at = document.find(kElement); at != std::string::npos; at = document.find(kElement, at + 1)) {
    std::tm utc{};
    if (::strptime(document.c_str() + at + kElement.size(), " %Y-%m-%dT%H:%M:%S", &utc) == nullptr) continue;
    const Time time = std::chrono::system_clock::from_time_t(timegm(&utc));
    first = std::min(first.value_or(time), time);
  }
  return first;
}

std::vector<std::string> arms_in(const std::string& document) {
  std::set<std::string> arms;
  for (std::size_t at = document.find(kArmPartition); at != std::string::npos;
       at = document.find(kArmPartition, at + 1)) {
    const std::size_t begin = at + kArmPartition.size();
    arms.insert(document.substr(begin, document.find('<', begin) - begin));
  }
  return {arms.begin(), arms.end()};
}

std::vector<std::string> missing_permissions(Role role, const std::string& document) {
  const std::set<std::string> present = allowed_in(document);
  std::vector<std::string> missing;
  for (const std::string& one : allowed_in(permissions_xml(role, {}, {}, {}, arms_in(document)))) {
    if (!present.contains(one)) missing.push_back("may not " + one);
  }
  return missing;
}

std::string xml_time(Time time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  return text;
}

}  // namespace hecaton::services
