/// An own wall clock for hosts that share the kernel (`namespaces.py`). Preloaded (LD_PRELOAD) into all processes of a
/// host, the library shifts CLOCK_REALTIME by the offset [ns] in the file HOST_CLOCK (eight bytes), at once. Steady
/// clocks do not change.
///
/// Reading a clock must never block, as in the vDSO. libfaketime holds a mutex meanwhile; a preempted low-priority
/// thread in it would block a process's control loop.
///
/// Absolute deadlines are shifted back when a wait begins. A wait during a clock change keeps its length; a kernel
/// would adjust it.
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <ctime>

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <unistd.h>

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;  // [ns]
constexpr std::time_t kOldest =
    1'000'000'000;  // [s] larger values are wall clock times, smaller ones are times since boot

/// Shared by the processes of a host; null without the file, or before main().
const std::atomic<std::int64_t>* shared_offset = nullptr;

[[gnu::constructor]] void find_offset() {
  const char* name = std::getenv("HOST_CLOCK");
  const int file = name == nullptr ? -1 : open(name, O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    return;
  }
  void* memory = mmap(nullptr, sizeof(std::int64_t), PROT_READ, MAP_SHARED, file, 0);
  close(file);
  if (memory != MAP_FAILED) {
    shared_offset = static_cast<const std::atomic<std::int64_t>*>(memory);
  }
}

std::int64_t offset() {
  return shared_offset == nullptr ? 0 : shared_offset->load(std::memory_order_relaxed);
}

timespec shifted(const timespec& time, std::int64_t by) {
  const std::int64_t nanoseconds = time.tv_nsec + by % kSecond;  // within one second of [0, 1 s)
  const std::int64_t carry = nanoseconds < 0 ? -1 : nanoseconds / kSecond;
  return {.tv_sec = time.tv_sec + by / kSecond + carry, .tv_nsec = nanoseconds - carry * kSecond};
}

/// A deadline on the kernel's clock.
timespec true_time(const timespec& deadline) {
  return deadline.tv_sec > kOldest ? shifted(deadline, -offset()) : deadline;
}

/// The function of this name that this library replaces; `signature` only gives its type.
template <class Signature>
Signature* hidden(const char* name, Signature* /*signature*/) {
  return reinterpret_cast<Signature*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static const auto real = hidden("clock_gettime", &clock_gettime);
  const int result = real(clock, time);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) {
    *time = shifted(*time, offset());
  }
  return result;
}

int gettimeofday(timeval* __restrict time, void* __restrict /*zone*/) noexcept {
  timespec now{};
  const int result = clock_gettime(CLOCK_REALTIME, &now);
  *time = {.tv_sec = now.tv_sec, .tv_usec = now.tv_nsec / 1000};
  return result;
}

std::time_t time(std::time_t* result) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (result != nullptr) {
    *result = now.tv_sec;
  }
  return now.tv_sec;
}

int pthread_cond_timedwait(pthread_cond_t* __restrict condition, pthread_mutex_t* __restrict mutex,
                           const timespec* __restrict deadline) {
  static const auto real = hidden("pthread_cond_timedwait", &pthread_cond_timedwait);
  const timespec then = true_time(*deadline);
  return real(condition, mutex, &then);
}

int pthread_cond_clockwait(pthread_cond_t* __restrict condition, pthread_mutex_t* __restrict mutex, clockid_t clock,
                           const timespec* __restrict deadline) {
  static const auto real = hidden("pthread_cond_clockwait", &pthread_cond_clockwait);
  const timespec then = true_time(*deadline);
  return real(condition, mutex, clock, &then);
}

int pthread_mutex_timedlock(pthread_mutex_t* __restrict mutex, const timespec* __restrict deadline) noexcept {
  static const auto real = hidden("pthread_mutex_timedlock", &pthread_mutex_timedlock);
  const timespec then = true_time(*deadline);
  return real(mutex, &then);
}

int pthread_mutex_clocklock(pthread_mutex_t* __restrict mutex, clockid_t clock,
                            const timespec* __restrict deadline) noexcept {
  static const auto real = hidden("pthread_mutex_clocklock", &pthread_mutex_clocklock);
  const timespec then = true_time(*deadline);
  return real(mutex, clock, &then);
}

int sem_timedwait(sem_t* __restrict semaphore, const timespec* __restrict deadline) {
  static const auto real = hidden("sem_timedwait", &sem_timedwait);
  const timespec then = true_time(*deadline);
  return real(semaphore, &then);
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* deadline, timespec* rest) {
  static const auto real = hidden("clock_nanosleep", &clock_nanosleep);
  const timespec then = (flags & TIMER_ABSTIME) != 0 ? true_time(*deadline) : *deadline;
  return real(clock, flags, &then, rest);
}

int timerfd_settime(int timer, int flags, const itimerspec* alarm, itimerspec* old) noexcept {
  static const auto real = hidden("timerfd_settime", &timerfd_settime);
  itimerspec then = *alarm;
  if ((flags & TFD_TIMER_ABSTIME) != 0) {
    then.it_value = true_time(then.it_value);
  }
  return real(timer, flags, &then, old);
}

}  // extern "C"
