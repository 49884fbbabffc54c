#pragma once
/// Serialisation of the message types of topics.hpp. Private to services/bus.

#include <idl/armPubSubTypes.h>
#include <idl/devicePubSubTypes.h>
#include <idl/goalPubSubTypes.h>
#include <idl/healthPubSubTypes.h>
#include <idl/plannerPubSubTypes.h>
#include <idl/recorderPubSubTypes.h>
#include <idl/supervisorPubSubTypes.h>
#include <idl/worldPubSubTypes.h>

#include "services/bus/endpoint_definition.hpp"
#include "services/bus/topics.hpp"

namespace hecaton::bus {

#define HECATON_PUBSUB(Type, ...)       \
  template <>                           \
  struct PubSubOf<msg::Type> {          \
    using type = msg::Type##PubSubType; \
  };
HECATON_TOPICS(HECATON_PUBSUB)
#undef HECATON_PUBSUB

}  // namespace hecaton::bus
