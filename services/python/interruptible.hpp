#pragma once
/// Waits without the interpreter lock that end at Ctrl-C. Python runs signal handlers in its main thread and only with
/// the lock. No thread of C++ takes the lock: results and events reach Python in threads of Python alone.

#include <chrono>
#include <future>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include <pybind11/pybind11.h>

namespace hecaton::python {

/// Between two looks for signals during a wait.
inline constexpr std::chrono::milliseconds kSignalPeriod{50};

/// Runs `work(std::stop_token)` in a thread of its own, without the interpreter lock, and returns its result. A signal
/// whose handler raises, and a stop request of `outer`, request a stop of the token; the function returns when `work`
/// has ended, and raises what the handler raised. Needs the interpreter lock.
template <class Work>
auto run_interruptibly(const std::stop_token& outer, Work work) {
  namespace py = pybind11;
  using Result = decltype(work(std::stop_token()));
  std::stop_source stop;
  const std::stop_callback forward(outer, [&stop] { stop.request_stop(); });
  std::packaged_task<Result()> task([&work, &stop] { return work(stop.get_token()); });
  std::future<Result> result = task.get_future();
  bool raised = false;
  {
    const py::gil_scoped_release unlocked;
    const std::jthread thread(std::move(task));
    while (!raised && result.wait_for(kSignalPeriod) != std::future_status::ready) {
      const py::gil_scoped_acquire locked;
      raised = PyErr_CheckSignals() != 0;
    }
    if (raised) stop.request_stop();
  }
  if (raised) throw py::error_already_set();
  return result.get();
}

/// An object whose destructor may wait: destroys it without the interpreter lock.
template <class T>
class Unlocked {
 public:
  explicit Unlocked(T value) : value_(std::move(value)) {}
  ~Unlocked() {
    const pybind11::gil_scoped_release unlocked;
    value_.reset();
  }
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;
  const T& operator*() const { return *value_; }
  const T* operator->() const { return &*value_; }

 private:
  std::optional<T> value_;
};

}  // namespace hecaton::python
