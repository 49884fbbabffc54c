#include "services/config/yaml_tree.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

constexpr std::uintmax_t kLargestFile = 4U << 20U;  // [bytes]
constexpr std::size_t kDeepest = 24;                // levels of maps and sequences
constexpr std::size_t kMostNodes = 200'000;         // after the expansion of aliases

std::size_t count_nodes(const YamlNode& node) {
  std::size_t count = 1;
  for (const YamlNode& item : node.items) count += count_nodes(item);
  return count;
}

std::size_t depth_of(const YamlNode& node) {
  std::size_t deepest = 0;
  for (const YamlNode& item : node.items) deepest = std::max(deepest, depth_of(item));
  return deepest + 1;
}

// Builds the tree from the parser's events. Unlike YAML::Load, this detects keys that appear twice.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(const std::string& path) : path_(path) {}

  YamlNode take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { add_leaf(mark, anchor, YamlNode{}); }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto anchored = anchors_.find(anchor);
    if (anchored == anchors_.end()) fail(mark, "an alias must not stand inside what it names");
    if (stack_.size() + depth_of(anchored->second) > kDeepest) fail_too_deep(mark);
    add_leaf(mark, 0, anchored->second);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode node;
    node.kind = YamlNode::Kind::kScalar;
    node.text = value;
    node.quoted = tag == "!";
    add_leaf(mark, anchor, std::move(node));
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor, YamlNode::Kind::kSequence);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark, anchor, YamlNode::Kind::kMap);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YamlNode node;
    YAML::anchor_t anchor;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& what) const {
    throw ConfigError(path_ + ": line " + std::to_string(mark.line + 1) + ": " + what);
  }
  [[noreturn]] void fail_too_deep(const YAML::Mark& mark) const {
    fail(mark, "maps and lists must not nest deeper than " + std::to_string(kDeepest) + " levels");
  }

  void count(const YAML::Mark& mark, std::size_t nodes) {
    nodes_ += nodes;
    if (nodes_ > kMostNodes) fail(mark, "the file must not hold more than " + std::to_string(kMostNodes) + " values");
  }

  bool expects_key() const {
    return !stack_.empty() && stack_.back().node.kind == YamlNode::Kind::kMap &&
           stack_.back().node.keys.size() == stack_.back().node.items.size();
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor, YamlNode::Kind kind) {
    if (expects_key()) fail(mark, "a key must be a plain word, not a map or a list");
    if (stack_.size() + 1 >= kDeepest) fail_too_deep(mark);
    Open& opened = stack_.emplace_back();
    opened.node.kind = kind;
    opened.anchor = anchor;
    count(mark, 1);
  }

  void close() {
    Open closed = std::move(stack_.back());
    stack_.pop_back();
    if (closed.anchor != 0) anchors_[closed.anchor] = closed.node;
    place(std::move(closed.node));
  }

  void add_leaf(const YAML::Mark& mark, YAML::anchor_t anchor, YamlNode node) {
    count(mark, count_nodes(node));
    if (anchor != 0) anchors_[anchor] = node;
    if (!expects_key()) {
      place(std::move(node));
      return;
    }
    if (node.kind != YamlNode::Kind::kScalar) fail(mark, "a key must be a plain word");
    auto& keys = stack_.back().node.keys;
    if (std::find(keys.begin(), keys.end(), node.text) != keys.end()) {
      fail(mark, "key '" + printable(node.text) + "' appears a second time in the same map, but must appear once");
    }
    keys.push_back(std::move(node.text));
  }

  void place(YamlNode node) {
    if (stack_.empty()) {
      root_ = std::move(node);
    } else {
      stack_.back().node.items.push_back(std::move(node));
    }
  }

  const std::string& path_;
  std::vector<Open> stack_;
  std::map<YAML::anchor_t, YamlNode> anchors_;
  std::size_t nodes_ = 0;
  YamlNode root_;
};

}  // namespace

YamlNode read_yaml_text(const std::string& text, const std::string& path) {
  TreeBuilder builder(path);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) throw ConfigError(path + ": is empty, but must hold one YAML map");
    YamlNode root = builder.take();
    TreeBuilder rest(path);
    if (parser.HandleNextDocument(rest)) {
      throw ConfigError(path + ": holds several YAML documents, but must hold one");
    }
    return root;
  } catch (const YAML::Exception& error) {
    throw ConfigError(path + ": line " + std::to_string(error.mark.line + 1) +
                      ": malformed YAML: " + printable(error.msg));
  }
}

YamlNode read_yaml_file(const std::string& path, planner::SourceFiles& sources) {
  std::error_code error;
  const std::filesystem::path place = sources.open(path);
  if (std::filesystem::is_directory(place, error)) {
    throw ConfigError(path + ": is a folder, but must be a YAML file");
  }
  std::ifstream file(place, std::ios::binary);
  if (!file) throw ConfigError(path + ": cannot be opened; it must be a readable YAML file");
  std::string text(kLargestFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestFile) {
    throw ConfigError(path + ": is larger than " + std::to_string(kLargestFile >> 20U) +
                      " MiB, the most a cell file may be");
  }
  // yaml-cpp reads UTF-16.
  return read_yaml_text(planner::is_utf16(text) ? text : planner::utf8_text(std::move(text)), path);
}

}  // namespace hecaton::config
