#include "services/bus/endpoint_definition.hpp"
#include "services/bus/type_support.hpp"

namespace hecaton::bus {

#define HECATON_KEY(Type, key, ...)                                                \
  std::string Topic<msg::Type>::key_of([[maybe_unused]] const msg::Type& sample) { \
    return key;                                                                    \
  }
HECATON_TOPICS(HECATON_KEY)
#undef HECATON_KEY

#define HECATON_INSTANTIATE(Type, ...) \
  template class Writer<msg::Type>;    \
  template class Reader<msg::Type>;
HECATON_TOPICS(HECATON_INSTANTIATE)
#undef HECATON_INSTANTIATE

}  // namespace hecaton::bus
