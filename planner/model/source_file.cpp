#include "planner/model/source_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

namespace hecaton::planner {
namespace {

namespace fs = std::filesystem;

fs::path full_path(const fs::path& file) {
  std::error_code ignored;
  return fs::absolute(file, ignored).lexically_normal();
}

fs::path copy_in(const fs::path& snapshot, const fs::path& file) {
  return snapshot / full_path(file).relative_path();
}

}  // namespace

fs::path SourceFiles::place(const fs::path& file) const {
  return snapshot_.empty() ? file : copy_in(snapshot_, file);
}

fs::path SourceFiles::open(const fs::path& file) {
  read_.insert(full_path(file).string());
  return place(file);
}

void SourceFiles::keep_as(const fs::path& file, std::string text) {
  texts_[full_path(file).string()] = std::move(text);
}

void SourceFiles::keep(const fs::path& folder) const {
  for (const std::string& file : read_) {
    const fs::path copy = copy_in(folder, file);
    fs::create_directories(copy.parent_path());
    fs::copy_file(place(file), copy, fs::copy_options::overwrite_existing);
  }
  for (const auto& [file, text] : texts_) {
    const fs::path copy = copy_in(folder, file);
    fs::create_directories(copy.parent_path());
    std::ofstream(copy, std::ios::binary | std::ios::trunc) << text;
  }
}

bool is_utf16(const std::string& bytes) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) return true;
  return bytes.size() >= 2 && (bytes[0] == '\0') != (bytes[1] == '\0');
}

bool is_lfs_pointer(std::string_view bytes) {
  return bytes.starts_with("version https://git-lfs.github.com/spec/");
}

std::size_t utf8_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = byte(i);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF5 ? 0 : first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC2 ? 2 : 0;
  if (length == 0 || i + length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xC0U) != 0x80) return 0;
  }
  // Overlong forms, surrogates, and characters above U+10FFFF.
  const unsigned char second = byte(i + 1);
  const bool bad = (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
                   (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
  return bad ? 0 : length;
}

namespace {

bool is_utf8(const std::string& text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    if (length == 0) return false;
    i += length;
  }
  return true;
}

}  // namespace

std::string cut_utf8(const std::string& text, std::size_t most_bytes) {
  if (text.size() <= most_bytes) return text;
  std::size_t end = 0;
  while (end < text.size()) {
    const std::size_t next = end + std::max<std::size_t>(1, utf8_length(text, end));
    if (next > most_bytes) break;
    end = next;
  }
  return text.substr(0, end);
}

std::string utf8_text(std::string bytes) {
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.erase(0, 3);
  if (is_utf8(bytes)) return bytes;
  std::string text;
  text.reserve(bytes.size() + bytes.size() / 8);
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xC0U | (byte >> 6U));
      text += static_cast<char>(0x80U | (byte & 0x3FU));
    }
  }
  return text;
}

namespace {

bool is_file(const fs::path& path, const SourceFiles& sources) {
  std::error_code ignored;
  return fs::is_regular_file(sources.place(path), ignored);
}

/// The text with a byte for each %XX.
std::string percent_decoded(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned value = 0;
    const char* digits = text.data() + i + 1;
    const bool escaped = text[i] == '%' && i + 2 < text.size() &&
                         std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2 && value != 0;
    decoded += escaped ? static_cast<char>(value) : text[i];
    if (escaped) i += 2;
  }
  return decoded;
}

