#include "services/bus/datagram_check.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "services/bus/rtps_wire.hpp"

namespace hecaton::bus {
namespace {

namespace flag = wire::flag;
namespace parameter = wire::parameter;
namespace submessage = wire::submessage;
using wire::kAnnouncer;
using wire::kAuthenticator;
using wire::kBuiltin;
using wire::kHeader;
using wire::kReaderAnnouncer;
using wire::kWriterAnnouncer;

constexpr std::int64_t kLargestNumber = std::int64_t{1} << 62;

bool is(const std::uint8_t* entity, const std::array<std::uint8_t, 4>& known) {
  return std::equal(known.begin(), known.end(), entity);
}

std::optional<std::string_view> unless(bool good, std::string_view why) {
  return good ? std::nullopt : std::optional(why);
}

}  // namespace

/// Reads numbers of a submessage; false beyond its end.
class DatagramCheck::Reader {
 public:
  Reader(std::span<const std::uint8_t> body, bool little) : body_(body), little_(little) {}

  template <class T>
  bool read(T& value) {
    if (at_ + sizeof(T) > body_.size()) return false;
    value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const std::size_t from = little_ ? sizeof(T) - 1 - i : i;
      value = static_cast<T>(value << 8U | body_[at_ + from]);
    }
    at_ += sizeof(T);
    return true;
  }
  bool skip(std::size_t bytes) {
    if (at_ + bytes > body_.size()) return false;
    at_ += bytes;
    return true;
  }
  /// Bytes that have one order.
  bool bytes(std::uint8_t* to, std::size_t count) {
    if (at_ + count > body_.size()) return false;
    std::copy_n(body_.data() + at_, count, to);
    at_ += count;
    return true;
  }
  /// The identifier of an endpoint.
  bool entity(std::uint8_t* to) { return bytes(to, 4); }
  void set_order(bool little) { little_ = little; }
  [[nodiscard]] std::size_t at() const { return at_; }
  bool number(std::int64_t& value) {
    std::uint32_t high = 0;
    std::uint32_t low = 0;
    if (!read(high) || !read(low)) return false;
    value = static_cast<std::int64_t>(std::uint64_t{high} << 32U | low);
    return true;
  }
  /// The bitmap of a set: at most 256 bits.
  bool bitmap() {
    std::uint32_t bits = 0;
    return read(bits) && bits <= 256 && skip((bits + 31) / 32 * 4);
  }

 private:
  std::span<const std::uint8_t> body_;
  bool little_;
  std::size_t at_ = 0;
};

std::size_t DatagramCheck::Hash::operator()(const Prefix& participant) const {
  std::uint64_t one = 0;
  std::uint32_t other = 0;
  std::memcpy(&one, participant.data(), 8);
  std::memcpy(&other, participant.data() + 8, 4);
  return static_cast<std::size_t>((one * 0x9E3779B97F4A7C15U) ^ (other * 0xC2B2AE3D27D4EB4FU));
}

DatagramCheck::Writer* DatagramCheck::find(const Guid& writer) {
  const auto all = writers_.find(writer.participant);
  if (all == writers_.end()) return nullptr;
  const auto known =
      std::ranges::find_if(all->second, [&](const Writer& entry) { return entry.entity == writer.entity; });
  return known == all->second.end() ? nullptr : &*known;
}

bool DatagramCheck::add(const Guid& guid, const Writer& writer) {
  Writers& all = writers_[guid.participant];
  if (all.size() == kWriters) {
    const auto rank = [](const Writer& entry) { return std::pair(entry.last > kMostListed, entry.heard); };
    const auto quietest = std::ranges::min_element(all, {}, rank);
    if (quietest->last > kMostListed) return false;
    all.erase(quietest);
  }
  all.push_back(writer);
  all.back().entity = guid.entity;
  return true;
}

std::int64_t DatagramCheck::longest_leap(const Writer& writer, Clock::time_point now) {
  return now - writer.heard > kPause ? kLeapAfterPause : longest_leap(writer, writer.heard, now);
}

std::int64_t DatagramCheck::longest_leap(const Writer& writer, Clock::time_point heard, Clock::time_point now) {
  using Seconds = std::chrono::duration<double>;
  constexpr double kRarely = 5.0;  // [1/s]
  const double known = Seconds(writer.heard - writer.since).count();
  const double average = known > 1.0 ? static_cast<double>(writer.last - writer.first) / known : 0.0;
  const double rate = average > kRarely ? std::min(average, kBurst) : kBurst;
  // Of two receiving threads the one that waited for the lock may have read the clock long before the other.
  const Clock::duration silence = std::max(now - heard, Clock::duration::zero());
  return kLeap + static_cast<std::int64_t>(2.0 * rate * Seconds(silence).count());
}

