#include "services/security/permissions.hpp"

#include <algorithm>
#include <ctime>
#include <vector>

#include "services/bus/topics.hpp"

namespace hecaton::services {
namespace {

using Time = std::chrono::system_clock::time_point;

/// The words of the table of topics that mean this role.
std::vector<std::string_view> words_of(Role role) {
  if (role == Role::kOperator) return {"all", "cli", "clients", "perception"};
  if (role == Role::kViewer) return {"all"};
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

std::string rule_xml(const std::string& element, const std::vector<std::string>& topics) {
  if (topics.empty()) return {};
  std::string text = "        <" + element + ">\n          <topics>\n";
  for (const std::string& topic : topics) text += "            <topic>" + topic + "</topic>\n";
  return text + "          </topics>\n          <partitions><partition>*</partition></partitions>\n        </" +
         element + ">\n";
}

}  // namespace

std::string_view role_name(Role role) {
  constexpr std::array<std::string_view, kRoles.size()> kNames{"agent",   "supervisor", "world", "driver",
                                                               "planner", "operator",   "viewer"};
  return kNames[static_cast<std::size_t>(role)];
}

std::string governance_xml() {
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";
}

std::string permissions_xml(Role role, const std::string& subject, Time from, Time until) {
  std::vector<std::string> publishes;
  std::vector<std::string> subscribes;
  const bool reads_all = role == Role::kOperator || role == Role::kViewer;
  for (const bus::TopicInfo& topic : bus::kTopics) {
    if (has_any(topic.writers, words_of(role))) publishes.emplace_back(topic.name);
    if (reads_all || has_any(topic.readers, words_of(role))) subscribes.emplace_back(topic.name);
  }
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <permissions>
    <grant name=")" +
         std::string(role_name(role)) + R"(">
      <subject_name>)" +
         subject + R"(</subject_name>
      <validity><not_before>)" +
         xml_time(from) + "</not_before><not_after>" + xml_time(until) + R"(</not_after></validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
)" + rule_xml("publish", publishes) +
         rule_xml("subscribe", subscribes) + R"(      </allow_rule>
      <default>DENY</default>
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

std::string xml_time(Time time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  return text;
}

}  // namespace hecaton::services
