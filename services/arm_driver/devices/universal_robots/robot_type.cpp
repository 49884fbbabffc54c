#include "services/arm_driver/devices/universal_robots/robot_type.hpp"

#include <algorithm>
#include <array>

namespace hecaton::device::universal_robots {
namespace {

enum class Series { kCb3, kLater };

struct RobotType {
  std::string_view name;
  std::string_view model;  ///< as its controller answers
  Series series;
};

/// Controllers of a UR7e and a UR12e answer as those of the arms that they are derived from.
constexpr std::array<RobotType, 14> kTypes{{
    {"ur3", "UR3", Series::kCb3},
    {"ur5", "UR5", Series::kCb3},
    {"ur10", "UR10", Series::kCb3},
    {"ur3e", "UR3", Series::kLater},
    {"ur5e", "UR5", Series::kLater},
    {"ur7e", "UR5", Series::kLater},
    {"ur8long", "UR8LONG", Series::kLater},
    {"ur10e", "UR10", Series::kLater},
    {"ur12e", "UR10", Series::kLater},
    {"ur15", "UR15", Series::kLater},
    {"ur16e", "UR16", Series::kLater},
    {"ur18", "UR18", Series::kLater},
    {"ur20", "UR20", Series::kLater},
    {"ur30", "UR30", Series::kLater},
}};
constexpr std::uint32_t kFirstLater = 5;  // major version of the controller

const RobotType* find_type(std::string_view name) {
  const auto* found = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& type) { return type.name == name; });
  return found == kTypes.end() ? nullptr : found;
}

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

/// Letters and digits of an answer such as "UR5e": "UR5".
std::string model_of(std::string_view answer) {
  std::string model;
  for (const char c : answer) {
    const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    if ((upper >= 'A' && upper <= 'Z') || (upper >= '0' && upper <= '9')) model += upper;
  }
  if (model.size() > 1 && model.back() == 'E') model.pop_back();
  return model;
}

}  // namespace

std::string robot_types() {
  std::string text;
  for (const RobotType& type : kTypes) {
    text += text.empty() ? "" : &type == &kTypes.back() ? " or " : ", ";
    text += type.name;
  }
  return text;
}

bool is_robot_type(std::string_view type) {
  return find_type(type) != nullptr;
}

std::optional<std::string> mentioned_type(const std::vector<std::string>& names) {
  std::optional<std::string> found;
  for (const std::string& name : names) {
    std::string word;
    for (std::size_t i = 0; i <= name.size(); ++i) {
      const char c = i == name.size() ? ' ' : name[i];
      const char lower = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      if (is_letter_or_digit(lower)) {
        word += lower;
        continue;
      }
      if (is_robot_type(word)) {
        if (found && *found != word) return std::nullopt;
        found = word;
      }
      word.clear();
    }
  }
  return found;
}

std::string FoundRobot::name() const {
  const std::string type = model_of(model);
  const bool later = major_version >= kFirstLater;
  if (type.empty())
    return major_version == 0 ? "" : later ? "robot of the e-Series or later" : "robot of the CB3 series";
  const bool has_two = std::any_of(kTypes.begin(), kTypes.end(), [&](const auto& one) {
    return one.model == type && one.series == Series::kLater && one.name.ends_with('e');
  });
  return later && has_two ? type + "e" : type;
}

bool FoundRobot::may_be(std::string_view expected) const {
  const RobotType* type = find_type(expected);
  if (type == nullptr) return true;
  const Series series = major_version >= kFirstLater ? Series::kLater : Series::kCb3;
  if (major_version != 0 && series != type->series) return false;
  const std::string found = model_of(model);
  return found.empty() || found == type->model;
}

}  // namespace hecaton::device::universal_robots
