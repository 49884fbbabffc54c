/// hecaton up: starts a whole cell on this host, shows it or gives it tasks, and stops it.

#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "services/arm_driver/device_choice.hpp"
#include "services/arm_driver/taken_ports.hpp"
#include "services/cli/cell_access.hpp"
#include "services/cli/cell_monitors.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/running_cell.hpp"
#include "services/cli/status_output.hpp"
#include "services/cli/task_report.hpp"
#include "services/cli/task_rounds.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/run_folder.hpp"

namespace hecaton::services::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct UpOptions {
  std::string cell;
  TaskRounds::Options tasks;
  std::string report;
  std::string log_dir;
  bool headless = false;
  bool view = false;
  double start_timeout = 30.0;  // [s]
};

constexpr auto kViewLimit = 5s;  // for the start of hecaton-view

double since(Clock::time_point began) {
  return std::chrono::duration<double>(Clock::now() - began).count();
}

/// Lines of progress on stderr, or a live view of the cell there.
class Display {
 public:
  explicit Display(bool headless)
      : in_place_(!headless && isatty(STDERR_FILENO) != 0), palette_(Palette::for_stream(stderr)), screen_(stderr) {}

  void line(const std::string& text) {
    last_line_ = text;
    if (!in_place_) std::fprintf(stderr, "[%7.2f s] %s\n", since(began_), config::valid_utf8(text).c_str());
  }
  void cell(const msg::CellStatus& status) {
    if (!in_place_) return;
    std::string text = status_text(status, palette_);
    if (!last_line_.empty()) text += "\n" + palette_.dim(last_line_) + "\n";
    screen_.show(text);
  }
  [[nodiscard]] const Palette& palette() const { return palette_; }

 private:
  bool in_place_;
  Palette palette_;
  Screen screen_;
  Clock::time_point began_ = Clock::now();
  std::string last_line_;
};

/// One run of `up` with a valid cell file.
class Run {
 public:
  Run(const Settings& settings, const UpOptions& options, const config::CellFile& file)
      : settings_(settings),
        options_(options),
        domain_(domain_of(settings, file)),
        display_(options.headless),
        logs_(options.log_dir, file.cell.name),
        file_(file) {
    report_.cell = file.cell.name;
    report_.method = "as configured";
    report_.seed = options.tasks.seed;
    report_.asked = options.tasks.tasks;
  }

  ExitCode run() {
    refuse_occupied_domain(domain_);
    refuse_taken_ports();
    display_.line("starting cell " + file_.cell.name + " in DDS domain " + std::to_string(domain_) + ", logs in " +
                  logs_.path());
    bool clean = true;
    ExitCode code = ExitCode::kDone;
    {
      RunningCell cell(file_, {domain_, logs_.path(), options_.view});
      if (cell.wait_until_up(options_.start_timeout, [&](const std::string& text) { display_.line(text); })) {
        start_up_ = since(began_);
        display_.line("the cell is up");
        if (options_.view || file_.view) announce_page(cell);
        if (options_.tasks.tasks > 0) {
          give_tasks(cell);
        } else {
          watch(cell);
        }
      }
      display_.line("stopping the cell");
      clean = cell.agent().end();
      const bool complete = report_.tasks + report_.not_drawn >= report_.asked;
      if (cell.signal() != 0 && !complete) {
        report_.interrupted = Interrupted{cell.signal(), report_.tasks, report_.asked, "tasks"};
      }
    }
    if (!clean) display_.line("some processes did not end in time and were killed");
    if (options_.tasks.tasks > 0) code = conclude();
    if (code == ExitCode::kDone && clean) logs_.discard();
    return code;
  }

 private:
  static int domain_of(const Settings& settings, const config::CellFile& file) {
    ServiceOptions options;
    options.domain = settings.domain;
    return choose_domain(options, file.network.domain);
  }

