#include "services/bus/recorded_sample.hpp"

#include <memory>
#include <mutex>
#include <string>

#include "services/bus/type_support.hpp"

namespace hecaton::bus {
namespace {

/// Generated code keeps buffers: each thread has a support of its own.
template <class T>
GuardedType<T>& support_of_thread() {
  thread_local const std::unique_ptr<GuardedType<T>> support = [] {
    const std::scoped_lock lock(Participant::Impl::endpoints_mutex);
    return std::make_unique<GuardedType<T>>();
  }();
  return *support;
}

}  // namespace

std::uint32_t schema_in(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kEncapsulation = 4;
  if (bytes.size() < kEncapsulation + 4) return 0;
  const bool little = bytes[1] == 1;
  std::uint32_t schema = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    schema = (schema << 8U) | bytes[kEncapsulation + (little ? 3 - i : i)];
  }
  return schema;
}

template <class T>
DecodedSample<T> decode_recorded(std::span<const std::uint8_t> bytes) {
  const CheckedSample checked = check_sample(*rule_of<T>(), bytes);
  if (checked.other_schema) return {std::nullopt, true};
  if (checked.refusal) return {};
  std::optional<T> value(std::in_place);
  const std::uint32_t schema = value->schema();
  support_of_thread<T>().read(std::string(bytes.begin(), bytes.end()), *value);
  if (value->schema() != schema) return {};
  return {std::move(value), false};
}

template <class T>
std::vector<std::uint8_t> encode_recorded(const T& sample) {
  const std::string text = support_of_thread<T>().bytes_of(sample);
  std::vector<std::uint8_t> bytes(text.begin(), text.end());
  if (check_sample(*rule_of<T>(), bytes).refusal) bytes.clear();
  return bytes;
}

#define HECATON_DECODE(Type, ...)                                                              \
  template DecodedSample<msg::Type> decode_recorded<msg::Type>(std::span<const std::uint8_t>); \
  template std::vector<std::uint8_t> encode_recorded<msg::Type>(const msg::Type&);
HECATON_TOPICS(HECATON_DECODE)
#undef HECATON_DECODE

}  // namespace hecaton::bus
