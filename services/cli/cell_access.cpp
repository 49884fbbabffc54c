#include "services/cli/cell_access.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::services::cli {
namespace {

ExitCode code_of(CauseKind kind) {
  switch (kind) {
    case CauseKind::kUnknownName:
    case CauseKind::kNameTaken:
    case CauseKind::kInvalidValue:
      return ExitCode::kBadInput;
    default:
      return ExitCode::kNegative;
  }
}

}  // namespace

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text.empty() ? "none" : text;
}

Wait answer_limit(const Settings& settings) {
  return Seconds(settings.connect_timeout);
}

Connection connect(const Settings& settings) {
  ConnectOptions options;
  options.domain = settings.domain;
  if (!settings.cell_file.empty()) options.cell_file = settings.cell_file;
  Connection connection = client::Connection::make(client::join(options));
  connection->wait_for_cell(answer_limit(settings));
  return connection;
}

Failure failure_of(const Error& error) {
  if (const auto* rejected = dynamic_cast<const Rejected*>(&error)) {
    return {code_of(rejected->cause().kind), rejected->cause().text};
  }
  if (const auto* unreachable = dynamic_cast<const Unreachable*>(&error)) {
    const Unreachable::Reason& reason = unreachable->reason();
    return {ExitCode::kUnreachable, reason.no_cell ? reason.why +
                                                         ": start one with 'hecaton up CELL', select its domain with "
                                                         "--domain or --cell, or see whether this machine reaches the "
                                                         "supervisor's"
                                                   : unreachable->what()};
  }
  if (dynamic_cast<const NoAnswer*>(&error) != nullptr) return {ExitCode::kTimeOut, error.what()};
  if (dynamic_cast<const Interrupted*>(&error) != nullptr) return {ExitCode::kNegative, error.what()};
  return {ExitCode::kBadInput, error.what()};
}

std::function<ExitCode()> on_cell(std::function<ExitCode()> action) {
  return [action = std::move(action)] {
    try {
      return action();
    } catch (const Error& error) {
      throw failure_of(error);
    }
  };
}

const msg::ArmStatus& require_arm(const msg::CellStatus& status, std::string_view arm) {
  std::vector<std::string> names;
  for (const msg::ArmStatus& known : status.arms()) {
    if (known.arm() == arm) return known;
    names.push_back(known.arm());
  }
  throw Failure(ExitCode::kBadInput,
                "cell '" + status.cell() + "' has no arm '" + std::string(arm) + "'; its arms: " + listed(names));
}

void require_arms(const msg::CellStatus& status, const std::vector<std::string>& arms) {
  for (const std::string& arm : arms) static_cast<void>(require_arm(status, arm));
}

bool concerns(const std::vector<std::string>& arms, const msg::ArmStatus& arm) {
  return arms.empty() || std::find(arms.begin(), arms.end(), arm.arm()) != arms.end();
}

}  // namespace hecaton::services::cli
