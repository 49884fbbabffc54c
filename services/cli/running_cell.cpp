#include "services/cli/running_cell.hpp"

#include <utility>
#include <vector>

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

Membership join_as_member(const config::CellFile& file, int domain) {
  return {visit(file, domain), "DDS domain " + std::to_string(domain)};
}

}  // namespace

void refuse_occupied_domain(int domain) {
  Settings settings;
  settings.domain = domain;
  Client probe(join(settings), kAnswer);
  bus::Reader<msg::Heartbeat> beats(probe.participant(), &probe.mailbox());
  const auto until = bus::Clock::now() + kProbe;
  while (beats.take().empty()) {
    const auto left = until - bus::Clock::now();
    if (left <= 0ns) return;
    [[maybe_unused]] const bool arrived = beats.wait_for_data(left);
  }
  msg::CellStatus status;
  const std::string name = probe.poll_status(status, kAnswer) ? " '" + status.cell() + "'" : "";
  throw Failure(ExitCode::kBadInput, "another cell" + name + " is up in DDS domain " + std::to_string(domain) +
                                         "; end it first, or choose another domain with --domain");
}

std::string missing_parts(const msg::CellStatus& status) {
  std::vector<std::string> missing;
  for (const msg::NodeStatus& node : status.nodes()) {
    if (!node.alive()) missing.push_back(node.heartbeat().node());
  }
  for (const msg::ArmStatus& arm : status.arms()) {
    if (arm.state_age() < 0.0) missing.push_back("the state of " + arm.arm());
  }
  if (!status.has_referee()) missing.emplace_back("the referee");
  if (status.arms().empty()) missing.emplace_back("arms");
  std::string text;
  for (std::size_t i = 0; i < missing.size(); ++i) {
    if (i > 0) text += i + 1 == missing.size() ? " and " : ", ";
    text += missing[i];
  }
  return text;
}

RunningCell::RunningCell(const config::CellFile& file, const Options& options)
    : file_(file),
      log_(options.log_folder + "/agent.log"),
      client_(join_as_member(file, options.domain), kAnswer),
      leftovers_{file, options.domain},
      agent_(agent_arguments(file, options), log_) {
  shutdown_.wake(&client_.mailbox());
}

RunningCell::Leftovers::~Leftovers() {
  for (const config::Host& host : file.hosts) remove_run({file.cell.name, domain, host.name});
}

bool RunningCell::look() {
  const std::string ended = agent_.ended();
  if (!ended.empty()) {
    throw Failure(ExitCode::kNegative, "the cell's agent " + ended + "; its log is " + log_);
  }
  return answered_ = client_.poll_status(status_, kAnswer);
}

bool RunningCell::wait_until_up(double timeout, const std::function<void(const std::string&)>& tell) {
  const auto until = bus::Clock::now() + seconds(timeout);
  std::string told;
  while (!interrupted()) {
    const bool answered = look();
    const std::string missing = answered ? missing_parts(status_) : "the supervisor";
    if (missing.empty() && status_.mode().mode() == msg::Mode::MODE_RUN) return true;
    const std::string waits = missing.empty() ? "the cell's mode to be run: " + causes_text(status_.mode()) : missing;
    if (waits != told) tell("waiting for " + waits);
    told = waits;
    if (bus::Clock::now() > until) {
      throw Failure(ExitCode::kTimeOut, "the cell is not up after " + duration_text(timeout) + ": still waiting for " +
                                            waits + "; logs are beside " + log_);
    }
    if (answered) {
      [[maybe_unused]] const bool woken = client_.mailbox().wait(50ms);
    }
  }
  return false;
}

}  // namespace hecaton::services::cli
