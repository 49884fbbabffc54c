#pragma once
/// Where a program keeps the link pairs that it proved.

#include <filesystem>

namespace hecaton::config {

/// The folder `hecaton/link-pairs` of the user's caches: in XDG_CACHE_HOME, otherwise in .cache of HOME. Empty when the
/// environment has no absolute path in either.
[[nodiscard]] std::filesystem::path link_pair_folder();

/// Makes planner::load_arm_model() of this process use link_pair_folder(). For main(), before a robot is loaded.
void use_link_pair_folder();

}  // namespace hecaton::config
