#pragma once
/// Typed access to a YAML tree that knows its key path: every rejection names file, key path, value and what is
/// allowed. All functions throw ConfigError.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "services/config/schema.hpp"
#include "services/config/text.hpp"
#include "services/config/yaml_tree.hpp"
#include "world/model/pose.hpp"

namespace hecaton::config {

class MapView;

/// The file of a tree.
struct YamlSource {
  std::string path;               ///< for messages
  planner::SourceFiles& sources;  ///< opens the files that it names
};

/// One value of the file. Refers to the tree and the source, which must outlive it.
class YamlView {
 public:
  YamlView(const YamlNode& node, const YamlSource& file, std::string path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::string& file() const { return file_->path; }
  [[nodiscard]] planner::SourceFiles& sources() const { return file_->sources; }
  [[nodiscard]] bool is_sequence() const { return node_->kind == YamlNode::Kind::kSequence; }
  [[nodiscard]] bool is_map() const { return node_->kind == YamlNode::Kind::kMap; }
  /// No value, or an empty text. False for lists and maps.
  [[nodiscard]] bool is_empty() const { return !is_sequence() && !is_map() && node_->text.empty(); }
  /// The value on one line, cut when long.
  [[nodiscard]] std::string value() const;

  /// "cell.yaml: arms[1].name = x must be a word"
  [[noreturn]] void fail(const std::string& must_be) const;
  /// "cell.yaml: arms[1].name: says"
  [[noreturn]] void fail_with(const std::string& says) const;

  [[nodiscard]] double number(const Bounds& bounds) const;
  /// Any number, also one that is not finite; the caller checks it.
  [[nodiscard]] double number() const;
  [[nodiscard]] int integer(int low, int high) const;
  [[nodiscard]] bool boolean() const;
  /// A duration with its unit; bounds and result in seconds.
  [[nodiscard]] double seconds(const Bounds& bounds) const;
  [[nodiscard]] double seconds() const;  ///< any, as number()
  /// A text that is not empty.
  [[nodiscard]] std::string text() const;
  /// A text that is_name() accepts.
  [[nodiscard]] std::string name() const;
  /// The index of the word among the choices.
  [[nodiscard]] std::size_t choice(std::span<const std::string_view> choices) const;

  /// The items of a list of `least` to `most` items; `of` names them in the plural for the message.
  [[nodiscard]] std::vector<YamlView> items(std::size_t least, std::size_t most, std::string_view of) const;
  /// A map whose keys all belong to the section.
  [[nodiscard]] MapView map(const Section& section) const;
  /// The value at a key of a map in another format than the cell file, without a check of other keys.
  [[nodiscard]] std::optional<YamlView> entry(std::string_view key) const;
  /// The value at a path such as "motion.speed" or "shapes[0].size[1]" below this one, or the last value on that path.
  [[nodiscard]] YamlView at_path(std::string_view path) const;
  /// The index of the word at the key "type", which determines the other keys of this map.
  [[nodiscard]] std::size_t type(std::span<const std::string_view> choices) const;
  /// The entries of a map whose keys are names that the user chose (checked as by name()).
  [[nodiscard]] std::vector<std::pair<std::string, YamlView>> named_items(std::size_t most) const;

 private:
  friend class MapView;
  [[nodiscard]] const std::string& scalar(const std::string& must_be) const;
  [[nodiscard]] double parsed_number(const std::string& must_be) const;
  [[nodiscard]] std::optional<YamlView> child(std::string_view key) const;  ///< of a map

  const YamlNode* node_;
  const YamlSource* file_;
  std::string path_;
};

/// A map of the file with the keys of a section.
class MapView {
 public:
  /// Throws for a key that the section does not have.
  MapView(const YamlView& view, const Section& section);

  [[nodiscard]] const YamlView& view() const { return view_; }
  [[nodiscard]] std::optional<YamlView> find(std::string_view key) const;
  /// A missing key is an error.
  [[nodiscard]] YamlView at(std::string_view key) const;
  /// "cell.yaml: timing.driver_period = 10ms must be …", for a value that may be a default.
  [[noreturn]] void fail(std::string_view key, const std::string& value, const std::string& must_be) const;
  /// "cell.yaml: arms[0].host is missing, but must be …"
  [[noreturn]] void fail_missing(std::string_view key, const std::string& must_be) const;

 private:
  YamlView view_;
  const Section* section_;
};

/// These readers keep `out` when the key is absent.
void read_number(const MapView& map, std::string_view key, double& out);  ///< any, as YamlView::number()
void read_number(const MapView& map, std::string_view key, const Bounds& bounds, double& out);
void read_seconds(const MapView& map, std::string_view key, const Bounds& bounds, double& out);
void read_boolean(const MapView& map, std::string_view key, bool& out);
/// `out`: a bool or an enumeration with the values 0, 1, … in the order of `words`.
template <class Choice>
void read_choice(const MapView& map, std::string_view key, std::span<const std::string_view> words, Choice& out) {
  if (const auto view = map.find(key)) out = static_cast<Choice>(view->choice(words));
}

[[nodiscard]] Eigen::Vector3d read_vector(const YamlView& view, const Bounds& bounds, std::string_view of);
/// Any three numbers, also ones that are not finite; the caller checks them.
[[nodiscard]] Eigen::Vector3d read_vector(const YamlView& view, std::string_view of);
/// Normalised; the zero vector is rejected.
[[nodiscard]] Eigen::Vector3d read_direction(const YamlView& view);
/// {xyz, rpy}, either may be missing.
[[nodiscard]] world::Pose read_pose(const YamlView& view);
/// Identity when the key is absent.
[[nodiscard]] world::Pose read_pose(const MapView& map, std::string_view key);

/// The path `relative` to the folder of the cell file; absolute paths stay.
[[nodiscard]] std::string beside(const std::string& cell_file, const std::string& relative);

}  // namespace hecaton::config
