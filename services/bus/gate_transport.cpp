#include "services/bus/gate_transport.hpp"

#include <algorithm>

namespace hecaton::bus {
namespace {

class GateTransport : public FrontTransport {
 public:
  explicit GateTransport(const GateDescriptor& descriptor)
      : FrontTransport(descriptor), descriptor_(descriptor), gate_(descriptor.gate) {}

  [[nodiscard]] rtps::TransportDescriptorInterface* get_configuration() override { return &descriptor_; }

  bool pass_on(const Datagram& datagram, rtps::SenderResource& behind, rtps::LocatorsIterator& begin,
               rtps::LocatorsIterator& end, const std::chrono::steady_clock::time_point& until) override {
    if (!gate_->lets_out()) return true;
    if (!gate_->hearing.shuns_anybody()) return datagram.send(behind, begin, end, until);
    rtps::LocatorList others;
    for (; begin != end; ++begin) {
      if (!gate_->hearing.shuns(address_of(*begin))) others.push_back(*begin);
    }
    rtps::Locators first(others.begin());
    rtps::Locators last(others.end());
    return others.empty() || datagram.send(behind, first, last, until);
  }

  void receive(rtps::TransportReceiverInterface* next, const rtps::octet* data, std::uint32_t size,
               const rtps::Locator_t& local, const rtps::Locator_t& remote) override {
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

Hearing::Address address_of(const rtps::Locator_t& locator) {
  std::uint32_t ipv4 = 0;
  for (int i = 12; i < 16; ++i) ipv4 = ipv4 << 8U | locator.address[i];
  return Hearing::address_of(ipv4, static_cast<std::uint16_t>(locator.port));
}

rtps::TransportInterface* GateDescriptor::create_transport() const {
  return new GateTransport(*this);
}

}  // namespace hecaton::bus