  /// Another program would keep robots from their drivers.
  void refuse_taken_ports() const {
    const std::vector<TakenPort> taken = taken_ports(file_);
    if (!taken.empty()) throw Failure(ExitCode::kBadInput, taken.front().text);
  }

  /// Says where the page is as soon as the view sends heartbeats, or why it is not there. The cell runs without it.
  void announce_page(RunningCell& cell) {
    const auto until = Clock::now() + kViewLimit;
    while (!cell.interrupted()) {
      for (const msg::NodeStatus& node : cell.status().nodes()) {
        if (node.heartbeat().node() != view_node()) continue;
        const msg::Cause& cause = node.heartbeat().cause();
        const std::string url = config::view_url(file_.view.value_or(config::View{}), domain_);
        display_.line(is_none(cause) ? "its page: " + url : "no page: " + cause.text());
        if (is_none(cause) && file_.view && (file_.view->control || config::is_reachable_by_others(*file_.view))) {
          const RunName run{file_.cell.name, domain_, file_.view->host};
          display_.line(std::string("to ") + (file_.view->control ? "control" : "see") +
                        " the cell, open the address in " + (run_path(run) / kViewTokenFile).string());
        }
        return;
      }
      if (Clock::now() > until) {
        display_.line("no page: hecaton-view has not started within 5 s; see its log in " + logs_.path());
        return;
      }
      static_cast<void>(cell.poll());
      static_cast<void>(cell.connection().wait_until([&] { return cell.interrupted(); }, 50ms));
    }
  }

  void watch(RunningCell& cell) {
    SupervisorMonitor supervisor(cell.connection());
    while (!cell.interrupted()) {
      static_cast<void>(cell.poll());
      display_.cell(cell.status());
      print_changes(cell, supervisor);
      static_cast<void>(cell.connection().wait_until([&] { return cell.interrupted(); }, 250ms));
    }
  }

  void print_changes(const RunningCell& cell, SupervisorMonitor& supervisor) {
    for (const std::string& line : supervisor.update(cell.answered() ? &cell.status() : nullptr)) display_.line(line);
    std::string open;
    for (const msg::Fault& fault : cell.status().faults()) {
      if (!fault.cleared()) open += (open.empty() ? "" : "; ") + fault.cause().text();
    }
    if (open != faults_) display_.line(open.empty() ? "all faults are cleared" : "fault: " + open);
    faults_ = open;
  }

  void give_tasks(RunningCell& cell) {
    bus::Reader<msg::ContactReport> contact_reports(cell.connection().participant(), &cell.connection().mailbox());
    ContactTotals contacts;
    TickStatistics ticks;
    UsageMonitor usage;
    SupervisorMonitor supervisor(cell.connection());
    const auto update_contacts = [&] {
      for (const auto& sample : contact_reports.take()) {
        if (!sample.disposed) contacts.update(sample.value);
      }
    };
    usage.begin(cell.status());
    const auto began = Clock::now();
    TaskRounds rounds(cell, options_.tasks,
                      {[&] {
                         update_contacts();
                         ticks.update(cell.status());
                         print_changes(cell, supervisor);
                         display_.cell(cell.status());
                       },
                       [&](const std::string& text) { display_.line(text); }});
    try {
      rounds.run();
    } catch (const Failure& failure) {  // of the cell; the report has the tasks before it
      failure_ = failure;
    }

    // Waits for one more report of the contact monitor: it covers all motion until now.
    update_contacts();
    const double last = contacts.time();
    static_cast<void>(cell.connection().wait_until(
        [&] {
          update_contacts();
          return failure_ || contacts.time() > last;
        },
        1s));
    if (!failure_) static_cast<void>(cell.poll());
    ticks.update(cell.status());

    const Report begun = std::exchange(report_, rounds.tally());
    report_.cell = begun.cell;
    report_.method = begun.method;
    report_.contacts = contacts.contacts();
    report_.smallest = contacts.smallest();
    report_.duration = since(began);
    report_.tick_us = ticks.typical();
    report_.faults = list_json(cell.status().faults());
    if (const auto worst = ticks.worst()) {
      report_.extra["tick_us_worst_window"] = {{"p50", worst->p50}, {"p99", worst->p99}, {"max", worst->max}};
    }
    report_.extra["rounds"] = rounds.rounds();
    report_.extra["start_up_s"] = start_up_;
    report_.extra["processes"] = usage.end(cell.status());
  }