bool DatagramCheck::follows_stall(Writer& writer, std::int64_t number, const Reading& reading) {
  std::optional<Mark>& mark = writer.before_stall;
  if (!reading.after_stall) {
    mark.reset();
    return false;
  }
  if (!mark || reading.now - mark->set > kLongestBacklog) mark = Mark{writer.last, writer.heard, reading.now};
  return number <= mark->number + longest_leap(writer, mark->heard, reading.now);
}

bool DatagramCheck::follows(const Guid& writer, std::int64_t number, const Reading& reading,
                            std::optional<std::int64_t> passed) {
  const Clock::time_point now = reading.now;
  const std::scoped_lock lock(mutex_);
  Writer* const known = find(writer);
  if (known == nullptr) return number <= kFirst && add(writer, Writer{{}, number, number, now, now, passed});
  Writer& entry = *known;
  const bool settles = now - entry.since <= kSettling && number <= kFirst;
  const bool follows_backlog = follows_stall(entry, number, reading);
  if (number > entry.last + longest_leap(entry, now) && !settles && !follows_backlog) return false;
  if (entry.passed) {
    if (number - std::max(*entry.passed, passed.value_or(0)) > kMostListed) return false;
    // The reader receives a stream as it comes: it does not fall behind because a key is never written again.
    const std::int64_t step = number - entry.last;
    if (step > 0 && step <= kLeap) *entry.passed += step;
  }
  if (passed) entry.passed = std::max(entry.passed.value_or(0), *passed);
  entry.last = std::max(entry.last, number);
  entry.heard = std::max(entry.heard, now);
  return true;
}

bool DatagramCheck::lists_too_many(const Guid& writer, std::int64_t first, std::int64_t last) {
  const std::scoped_lock lock(mutex_);
  std::int64_t passed = first - 1;
  if (const Writer* known = find(writer)) {
    last = std::max(last, known->last);
    passed = std::max(passed, known->passed.value_or(0));
  }
  return last - passed > kMostListed;
}

std::int64_t DatagramCheck::last_of(const Guid& writer) {
  const std::scoped_lock lock(mutex_);
  const Writer* known = find(writer);
  return known == nullptr ? 0 : known->last;
}

void DatagramCheck::forget(const Prefix& participant) {
  const std::scoped_lock lock(mutex_);
  writers_.erase(participant);
}

template <class Visit>
bool DatagramCheck::visit_submessages(std::span<const std::uint8_t> datagram, Visit visit) {
  std::size_t at = kHeader;
  while (at + 4 <= datagram.size()) {
    const std::uint8_t id = datagram[at];
    const std::uint8_t flags = datagram[at + 1];
    const bool little = (flags & flag::kLittleEndian) != 0;
    std::size_t length = little ? datagram[at + 2] | datagram[at + 3] << 8U : datagram[at + 2] << 8U | datagram[at + 3];
    at += 4;
    if (length == 0 && id != submessage::kPad && id != submessage::kInfoTimestamp)
      length = datagram.size() - at;  // up to the end
    if (length > datagram.size() - at) return false;
    if (visit(Submessage{id, flags, datagram.subspan(at, length)})) return true;
    at += (length + 3) & ~std::size_t{3};  // Fast DDS looks for the next one there
  }
  return true;
}

bool DatagramCheck::announces_departure(std::span<const std::uint8_t> datagram) {
  bool departs = false;
  visit_submessages(datagram, [&](const Submessage& submessage) { return departs = is_departure(submessage); });
  return departs;
}

bool DatagramCheck::is_departure(const Submessage& submessage) {
  if (submessage.id != submessage::kData) return false;
  Reader reader(submessage.body, (submessage.flags & flag::kLittleEndian) != 0);
  std::uint16_t to_parameters = 0;
  std::array<std::uint8_t, 4> writer{};
  if (!reader.skip(2) || !reader.read(to_parameters) || !reader.skip(4) || !reader.entity(writer.data())) return false;
  if (writer != kAnnouncer) return false;
  if ((submessage.flags & flag::kKeyOnly) != 0) return true;
  constexpr std::size_t kRead = 12;  // of the body, after the field that counts
  if ((submessage.flags & flag::kParameters) == 0 || to_parameters < kRead - 4U) return false;
  if (!reader.skip(to_parameters + 4U - kRead)) return false;
  std::uint16_t parameter = 0;
  std::uint16_t length = 0;
  while (reader.read(parameter) && reader.read(length) && parameter != parameter::kEnd) {
    if (parameter == parameter::kStatus) return true;  // announcements of the living have none
    if (!reader.skip(length)) break;
  }
  return false;
}

