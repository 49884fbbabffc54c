#include "services/recorder/message_schema.hpp"

#include <string>

namespace hecaton::services::recorder {

std::string_view message_schema(std::string_view type) {
  const std::string definition = "struct " + std::string(type) + " {";
  std::string_view shortest;
  for (const std::string_view file : message_files()) {
    const bool defines = file.find(definition) != std::string_view::npos;
    if (defines && (shortest.empty() || file.size() < shortest.size())) shortest = file;
  }
  return shortest;
}

}  // namespace hecaton::services::recorder
