#include "services/view/page.hpp"

#include <memory>
#include <string>

namespace hecaton::services::view {
namespace {

constexpr std::string_view kNoPage =
    "This hecaton-view was built without its page, because npm was not found. Install nodejs and npm, configure the "
    "build again, and build hecaton-view.\n";

}  // namespace

std::optional<WebFile> page_file(std::string_view path) {
  if (path == "/" && packed_files().empty()) {
    return WebFile{"text/plain; charset=utf-8", std::make_shared<const std::string>(kNoPage)};
  }
  const std::string_view wanted = path == "/" ? "/index.html" : path;
  for (const PackedFile& file : packed_files()) {
    if (file.path != wanted) continue;
    const auto content = std::make_shared<const std::string>(file.gzip.begin(), file.gzip.end());
    return WebFile{std::string(file.type), content, true};
  }
  return std::nullopt;
}

}  // namespace hecaton::services::view