DatagramCheck::Protection DatagramCheck::protection(std::span<const std::uint8_t> datagram) {
  bool first = true;
  auto all = Protection::kNotNeeded;
  const bool whole = visit_submessages(datagram, [&](const Submessage& submessage) {
    // Fast DDS takes a message for an encrypted one when it begins like one.
    if (std::exchange(first, false) && submessage.id == submessage::kSecureMessage) return true;
    all = std::max(all, protection(submessage));
    return false;
  });
  return whole ? all : Protection::kForged;
}

DatagramCheck::Protection DatagramCheck::protection(const Submessage& submessage) {
  Reader reader(submessage.body, (submessage.flags & flag::kLittleEndian) != 0);
  std::array<std::uint8_t, 4> writer{};
  if (submessage.id >= submessage::kFirstOfVendors) return Protection::kNotNeeded;  // statistics of Fast DDS
  switch (submessage.id) {
    case submessage::kPad:
    case submessage::kInfoTimestamp:
    case submessage::kInfoSource:
    case submessage::kInfoReply4:
    case submessage::kInfoDestination:
    case submessage::kInfoReply:
    case submessage::kSecureBody:  // of a submessage that is encrypted, such as the keys that follow a handshake
    case submessage::kSecurePrefix:
    case submessage::kSecurePostfix:
      return Protection::kNotNeeded;
    case submessage::kData:
    case submessage::kDataFragment:
      if (!reader.skip(8)) return Protection::kForged;
      break;
    default:
      if (!reader.skip(4)) return Protection::kForged;
  }
  if (!reader.entity(writer.data())) return Protection::kForged;
  if (writer == kAnnouncer || writer == kAuthenticator) return Protection::kNotNeeded;
  return (writer.back() & kBuiltin) == kBuiltin ? Protection::kMissing : Protection::kForged;
}

template <class Visit>
bool DatagramCheck::visit_parameters(Reader& list, Visit visit) {
  std::uint16_t parameter = 0;
  std::uint16_t length = 0;
  while (list.read(parameter) && list.read(length)) {
    if (parameter == parameter::kEnd) return true;
    const std::size_t next = list.at() + ((length + 3U) & ~std::size_t{3});
    if (!visit(parameter, length) || !list.skip(next - list.at())) return false;
  }
  return false;
}

// Fast DDS updates and removes whatever participant or endpoint such a sample names.
bool DatagramCheck::speaks_of_itself(const Submessage& sample, const Sender& sender, Clock::time_point now) {
  Reader list(sample.body, (sample.flags & flag::kLittleEndian) != 0);
  std::uint16_t to_parameters = 0;
  if (!list.skip(2) || !list.read(to_parameters) || !list.skip(to_parameters)) return true;
  bool itself = true;
  const auto check = [&](std::uint16_t parameter, std::uint16_t length) {
    const bool names = parameter == parameter::kParticipantGuid || parameter == parameter::kEndpointGuid ||
                       parameter == parameter::kKeyHash;
    Prefix named{};
    if (!names || length < named.size() || !list.bytes(named.data(), named.size())) return true;
    itself = named == sender.participant || !refuse_source(named, sender.source, now);
    return itself;
  };
  if ((sample.flags & flag::kParameters) != 0 && !visit_parameters(list, check)) return itself;
  if ((sample.flags & (flag::kPayload | flag::kKeyOnly)) == 0) return itself;
  std::array<std::uint8_t, 4> encapsulation{};
  if (!list.bytes(encapsulation.data(), encapsulation.size())) return itself;
  list.set_order((encapsulation[1] & 1U) != 0);
  visit_parameters(list, check);
  return itself;
}

std::optional<std::string_view> DatagramCheck::refuse_source(const Prefix& participant, Address source,
                                                             Clock::time_point now) {
  std::optional<Prefix> forgotten;
  const auto why = sources_.refuse(participant, source, now, &forgotten);
  if (forgotten) forget(*forgotten);
  return why;
}

std::optional<std::string_view> DatagramCheck::refuse(std::span<const std::uint8_t> datagram, Address source,
                                                      Clock::time_point now,
                                                      std::optional<Clock::time_point> stall_ended) {
  if (datagram.size() < kHeader || std::memcmp(datagram.data(), "RTPS", 4) != 0) return std::nullopt;
  Sender sender{.participant = {}, .source = source};
  std::copy_n(datagram.data() + 8, sender.participant.size(), sender.participant.begin());
  std::optional<std::string_view> why = refuse_source(sender.participant, source, now);
  if (why) return why;
  const Reading reading{.now = now, .after_stall = stall_ended && now - *stall_ended <= kBacklog};
  const bool whole = visit_submessages(datagram, [&](const Submessage& submessage) {
    // Fast DDS aborts the process otherwise.
    const bool is_last = std::to_address(submessage.body.end()) == std::to_address(datagram.end());
    why = submessage.id == submessage::kStatistics ? unless(is_last, "statistics do not end their datagram")
                                                   : refuse(submessage, sender, reading);
    return why.has_value();
  });
  return whole ? why : "a submessage is longer than its datagram";
}

