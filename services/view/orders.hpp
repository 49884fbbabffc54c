#pragma once
/// Orders of pages: stop from every page, and all others from the one page that controls. It sends them through the
/// client library and logs each with the address of its page. page/src/orders.ts is the other side.
///
/// A page takes control with the token of the view, and keeps it until it releases it, is closed, or has been silent
/// for kControlLease. No other page can take it meanwhile. An order that waits when its page leaves is not sent, except
/// a hold or a stop. Hold, resume and stop do not wait for other orders (services/client/mode_orders.hpp).
///
/// A page names with its order the newest state that it has received. TCP keeps what a page sends while the network
/// stalls: an order that arrives more than kLongestDelay after the server sent that state is refused, but for a hold or
/// a stop. Both times are of the server's steady clock.
///
/// The stop is an order over the network. It is not a safety function.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <hecaton/client.hpp>

#include "services/client/connection.hpp"
#include "services/client/mode_orders.hpp"
#include "services/config/cell_file.hpp"
#include "services/view/goal_preview.hpp"
#include "services/view/json.hpp"
#include "services/view/token_file.hpp"
#include "services/view/web_server.hpp"

namespace hecaton::services {

/// The page sends a message each two seconds while it controls.
inline constexpr std::chrono::seconds kControlLease{10};

/// A state is sent each 33 ms, and a round trip over a slow network with a busy browser takes up to a second. A person
/// does not notice a second more.
inline constexpr std::chrono::seconds kLongestDelay{2};

struct OrderOptions {
  bool stop = true;        ///< pages without control may stop the cell
  std::string token;       ///< of the page that controls; empty: no page may control
  std::string refused_as;  ///< why it has no connection: a sentence; empty: no page shall give orders
};

/// All public functions are thread-safe.
class Orders {
 public:
  using Clock = std::chrono::steady_clock;
  using Replies = std::vector<std::pair<std::uint64_t, view::Json>>;  ///< number of a WebClient, message to it

  /// `file` must outlive it. `connection`: to the cell; null: every order is refused with `refused_as`.
  Orders(const config::CellFile& file, OrderOptions options, std::shared_ptr<client::Connection> connection);
  /// Interrupts the orders that wait for an answer.
  ~Orders();
  Orders(const Orders&) = delete;
  Orders& operator=(const Orders&) = delete;

  /// Takes a message of a page. Does not wait for the cell.
  void received(const WebClient& page, std::string_view message, Clock::time_point now = Clock::now());
  void left(const WebClient& page);
  /// Told what became of an order, once. The call must not call this object.
  using Told = std::function<void(bool done, const std::string& text)>;
  /// Hold, resume or stop of a program that has shown the token; `arms` empty: the cell. Does not wait for the cell.
  void give(const WebClient& program, client::ModeOrder order, const std::vector<std::string>& arms, Told told,
            Clock::time_point now = Clock::now());
  /// Ends the control of a page that is silent.
  void update(Clock::time_point now);

  /// The states that pages name have times since then.
  [[nodiscard]] Clock::time_point began() const { return began_; }
  /// What pages shall receive since the last call.
  [[nodiscard]] Replies take_replies();
  /// Which page controls and what pages may order, for all pages. Empty: unchanged since the last call.
  [[nodiscard]] std::optional<view::Json> take_control_change();
  /// The next take_control_change() is not empty.
  void announce_control();
  /// The newest preview that the page in control has asked for, once. Older ones that were not taken are dropped.
  [[nodiscard]] std::optional<PreviewQuestion> take_preview();

 private:
  /// Carries the order out and returns a sentence, or throws hecaton::Error.
  using Action = std::function<std::string(const Cell& cell, const Wait& wait)>;
  struct Sender {
    WebClient page;
    std::int64_t id = 0;  ///< that the page gave the order
    Told told = nullptr;  ///< of a program
  };
  struct Order {
    Sender sender;
    std::string op;
    std::string subject;  ///< for the log
    Action action;
    bool final = true;  ///< the first answer is the last
  };
  /// Messages that a page may send now.
  struct Bucket {
    double left;
    Clock::time_point at;
  };
  struct Controller {
    WebClient page;
    Clock::time_point heard;
  };

  void accept(const Sender& from, const view::Json& message, Clock::time_point now);
  void require_fresh(const view::Json& message, Clock::time_point now) const;
  void take_control(const Sender& from, const view::Json& message, Clock::time_point now);
  void end_control(const char* reason);
  void withdraw(const WebClient& page);
  [[nodiscard]] std::string controlled_elsewhere() const;  ///< the refusal, while a page controls
  void enqueue(Order order);
  void give_mode(const Sender& from, client::ModeOrder order, const std::vector<std::string>& arms);
  [[nodiscard]] Order order_of(const Sender& from, const std::string& op, const view::Json& message);
  [[nodiscard]] Action goal_of(const Sender& from, const view::Json& message, std::string& subject);
  [[nodiscard]] PreviewQuestion preview_of(const Sender& from, const view::Json& message) const;
  [[nodiscard]] std::vector<std::string> arms_in(const view::Json& message) const;
  [[nodiscard]] int arm_index_in(const view::Json& message) const;
  [[nodiscard]] const planner::Arm& arm_in(const view::Json& message) const;
  [[nodiscard]] bool controls(const WebClient& page) const;
  [[nodiscard]] bool may_send(const WebClient& page, Clock::time_point now);
  [[nodiscard]] Wait patience(const std::stop_token& stop) const;
  void work(const std::stop_token& stop);
  void carry_out(const std::stop_token& stop, const Order& order);
  void log(const Sender& from, const std::string& op, const std::string& subject, bool done, const std::string& text);
  /// Needs no lock.
  void answer(const Sender& to, const std::string& op, bool done, bool final, const std::string& text);

  const config::CellFile& file_;
  const OrderOptions options_;
  std::shared_ptr<client::Connection> connection_;
  const Clock::time_point began_ = Clock::now();
  std::mutex replies_mutex_;  // is locked last
  Replies replies_;
  std::mutex mutex_;  // guards all that follows but the threads
  std::deque<Order> waiting_;
  std::condition_variable_any arrived_;
  std::map<std::uint64_t, Bucket> buckets_;
  std::optional<Controller> controller_;
  std::optional<PreviewQuestion> preview_;
  bool control_changed_ = true;
  std::optional<client::ModeOrders> modes_;  // last, with the thread of all other orders: they use all of it
  std::jthread worker_;
};

}  // namespace hecaton::services
