/// What calls of the C++ client library cost in a running cell, for tests/bench/python_cost.py, which makes the same
/// calls in Python.
///
/// usage: client-cost CELL DOMAIN ARM
///
/// Prints a line for each call: its name, the median and the 99th percentile [µs].

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <hecaton/client.hpp>

namespace hecaton::bench {
namespace {

constexpr Seconds kPatience{120.0};

template <class Call>
void cost(const char* name, std::size_t calls, const Call& call) {
  std::vector<double> took;
  took.reserve(calls);
  for (std::size_t i = 0; i < calls; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    call();
    took.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  std::sort(took.begin(), took.end());
  std::printf("%s %.3f %.3f\n", name, took[calls / 2], took[calls * 99 / 100]);
}

void measure(const std::string& file, int domain, const std::string& name) {
  ConnectOptions options;
  options.cell_file = file;
  options.domain = domain;
  const Cell cell = Cell::connect(options, kPatience);
  const Arm arm = cell.arm(name);
  const std::vector<double> q = arm.state(kPatience).q;
  const Goal goal = arm.go_to(q);
  if (!goal.wait(kPatience)) throw Error("the arm has not reached where it stands");
  // What a call returns must not be left out by the compiler.
  double sum = 0.0;
  cost("arm.state()", 5000, [&] { sum += arm.state().q.front(); });
  cost("goal.progress", 5000, [&] { sum += goal.progress()->distance; });
  cost("arm.go_to(q)", 100, [&] { static_cast<void>(arm.go_to(q)); });
  cost("cell.status()", 100, [&] { sum += static_cast<double>(cell.status(kPatience).arms.size()); });
  std::fprintf(stderr, "sum %g\n", sum);
}

}  // namespace
}  // namespace hecaton::bench

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("usage: client-cost CELL DOMAIN ARM\n", stderr);
    return 2;
  }
  try {
    hecaton::bench::measure(argv[1], std::atoi(argv[2]), argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "client-cost: %s\n", error.what());
    return 1;
  }
}
