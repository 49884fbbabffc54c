#include "services/cli/formatted.hpp"

#include <cstdarg>
#include <cstdio>

namespace hecaton::services::cli {

std::string formatted(const char* format, ...) {
  char buffer[512];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

}  // namespace hecaton::services::cli
