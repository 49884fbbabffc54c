#pragma once
/// The connection of a process to a cell, in terms of messages. The public classes of <hecaton/client.hpp> and the
/// command line share it. Thread-safe. Its own thread receives all messages and runs the callbacks.

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
#include <idl/recorder.h>
#include <idl/supervisor.h>
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/runtime/latest_faults.hpp"

namespace hecaton::client {

using bus::Clock;

/// The end of a wait with this limit: now for 0, negative and NaN, in one year at most.
[[nodiscard]] Clock::time_point deadline_of(Seconds limit);

/// A participant in a domain.
struct Membership {
  bus::Participant participant;
  std::string where;                       ///< "DDS domain 42 under the name 'three_puma'"
  std::vector<std::string> supervisors{};  ///< nodes; empty: any
  std::vector<std::string> arms{};         ///< of the cell file; empty: not known
};

/// Joins the domain that `options` select. Throws InvalidArgument (cell file, domain, network interface).
[[nodiscard]] Membership join(const ConnectOptions& options);
/// Joins the domain of a cell file that is already loaded. `host`: whose operator's identity it uses in a secured cell;
/// empty: the first one of the keystore. Throws std::runtime_error with a sentence when the keys cannot be used.
[[nodiscard]] Membership join(const config::CellFile& file, int domain, const std::string& host = {});

/// `a` is a later status of the same arm than `b`.
[[nodiscard]] bool is_later(const msg::GoalStatus& a, const msg::GoalStatus& b);

/// A goal that was sent by a connection, whose mutex guards all but the constant members.
struct GoalRecord {
  msg::Goal goal;                         // constant
  Clock::time_point sent;                 // constant
  std::optional<msg::GoalStatus> status;  // newest
  Clock::time_point heard;                // when it arrived
  std::function<void(const Progress&)> callback;
  bool news = false;  // the callback has not got the newest status
};

class Connection {
 public:
  /// Creates the endpoints and starts the thread. Does not wait.
  [[nodiscard]] static std::shared_ptr<Connection> make(Membership membership);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Waits until a supervisor or a world service is found. Throws Unreachable, Interrupted.
  void wait_for_cell(const Wait& wait);

  /// Requests the status from the supervisor. Throws Unreachable, Interrupted; InvalidArgument when several cells
  /// answer.
  [[nodiscard]] msg::CellStatus status(const Wait& wait);
  /// Requests the status once. Empty without a reply within the limit.
  [[nodiscard]] std::optional<msg::CellStatus> poll_status(Seconds limit);
  /// Sends an order for the arms; an empty list: for the whole cell. First requests the status, to know that the
  /// leading supervisor is connected, and then writes the order once: a repetition could undo a later order. Throws
  /// like status().
  [[nodiscard]] msg::SupervisorReply order(msg::RequestKind kind, const std::vector<std::string>& arms,
                                           const Wait& wait);
  /// The same for a request whose client and number are not set yet.
  [[nodiscard]] msg::SupervisorReply order(msg::SupervisorRequest request, const Wait& wait);
  /// Sends an edit to the world service and waits for its reply. Throws Unreachable, NoAnswer, Interrupted;
  /// InvalidArgument when several cells answer.
  [[nodiscard]] msg::WorldEditReply edit(msg::WorldEditRequest request, const Wait& wait);

  /// Sends an order to the device of an arm and waits for the reply of its driver. Throws Unreachable, Interrupted.
  [[nodiscard]] msg::DeviceReply order_device(const std::string& arm, msg::DeviceOrder order, const Wait& wait);
  /// The same for a request whose client and number are not set yet.
  [[nodiscard]] msg::DeviceReply order_device(msg::DeviceRequest request, const Wait& wait);

  /// Orders all recorders to save what they keep. Returns the replies that have arrived soon after the first one.
  /// Throws Unreachable when no recorder replies, and Interrupted.
  [[nodiscard]] std::vector<msg::RecorderReply> order_recorders(const Wait& wait);

  /// Sets client, identifier, sequence number and stamp of the goal and writes it. Throws Unreachable.
  [[nodiscard]] std::shared_ptr<GoalRecord> send(msg::Goal goal);
  /// The two halves of send(), for a process that saves the identifier before any planner knows it. A prepared goal has
  /// client, identifier, sequence number and stamp. Throws InvalidArgument.
  [[nodiscard]] static Goal prepare(const std::shared_ptr<Connection>& connection, msg::Goal goal);
  /// Writes a prepared goal. Throws Unreachable.
  void send_prepared(const Goal& goal);
  /// A goal of an arm that another connection has sent: this one follows and cancels it, and sends nothing now.
  [[nodiscard]] static Goal adopt(const std::shared_ptr<Connection>& connection, const std::string& arm,
                                  const std::string& goal);
  void cancel(const GoalRecord& record);
  [[nodiscard]] std::optional<msg::GoalStatus> status_of(const GoalRecord& record) const;
  /// The same for programs, with its age.
  [[nodiscard]] std::optional<Progress> progress_of(const GoalRecord& record) const;
  void set_callback(const std::shared_ptr<GoalRecord>& record, std::function<void(const Progress&)> callback);
  /// Names of the arms: of the last status, else of the cell file. Empty: not known. Does not wait.
  [[nodiscard]] std::vector<std::string> arms() const;

