#include "services/bus/permission_log.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>
#include <mutex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <fastdds/dds/log/Log.hpp>

namespace hecaton::bus {
namespace {

namespace dds = eprosima::fastdds::dds;

struct Phrase {
  std::string_view begin;  ///< of the entry; the GUID follows
  std::string_view text;
};
// SecurityManager.cpp of Fast DDS 2.9 and 3.1.
constexpr std::array<Phrase, 5> kPhrases = {{
    {"Error checking create remote writer ", "its keys do not allow this writer"},
    {"Error checking create remote reader ", "its keys do not allow this reader"},
    {"Error checking remote participant ", "its keys do not allow it to join"},
    {"Error validating remote permissions for ", "its permissions are not valid"},
    {"Not receive remote permissions of participant ", "it has no permissions"},
}};

/// "01.0f.….03|0.0.1.3": the prefix, and the endpoint. Removes what it reads.
std::optional<EndpointId> read_guid(std::string_view& text) {
  EndpointId id;
  for (std::size_t i = 0; i < id.bytes.size(); ++i) {
    if (i > 0) {
      if (text.empty() || text.front() != (i == 12 ? '|' : '.')) return std::nullopt;
      text.remove_prefix(1);
    }
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id.bytes[i], 16);
    if (error != std::errc()) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return id;
}

class Logs {
 public:
  /// True for the first one of the process.
  bool add(const std::shared_ptr<RefusalLog>& log) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(logs_, [](const auto& one) { return one.expired(); });
    logs_.push_back(log);
    return !std::exchange(registered_, true);
  }
  void note(const Refused& refused) {
    const std::scoped_lock lock(mutex_);
    for (const auto& one : logs_) {
      if (const auto log = one.lock()) log->note(refused);
    }
  }

 private:
  std::mutex mutex_;
  std::vector<std::weak_ptr<RefusalLog>> logs_;
  bool registered_ = false;
};

/// Never destroyed: the thread of the log may end after other global objects.
Logs& logs() {
  static auto* all = new Logs;
  return *all;
}

class Consumer : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    if (entry.kind != dds::Log::Kind::Error) return;
    auto refused = refused_permissions(entry.message);
    if (!refused) return;
    refused->last = Clock::now();
    logs().note(*refused);
  }
};

}  // namespace

std::optional<Refused> refused_permissions(std::string_view message) {
  for (const Phrase& phrase : kPhrases) {
    if (message.substr(0, phrase.begin.size()) != phrase.begin) continue;
    message.remove_prefix(phrase.begin.size());
    while (!message.empty() && message.front() == ' ') message.remove_prefix(1);
    const auto sender = read_guid(message);
    if (!sender) return std::nullopt;
    Refused refused;
    refused.sender = *sender;
    // A fault names participants, as for datagrams.
    std::fill(std::next(refused.sender.bytes.begin(), 12), refused.sender.bytes.end(), std::uint8_t{0});
    refused.text = phrase.text;
    const auto begin = message.find('(');
    const auto end = std::min(message.rfind(')'), message.find(" (./"));  // without its place in Fast DDS
    if (begin != std::string_view::npos && end != std::string_view::npos && end > begin + 1) {
      refused.text.append(": ").append(message.substr(begin + 1, end - begin - 1));
    }
    return refused;
  }
  return std::nullopt;
}

void note_refused_permissions(const std::shared_ptr<RefusalLog>& log) {
  if (logs().add(log)) dds::Log::RegisterConsumer(std::make_unique<Consumer>());
}

}  // namespace hecaton::bus
