#pragma once
/// Serialisation of the table's types. Private to services/bus.

#include <mutex>

#include <idl/armPubSubTypes.h>
#include <idl/goalPubSubTypes.h>
#include <idl/healthPubSubTypes.h>
#include <idl/supervisorPubSubTypes.h>
#include <idl/worldPubSubTypes.h>

#include "services/bus/topics.hpp"

namespace hecaton::bus {

template <class T>
struct PubSubOf;

#define HECATON_PUBSUB(Type, ...)       \
  template <>                           \
  struct PubSubOf<msg::Type> {          \
    using type = msg::Type##PubSubType; \
  };
HECATON_TOPICS(HECATON_PUBSUB)
#undef HECATON_PUBSUB

/// The generated type support, made safe for several threads and for what the wire may bring.
template <class T>
class GuardedType : public PubSubOf<T>::type {
  using Base = typename PubSubOf<T>::type;

 public:
  /// The generated one serialises every key of every writer into one buffer.
  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle, bool force_md5) override {
    const std::scoped_lock lock(key_mutex_);
    return Base::getKey(data, handle, force_md5);
  }

  /// A payload that cannot be read becomes a sample of schema 0, which the reader counts and drops: refusing it here
  /// would leave it in the history.
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) override {
    try {
      if (Base::deserialize(payload, data)) return true;
    } catch (const std::exception&) {
    }
    auto& sample = *static_cast<T*>(data);
    sample = T();
    sample.schema(0);
    return true;
  }

 private:
  std::mutex key_mutex_;
};

}  // namespace hecaton::bus
