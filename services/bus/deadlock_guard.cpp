#include "services/bus/deadlock_guard.hpp"

#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include <unistd.h>

namespace hecaton::bus {
namespace {

/// The thread that stays holds locks for which destructors of global objects would wait.
void end_without_destructors() {
  static std::once_flag once;
  std::call_once(once, [] {
    const auto end = [](int exit_code, void*) {
      static_cast<void>(std::fflush(nullptr));
      _exit(exit_code);
    };
    if (on_exit(end, nullptr) != 0) std::abort();  // no memory
  });
}

struct Progress {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
};

}  // namespace

bool finishes_within(Clock::duration limit, std::function<void()> work) {
  const auto progress = std::make_shared<Progress>();
  const auto run = [progress, work = std::move(work)] {
    work();
    const std::scoped_lock lock(progress->mutex);
    progress->done = true;
    progress->changed.notify_one();
  };
  std::thread worker;
  try {
    worker = std::thread(run);
  } catch (const std::system_error&) {
    run();  // the process can have no more threads
    return true;
  }
  std::unique_lock lock(progress->mutex);
  const bool done = progress->changed.wait_for(lock, limit, [&] { return progress->done; });
  lock.unlock();
  if (done) {
    worker.join();
  } else {
    worker.detach();
    end_without_destructors();
  }
  return done;
}

}  // namespace hecaton::bus
