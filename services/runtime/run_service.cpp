#include "services/runtime/run_service.hpp"

#include <bit>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <semaphore>
#include <system_error>
#include <thread>

#include <link.h>
#include <linux/capability.h>
#include <linux/close_range.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "services/config/link_pair_cache.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

void touch(std::uintptr_t begin, std::size_t size) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (std::size_t offset = 0; offset < size; offset += page) {
    static_cast<void>(*std::bit_cast<const volatile char*>(begin + offset));
  }
}

/// Touches every readable segment of a loaded program or library.
int touch_segments(dl_phdr_info* object, std::size_t, void*) {
  for (int i = 0; i < object->dlpi_phnum; ++i) {
    const ElfW(Phdr)& segment = object->dlpi_phdr[i];
    if (segment.p_type == PT_LOAD && (segment.p_flags & PF_R) != 0) {
      touch(object->dlpi_addr + segment.p_vaddr, segment.p_memsz);
    }
  }
  return 0;
}

bool may_lock_any_amount() {
  __user_cap_header_struct self{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct sets[_LINUX_CAPABILITY_U32S_3]{};
  if (syscall(SYS_capget, &self, sets) == 0 && (sets[0].effective & (1U << CAP_IPC_LOCK)) != 0) return true;
  const rlimit none{RLIM_INFINITY, RLIM_INFINITY};
  return setrlimit(RLIMIT_MEMLOCK, &none) == 0;
}

/// The notifier's thread reports through this whether it holds the descriptor.
struct NotifierStart {
  int error = 0;
  std::binary_semaphore done{0};
};

/// Leaves the calling thread with this descriptor only, and all other threads with theirs. close_range(2) works where
/// containers forbid unshare(2). Returns errno's value; 0: done.
int keep_only(int fd) {
  const auto own = static_cast<unsigned>(fd);
  if (syscall(SYS_close_range, own + 1, ~0U, CLOSE_RANGE_UNSHARE) != 0) return errno;
  if (own > 0) static_cast<void>(syscall(SYS_close_range, 0U, own - 1, 0U));
  return 0;
}

void hold_until_exit(int fd, const std::shared_ptr<NotifierStart>& start) {
  prctl(PR_SET_NAME, "exit notifier");
  start->error = keep_only(fd);
  const bool holds = start->error == 0;
  start->done.release();
  if (!holds) return;
  while (true) pause();
}

}  // namespace

int run_service(int argc, const char* const* argv, const std::string& description, Subject subject,
                const std::function<void(const ServiceOptions&, ShutdownSignal&)>& body, const MoreOptions& more) {
  ShutdownSignal shutdown;
  ServiceOptions options;
  if (const auto leave = parse_options(argc, argv, description, subject, options, more))
    return static_cast<int>(*leave);
  keep_files_private();
  config::use_link_pair_folder();
  try {
    body(options, shutdown);
    return static_cast<int>(ExitCode::kDone);
  } catch (const std::bad_alloc&) {
    complain(
        "this process gets no more memory: supervision.memory_limit in the cell file, its unit or shell bounds it");
    return static_cast<int>(ExitCode::kNoMemory);
  } catch (const std::exception& error) {
    complain(error.what());
    return static_cast<int>(ExitCode::kBadInput);
  }
}

void keep_files_private() {
  static_cast<void>(::umask(S_IRWXG | S_IRWXO));
}

void lock_memory() {
  // Below a limit, the kernel would refuse later mappings instead of leaving them unlocked.
  if (!may_lock_any_amount()) {
    log_info("memory is not locked", {{"reason", "neither CAP_IPC_LOCK nor an unlimited RLIMIT_MEMLOCK"}});
  } else if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    log_info("memory is not locked", {{"reason", std::strerror(errno)}});
  }
  dl_iterate_phdr(touch_segments, nullptr);  // after mlockall(), which locks what is touched from now on
}

void start_exit_notifier(int fd) {
  if (fd < 0) return;
  const auto start = std::make_shared<NotifierStart>();
  // The thread takes no signals: handlers use descriptors that it does not have.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  try {
    std::thread([fd, start] { hold_until_exit(fd, start); }).detach();
    start->done.acquire();
  } catch (const std::system_error& error) {
    start->error = error.code().value();
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (start->error == 0) {
    close(fd);  // the notifier has its own
  } else {
    log_info("no exit notifier: the agent learns of this process's end when its last thread has ended",
             {{"reason", std::strerror(start->error)}});
  }
}

void raise_service_priority(const config::CellFile& file, ThreadPriority priority) {
  if (!file.real_time) return;
  if (const auto reason = raise_priority(priority)) log_warning("no real-time priority", {{"reason", *reason}});
}

}  // namespace hecaton::services
