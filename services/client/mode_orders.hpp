#pragma once
/// Hold, resume and stop from several people at once, for services that pass orders on: the page, Foxglove, ROS 2.
///
/// No arm may move by an order that is older than a hold or a stop. So a stop or a hold withdraws the resumes of its
/// arms that wait, and interrupts one that is under way. A resume waits for stops and holds that were given before it.
/// Nothing delays a stop: stops, holds and resumes have a thread each, and all stops that wait are sent as one, as are
/// all holds.
///
/// The stop is an order over the network. It is not a safety function.

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <hecaton/client.hpp>

namespace hecaton::client {

enum class ModeOrder : std::uint8_t { kStop, kHold, kResume };

/// What became of an order.
struct ModeOutcome {
  bool done = false;
  std::string text;  ///< done: a warning, or nothing; otherwise why not, a sentence
};

/// All functions are thread-safe.
class ModeOrders {
 public:
  using Arms = std::vector<std::string>;  ///< empty: the cell
  /// Sends an order to the supervisor and waits for the reply, in a thread of this object. Throws hecaton::Error, also
  /// when `interrupted` is set.
  using Send = std::function<Receipt(ModeOrder order, const Arms& arms, const std::stop_token& interrupted)>;
  /// Called once for each order, in give() or in a thread of this object. It must not call this object.
  using Told = std::function<void(const ModeOutcome& outcome)>;

  static constexpr std::size_t kMostResumes = 32;   ///< that wait
  static constexpr std::size_t kMostAnswers = 256;  ///< of stops, and of holds, that wait for one reply

  explicit ModeOrders(Send send);
  /// Interrupts the orders under way, and answers those that wait.
  ~ModeOrders();
  ModeOrders(const ModeOrders&) = delete;
  ModeOrders& operator=(const ModeOrders&) = delete;

  /// `arms`: of the cell. `giver`: for withdraw().
  void give(ModeOrder order, const Arms& arms, std::uint64_t giver, Told told);
  /// Withdraws the resumes of this giver that wait: it is gone, and would not see what they do.
  void withdraw(std::uint64_t giver);

 private:
  /// Stops, or holds, that are sent as one.
  struct Restriction {
    bool whole_cell = false;
    std::set<std::string> arms;
    std::vector<Told> told;
    bool wanted = false;
    bool under_way = false;
  };
  struct Resume {
    Arms arms;
    std::uint64_t giver = 0;
    Told told;
  };
  struct Resuming {
    Arms arms;
    std::stop_source interruption;
    bool withdrawn = false;
  };

  [[nodiscard]] std::vector<Told> withdraw_resumes(const std::function<bool(const Resume&)>& concerned);
  void restrict(const std::stop_token& stop, ModeOrder order, Restriction& restriction);
  void resume(const std::stop_token& stop);
  [[nodiscard]] ModeOutcome send(ModeOrder order, const Arms& arms, const std::stop_token& interrupted) const;

  const Send send_;
  std::mutex mutex_;  // guards all that follows but the threads
  std::condition_variable_any changed_;
  Restriction stop_;
  Restriction hold_;
  std::deque<Resume> resumes_;
  std::optional<Resuming> resuming_;
  std::array<std::jthread, 3> threads_;  // last: they use all of it
};

}  // namespace hecaton::client
