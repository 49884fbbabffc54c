#pragma once
/// One process's connection to a cell, in messages: what the public classes of <hecaton/client.hpp> and the command
/// line share. Thread-safe. A thread of its own takes whatever arrives and runs the callbacks.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <hecaton/client.hpp>
#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/supervisor.h>
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/told_faults.hpp"

namespace hecaton::client {

using bus::Clock;

/// When a wait ends. A limit that is infinite ends in a year.
[[nodiscard]] Clock::time_point deadline_of(Seconds limit);

/// A place in a domain, and its name in sentences.
struct Membership {
  bus::Participant participant;
  std::string where;                       ///< "DDS domain 42 under the name 'three_puma'"
  std::vector<std::string> supervisors{};  ///< nodes; empty: whatever they are called
};

/// Throws InvalidArgument: the cell file, the domain, the interface.
[[nodiscard]] Membership join(const ConnectOptions& options);
/// Joins the cell of a file that was read already.
[[nodiscard]] Membership join(const config::CellFile& file, int domain);

/// `a` says something later of its arm than `b`.
[[nodiscard]] bool is_later(const msg::GoalStatus& a, const msg::GoalStatus& b);

/// A goal that was given through a connection. Guarded by its mutex but for what never changes.
struct GoalRecord {
  msg::Goal goal;                         // never changes
  Clock::time_point sent;                 // never changes
  std::optional<msg::GoalStatus> status;  // newest
  std::function<void(const Progress&)> callback;
  bool news = false;  // for the callback
};

class Connection {
 public:
  /// Joins; waits for nothing.
  [[nodiscard]] static std::shared_ptr<Connection> make(Membership membership);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Waits until a supervisor or a world is found. Throws Unreachable, Interrupted.
  void wait_for_cell(const Wait& wait);

  /// The supervisor's answer. Throws Unreachable, Interrupted; InvalidArgument when several cells answer.
  [[nodiscard]] msg::CellStatus status(const Wait& wait);
  /// Nothing when there is no answer in time.
  [[nodiscard]] std::optional<msg::CellStatus> poll_status(Seconds limit);
  /// Orders for the arms, or for the whole cell when there are none. Written once, when the supervisor that leads is
  /// known to hear it: written again it could undo a later order. Throws like status().
  [[nodiscard]] msg::SupervisorReply order(msg::RequestKind kind, const std::vector<std::string>& arms,
                                           const Wait& wait);
  /// Throws Unreachable, NoAnswer, Interrupted; InvalidArgument when several cells may answer.
  [[nodiscard]] msg::WorldEditReply edit(msg::WorldEditRequest request, const Wait& wait);

  [[nodiscard]] std::shared_ptr<GoalRecord> send(msg::Goal goal);
  void cancel(const GoalRecord& record);
  [[nodiscard]] std::optional<msg::GoalStatus> status_of(const GoalRecord& record) const;
  void set_callback(const std::shared_ptr<GoalRecord>& record, std::function<void(const Progress&)> callback);
  /// Newest of the arm, given by any client, but for goals that a later one has replaced.
  [[nodiscard]] std::optional<msg::GoalStatus> newest_goal(const std::string& arm);

  [[nodiscard]] std::vector<msg::Fault> faults();
  void set_fault_callback(std::function<void(const Fault&)> callback);

  template <class T>
  struct Heard {
    T value;
    Seconds age;
  };
  /// Newest; waits for the first. Nothing: none came in time.
  [[nodiscard]] std::optional<Heard<msg::ArmState>> arm_state(const std::string& arm, const Wait& wait);
  struct Scene {
    Heard<msg::ObstacleStates> states;
    std::map<std::string, msg::ObstacleShapes> shapes;  ///< by name
  };
  [[nodiscard]] std::optional<Scene> scene(const Wait& wait);

