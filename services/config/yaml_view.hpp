#pragma once
/// Typed access to a YAML tree that knows where it is: every rejection names file, key path, value and what is allowed.
/// All functions throw ConfigError.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/config/bounds.hpp"
#include "services/config/schema.hpp"
#include "services/config/yaml_tree.hpp"

namespace hecaton::config {

class MapView;

/// A file that is read.
struct YamlSource {
  std::string path;               ///< as messages name it
  planner::SourceFiles& sources;  ///< where the files that it names are read from
};

/// One value of the file. Refers to the tree and to the file, which must outlive it.
class YamlView {
 public:
  YamlView(const YamlNode& node, const YamlSource& file, std::string path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::string& file() const { return file_->path; }
  [[nodiscard]] planner::SourceFiles& sources() const { return file_->sources; }
  [[nodiscard]] bool is_sequence() const { return node_->kind == YamlNode::Kind::kSequence; }
  [[nodiscard]] bool is_map() const { return node_->kind == YamlNode::Kind::kMap; }
  /// No value, or an empty text; of lists and maps never.
  [[nodiscard]] bool is_empty() const { return !is_sequence() && !is_map() && node_->text.empty(); }
  /// The value on one line, shortened.
  [[nodiscard]] std::string value() const;

  /// "cell.yaml: arms[1].name = x must be a word"
  [[noreturn]] void fail(const std::string& must_be) const;
  /// "cell.yaml: arms[1].name: says"
  [[noreturn]] void fail_with(const std::string& says) const;

  [[nodiscard]] double number(const Bounds& bounds) const;
  /// Any number, also one that is not finite: whoever uses this judges it.
  [[nodiscard]] double number() const;
  [[nodiscard]] int integer(int low, int high) const;
  [[nodiscard]] bool boolean() const;
  /// A duration with its unit; bounds and result in seconds.
  [[nodiscard]] double seconds(const Bounds& bounds) const;
  [[nodiscard]] double seconds() const;  ///< any, as number()
  /// Any text that is not empty.
  [[nodiscard]] std::string text() const;
  /// 1 to 64 letters, digits, '_', '-' and '.': what goes into topics and messages.
  [[nodiscard]] std::string name() const;
  /// The index of the word among the choices.
  [[nodiscard]] std::size_t choice(std::span<const std::string_view> choices) const;

  /// The items of a list of `least` to `most`; `of` says of what, in the plural.
  [[nodiscard]] std::vector<YamlView> items(std::size_t least, std::size_t most, std::string_view of) const;
  /// A map whose keys all belong to the section.
  [[nodiscard]] MapView map(const Section& section) const;
  /// The value of a key of a map of a foreign format, whose other keys are none of our business.
  [[nodiscard]] std::optional<YamlView> entry(std::string_view key) const;
  /// The value at "motion.speed" or "shapes[0].size[1]" below this one; as far as the path leads.
  [[nodiscard]] YamlView at_path(std::string_view path) const;
  /// The index of the word at the key "type", which says what other keys this map may have.
  [[nodiscard]] std::size_t type(std::span<const std::string_view> choices) const;
  /// The entries of a map whose keys are names that its author chose (checked as by name()).
  [[nodiscard]] std::vector<std::pair<std::string, YamlView>> named_items(std::size_t most) const;

 private:
  friend class MapView;
  [[nodiscard]] const std::string& scalar(const std::string& must_be) const;
  [[nodiscard]] double parsed_number(const std::string& must_be) const;

  const YamlNode* node_;
  const YamlSource* file_;
  std::string path_;
};

class MapView {
 public:
  /// Throws ConfigError for a key that the section does not have.
  MapView(const YamlView& view, const Section& section);

  [[nodiscard]] const YamlView& view() const { return view_; }
  [[nodiscard]] std::optional<YamlView> find(std::string_view key) const;
  /// A missing key is an error.
  [[nodiscard]] YamlView at(std::string_view key) const;
  /// "cell.yaml: timing.driver_period = 10ms must be …", for a value that may come from a default.
  [[noreturn]] void fail(std::string_view key, const std::string& value, const std::string& must_be) const;
  /// "cell.yaml: arms[0].host is missing, but must be …"
  [[noreturn]] void fail_missing(std::string_view key, const std::string& must_be) const;

 private:
  YamlView view_;
  const Section* section_;
};

}  // namespace hecaton::config
