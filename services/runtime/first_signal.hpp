#pragma once
/// The first signal that asks a process to end, and those that repeat it. Standard library and system calls only.

namespace hecaton::services::first_signal {

enum class Arrival {
  kFirst,
  kEcho,    ///< within 200 ms after the first: `timeout` signals a program and then its group
  kSecond,  ///< later
};
/// For signal handlers: async-signal-safe and lock-free.
[[nodiscard]] Arrival arrived(int number);

/// The first one; 0 before it. Thread-safe.
[[nodiscard]] int number();
/// Forgets the first one. Call it before handlers are set.
void forget();

/// Exit code of a program that a signal ends, as shells count.
[[nodiscard]] constexpr int exit_code(int number) {
  return 128 + number;
}

}  // namespace hecaton::services::first_signal
