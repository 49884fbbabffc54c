#include "services/replay/recorded_files.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>

#include "services/config/text.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/recorder/recorder.hpp"

namespace hecaton::services::replay {
namespace {

namespace fs = std::filesystem;
using recorder::AttachedFile;
using recorder::RecordingError;

/// The files that are attached before the first message.
std::vector<AttachedFile> attachments_in(const std::string& path) {
  std::vector<AttachedFile> files;
  recorder::McapVisitor visitor;
  visitor.attachment = [&](const recorder::McapAttachment& file) {
    files.push_back({file.name, file.media_type, std::string(file.data.begin(), file.data.end())});
  };
  visitor.chunk = [](std::uint64_t) { return false; };
  recorder::read_mcap(path, visitor);
  return files;
}

/// The recorder attaches the cell file first.
const AttachedFile* cell_file_in(const std::vector<AttachedFile>& files) {
  return files.empty() || files.front().media_type != recorder::kYamlFile ? nullptr : &files.front();
}

/// Makes `folder` a snapshot of planner::SourceFiles.
void put(const std::vector<AttachedFile>& files, const fs::path& folder) {
  for (const AttachedFile& file : files) {
    // Names come from a recording: none may lead out of the folder.
    const fs::path name = fs::path(file.name).lexically_normal();
    if (!name.is_absolute() || !name.has_filename()) continue;
    const fs::path copy = folder / name.relative_path();
    std::error_code ignored;
    fs::create_directories(copy.parent_path(), ignored);
    std::ofstream stream(copy, std::ios::binary | std::ios::trunc);
    stream << file.text;
    stream.close();
    if (!stream) throw RecordingError(copy.string() + " cannot be written; name another place by TMPDIR");
  }
}

/// An environment variable with another value, for as long as the object lives.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value.c_str(), 1);
  }
  ~Variable() {
    if (before_) {
      setenv(name_, before_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

/// The folder of robots by name on the machine of the recorder; empty: the cell has none of them.
std::optional<std::string> robots_folder_in(const std::vector<AttachedFile>& files) {
  for (std::size_t i = 1; i < files.size(); ++i) {
    const fs::path folder = fs::path(files[i].name).parent_path();
    if (files[i].media_type == recorder::kYamlFile && folder.filename() == "robots") return folder.string();
  }
  return std::nullopt;
}

std::string note_of(const config::CellFile& file, const view::Drawings& drawings) {
  std::vector<std::string_view> arms;
  std::string reason;
  for (std::size_t i = 0; i < drawings.arms().size(); ++i) {
    const view::ArmDrawing& drawing = drawings.arms()[i];
    if (drawing.has_visuals || drawing.note.empty()) continue;
    if (arms.empty()) reason = drawing.note;
    arms.push_back(file.cell.arms[i].arm.name);
  }
  return arms.empty() ? "" : "drawn by collision shapes: " + config::listed(arms) + "; " + reason;
}

void require_same_cell(const std::string& first, const AttachedFile& expected, const std::string& path) {
  const std::vector<AttachedFile> files = attachments_in(path);
  const AttachedFile* cell = cell_file_in(files);
  if (cell != nullptr && cell->text == expected.text) return;
  throw RecordingError(path + " has another cell file than " + first + "; name the files of one recording");
}

}  // namespace

RecordedFiles read_recorded_files(const std::vector<std::string>& paths) {
  const std::vector<AttachedFile> files = attachments_in(paths.front());
  const AttachedFile* cell = cell_file_in(files);
  if (cell == nullptr) {
    throw RecordingError(paths.front() + " has no cell file attached; name a file that `hecaton record` has written");
  }
  for (std::size_t i = 1; i < paths.size(); ++i) require_same_cell(paths.front(), *cell, paths[i]);
  auto copies = std::make_shared<const TemporaryFolder>();
  put(files, copies->path());
  std::optional<Variable> robots;
  if (const auto folder = robots_folder_in(files)) robots.emplace("HECATON_ROBOTS", *folder);
  config::CellFile file = config::load_cell_file(cell->name, copies->path());
  view::Drawings drawings(file, copies->path());
  std::string note = note_of(file, drawings);
  return {std::move(copies), std::move(file), std::move(drawings), std::move(note)};
}

}  // namespace hecaton::services::replay