  /// Goals that have not ended, but for those without an answer and without another owner.
  [[nodiscard]] std::size_t open_goals() const;
  /// Status of the arm's newest goal, of any client; never of a replaced goal.
  [[nodiscard]] std::optional<msg::GoalStatus> newest_goal(const std::string& arm);
  /// The same for programs, with its age.
  [[nodiscard]] std::optional<Progress> newest_progress(const std::string& arm);

  [[nodiscard]] std::vector<msg::Fault> faults();
  void set_fault_callback(std::function<void(const Fault&)> callback);

  template <class T>
  struct Heard {
    T value;
    Seconds age;
  };
  /// The newest state; waits for the first one. Empty when none arrived within the limit.
  [[nodiscard]] std::optional<Heard<msg::ArmState>> arm_state(const std::string& arm, const Wait& wait);
  /// The newest state of the arm's gripper and signals that `fits`; waits for the first one. Empty when none arrived
  /// within the limit: the arm then has neither, or its driver does not run.
  [[nodiscard]] std::optional<Heard<msg::ToolState>> tool_state(
      const std::string& arm, const Wait& wait, const std::function<bool(const msg::ToolState&)>& fits = {});
  struct Scene {
    Heard<msg::ObstacleStates> states;
    std::map<std::string, msg::ObstacleShapes> shapes;  ///< by name
  };
  [[nodiscard]] std::optional<Scene> scene(const Wait& wait);

  /// Evaluates `condition` in this thread and without a lock, now and after every received message, until it is true.
  /// False: time limit or stop request. Throws std::logic_error in a callback.
  bool wait_until(const std::function<bool()>& condition, const Wait& wait);

  /// Of this client; unique among all clients.
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] bus::Participant& participant() { return participant_; }
  /// A notification of it makes every wait evaluate its condition.
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
    Seconds again = kForever;          ///< the request is written again after this time without a reply
    Seconds others = Seconds::zero();  ///< time for more replies when several services read the request
  };
  explicit Connection(Membership membership);
  /// The replies; empty when none arrived within the limit. Throws Interrupted.
  template <class Request, class Reply>
  [[nodiscard]] std::vector<Reply> call(Channel<Request, Reply>& channel, Request request, const Wait& wait,
                                        const CallOptions& options);
  /// Calls `look` under the lock until its result has a value, and returns it.
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
  [[nodiscard]] std::shared_ptr<GoalRecord> record_of(msg::Goal goal);
  void write(const std::shared_ptr<GoalRecord>& record);

  std::string where_;
  std::vector<std::string> supervisors_;
  std::string name_;
  bus::Mailbox mailbox_;
  bus::Mailbox state_mailbox_;
  bus::Participant participant_;

  mutable std::mutex mutex_;  // guards all that follows
  std::condition_variable_any arrived_;
  std::uint64_t news_ = 0;  ///< counts arrivals
  std::uint64_t numbers_ = 0;
  std::vector<std::string> arms_;  ///< as arms()
  struct Endpoints {
    std::optional<Channel<msg::SupervisorRequest, msg::SupervisorReply>> supervisor;
    std::optional<Channel<msg::WorldEditRequest, msg::WorldEditReply>> world;
    std::optional<Channel<msg::DeviceRequest, msg::DeviceReply>> devices;
    std::optional<Channel<msg::RecorderRequest, msg::RecorderReply>> recorders;
    std::optional<GoalTopics> goals;
    std::optional<bus::Reader<msg::Fault>> faults;
    std::optional<bus::Reader<msg::ArmState>> arms;
    std::optional<bus::Reader<msg::ToolState>> tools;
    std::optional<SceneTopics> scene;
  } endpoints_;
  std::map<std::string, std::shared_ptr<GoalRecord>> goals_;  ///< that have not ended, by name
  struct Newest {
    msg::GoalStatus status;
    Clock::time_point heard;
  };
  std::map<std::string, Newest> newest_;  ///< by arm
  services::LatestFaults faults_;
  std::function<void(const Fault&)> on_fault_;
  std::vector<msg::Fault> fault_news_;  ///< for the callback
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace hecaton::client
