#include "services/bus/gate_transport.hpp"

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
    return !gate_->lets_out() || behind->send(data, size, begin, end, until);
  }

  void receive(fast::TransportReceiverInterface* next, const wire::octet* data, std::uint32_t size,
               const wire::Locator_t& local, const wire::Locator_t& remote) override {
    if (!gate_->lets_in()) return;
    const std::size_t place = gate_->receivers.enter(Clock::now());
    next->OnDataReceived(data, size, local, remote);
    gate_->receivers.leave(place);
  }

 private:
  GateDescriptor descriptor_;
  std::shared_ptr<Gate> gate_;
};

}  // namespace

fast::TransportInterface* GateDescriptor::create_transport() const {
  return new GateTransport(*this);
}

}  // namespace hecaton::bus
