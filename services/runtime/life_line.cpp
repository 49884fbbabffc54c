#include "services/runtime/life_line.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <semaphore>
#include <system_error>
#include <thread>

#include <linux/close_range.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

/// Where the thread has come to.
struct Beginning {
  int error = 0;
  std::binary_semaphore done{0};
};

/// Leaves the caller's thread with no descriptor but this one, and all others with all that they have. close_range(2)
/// does so where containers forbid unshare(2).
int keep_alone(int fd) {
  const auto own = static_cast<unsigned>(fd);
  if (syscall(SYS_close_range, own + 1, ~0U, CLOSE_RANGE_UNSHARE) != 0) return errno;
  if (own > 0) static_cast<void>(syscall(SYS_close_range, 0U, own - 1, 0U));
  return 0;
}

void sleep_for_good(int fd, const std::shared_ptr<Beginning>& beginning) {
  prctl(PR_SET_NAME, "life line");
  beginning->error = keep_alone(fd);
  const bool alone = beginning->error == 0;
  beginning->done.release();
  if (!alone) return;
  while (true) pause();
}

}  // namespace

void hold_life_line(int fd) {
  if (fd < 0) return;
  const auto beginning = std::make_shared<Beginning>();
  // No signal is for this thread: handlers use descriptors that it does not have.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  try {
    std::thread([fd, beginning] { sleep_for_good(fd, beginning); }).detach();
    beginning->done.acquire();
  } catch (const std::system_error& error) {
    beginning->error = error.code().value();
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (beginning->error == 0) {
    close(fd);  // ours; it has its own
  } else {
    log_info("the end of this process is told when all of it has ended", {{"reason", std::strerror(beginning->error)}});
  }
}

}  // namespace hecaton::services
