#pragma once
/// Keeps in files what automatic_filter() finds, so that a machine proves the link pairs of a robot once.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "planner/model/collision_filter.hpp"
#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// From now on load_arm_model() of this process reads and writes files in `folder`. Empty, as at the start: it proves
/// anew each time. Not thread-safe: call it before models are loaded.
void keep_filter_results_in(std::filesystem::path folder);
[[nodiscard]] const std::filesystem::path& folder_of_filter_results();

/// A hash of the sources that the results depend on. The build makes it.
[[nodiscard]] std::string_view filter_code();

/// The bytes of all that automatic_filter() reads, with filter_code(). Empty when a shape is a cloud of points.
[[nodiscard]] std::string filter_inputs(const RobotModel& model, const FilterOptions& options);

/// The file of these inputs. Other inputs may have the same file; then the later ones replace the earlier ones.
[[nodiscard]] std::filesystem::path file_of_filter(const std::filesystem::path& folder, std::string_view inputs);

/// The model as automatic_filter() left it for the same inputs. Empty when the folder has no file of these inputs. A
/// file that is damaged, or that another user owns or may write, does not count.
[[nodiscard]] std::optional<RobotModel> kept_filter_result(const std::filesystem::path& folder, std::string_view inputs,
                                                           const RobotModel& before);

/// Writes the file as a whole or not at all, and removes the oldest files above 256. A failure has no consequence but
/// that the next process proves anew.
void keep_filter_result(const std::filesystem::path& folder, std::string_view inputs, const RobotModel& before,
                        const RobotModel& after);

}  // namespace hecaton::planner
