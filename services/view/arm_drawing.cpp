#include "services/view/arm_drawing.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <iterator>

#include "planner/model/xacro.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::view {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMeshes = "/meshes/";
constexpr std::array<std::string_view, 8> kTextures = {".png", ".jpg", ".jpeg", ".bmp", ".tga", ".gif", ".mtl", ".bin"};

std::string content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The URDF's text; empty when it cannot be read. A snapshot holds what xacro wrote.
std::string urdf_text(const config::RobotFiles& robot, const planner::SourceFiles& sources) {
  const fs::path place = sources.place(robot.urdf);
  std::string text = content_of(place);
  if (place != fs::path(robot.urdf) || text.find("<xacro:") == std::string::npos) return text;
  try {
    planner::SourceFiles read = sources;
    return planner::expand_xacro(robot.urdf, read, {robot.xacro_arguments, robot.packages, "", ""}).value_or("");
  } catch (const planner::ModelError&) {
    return {};
  }
}

/// `text` with the characters that XML escapes in an attribute.
std::string unescaped(std::string text) {
  constexpr std::array<std::pair<std::string_view, char>, 5> kEntities = {
      {{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}, {"&amp;", '&'}}};
  for (const auto& [entity, character] : kEntities) {
    for (std::size_t at = text.find(entity); at != std::string::npos; at = text.find(entity, at + 1)) {
      text.replace(at, entity.size(), 1, character);
    }
  }
  return text;
}

/// Calls `replace` with the value of each attribute `filename`, and writes what it returns.
template <class Replace>
std::string with_filenames(const std::string& text, const Replace& replace) {
  constexpr std::string_view kAttribute = "filename";
  std::string out;
  std::size_t done = 0;
  for (std::size_t at = text.find(kAttribute); at != std::string::npos; at = text.find(kAttribute, at + 1)) {
    const std::size_t equals = text.find_first_not_of(" \t\r\n", at + kAttribute.size());
    if (equals == std::string::npos || text[equals] != '=') continue;
    const std::size_t quote = text.find_first_not_of(" \t\r\n", equals + 1);
    if (quote == std::string::npos || (text[quote] != '"' && text[quote] != '\'')) continue;
    const std::size_t end = text.find(text[quote], quote + 1);
    if (end == std::string::npos) break;
    out += text.substr(done, quote + 1 - done) + replace(unescaped(text.substr(quote + 1, end - quote - 1)));
    done = end;
    at = end;
  }
  return out + text.substr(done);
}

/// A name for a URL: other characters than letters, digits, '.', '-' and '_' become '_'.
std::string url_name(std::string name) {
  const auto allowed = [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
           c == '_';
  };
  std::replace_if(
      name.begin(), name.end(), [&](char c) { return !allowed(static_cast<unsigned char>(c)); }, '_');
  return name;
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return text;
}

bool is_texture(const fs::path& file) {
  const std::string extension = lower_case(file.extension().string());
  return std::find(kTextures.begin(), kTextures.end(), extension) != kTextures.end();
}

/// Adds a mesh, and the textures in its folder whose names it has.
void add_files(const fs::path& mesh, std::vector<fs::path>& files) {
  if (std::find(files.begin(), files.end(), mesh) != files.end()) return;
  files.push_back(mesh);
  const std::string extension = lower_case(mesh.extension().string());
  if (extension == ".stl") return;  // it has none
  const std::string content = content_of(mesh);
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(mesh.parent_path(), none)) {
    const fs::path& file = entry.path();
    const bool named = is_texture(file) && content.find(file.filename().string()) != std::string::npos;
    if (named && std::find(files.begin(), files.end(), file) == files.end()) files.push_back(file);
  }
}

}  // namespace

Drawings::Drawings(const config::CellFile& file, const fs::path& recorded) : recorded_(recorded) {
  std::error_code none;
  if (!recorded.empty()) {
    for (const auto& entry : fs::recursive_directory_iterator(recorded, none)) {
      if (entry.is_regular_file(none)) recorded_files_.push_back(entry.path());
    }
  }
  for (std::size_t i = 0; i < file.robots.size(); ++i) {
    ArmDrawing drawing = draw(file.robots[i], file.sources);
    drawing.url = "/robots/" + std::to_string(i) + ".urdf";
    arms_.push_back(std::move(drawing));
  }
}

