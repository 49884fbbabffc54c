#include "services/runtime/options.hpp"

#include <charconv>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string_view>

#include <CLI/CLI.hpp>

#include "services/runtime/version.hpp"

namespace hecaton::services {
namespace {

constexpr int kHighestDomain = 199;  // beyond, the ports of many participants leave the range of 16 bits

const std::map<std::string, LogLevel> kLevels{{"debug", LogLevel::kDebug},
                                              {"info", LogLevel::kInfo},
                                              {"warning", LogLevel::kWarning},
                                              {"error", LogLevel::kError}};

}  // namespace

void add_common_options(CLI::App& app, ServiceOptions& options) {
  app.add_option("--domain", options.domain, "DDS domain; otherwise HECATON_DOMAIN, otherwise the cell file's")
      ->check(CLI::Range(0, kHighestDomain));
  app.add_option("--host", options.host,
                 "name of the cell's host that this is; otherwise where the cell file places it");
  app.add_option("--log-level", options.log_level, "least severity that is logged")
      ->transform(CLI::CheckedTransformer(kLevels, CLI::ignore_case).description("debug|info|warning|error"));
  app.add_option("--log-file", options.log_file, "where the log goes instead of stderr");
}

std::optional<ExitCode> parse_options(int argc, const char* const* argv, const std::string& description,
                                      Subject subject, ServiceOptions& options) {
  CLI::App app(description);
  app.set_version_flag("--version", std::string(kVersion));
  app.add_option("CELL", options.cell, "cell file (YAML)")->required();
  if (subject == Subject::kArm) {
    app.add_option("--arm", options.arm, "the arm of the cell that it serves")->required();
  }
  add_common_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? ExitCode::kDone : ExitCode::kUsage;
  }
  return std::nullopt;
}

int choose_domain(const ServiceOptions& options, int of_cell) {
  if (options.domain) return *options.domain;
  const char* text = std::getenv("HECATON_DOMAIN");
  if (text == nullptr || *text == '\0') return of_cell;
  const std::string_view value(text);
  int domain = -1;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), domain);
  if (error != std::errc{} || end != value.data() + value.size() || domain < 0 || domain > kHighestDomain) {
    throw std::runtime_error("environment: HECATON_DOMAIN = " + std::string(value) + " must be a number from 0 to " +
                             std::to_string(kHighestDomain));
  }
  return domain;
}

}  // namespace hecaton::services
