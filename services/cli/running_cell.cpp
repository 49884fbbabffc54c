#include "services/cli/running_cell.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "services/cli/cell_access.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"
#include "services/runtime/orders.hpp"
#include "services/runtime/run_folder.hpp"

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;

/// Nodes of a living cell are found within milliseconds; under load, within this.
constexpr auto kProbe = 800ms;
constexpr auto kAnswer = 500ms;

std::vector<std::string> agent_arguments(const config::CellFile& file, const RunningCell::Options& options) {
  return {file.path, "--anew", "--domain", std::to_string(options.domain), "--log-dir", options.log_folder};
}

}  // namespace

LogFolder::LogFolder(const std::string& wanted, const std::string& cell) : path_(wanted), temporary_(wanted.empty()) {
  std::error_code error;
  if (!temporary_) {
    std::filesystem::create_directories(path_, error);
    path_ = std::filesystem::absolute(path_);
    if (error) throw Failure(ExitCode::kBadInput, "log folder '" + path_ + "' cannot be made: " + error.message());
    return;
  }
  const char* chosen = std::getenv("TMPDIR");
  const std::filesystem::path parent = chosen == nullptr || *chosen == '\0' ? "/tmp" : chosen;
  std::string name = parent / ("hecaton-" + cell + "-XXXXXX");
  if (mkdtemp(name.data()) == nullptr) {
    throw Failure(ExitCode::kBadInput, "no folder for the logs can be made in " + parent.string() + ": " +
                                           std::strerror(errno) + "; TMPDIR or --log-dir may name another place");
  }
  path_ = name;
}

LogFolder::~LogFolder() {
  std::error_code ignored;
  if (discard_) std::filesystem::remove_all(path_, ignored);
}

void refuse_occupied_domain(int domain) {
  const auto probe = client::Connection::make(client::join({std::nullopt, domain}));
  bus::Reader<msg::Heartbeat> beats(probe->participant(), &probe->mailbox());
  if (!probe->wait_until([&] { return !beats.take().empty(); }, kProbe)) return;
  const auto status = probe->poll_status(kAnswer);
  const std::string name = status ? " '" + status->cell() + "'" : "";
  throw Failure(ExitCode::kBadInput, "another cell" + name + " is up in DDS domain " + std::to_string(domain) +
                                         "; end it first, or choose another domain with --domain");
}

std::optional<std::string> missing_parts(const msg::CellStatus& status) {
  std::vector<std::string> missing;
  for (const msg::NodeStatus& node : status.nodes()) {
    if (!node.alive()) missing.push_back(node.heartbeat().node());
  }
  for (const msg::ArmStatus& arm : status.arms()) {
    if (arm.state_age() < 0.0) missing.push_back("the state of " + arm.arm());
  }
  if (!status.has_referee()) missing.emplace_back("the referee");
  if (status.arms().empty()) missing.emplace_back("arms");
  return missing.empty() ? std::nullopt : std::optional(listed(missing));
}

RunningCell::RunningCell(const config::CellFile& file, const Options& options)
    : file_(file),
      log_(options.log_folder + "/agent.log"),
      connection_(client::Connection::make(client::join(file, options.domain))),
      leftovers_{file, options.domain},
      agent_(agent_arguments(file, options), log_) {
  shutdown_.wake(&connection_->mailbox());
}

RunningCell::Leftovers::~Leftovers() {
  for (const config::Host& host : file.hosts) remove_run({file.cell.name, domain, host.name});
}

bool RunningCell::look() {
  if (const auto ended = agent_.ended()) {
    throw Failure(ExitCode::kNegative, "the cell's agent " + *ended + "; its log is " + log_);
  }
  const auto newest = connection_->poll_status(kAnswer);
  answered_ = newest.has_value();
  if (answered_) status_ = *newest;
  return answered_;
}

bool RunningCell::wait_until_up(double timeout, const std::function<void(const std::string&)>& tell) {
  const auto until = client::deadline_of(Seconds(timeout));
  std::string told;
  while (!interrupted()) {
    const bool answered = look();
    const auto missing = answered ? missing_parts(status_) : "the supervisor";
    if (!missing && status_.mode().mode() == msg::Mode::MODE_RUN) return true;
    const std::string waits = missing ? *missing : "the cell's mode to be run: " + causes_text(status_.mode());
    if (waits != told) tell("waiting for " + waits);
    told = waits;
    if (client::Clock::now() > until) {
      throw Failure(ExitCode::kTimeOut, "the cell is not up after " + duration_text(timeout) + ": still waiting for " +
                                            waits + "; logs are beside " + log_);
    }
    if (answered) static_cast<void>(connection_->wait_until([this] { return interrupted(); }, 50ms));
  }
  return false;
}

}  // namespace hecaton::services::cli
