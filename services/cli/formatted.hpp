#pragma once
/// printf into a string, for the lines of pictures.

#include <string>

namespace hecaton::services::cli {

/// At most 511 characters.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] std::string formatted(const char* format, ...);

}  // namespace hecaton::services::cli
