#include "services/supervisor/memory.hpp"

#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace hecaton::services {
namespace {

std::optional<MoveMode> parse_mode(const std::string& name) {
  for (const MoveMode mode : {MoveMode::kRun, MoveMode::kHold, MoveMode::kStop}) {
    if (mode_name(mode) == name) return mode;
  }
  return std::nullopt;
}

bool parse_line(const std::string& line, Memory& memory) {
  std::istringstream words(line);
  std::string kind;
  words >> kind;
  if (kind == "term") return static_cast<bool>(words >> memory.term);
  std::string arm;
  std::string mode;
  if (kind == "arm") words >> arm;
  words >> mode;
  const auto parsed = parse_mode(mode);
  if (!parsed || (kind != "arm" && kind != "cell")) return false;
  (kind == "cell" ? memory.orders.cell : memory.orders.arms[arm]) = *parsed;
  return true;
}

}  // namespace

std::string memory_text(const Memory& memory) {
  std::ostringstream text;
  text << "term " << memory.term << "\ncell " << mode_name(memory.orders.cell) << '\n';
  for (const auto& [arm, mode] : memory.orders.arms) text << "arm " << arm << ' ' << mode_name(mode) << '\n';
  return text.str();
}

std::optional<Memory> parse_memory(const std::string& text) {
  Memory memory;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!parse_line(line, memory)) return std::nullopt;
  }
  if (memory.term == 0) return std::nullopt;
  return memory;
}

std::optional<Memory> read_memory(const std::string& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  auto memory = parse_memory(text.str());
  if (!memory) throw std::runtime_error("--memory " + path + " is not what a supervisor wrote: remove or repair it");
  return memory;
}

bool write_memory(const std::string& path, const Memory& memory) {
  const std::string next = path + ".next";
  {
    std::ofstream file(next, std::ios::trunc);
    file << memory_text(memory);
    if (!file.flush()) return false;
  }
  return std::rename(next.c_str(), path.c_str()) == 0;
}

}  // namespace hecaton::services
