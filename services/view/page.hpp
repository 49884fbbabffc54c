#pragma once
/// The files of the page, packed into the program when it is built (page.cmake).

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "services/view/web_server.hpp"

namespace hecaton::services::view {

/// A file as page/build.mjs writes it into a source.
struct PackedFile {
  std::string_view path;  ///< on the server
  std::string_view type;  ///< MIME type
  std::span<const unsigned char> gzip;
};

/// All of them. Empty: the program was built without npm.
[[nodiscard]] std::span<const PackedFile> packed_files();

/// The file at a path of the server; "/" is the page itself. Without packed files the page is a sentence that says how
/// to get it. Empty: there is no such file.
[[nodiscard]] std::optional<WebFile> page_file(std::string_view path);

}  // namespace hecaton::services::view