std::optional<std::string_view> DatagramCheck::refuse(const Submessage& submessage, const Sender& sender,
                                                      const Reading& reading) {
  Reader reader(submessage.body, (submessage.flags & flag::kLittleEndian) != 0);
  const Prefix& participant = sender.participant;
  Guid writer{.participant = participant};
  std::uint8_t* const entity = writer.entity.data();
  const auto endpoints = [&] { return reader.skip(4) && reader.entity(entity); };
  std::int64_t first = 0;
  std::int64_t last = 0;
  switch (submessage.id) {
    case submessage::kInfoSource: {  // signed messages name their sender again
      constexpr std::size_t kPrefixAt = 8;
      const bool own = submessage.body.size() >= kPrefixAt + participant.size() &&
                       std::equal(participant.begin(), participant.end(), submessage.body.begin() + kPrefixAt);
      return unless(own, "a submessage speaks for another participant");
    }
    case submessage::kData: {
      if (!reader.skip(4) || !endpoints() || !reader.number(first)) return "a sample is cut off";
      if (first < 1 || first > kLargestNumber) return "the number of a sample is out of range";
      const bool discovery = is(entity, kAnnouncer) || is(entity, kWriterAnnouncer) || is(entity, kReaderAnnouncer);
      if (discovery && !speaks_of_itself(submessage, sender, reading.now)) return "it announces another participant";
      return unless(follows(writer, first, reading), "the number of a sample leaps");
    }
    case submessage::kDataFragment: {
      std::uint32_t fragment = 0;
      std::uint16_t fragments = 0;
      std::uint16_t fragment_bytes = 0;
      std::uint32_t sample_bytes = 0;
      if (!reader.skip(4) || !endpoints() || !reader.number(first) || !reader.read(fragment) ||
          !reader.read(fragments) || !reader.read(fragment_bytes) || !reader.read(sample_bytes)) {
        return "a fragment is cut off";
      }
      if (first < 1 || first > kLargestNumber) return "the number of a sample is out of range";
      if (sample_bytes > kMostSampleBytes) return "a fragmented sample is larger than 4 MiB";
      if (is(entity, kAnnouncer)) return "an announcement comes in fragments";
      if (fragment < 1 || fragments < 1 || fragment_bytes < 1 || fragment_bytes > sample_bytes) {
        return "the numbers of a fragment are out of range";
      }
      const std::uint64_t all = (std::uint64_t{sample_bytes} + fragment_bytes - 1) / fragment_bytes;
      if (std::uint64_t{fragment} + fragments - 1 > all) return "a fragment is beyond the end of its sample";
      return unless(follows(writer, first, reading), "the number of a sample leaps");
    }
    case submessage::kHeartbeat: {
      if (!endpoints() || !reader.number(first) || !reader.number(last)) return "a heartbeat is cut off";
      if (first < 1 || last < first - 1 || last > kLargestNumber) return "the range of a heartbeat is out of range";
      if (lists_too_many(writer, first, last)) return "a heartbeat lists more than 1048576 samples";
      return unless(follows(writer, std::max(first, last), reading, first - 1), "the range of a heartbeat leaps");
    }
    case submessage::kGap: {
      if (!endpoints() || !reader.number(first) || !reader.number(last) || !reader.bitmap()) return "a gap is cut off";
      if (first < 1 || last < first || last > kLargestNumber) return "the range of a gap is out of range";
      if (last - std::max(first, last_of(writer) + 1) > kMostSkipped) return "a gap skips more than 131072 samples";
      if (lists_too_many(writer, first, last)) return "a gap begins more than 1048576 samples before the last one";
      return unless(follows(writer, last, reading), "the range of a gap leaps");
    }
    case submessage::kAckNack: {
      if (!reader.skip(8) || !reader.number(first) || !reader.bitmap()) return "an acknowledgement is cut off";
      return unless(first >= 0 && first <= kLargestNumber, "the number of an acknowledgement is out of range");
    }
    case submessage::kNackFragments: {
      std::uint32_t fragment = 0;
      if (!reader.skip(8) || !reader.number(first) || !reader.read(fragment) || !reader.bitmap()) {
        return "a request of fragments is cut off";
      }
      return unless(first >= 1 && first <= kLargestNumber && fragment >= 1, "a request of fragments is out of range");
    }
    case submessage::kHeartbeatFragments: {
      std::uint32_t fragment = 0;
      if (!endpoints() || !reader.number(first) || !reader.read(fragment)) return "a heartbeat is cut off";
      const bool usable = first >= 1 && first <= kLargestNumber && fragment <= kMostSampleBytes;
      return unless(usable, "a heartbeat of fragments is out of range");
    }
    default:
      return std::nullopt;
  }
}

}  // namespace hecaton::bus
