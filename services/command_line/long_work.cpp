#include "services/command_line/long_work.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <string_view>
#include <utility>

#include <unistd.h>

#include "services/command_line/terminal.hpp"
#include "services/runtime/first_signal.hpp"

namespace hecaton::services::cli {
namespace {

constexpr auto kQuietAtFirst = std::chrono::milliseconds(500);
constexpr auto kDrawInterval = std::chrono::milliseconds(200);
constexpr auto kLineInterval = std::chrono::seconds(5);

/// Signals and what they did before; by one Interruption at a time.
struct Handled {
  int number;
  struct sigaction before;
};
std::array<Handled, 2> handled{{{SIGINT, {}}, {SIGTERM, {}}}};

void on_signal(int number) {
  if (first_signal::arrived(number) == first_signal::Arrival::kSecond) _exit(first_signal::exit_code(number));
}

/// In whole seconds, for it is an estimate.
std::string time_left_text(double seconds) {
  return seconds < 119.5 ? decimal_text(seconds, 0) + " s" : duration_text(seconds);
}

std::string number_text(double value) {
  return decimal_text(value, std::floor(value) == value ? 0 : 1);
}

}  // namespace

std::string Interrupted::text() const {
  return std::string("interrupted by ") + (signal == SIGTERM ? "SIGTERM" : "SIGINT") + ": " +
         number_text(done.get<double>()) + " of " + number_text(asked.get<double>()) + " " + unit + " done";
}

ExitCode Interrupted::exit_code() const {
  return static_cast<ExitCode>(first_signal::exit_code(signal));
}

Json to_json(const std::optional<Interrupted>& interrupted) {
  if (!interrupted) return nullptr;
  return {{"signal", interrupted->signal == SIGTERM ? "SIGTERM" : "SIGINT"},
          {"done", interrupted->done},
          {"asked", interrupted->asked},
          {"unit", interrupted->unit}};
}

Interruption::Interruption() {
  first_signal::forget();
  for (Handled& one : handled) {
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(one.number, nullptr, &one.before);
    if (one.before.sa_handler != SIG_IGN) sigaction(one.number, &action, nullptr);
  }
}

Interruption::~Interruption() {
  for (const Handled& one : handled) sigaction(one.number, &one.before, nullptr);
}

int Interruption::signal() const {
  return first_signal::number();
}

std::optional<Interrupted> Interruption::after(Json done, Json asked, std::string unit) const {
  if (!requested()) return std::nullopt;
  return Interrupted{signal(), std::move(done), std::move(asked), std::move(unit)};
}

Progress::Progress(Elsewhere elsewhere, std::FILE* stream)
    : stream_(stream), terminal_(is_terminal(stream)), elsewhere_(elsewhere) {}

Progress::~Progress() {
  clear();
}

void Progress::show(const std::string& what, double done, double all, const std::string& unit,
                    const std::string& note) {
  if (!terminal_ && elsewhere_ == Elsewhere::kNothing) return;
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  if (what != what_ || began_ == Clock::time_point()) {
    what_ = what;
    done_at_beginning_ = done;
    began_ = now;
    drawn_ = now;
  }
  const bool first = !visible_ && now - began_ < kQuietAtFirst;
  if (first || now - drawn_ < (terminal_ ? Clock::duration(kDrawInterval) : Clock::duration(kLineInterval))) return;
  drawn_ = now;
  constexpr int kWidth = 20;  // with names and numbers the line fits 80 columns
  const double share = all > 0.0 ? std::clamp(done / all, 0.0, 1.0) : 0.0;
  const auto filled = static_cast<std::size_t>(share * kWidth);
  std::string text = what + " [" + std::string(filled, '#') + std::string(kWidth - filled, ' ') + "] " +
                     number_text(done) + " of " + number_text(all) + " " + unit;
  const double gained = done - done_at_beginning_;
  if (gained > 0.0) {
    const std::chrono::duration<double> spent = now - began_;
    text += ", " + time_left_text(spent.count() / gained * std::max(0.0, all - done)) + " left";
  }
  if (!note.empty()) text += ", " + note;
  text = terminal_ ? "\r" + clip(text, terminal_columns(stream_) - 1) + "\x1b[K" : text + "\n";
  std::fwrite(text.data(), 1, text.size(), stream_);
  std::fflush(stream_);
  visible_ = terminal_;
}

void Progress::clear() {
  const std::lock_guard lock(mutex_);
  if (!visible_) return;
  std::fputs("\r\x1b[K", stream_);
  std::fflush(stream_);
  visible_ = false;
}

}  // namespace hecaton::services::cli
