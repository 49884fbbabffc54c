#include "services/bus/gate_transport.hpp"

#include <algorithm>

#include <fastdds/rtps/common/LocatorList.hpp>

namespace hecaton::bus {
namespace {

namespace fast = eprosima::fastdds::rtps;
namespace wire = eprosima::fastrtps::rtps;

class GateTransport : public fast::ChainingTransport {
 public:
  explicit GateTransport(const GateDescriptor& descriptor)
      : ChainingTransport(descriptor), descriptor_(descriptor), gate_(descriptor.gate) {}

  [[nodiscard]] fast::TransportDescriptorInterface* get_configuration() override { return &descriptor_; }

  bool send(wire::SenderResource* behind, const wire::octet* data, std::uint32_t size, wire::LocatorsIterator* begin,
            wire::LocatorsIterator* end, const std::chrono::steady_clock::time_point& until) override {
    if (!gate_->lets_out()) return true;
    if (!gate_->hearing.shuns_anybody()) return behind->send(data, size, begin, end, until);
    fast::LocatorList others;
    for (; *begin != *end; ++*begin) {
      if (!gate_->hearing.shuns(address_of(**begin))) others.push_back(**begin);
    }
    fast::Locators first(others.begin());
    fast::Locators last(others.end());
    return others.empty() || behind->send(data, size, &first, &last, until);
  }

  void receive(fast::TransportReceiverInterface* next, const wire::octet* data, std::uint32_t size,
               const wire::Locator_t& local, const wire::Locator_t& remote) override {
    if (!gate_->lets_in()) return;
    // RTPS header: "RTPS", version, vendor, then the sender's prefix.
    Hearing::Prefix sender{};
    constexpr std::size_t kPrefixAt = 8;
    if (size < kPrefixAt + sender.size()) return;
    std::copy_n(data + kPrefixAt, sender.size(), sender.begin());
    if (!gate_->hearing.hears(sender, Clock::now())) return;
    const std::size_t place = gate_->receivers.enter(Clock::now());
    next->OnDataReceived(data, size, local, remote);
    gate_->receivers.leave(place);
  }

 private:
  GateDescriptor descriptor_;
  std::shared_ptr<Gate> gate_;
};

}  // namespace

Hearing::Address address_of(const wire::Locator_t& locator) {
  std::uint32_t ipv4 = 0;
  for (int i = 12; i < 16; ++i) ipv4 = ipv4 << 8U | locator.address[i];
  return Hearing::address_of(ipv4, static_cast<std::uint16_t>(locator.port));
}

fast::TransportInterface* GateDescriptor::create_transport() const {
  return new GateTransport(*this);
}

}  // namespace hecaton::bus