/// The name in the folder's package.xml; empty without one.
std::string package_name(const fs::path& folder, SourceFiles& sources) {
  const fs::path file = folder / "package.xml";
  if (!is_file(file, sources)) return {};
  std::ifstream stream(sources.open(file), std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  constexpr std::string_view kOpen = "<name>";
  const std::size_t open = text.find(kOpen);
  const std::size_t close = text.find("</name>", open);
  if (open == std::string::npos || close == std::string::npos) return {};
  std::istringstream words(text.substr(open + kOpen.size(), close - open - kOpen.size()));
  std::string name;
  words >> name;
  return name;
}

/// The folders of a list such as "/opt/a:/opt/b/", without slashes at their ends.
std::vector<fs::path> folders_of(const char* variable) {
  std::vector<fs::path> folders;
  const char* list = std::getenv(variable);
  if (list == nullptr) return folders;
  std::istringstream items(list);
  for (std::string item; std::getline(items, item, ':');) {
    if (item.empty()) continue;
    const fs::path folder(item);
    folders.push_back(folder.has_filename() ? folder : folder.parent_path());
  }
  return folders;
}

/// Finds the files that one URDF names.
class ResourceFinder {
 public:
  ResourceFinder(const std::string& urdf_path, const std::map<std::string, std::string>& packages, SourceFiles& sources)
      : packages_(packages), sources_(sources) {
    std::error_code ignored;
    for (const fs::path& path : {full_path(urdf_path), fs::weakly_canonical(full_path(urdf_path), ignored)}) {
      if (path.empty() || (!folders_.empty() && folders_.front() == path.parent_path())) continue;
      folders_.push_back(path.parent_path());
    }
    beside_ = fs::path(urdf_path).parent_path();
  }

  /// A path without scheme.
  [[nodiscard]] std::optional<fs::path> plain(const std::string& path) const {
    if (is_file(beside_ / path, sources_)) return beside_ / path;  // an absolute path replaces the folder
    for (const fs::path& folder : folders_) {
      if (is_file(folder / path, sources_)) return folder / path;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<fs::path> packaged(const std::string& package, const std::string& inside) {
    if (const auto entry = packages_.find(package); entry != packages_.end()) {
      const fs::path path = fs::path(entry->second) / inside;
      return is_file(path, sources_) ? std::optional(path) : std::nullopt;
    }
    for (const fs::path& start : folders_) {
      for (fs::path folder = start; !folder.empty(); folder = folder.parent_path()) {
        if (auto path = in_folder(folder, package, inside)) return path;
        if (folder == folder.parent_path()) break;
      }
    }
    for (const fs::path& prefix : folders_of("AMENT_PREFIX_PATH")) {
      fs::path path = prefix / "share" / package / inside;
      if (is_file(path, sources_)) return path;
    }
    for (const fs::path& folder : folders_of("ROS_PACKAGE_PATH")) {
      if (auto path = in_folder(folder, package, inside)) return path;
    }
    return std::nullopt;
  }

  /// A folder of the package; empty: no such package.
  [[nodiscard]] std::optional<fs::path> folder_of_package(const std::string& package) {
    if (const auto entry = packages_.find(package); entry != packages_.end()) return entry->second;
    std::error_code ignored;
    for (const fs::path& start : folders_) {
      for (fs::path folder = start; folder != folder.parent_path(); folder = folder.parent_path()) {
        if (folder.filename() == package || package_name(folder, sources_) == package) return folder;
        if (package_name(folder / package, sources_) == package) return folder / package;
      }
    }
    std::vector<fs::path> candidates;
    for (const fs::path& prefix : folders_of("AMENT_PREFIX_PATH")) candidates.push_back(prefix / "share" / package);
    for (const fs::path& folder : folders_of("ROS_PACKAGE_PATH")) {
      if (folder.filename() == package) candidates.push_back(folder);
      candidates.push_back(folder / package);
    }
    const auto found = std::find_if(candidates.begin(), candidates.end(),
                                    [&](const fs::path& folder) { return fs::is_directory(folder, ignored); });
    return found == candidates.end() ? std::nullopt : std::optional(*found);
  }

 private:
  /// The file `inside` of a package whose folder is `folder` itself or a child of it.
  [[nodiscard]] std::optional<fs::path> in_folder(const fs::path& folder, const std::string& package,
                                                  const std::string& inside) {
    if (is_file(folder / inside, sources_)) {
      if (folder.filename() == package || package_name(folder, sources_) == package) return folder / inside;
    }
    if (is_file(folder / package / inside, sources_)) return folder / package / inside;
    return std::nullopt;
  }

  const std::map<std::string, std::string>& packages_;
  SourceFiles& sources_;
  fs::path beside_;                ///< the URDF's folder as given
  std::vector<fs::path> folders_;  ///< the URDF's, and that of the file behind a link
};

/// "package://P/x" as P and x.
struct PackageFile {
  std::string package;
  std::string inside;
};

std::optional<PackageFile> package_file(const std::string& uri) {
  for (const std::string_view scheme : {"package://", "model://"}) {
    if (!uri.starts_with(scheme)) continue;
    const std::string rest = uri.substr(scheme.size());
    const std::size_t slash = rest.find('/');
    return PackageFile{rest.substr(0, slash), slash == std::string::npos ? "" : rest.substr(slash + 1)};
  }
  return std::nullopt;
}

/// The path of a file URI (file:///x, file://localhost/x, file:/x), or the text itself.
std::string path_of(const std::string& uri) {
  for (const std::string_view scheme : {"file://localhost/", "file:///"}) {
    if (uri.starts_with(scheme)) return "/" + uri.substr(scheme.size());
  }
  if (uri.starts_with("file:/") && !uri.starts_with("file://")) return uri.substr(std::string_view("file:").size());
  return uri;
}

std::optional<fs::path> find_resource(ResourceFinder& finder, const std::string& uri) {
  if (const auto file = package_file(uri)) return finder.packaged(file->package, file->inside);
  return finder.plain(path_of(uri));
}

[[noreturn]] void refuse_package(const std::string& uri, const PackageFile& file,
                                 const std::map<std::string, std::string>& packages, ResourceFinder& finder,
                                 const std::string& where, const std::string& remedy) {
  std::string how = remedy;
  if (const std::size_t name = how.find('@'); name != std::string::npos) how.replace(name, 1, file.package);
  if (!how.empty()) how = " (" + how + ")";
  const auto entry = packages.find(file.package);
  if (entry != packages.end()) {
    throw ModelError(where + ": '" + uri + "': package '" + file.package + "' is mapped to '" + entry->second +
                     "', where there is no file '" + file.inside + "'; map it to the folder that has this file" + how);
  }
  if (const auto folder = finder.folder_of_package(file.package)) {
    throw ModelError(where + ": '" + uri + "': package '" + file.package + "' is in '" + folder->string() +
                     "', where there is no file '" + file.inside +
                     "'; add it, or map the package to the folder that has this file" + how);
  }
  throw ModelError(where + ": '" + uri + "' is not found: map package '" + file.package + "' to its folder" + how +
                   ", or keep the URDF below a folder of that name, or set AMENT_PREFIX_PATH or ROS_PACKAGE_PATH");
}

}  // namespace

std::optional<fs::path> package_folder(const std::string& package, const std::string& urdf_path,
                                       const std::map<std::string, std::string>& packages, SourceFiles& sources) {
  return ResourceFinder(urdf_path, packages, sources).folder_of_package(package);
}

std::string resolve_resource(const std::string& uri, const std::string& urdf_path,
                             const std::map<std::string, std::string>& packages, const std::string& where,
                             SourceFiles& sources, const std::string& remedy) {
  const auto file = package_file(uri);
  if (file && (file->package.empty() || file->inside.empty())) {
    throw ModelError(where + ": '" + uri + "' must name a package and a file in it, as in package://robot/mesh.stl");
  }
  const std::string path = path_of(uri);
  if (path.starts_with("file:")) {
    throw ModelError(where + ": '" + uri + "' must be absolute, as in file:///folder/mesh.stl");
  }
  if (!file && path.find("://") != std::string::npos) {
    throw ModelError(where + ": '" + uri +
                     "' has an unknown scheme; package://, model://, file:// and plain paths are allowed");
  }
  ResourceFinder finder(urdf_path, packages, sources);
  std::string with_slashes = uri;
  std::replace(with_slashes.begin(), with_slashes.end(), '\\', '/');
  for (const std::string& spelling : {uri, percent_decoded(uri), with_slashes}) {
    if (const auto found = find_resource(finder, spelling)) return found->string();
  }
  if (file) refuse_package(uri, *package_file(percent_decoded(uri)), packages, finder, where, remedy);
  throw ModelError(where + ": mesh file '" + (fs::path(urdf_path).parent_path() / path).string() +
                   "' does not exist; copy it there, or correct the path in the URDF");
}

}  // namespace hecaton::planner
