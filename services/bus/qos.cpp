#include "services/bus/qos.hpp"

#include <algorithm>

namespace hecaton::bus {
namespace {

dds::DurabilityQosPolicyKind durability(bool keeps) {
  return keeps ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
}

/// What writers and readers have in common. Deadline and liveliness stay unset: with them, Fast DDS sets a timer anew
/// for each sample at both ends, which wakes a thread each time. Readers watch deadlines themselves
/// (ReaderBase::check).
template <class EntityQos>
void set_common(EntityQos& to, const Qos& qos, int depth, bool keyed) {
  to.reliability().kind = qos.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  to.reliability().max_blocking_time = duration(std::chrono::milliseconds(10));
  to.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  to.history().depth = depth;
  auto& limits = to.resource_limits();
  limits.max_instances = keyed ? qos.instances : 1;
  limits.max_samples_per_instance = depth;
  limits.max_samples = limits.max_instances * depth;
  limits.allocated_samples = std::min(limits.max_samples, 8);
  // Strings and sequences have no fixed size, and data sharing refuses keyed types.
  to.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  to.data_sharing().off();
}

}  // namespace

Duration duration(std::chrono::nanoseconds value) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(value);
  return {static_cast<std::int32_t>(seconds.count()), static_cast<std::uint32_t>((value - seconds).count())};
}

dds::DataWriterQos writer_qos(const Qos& qos, bool keyed) {
  dds::DataWriterQos to;
  set_common(to, qos, qos.depth, keyed);
  // Fast DDS 2.9 deadlocks the participant when a reader leaves while the sending thread has a sample of a volatile
  // reliable writer in its queue. The reader's departure removes the sample from the writer, and the two threads take
  // the locks of writer and queue in opposite orders. So the calling thread sends everything but repetitions, fragments
  // included, and reliable writers keep acknowledged samples. The reader's durability decides about late joiners.
  to.publish_mode().kind = dds::SYNCHRONOUS_PUBLISH_MODE;
  to.durability().kind = durability(qos.reliable);
  set_heartbeats(to, duration(std::chrono::milliseconds(1)), duration(qos.heartbeat));
  return to;
}

dds::DataReaderQos reader_qos(const Qos& qos, bool keyed) {
  dds::DataReaderQos to;
  set_common(to, qos, std::max(qos.depth, qos.reader_depth), keyed);
  to.durability().kind = durability(qos.transient_local);
  set_acknowledgements(to, duration(std::chrono::milliseconds(1)));
  return to;
}

std::string policy_name(dds::QosPolicyId_t id) {
  switch (id) {
    case dds::RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case dds::DURABILITY_QOS_POLICY_ID:
      return "durability";
    case dds::OWNERSHIP_QOS_POLICY_ID:
      return "ownership";
    case dds::PARTITION_QOS_POLICY_ID:
      return "partition";
    default:
      return "policy " + std::to_string(static_cast<int>(id));
  }
}

}  // namespace hecaton::bus
