#include "services/tick_log/program.hpp"

#include "services/runtime/version.hpp"

namespace hecaton::services {

std::string program_text() {
  std::string text(kVersion);
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0) text += " avx2";
  if (__builtin_cpu_supports("fma") != 0) text += " fma";
  if (__builtin_cpu_supports("avx512f") != 0) text += " avx512f";
#endif
  return text;
}

}  // namespace hecaton::services
