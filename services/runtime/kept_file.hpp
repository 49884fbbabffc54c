#pragma once
/// Contents of a file that are replaced as a whole: a crash leaves either the old or the new ones. Two files take
/// turns, and their room is taken beforehand: a disk that is full by then changes nothing until the contents outgrow
/// it.

#include <string>

namespace hecaton::services {

/// `padding` fills up the room behind the contents. Empty, or the sentence that says why they cannot be kept, which
/// begins with the path; then what was kept there before still is.
[[nodiscard]] std::string keep_in_file(const std::string& path, std::string contents, char padding);

/// Where the other of the two files is.
[[nodiscard]] std::string other_file_of(const std::string& path);

}  // namespace hecaton::services
