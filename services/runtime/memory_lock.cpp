#include "services/runtime/memory_lock.hpp"

#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <link.h>
#include <linux/capability.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

void touch(std::uintptr_t begin, std::size_t size) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (std::size_t offset = 0; offset < size; offset += page) {
    static_cast<void>(*std::bit_cast<const volatile char*>(begin + offset));
  }
}

/// Of a program or library that is loaded: every segment that may be read.
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

}  // namespace

void lock_memory() {
  // With a limit, what is mapped later would not be locked but refused.
  if (!may_lock_any_amount()) {
    log_info("memory is not locked", {{"reason", "neither CAP_IPC_LOCK nor an unlimited RLIMIT_MEMLOCK"}});
  } else if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    log_info("memory is not locked", {{"reason", std::strerror(errno)}});
  }
  dl_iterate_phdr(touch_segments, nullptr);  // afterwards: what is touched now is locked
}

}  // namespace hecaton::services
