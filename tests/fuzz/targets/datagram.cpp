// A stream of RTPS datagrams, each behind its length in two bytes.

#include "services/bus/datagram_check.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int HECATON_FUZZ_TARGET(datagram)(const std::uint8_t* data, std::size_t size) {
  using namespace hecaton;
  fuzz::Input input(data, size);
  bus::DatagramCheck check;
  bus::Clock::time_point now{};
  while (!input.empty()) {
    const std::size_t length = input.byte() | static_cast<std::size_t>(input.byte()) << 8U;
    const fuzz::View datagram = input.take(length);
    static_cast<void>(bus::DatagramCheck::announces_departure(datagram));
    const auto stall_ended = length % 7 == 0 ? std::optional(now) : std::nullopt;
    static_cast<void>(check.refuse(datagram, length % 3, now, stall_ended));
    now += std::chrono::milliseconds(length % 4096);
    if (length % 61 == 0 && datagram.size() >= 20) {
      bus::DatagramCheck::Prefix sender{};
      std::copy_n(datagram.begin() + 8, sender.size(), sender.begin());
      check.forget(sender);
      check.unbind(sender);
    }
  }
  return 0;
}
