#include "planner/model/source_file.hpp"

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

}  // namespace hecaton::planner
