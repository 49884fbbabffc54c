#pragma once
/// Runs a command line of a program inside the test process.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/command_line/program.hpp"

namespace hecaton::services::cli {

struct Ran {
  ExitCode code;
  std::string out;
  std::string err;
};

inline Ran run_line(const Program& program, std::vector<std::string> words) {
  words.insert(words.begin(), program.name);
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const ExitCode code = run_program(program, static_cast<int>(argv.size()), argv.data());
  std::fflush(stdout);
  return {code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

}  // namespace hecaton::services::cli
