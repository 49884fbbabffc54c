#include "services/ros2_messages/schema.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

namespace hecaton::ros2 {
namespace {

constexpr std::string_view kLine =
    "================================================================================";  // 80 characters
constexpr std::string_view kDummy = "structure_needs_at_least_one_member";               // of an empty message

constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kBasic{{{"boolean", "bool"},
                                                                                {"octet", "byte"},
                                                                                {"int8", "int8"},
                                                                                {"uint8", "uint8"},
                                                                                {"short", "int16"},
                                                                                {"unsigned short", "uint16"},
                                                                                {"long", "int32"},
                                                                                {"unsigned long", "uint32"},
                                                                                {"long long", "int64"},
                                                                                {"unsigned long long", "uint64"},
                                                                                {"float", "float32"},
                                                                                {"double", "float64"},
                                                                                {"string", "string"},
                                                                                {"char", "char"}}};

struct Type {
  std::string fields;               ///< lines of the definition
  std::vector<std::string> nested;  ///< types of fields
};
using Types = std::map<std::string, Type, std::less<>>;

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin);
}

/// "std_msgs::msg::Header" → "std_msgs/msg/Header"
std::string slashes(std::string_view name) {
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (name[i] != ':') {
      out += name[i];
    } else if (i > 0 && name[i - 1] == ':') {
      out += '/';
    }
  }
  return out;
}

/// The notation of a type that is no sequence; adds it to `type.nested` when it is a message.
std::string element(std::string_view idl, Type& type) {
  for (const auto& [theirs, ours] : kBasic) {
    if (idl == theirs) return std::string(ours);
  }
  type.nested.push_back(slashes(idl));
  // In a .msg file "msg" is left out.
  std::string name = type.nested.back();
  if (const std::size_t at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
  return name;
}

/// "sequence<double, 3> dimensions" → "float64[<=3] dimensions"
void add_field(std::string_view idl, Type& type) {
  const std::size_t space = idl.find_last_of(" \t\n");
  std::string_view name = idl.substr(space + 1);
  std::string_view of = trimmed(idl.substr(0, space));
  std::string count;
  if (const std::size_t bracket = name.find('['); bracket != std::string_view::npos) {
    count = std::string(name.substr(bracket));
    name = name.substr(0, bracket);
  }
  if (name == kDummy) return;
  if (name.front() == '_') name.remove_prefix(1);  // an escaped keyword of IDL
  constexpr std::string_view kSequence = "sequence<";
  if (of.starts_with(kSequence)) {
    of = of.substr(kSequence.size(), of.size() - kSequence.size() - 1);
    const std::size_t comma = of.find(',');
    count = comma == std::string_view::npos ? "[]" : "[<=" + std::string(trimmed(of.substr(comma + 1))) + "]";
    of = trimmed(of.substr(0, comma));
  }
  type.fields += element(of, type) + count + " " + std::string(name) + "\n";
}

std::string without_comments(std::string_view idl) {
  std::string out;
  while (!idl.empty()) {
    const std::string_view line = idl.substr(0, idl.find('\n'));
    out += line.substr(0, line.find("//"));
    out += '\n';
    idl.remove_prefix(std::min(idl.size(), line.size() + 1));
  }
  return out;
}

/// All structs of an IDL file of ours.
Types read(std::string_view idl) {
  const std::string text = without_comments(idl);
  Types types;
  std::vector<std::string> modules;
  constexpr std::string_view kModule = "module ";
  constexpr std::string_view kStruct = "struct ";
  for (std::size_t at = 0; at < text.size();) {
    const std::string_view left = std::string_view(text).substr(at);
    if (left.starts_with(kModule)) {
      const std::size_t brace = left.find('{');
      modules.emplace_back(trimmed(left.substr(kModule.size(), brace - kModule.size())));
      at += brace + 1;
    } else if (left.starts_with(kStruct)) {
      const std::size_t brace = left.find('{');
      const std::size_t end = left.find('}');
      std::string name;
      for (const std::string& module : modules) name += module + "/";
      Type& type = types[name + std::string(trimmed(left.substr(kStruct.size(), brace - kStruct.size())))];
      for (std::string_view body = left.substr(brace + 1, end - brace - 1); !trimmed(body).empty();) {
        const std::size_t semicolon = body.find(';');
        add_field(trimmed(body.substr(0, semicolon)), type);
        body.remove_prefix(semicolon + 1);
      }
      at += end + 1;
    } else {
      if (left.front() == '}') modules.pop_back();
      ++at;
    }
  }
  return types;
}

}  // namespace

std::string message_definition(std::string_view type) {
  static const Types kTypes = read(idl_text());
  const auto root = kTypes.find(type);
  if (root == kTypes.end()) throw std::invalid_argument("idl/ros2/ros2.idl has no type " + std::string(type));
  std::string text = root->second.fields;
  std::vector<std::string> needed = root->second.nested;
  for (std::size_t i = 0; i < needed.size(); ++i) {
    if (std::find(needed.begin(), needed.begin() + static_cast<std::ptrdiff_t>(i), needed[i]) !=
        needed.begin() + static_cast<std::ptrdiff_t>(i)) {
      continue;
    }
    const Type& nested = kTypes.at(needed[i]);
    std::string name = needed[i];
    if (const std::size_t at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
    text += std::string(kLine) + "\nMSG: " + name + "\n" + nested.fields;
    needed.insert(needed.end(), nested.nested.begin(), nested.nested.end());
  }
  return text;
}

}  // namespace hecaton::ros2