  /// Evaluates `condition`, in this thread and without a lock, now and after everything that arrives.
  bool wait_until(const std::function<bool()>& condition, const Wait& wait);

  /// Unique among all clients that run.
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] bus::Participant& participant() { return participant_; }
  /// A notification on it makes every wait evaluate its condition.
  [[nodiscard]] bus::Mailbox& mailbox() { return mailbox_; }

 private:
  /// A request topic and its reply topic.
  template <class Request, class Reply>
  struct Channel {
    Channel(bus::Participant& participant, bus::Mailbox& mailbox)
        : requests(participant, told(mailbox)), replies(participant, &mailbox) {}
    static bus::WriterOptions told(bus::Mailbox& mailbox) {
      bus::WriterOptions options;
      options.mailbox = &mailbox;
      return options;
    }
    bus::Writer<Request> requests;
    bus::Reader<Reply> replies;
    std::map<std::uint64_t, std::vector<Reply>> awaited;  ///< by request
  };
  struct GoalTopics {
    explicit GoalTopics(Connection& owner);
    bus::Writer<msg::Goal> goals;
    bus::Reader<msg::GoalStatus> statuses;
  };
  struct SceneTopics {
    SceneTopics(bus::Participant& participant, bus::Mailbox& mailbox)
        : shapes(participant, &mailbox), states(participant, &mailbox) {}
    bus::Reader<msg::ObstacleShapes> shapes;
    bus::Reader<msg::ObstacleStates> states;
  };
  using Lock = std::unique_lock<std::mutex>;

  struct CallOptions {
    Seconds again = kForever;          ///< without an answer for so long the request is written once more
    Seconds others = Seconds::zero();  ///< how long to listen for more answers when several services read it
  };
  explicit Connection(Membership membership);
  /// The answers that came; none within the limit. Throws Interrupted.
  template <class Request, class Reply>
  [[nodiscard]] std::vector<Reply> call(Channel<Request, Reply>& channel, Request request, const Wait& wait,
                                        const CallOptions& options);
  /// What `look` returns under the lock, as soon as it is something.
  template <class Look>
  [[nodiscard]] auto wait_for_state(const Look& look, const Wait& wait);
  template <class Request, class Reply>
  void take(Channel<Request, Reply>& channel);
  [[nodiscard]] Channel<msg::WorldEditRequest, msg::WorldEditReply>& world();
  [[nodiscard]] GoalTopics& goal_topics();
  [[nodiscard]] bus::Reader<msg::Fault>& fault_topic();
  [[nodiscard]] Unreachable unreachable() const;
  void note(const msg::CellStatus& status);
  void note(const msg::GoalStatus& status);
  void listen();
  void run();
  void refuse_in_callback() const;

  std::string where_;
  std::vector<std::string> supervisors_;
  std::string name_;
  bus::Mailbox mailbox_;
  bus::Mailbox state_mailbox_;
  bus::Participant participant_;

  mutable std::mutex mutex_;  // guards all that follows
  std::condition_variable_any arrived_;
  std::uint64_t news_ = 0;  ///< counts what has arrived
  std::uint64_t numbers_ = 0;
  struct Endpoints {
    std::optional<Channel<msg::SupervisorRequest, msg::SupervisorReply>> supervisor;
    std::optional<Channel<msg::WorldEditRequest, msg::WorldEditReply>> world;
    std::optional<GoalTopics> goals;
    std::optional<bus::Reader<msg::Fault>> faults;
    std::optional<bus::Reader<msg::ArmState>> arms;
    std::optional<SceneTopics> scene;
  } endpoints_;
  std::map<std::string, std::shared_ptr<GoalRecord>> goals_;  ///< that have not ended, by name
  std::map<std::string, msg::GoalStatus> newest_;             ///< by arm
  services::ToldFaults faults_;
  std::function<void(const Fault&)> on_fault_;
  std::vector<msg::Fault> fault_news_;  ///< for the callback
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace hecaton::client
