#include "services/config/link_pair_cache.hpp"

#include <cstdlib>

#include "planner/collision/filter_cache.hpp"

namespace hecaton::config {

std::filesystem::path link_pair_folder() {
  const auto absolute = [](const char* variable) {
    const char* value = std::getenv(variable);
    const std::filesystem::path path = value == nullptr ? "" : value;
    return path.is_absolute() ? path : std::filesystem::path();
  };
  std::filesystem::path caches = absolute("XDG_CACHE_HOME");
  if (caches.empty()) {
    const std::filesystem::path home = absolute("HOME");
    if (home.empty()) return {};
    caches = home / ".cache";
  }
  return caches / "hecaton" / "link-pairs";
}

void use_link_pair_folder() {
  planner::keep_filter_results_in(link_pair_folder());
}

}  // namespace hecaton::config