  ExitCode conclude() {
    if (failure_) report_.findings.push_back({config::Severity::kError, failure_->what()});
    report_.extra["wall_s"] = since(began_);
    std::string text = table_text(report_, Palette::for_stream(stdout));
    text += "wall time            " + duration_text(since(began_)) + ", start-up " + duration_text(start_up_) + "\n";
    if (report_.extra.contains("processes")) {
      text += "\n" + usage_text(report_.extra["processes"], Palette::for_stream(stdout));
    }
    for (const Json& fault : report_.faults) {
      text += "fault: " + fault.at("description").get<std::string>() + ", for " +
              duration_text(fault.at("duration_s").get<double>()) + "\n";
    }
    for (const config::Finding& finding : report_.findings) {
      if (!failure_) std::fprintf(stderr, "hecaton: %s\n", config::sentence_text(finding.sentence).c_str());
    }
    print(settings_, to_json(report_), text);
    if (!options_.report.empty()) write_report(options_.report, report_);
    if (failure_) throw Failure(*failure_);
    const bool none_drawn = report_.tasks == 0 && report_.not_drawn > 0;
    return none_drawn ? ExitCode::kBadInput : report_.exit_code();
  }

  const Settings& settings_;
  const UpOptions& options_;
  int domain_;
  Display display_;
  LogFolder logs_;
  const config::CellFile& file_;
  Clock::time_point began_ = Clock::now();
  double start_up_ = 0.0;
  std::string faults_;
  std::optional<Failure> failure_;  ///< of the cell, while it did tasks
  Report report_;
};

ExitCode run_up(const Settings& settings, const UpOptions& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  if (options.tasks.tasks > 0) require_tasks(file);
  require_interface(file);
  require_known_devices(file);
  static_cast<void>(sibling_program("hecaton-agent"));
  check_writable(options.report);
  return Run(settings, options, file).run();
}

}  // namespace

void add_up(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("up", "Starts a whole cell on this host, and stops it on Ctrl-C");
  auto options = std::make_shared<UpOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML)")->required();
  TaskRounds::Options& tasks = options->tasks;
  add_whole_number(
      *command, "--tasks", [&tasks](std::uint64_t n) { tasks.tasks = static_cast<int>(n); },
      "random conflicting goals until N have ended, then a report (run until Ctrl-C)", 1, kMostTasks);
  add_seed(*command, tasks.seed, "of the random goals (1)");
  command->add_option("--report", options->report, "also write the report to this file, as JSON")->type_name("FILE");
  command->add_flag("--view", options->view, "start hecaton-view also if the cell file has no key view");
  command->add_flag("--headless", options->headless, "print lines of progress instead of a live view of the cell");
  command->add_option("--log-dir", options->log_dir, "folder for all logs (a temporary one, kept only after an error)")
      ->type_name("DIR");
  add_duration(*command, "--start-timeout", options->start_timeout, "time limit for the start of the cell (30s)", 0.1,
               3600.0);
  command->footer(
      "Exit code with --tasks: 0 when all were reached without contact, 3 when no goals could be drawn, otherwise 1. "
      "Contacts and separations are the contact monitor's. Tick times: medians over windows of 512 ticks of all "
      "planners, and the longest tick.");
  command->callback([&session, options] {
    session.action = on_cell([&session, options] { return run_up(session.settings, *options); });
  });
}

}  // namespace hecaton::services::cli
