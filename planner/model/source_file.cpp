#include "planner/model/source_file.hpp"

#include <mutex>

namespace hecaton::planner {
namespace {

namespace fs = std::filesystem;

struct Sources {
  std::mutex mutex;
  fs::path snapshot;
  std::set<std::string> read;
};

Sources& sources() {
  static Sources all;
  return all;
}

fs::path full_path(const fs::path& file) {
  std::error_code ignored;
  return fs::absolute(file, ignored).lexically_normal();
}

fs::path place(const fs::path& snapshot, const fs::path& file) {
  return snapshot.empty() ? file : snapshot / full_path(file).relative_path();
}

}  // namespace

void read_sources_from(const fs::path& snapshot) {
  const std::scoped_lock lock(sources().mutex);
  sources().snapshot = snapshot;
}

fs::path source_place(const fs::path& file) {
  const std::scoped_lock lock(sources().mutex);
  return place(sources().snapshot, file);
}

fs::path open_source(const fs::path& file) {
  const std::scoped_lock lock(sources().mutex);
  sources().read.insert(full_path(file).string());
  return place(sources().snapshot, file);
}

std::set<std::string> sources_read() {
  const std::scoped_lock lock(sources().mutex);
  return sources().read;
}

void keep_sources(const fs::path& snapshot) {
  for (const std::string& file : sources_read()) {
    const fs::path copy = place(snapshot, file);
    fs::create_directories(copy.parent_path());
    fs::copy_file(source_place(file), copy, fs::copy_options::overwrite_existing);
  }
}

}  // namespace hecaton::planner
