#pragma once
/// Serialisation of the message types. Private to services/bus.

#include <idl/armPubSubTypes.h>
#include <idl/goalPubSubTypes.h>
#include <idl/healthPubSubTypes.h>
#include <idl/supervisorPubSubTypes.h>
#include <idl/worldPubSubTypes.h>

#include "services/bus/fastdds.hpp"
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

/// The type support of a message, see GuardedSupport.
template <class T>
using GuardedType = GuardedSupport<typename PubSubOf<T>::type, T>;

}  // namespace hecaton::bus
