#pragma once
/// The cell file of a recording and the robots that it names, from the files that are attached to it.

#include <memory>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/runtime/temporary_folder.hpp"
#include "services/view/arm_drawing.hpp"

namespace hecaton::services::replay {

struct RecordedFiles {
  std::shared_ptr<const TemporaryFolder> folder;  ///< of the copies: the drawings are read from it
  config::CellFile cell;
  view::Drawings drawings;  ///< only of files of the recording
  std::string note;         ///< which arms are drawn by their collision shapes, and why: a line; empty: none
};

/// Writes them into a temporary folder, and reads them there. A recording may come from elsewhere: no other file is
/// read, and no xacro is expanded. Sets HECATON_ROBOTS meanwhile, so that no other thread may run. Throws
/// recorder::RecordingError or config::ConfigError with a sentence: the recording has no cell file, another cell's than
/// the former paths, or one that this version of Hecaton refuses.
[[nodiscard]] RecordedFiles read_recorded_files(const std::vector<std::string>& paths);

}  // namespace hecaton::services::replay
