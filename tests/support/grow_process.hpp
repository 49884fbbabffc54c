#pragma once
/// Makes another process use more memory, as a leak in it would.

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>

namespace hecaton::test {

#ifdef __x86_64__
/// The main thread of a stopped process maps `bytes` by the system call mmap. Returns their address; nothing: it is in
/// no system call, at whose instruction the call can be made.
[[nodiscard]] inline std::optional<std::uintptr_t> map_in_stopped(pid_t pid, std::size_t bytes) {
  constexpr long kSyscallInstruction = 0x050F;
  constexpr std::uintptr_t kPage = 4096;
  user_regs_struct before{};
  if (ptrace(PTRACE_GETREGS, pid, nullptr, &before) != 0) return std::nullopt;
  const std::uintptr_t instruction = before.rip - 2;
  errno = 0;
  const long word = ptrace(PTRACE_PEEKTEXT, pid, instruction, nullptr);
  if (errno != 0 || (word & 0xFFFF) != kSyscallInstruction) return std::nullopt;
  user_regs_struct call = before;
  call.rip = instruction;
  call.orig_rax = static_cast<unsigned long long>(-1);  // the kernel must not repeat the interrupted call here
  call.rax = 9;                                         // mmap(address, length, protection, flags, file, offset)
  call.rdi = 0;
  call.rsi = bytes;
  call.rdx = PROT_READ | PROT_WRITE;
  call.r10 = MAP_PRIVATE | MAP_ANONYMOUS;
  call.r8 = static_cast<unsigned long long>(-1);
  call.r9 = 0;
  int status = 0;
  user_regs_struct after{};
  const bool returned = ptrace(PTRACE_SETREGS, pid, nullptr, &call) == 0 &&
                        ptrace(PTRACE_SINGLESTEP, pid, nullptr, nullptr) == 0 && waitpid(pid, &status, __WALL) == pid &&
                        WIFSTOPPED(status) && ptrace(PTRACE_GETREGS, pid, nullptr, &after) == 0;
  ptrace(PTRACE_SETREGS, pid, nullptr, &before);
  const bool mapped = returned && after.rip == before.rip && after.rax != 0 && after.rax % kPage == 0;
  return mapped ? std::optional<std::uintptr_t>(after.rax) : std::nullopt;
}

/// Maps and fills `bytes` in the process. False: it is gone, the kernel forbids it, or its main thread was in no system
/// call for `patience`. A process that ends meanwhile has been grown.
[[nodiscard]] inline bool grow_process(pid_t pid, std::size_t bytes, std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  std::optional<std::uintptr_t> address;
  while (!address) {
    int status = 0;
    if (std::chrono::steady_clock::now() > until || ptrace(PTRACE_ATTACH, pid, nullptr, nullptr) != 0) return false;
    if (waitpid(pid, &status, __WALL) != pid || !WIFSTOPPED(status)) return false;
    address = map_in_stopped(pid, bytes);
    ptrace(PTRACE_DETACH, pid, nullptr, nullptr);
    if (!address) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  // Services lock pages when they are first used (MCL_ONFAULT), so MAP_POPULATE would fill none.
  std::vector<std::uint8_t> part(std::size_t{1} << 20U);
  std::size_t filled = 0;
  while (filled < bytes) {
    const std::size_t size = std::min(part.size(), bytes - filled);
    const iovec from{part.data(), size};
    const iovec to{reinterpret_cast<void*>(*address + filled), size};
    if (process_vm_writev(pid, &from, 1, &to, 1, 0) <= 0) break;
    filled += size;
  }
  return filled > 0;
}
#endif

}  // namespace hecaton::test
