#include "services/runtime/run_origin.hpp"

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "planner/model/fnv1a.hpp"
#include "services/runtime/version.hpp"

namespace hecaton::services {
namespace {

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
    text += "file " + std::to_string(bytes.size()) + ' ' + std::to_string(planner::fnv1a(bytes)) + ' ' + path + '\n';
  }
  return text;
}

}  // namespace hecaton::services
