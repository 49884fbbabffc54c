#include "services/tick_log/program.hpp"

#include <charconv>
#include <string_view>

#include "services/runtime/version.hpp"

namespace hecaton::services {

std::string program_text() {
  std::string text = std::string(kVersion) + " memory " + std::to_string(kPlannerMemory);
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") != 0) text += " avx2";
  if (__builtin_cpu_supports("fma") != 0) text += " fma";
  if (__builtin_cpu_supports("avx512f") != 0) text += " avx512f";
#endif
  return text;
}

int planner_memory_of(const std::string& program) {
  constexpr std::string_view kWord = " memory ";
  const std::size_t at = program.find(kWord);
  int layout = 1;
  if (at == std::string::npos) return layout;
  std::from_chars(program.data() + at + kWord.size(), program.data() + program.size(), layout);
  return layout;
}

}  // namespace hecaton::services
