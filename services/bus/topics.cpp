#include "services/bus/topics.hpp"

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/supervisor.h>
#include <idl/world.h>

namespace hecaton::bus {

#define HECATON_KEY(Type, key, ...)                              \
  std::string key_of([[maybe_unused]] const msg::Type& sample) { \
    return key;                                                  \
  }
HECATON_TOPICS(HECATON_KEY)
#undef HECATON_KEY

}  // namespace hecaton::bus
