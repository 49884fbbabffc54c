#include "planner/model/collada_check.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

/// Walks through the elements once.
class ColladaCheck {
 public:
  ColladaCheck(const tinyxml2::XMLElement& root, std::string mesh) : mesh_(std::move(mesh)) {
    read(root, "");
    for (const auto& [node, unused] : inside_) require_end(node);
  }

 private:
  /// `node`: the nearest node with an identifier that has the element.
  void read(const tinyxml2::XMLElement& element, std::string node) {
    constexpr std::array<std::string_view, 4> kLists{"p", "h", "v", "vcount"};
    const std::string name = element.Name();
    const char* text = element.GetText();
    const bool is_list = std::find(kLists.begin(), kLists.end(), name) != kLists.end();
    if (is_list && text != nullptr &&
        std::string_view(text).find_first_not_of("0123456789-+ \t\r\n") != std::string::npos)
      throw ModelError(mesh_ + ": <" + name + "> must be a list of whole numbers");
    constexpr unsigned kMostValues = 1U << 26U;
    if (name.ends_with("_array") && element.UnsignedAttribute("count", kMostValues + 1) > kMostValues)
      throw ModelError(mesh_ + ": <" + name + "> must have the attribute 'count', the number of its values");
    const char* id = element.Attribute("id");
    if (name == "node" && id != nullptr) {
      inside_[node].insert(id);
      node = id;
    }
    const char* url = element.Attribute("url");
    if (name == "instance_node" && url != nullptr && *url == '#') inside_[node].insert(url + 1);
    for (const auto* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      read(*child, node);
    }
  }

  /// The node is in none of the nodes that it has inside.
  void require_end(const std::string& node) {
    if (ended_.contains(node)) return;
    if (!open_.insert(node).second)
      throw ModelError(mesh_ + ": node " + in_quotes(node) + " must not be inside itself");
    if (const auto found = inside_.find(node); found != inside_.end()) {
      for (const std::string& inner : found->second) require_end(inner);
    }
    open_.erase(node);
    ended_.insert(node);
  }

  std::string mesh_;
  std::map<std::string, std::set<std::string>> inside_;  ///< identifiers of nodes, by that of the node that has them
  std::set<std::string> open_;
  std::set<std::string> ended_;
};

}  // namespace

void check_collada(const tinyxml2::XMLElement& root, const std::string& mesh) {
  ColladaCheck(root, mesh);
}

}  // namespace hecaton::planner
