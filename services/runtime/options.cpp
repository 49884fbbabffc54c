#include "services/runtime/options.hpp"

#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string_view>

#include <CLI/CLI.hpp>

#include "services/config/text.hpp"
#include "services/runtime/version.hpp"

namespace hecaton::services {
namespace {

const std::map<std::string, LogLevel> kLevels{{"debug", LogLevel::kDebug},
                                              {"info", LogLevel::kInfo},
                                              {"warning", LogLevel::kWarning},
                                              {"error", LogLevel::kError}};

constexpr int kHighestDescriptor = 1 << 20;

int parse_domain(const std::string& name, const std::string& text) {
  int domain = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), domain);
  if (error == std::errc{} && end == text.data() + text.size() && domain >= 0 && domain <= kHighestDomain) {
    return domain;
  }
  throw std::runtime_error(name + " = '" + config::printable(text) + "' must be a whole number from 0 to " +
                           std::to_string(kHighestDomain));
}

}  // namespace

void add_common_options(CLI::App& app, ServiceOptions& options) {
  const auto set_domain = [&options](const std::string& text) { options.domain = parse_domain("--domain", text); };
  app.add_option_function<std::string>("--domain", set_domain,
                                       "DDS domain; otherwise HECATON_DOMAIN, otherwise the cell file's");
  app.add_option("--host", options.host,
                 "the cell's host that the program runs on; otherwise where the cell file places it");
  app.add_option("--log-level", options.log_level, "lowest severity that is logged")
      ->transform(CLI::CheckedTransformer(kLevels, CLI::ignore_case).description("debug|info|warning|error"));
  app.add_option("--log-file", options.log_file, "file for the log instead of stderr");
}

void complain(const std::string& sentence) {
  const std::string_view name = program_invocation_short_name;
  std::cerr << name.substr(0, name.find(' ')) << ": " << config::sentence_text(sentence) << '\n';
}

std::optional<ExitCode> parse_or_explain(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error) == 0 ? ExitCode::kDone : ExitCode::kUsage;
    complain(std::string(error.what()) + "; see --help");
    return ExitCode::kUsage;
  } catch (const std::exception& error) {
    complain(error.what());
    return ExitCode::kBadInput;
  }
  return std::nullopt;
}

std::optional<ExitCode> parse_options(int argc, const char* const* argv, const std::string& description,
                                      Subject subject, ServiceOptions& options, const MoreOptions& more) {
  CLI::App app(description);
  app.set_version_flag("--version", std::string(kVersion));
  app.add_option("CELL", options.cell, "cell file (YAML)")->required();
  if (subject == Subject::kArm) {
    app.add_option("--arm", options.arm, "the arm of the cell that the service serves")->required();
  }
  app.add_option("--checkpoint", options.checkpoint, "file from which the service continues after a restart");
  app.add_option("--sources", options.sources,
                 "folder with copies of the cell file and what it names, read instead of the originals");
  app.add_option("--heartbeat-fd", options.heartbeat_fd, "socket on which the loop shows its agent that it runs")
      ->check(CLI::Range(0, kHighestDescriptor));
  app.add_option("--exit-fd", options.exit_fd, "pipe that closes when the process ends")
      ->check(CLI::Range(0, kHighestDescriptor));
  add_common_options(app, options);
  if (more) more(app);
  return parse_or_explain(app, argc, argv);
}

int choose_domain(const ServiceOptions& options, int of_cell) {
  if (options.domain) return *options.domain;
  const char* text = std::getenv("HECATON_DOMAIN");
  if (text == nullptr || *text == '\0') return of_cell;
  return parse_domain("environment: HECATON_DOMAIN", text);
}

}  // namespace hecaton::services
