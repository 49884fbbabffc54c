#pragma once
/// Makes another process use more memory, as a leak in it would.

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <thread>

#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/user.h>
#include <sys/wait.h>

namespace hecaton::test {

#ifdef __x86_64__
/// The main thread of the process maps and fills `bytes`, by the system call mmap. False: the process is gone, the
/// kernel forbids it, or its main thread was in no system call, where the call can be made, for `patience`.
[[nodiscard]] inline bool grow_process(pid_t pid, std::size_t bytes, std::chrono::milliseconds patience) {
  constexpr long kSyscallInstruction = 0x050F;
  const auto until = std::chrono::steady_clock::now() + patience;
  do {
    if (ptrace(PTRACE_ATTACH, pid, nullptr, nullptr) != 0) return false;
    int status = 0;
    if (waitpid(pid, &status, __WALL) != pid || !WIFSTOPPED(status)) return false;
    user_regs_struct before{};
    bool grown = false;
    if (ptrace(PTRACE_GETREGS, pid, nullptr, &before) == 0) {
      const std::uintptr_t instruction = before.rip - 2;
      errno = 0;
      const long word = ptrace(PTRACE_PEEKTEXT, pid, instruction, nullptr);
      if (errno == 0 && (word & 0xFFFF) == kSyscallInstruction) {
        user_regs_struct call = before;
        call.rip = instruction;
        call.orig_rax = static_cast<unsigned long long>(-1);  // the kernel must not repeat the interrupted call here
        call.rax = 9;                                         // mmap(address, length, protection, flags, file, offset)
        call.rdi = 0;
        call.rsi = bytes;
        call.rdx = PROT_READ | PROT_WRITE;
        call.r10 = MAP_PRIVATE | MAP_ANONYMOUS | MAP_POPULATE;
        call.r8 = static_cast<unsigned long long>(-1);
        call.r9 = 0;
        user_regs_struct after{};
        grown = ptrace(PTRACE_SETREGS, pid, nullptr, &call) == 0 &&
                ptrace(PTRACE_SINGLESTEP, pid, nullptr, nullptr) == 0 && waitpid(pid, &status, __WALL) == pid &&
                WIFSTOPPED(status) && ptrace(PTRACE_GETREGS, pid, nullptr, &after) == 0 && after.rip == before.rip &&
                after.rax != 0 && after.rax % 4096 == 0;
        if (WIFSTOPPED(status)) ptrace(PTRACE_SETREGS, pid, nullptr, &before);
      }
    }
    ptrace(PTRACE_DETACH, pid, nullptr, nullptr);
    if (grown) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  } while (std::chrono::steady_clock::now() < until);
  return false;
}
#endif

}  // namespace hecaton::test
