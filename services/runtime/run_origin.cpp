#include "services/runtime/run_origin.hpp"

#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>

#include "services/runtime/version.hpp"

namespace hecaton::services {
namespace {

/// FNV-1a.
std::uint64_t digest(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return hash;
}

std::string contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + " cannot be read any more");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string run_origin(const planner::SourceFiles& sources) {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  std::string text = "version " + std::string(kVersion) + "\nboot " + boot + '\n';
  for (const std::string& path : sources.read()) {
    const std::string bytes = contents(sources.place(path));
    text += "file " + std::to_string(bytes.size()) + ' ' + std::to_string(digest(bytes)) + ' ' + path + '\n';
  }
  return text;
}

}  // namespace hecaton::services
