#include "services/python/session.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include <pthread.h>

#include "services/python/unknown_name.hpp"

namespace hecaton::python {

namespace py = pybind11;
using Clock = std::chrono::steady_clock;

namespace {

void end_without_destructors(int status, void* /*unused*/) {
  static_cast<void>(std::fflush(nullptr));
  std::_Exit(status);
}

/// The static destructors of the middleware wait for threads that a child of fork() does not have.
void spare_children_the_destructors() {
  static const bool done = [] {
    return pthread_atfork(nullptr, nullptr, [] { on_exit(end_without_destructors, nullptr); }) == 0;
  }();
  static_cast<void>(done);
}

}  // namespace

std::shared_ptr<Session> Session::connect(const ConnectOptions& options, Seconds limit) {
  spare_children_the_destructors();
  Cell cell = run_interruptibly(std::stop_token(), [&](std::stop_token stop) {
    return Cell::connect(options, Wait{limit, std::move(stop)});
  });
  // The last Python object that holds the session destroys it, with the interpreter lock.
  return std::shared_ptr<Session>(new Session(std::move(cell)));
}

Session::Call::Call(Session& session) : session_(session) {
  const std::lock_guard lock(session_.mutex_);
  ++session_.calls_[std::this_thread::get_id()];
}

Session::Call::~Call() {
  const std::lock_guard lock(session_.mutex_);
  const auto own = session_.calls_.find(std::this_thread::get_id());
  if (--own->second == 0) session_.calls_.erase(own);
  session_.ended_.notify_all();
}

void Session::require_own_process() const {
  if (getpid() != process_) throw Forked();
}

Cell Session::cell() const {
  require_own_process();
  const std::lock_guard lock(mutex_);
  if (!cell_) throw Closed();
  return *cell_;
}

Goal Session::goal(const std::string& id) const {
  require_own_process();
  const std::lock_guard lock(mutex_);
  const auto found = goals_.find(id);
  if (found == goals_.end()) throw Closed();
  return found->second;
}

std::vector<std::string> Session::arms() const {
  const Unlocked<Cell> cell(this->cell());
  const py::gil_scoped_release unlocked;
  return cell->arms();
}

void Session::require_arm(const std::string& name, Seconds limit) {
  const auto is_known = [&] {
    const std::vector<std::string> names = arms();
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (is_known()) return;
  try {
    // The running cell decides: the names may be those of an older cell file.
    call(limit, [](const Cell& cell, const Wait& wait) { return cell.status(wait); });
  } catch (const Unreachable&) {
  }
  const Unlocked<Cell> cell(this->cell());
  try {
    static_cast<void>(cell->arm(name));
  } catch (const InvalidArgument& error) {
    throw UnknownName(error.what(), name);
  }
}

std::string Session::keep(const Goal& goal) {
  const std::lock_guard lock(mutex_);
  if (cell_) goals_.emplace(goal.id(), goal);
  return goal.id();
}

Outcome Session::wait(const std::string& id, Seconds limit) {
  const Call counted(*this);  // to the end of the last wait for the interpreter lock, see close()
  const Unlocked<Goal> goal(this->goal(id));
  const auto began = Clock::now();
  while (true) {
    const Seconds left = limit - Seconds(Clock::now() - began);
    Outcome outcome;
    {
      const py::gil_scoped_release unlocked;
      outcome = goal->wait({std::min(left, Seconds(kSignalPeriod)), closing_.get_token()});
    }
    if (outcome.kind == OutcomeKind::kInterrupted) throw Closed();
    if (!(left > kSignalPeriod) || (outcome.progress && is_final(outcome.progress->state))) return outcome;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

std::optional<Progress> Session::progress(const std::string& id) const {
  const Unlocked<Goal> goal(this->goal(id));
  const py::gil_scoped_release unlocked;
  return goal->progress();
}

void Session::cancel(const std::string& id) const {
  const Unlocked<Goal> goal(this->goal(id));
  const py::gil_scoped_release unlocked;
  goal->cancel();
}

void Session::watch(const std::string& id) const {
  const Unlocked<Goal> goal(this->goal(id));
  const py::gil_scoped_release unlocked;
  goal->on_progress([events = events_](const Progress& progress) { events->push(progress); });
}

void Session::forget(const std::string& id) {
  if (getpid() != process_) return;
  decltype(goals_)::node_type dropped;
  {
    const std::lock_guard lock(mutex_);
    dropped = goals_.extract(id);
  }
  const py::gil_scoped_release unlocked;
  dropped = {};
}

void Session::watch_faults() const {
  const Unlocked<Cell> cell(this->cell());
  const py::gil_scoped_release unlocked;
  cell->on_fault([events = events_](const Fault& fault) { events->push(fault); });
}

std::vector<Fault> Session::faults() const {
  const Unlocked<Cell> cell(this->cell());
  const py::gil_scoped_release unlocked;
  return cell->faults();
}

std::optional<Event> Session::next_event() const {
  require_own_process();
  const py::gil_scoped_release unlocked;
  return events_->pop();
}

/// The threads of the connection are in the parent alone: to end it here would wait for them forever.
void Session::leave_to_parent() {
  static_cast<void>(new std::optional<Cell>(std::exchange(cell_, std::nullopt)));
  static_cast<void>(new auto(std::exchange(goals_, {})));
  static_cast<void>(new auto(events_));
}

void Session::close() {
  if (getpid() != process_) {
    leave_to_parent();
    return;
  }
  const py::gil_scoped_release unlocked;
  closing_.request_stop();
  events_->close();
  std::optional<Cell> cell;
  decltype(goals_) goals;
  {
    // Threads of Python that wait in a call must leave it before the interpreter ends. A signal handler that runs
    // during a call of this thread may close, too.
    constexpr auto kLeaves = std::chrono::seconds(2);
    std::unique_lock lock(mutex_);
    cell = std::exchange(cell_, std::nullopt);
    goals.swap(goals_);
    ended_.wait_for(lock, kLeaves, [this] {
      return std::all_of(calls_.begin(), calls_.end(),
                         [](const auto& call) { return call.first == std::this_thread::get_id(); });
    });
  }
}

}  // namespace hecaton::python