ArmDrawing Drawings::draw(const config::RobotFiles& robot, const planner::SourceFiles& sources) {
  ArmDrawing drawing;
  const std::string text = urdf_text(robot, sources);
  drawing.has_visuals = text.find("<visual") != std::string::npos;
  if (text.empty()) {
    drawing.note = config::printable_path(robot.urdf) + " cannot be read: the arm is drawn by its collision shapes";
  }
  if (!drawing.has_visuals) return drawing;
  bool found_some = false;
  drawing.urdf = with_filenames(text, [&](const std::string& uri) {
    try {
      const fs::path file = mesh_file(uri, robot);
      add_files(file, drawing.files);
      std::string url = mesh_url(file);
      if (uri.find("://") != std::string::npos) named_.try_emplace(uri, file);
      found_some = true;
      return url;
    } catch (const planner::ModelError& error) {
      if (drawing.note.empty()) drawing.note = error.what();
      return std::string();
    }
  });
  // Without any of its meshes the arm would be invisible. Of a recording, all of them are there or the shapes are
  // drawn.
  if (!drawing.note.empty() && (!found_some || !recorded_.empty())) drawing.has_visuals = false;
  return drawing;
}

fs::path Drawings::mesh_file(const std::string& uri, const config::RobotFiles& robot) const {
  if (!recorded_.empty()) {
    planner::SourceFiles recorded(recorded_);
    try {
      return recorded.place(planner::resolve_resource(uri, robot.urdf, robot.packages, robot.urdf, recorded));
    } catch (const planner::ModelError&) {
      // Its package may have been found by the environment of the machine that recorded it.
      const std::size_t scheme = uri.find("://");
      const std::string end = "/" + (scheme == std::string::npos ? uri : uri.substr(scheme + 3));
      const auto found = std::find_if(recorded_files_.begin(), recorded_files_.end(),
                                      [&](const fs::path& file) { return file.string().ends_with(end); });
      if (found != recorded_files_.end()) return *found;
    }
    // It may come from elsewhere, and name any file of this machine.
    throw planner::ModelError(config::printable_path(robot.urdf) + ": the recording has no mesh '" +
                              config::printable_path(uri) + "'");
  }
  // The snapshot of an agent has collision meshes only, so that meshes come from where they are.
  planner::SourceFiles in_place;
  return planner::resolve_resource(uri, robot.urdf, robot.packages, robot.urdf, in_place);
}

std::string Drawings::mesh_url(const fs::path& file) {
  auto known = std::find(meshes_.begin(), meshes_.end(), file);
  if (known == meshes_.end()) known = meshes_.insert(known, file);
  return std::string(kMeshes) + std::to_string(known - meshes_.begin()) + "/" + url_name(file.filename().string());
}

std::optional<fs::path> Drawings::mesh_named(std::string_view uri) const {
  const auto found = named_.find(uri);
  return found == named_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<fs::path> Drawings::mesh(std::string_view path) const {
  if (!path.starts_with(kMeshes)) return std::nullopt;
  path.remove_prefix(kMeshes.size());
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(path.data(), path.data() + path.size(), number);
  if (error != std::errc{} || number >= meshes_.size() || end == path.data() + path.size() || *end != '/') {
    return std::nullopt;
  }
  const std::string name(end + 1, path.data() + path.size());
  const fs::path& mesh = meshes_[number];
  if (name == url_name(mesh.filename().string())) return mesh;
  // A texture: below the folder of its mesh.
  const fs::path relative = fs::path(name).lexically_normal();
  if (relative.is_absolute() || relative.empty() || *relative.begin() == ".." || !is_texture(relative)) {
    return std::nullopt;
  }
  return mesh.parent_path() / relative;
}

}  // namespace hecaton::services::view
