#include "planner/model/source_file.hpp"

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>

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

void SourceFiles::keep(const fs::path& folder) const {
  for (const std::string& file : read_) {
    const fs::path copy = copy_in(folder, file);
    fs::create_directories(copy.parent_path());
    fs::copy_file(place(file), copy, fs::copy_options::overwrite_existing);
  }
}

namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path, const SourceFiles& sources) {
  std::error_code ignored;
  return fs::is_regular_file(sources.place(path), ignored);
}

/// The file `inside` of a package whose folder is `folder` itself or a child of it.
std::optional<fs::path> in_package(const fs::path& folder, const std::string& package, const std::string& inside,
                                   const SourceFiles& sources) {
  if (folder.filename() == package && is_file(folder / inside, sources)) return folder / inside;
  if (is_file(folder / package / inside, sources)) return folder / package / inside;
  return std::nullopt;
}

std::string resolve_package(const std::string& uri, const std::string& urdf_path,
                            const std::map<std::string, std::string>& packages, const std::string& where,
                            const SourceFiles& sources) {
  const std::string rest = uri.substr(std::string("package://").size());
  const std::size_t slash = rest.find('/');
  const std::string package = rest.substr(0, slash);
  const std::string inside = slash == std::string::npos ? "" : rest.substr(slash + 1);
  if (package.empty() || inside.empty()) {
    throw ModelError(where + ": '" + uri + "' must name a package and a file in it, as in package://robot/mesh.stl");
  }
  if (const auto entry = packages.find(package); entry != packages.end()) {
    const fs::path path = fs::path(entry->second) / inside;
    if (is_file(path, sources)) return path.string();
    throw ModelError(where + ": '" + uri + "': package '" + package + "' is mapped to '" + entry->second +
                     "', where there is no file '" + inside + "'");
  }
  std::error_code ignored;
  const fs::path absolute = fs::weakly_canonical(urdf_path, ignored);
  for (fs::path folder = absolute.parent_path(); !folder.empty(); folder = folder.parent_path()) {
    if (const auto path = in_package(folder, package, inside, sources)) return path->string();
    if (folder == folder.parent_path()) break;
  }
  if (const char* search = std::getenv("ROS_PACKAGE_PATH")) {
    std::istringstream folders(search);
    for (std::string folder; std::getline(folders, folder, ':');) {
      const fs::path without_slash =
          fs::path(folder).has_filename() ? fs::path(folder) : fs::path(folder).parent_path();
      if (const auto path = in_package(without_slash, package, inside, sources)) return path->string();
    }
  }
  throw ModelError(where + ": '" + uri + "' is not found: map package '" + package +
                   "' to its folder, or keep the URDF below a folder of that name, or set ROS_PACKAGE_PATH");
}

}  // namespace

std::string resolve_resource(const std::string& uri, const std::string& urdf_path,
                             const std::map<std::string, std::string>& packages, const std::string& where,
                             const SourceFiles& sources) {
  if (uri.starts_with("package://")) return resolve_package(uri, urdf_path, packages, where, sources);
  fs::path path;
  if (uri.starts_with("file://")) {
    path = uri.substr(std::string("file://").size());
    if (!path.is_absolute())
      throw ModelError(where + ": '" + uri + "' must be absolute, as in file:///folder/mesh.stl");
  } else if (uri.find("://") != std::string::npos) {
    throw ModelError(where + ": '" + uri + "' has an unknown scheme; package://, file:// and plain paths are allowed");
  } else {
    path = fs::path(urdf_path).parent_path() / uri;  // an absolute uri replaces the folder
  }
  if (!is_file(path, sources)) throw ModelError(where + ": mesh file '" + path.string() + "' does not exist");
  return path.string();
}

}  // namespace hecaton::planner
