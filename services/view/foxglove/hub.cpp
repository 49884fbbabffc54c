#include "services/view/foxglove/hub.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <utility>

#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/ros2_types.hpp"
#include "services/ros2_messages/schema.hpp"

namespace hecaton::services::foxglove {
namespace {

constexpr std::size_t kMostAnswers = 256;
constexpr std::size_t kAnswerMemory = std::size_t{1} << 20;  // [byte]
constexpr std::size_t kMostAssets = 256;                     // asked for and not yet sent
constexpr std::size_t kMostCalls = 16;                       // without answer
constexpr std::string_view kCdr = "cdr";

struct Message {
  std::uint64_t unix_ns = 0;
  std::shared_ptr<const std::string> bytes;  ///< null: none
};

/// Service ids: 1 + 3 × (0 for the cell, 1 + index of the arm) + kind.
constexpr std::array<std::pair<OrderKind, const char*>, 3> kOrders{
    {{OrderKind::kHold, "hold"}, {OrderKind::kResume, "resume"}, {OrderKind::kStop, "stop"}}};

std::vector<Channel> channels_of(const HubOptions& options) {
  std::vector<Channel> channels;
  for (const HubChannel& channel : options.channels) {
    channels.push_back({static_cast<std::uint32_t>(channels.size() + 1), channel.topic, channel.type, channel.schema});
  }
  return channels;
}

std::vector<Service> services_of(const HubOptions& options) {
  std::vector<Service> services;
  const auto add = [&](const std::string& prefix) {
    for (const auto& [kind, word] : kOrders) {
      services.push_back({static_cast<std::uint32_t>(services.size() + 1), prefix + word, "std_srvs/srv/Trigger",
                          ros2::message_definition("std_srvs/srv/Trigger_Request"),
                          ros2::message_definition("std_srvs/srv/Trigger_Response")});
    }
  };
  add(options.ns + "/hecaton/");
  for (const std::string& arm : options.arms) add(options.ns + "/" + arm + "/");
  return services;
}

std::string session_id() {
  const auto since = std::chrono::system_clock::now().time_since_epoch();
  return std::to_string(std::chrono::duration_cast<std::chrono::nanoseconds>(since).count());
}

/// To an order.
struct Answer {
  std::uint64_t client;
  std::uint32_t service;
  std::uint32_t call;
  OrderResult result;
};

}  // namespace

/// Of an asset that a client has asked for. The mutex of the hub guards it.
struct AssetReading {
  std::uint32_t request = 0;
  bool done = false;
  std::shared_ptr<const std::string> content;  // null: there is none
};

/// What a session keeps. The mutex of the hub guards all of it.
struct Client {
  std::uint64_t number = 0;
  std::function<void()> wake;
  WebClient who;
  bool may_order = false;
  std::vector<std::optional<std::uint32_t>> subscriptions;  // by channel
  std::vector<Message> waiting;                             // by channel
  std::map<std::uint32_t, std::size_t> channel_of;          // by subscription
  std::optional<std::uint64_t> time;
  std::deque<WebFrame> answers;
  std::size_t answer_memory = 0;
  std::deque<FetchAsset> assets;
  std::size_t calls = 0;  // without answer
  std::size_t turn = 0;   // channel to look at next
  bool asset_next = true;
  std::optional<std::string> end;
};

struct Hub::State {
  std::mutex mutex;  // guards all members but the next two
  std::atomic<int> client_count{0};
  std::atomic<std::uint64_t> skipped{0};
  std::map<std::uint64_t, Client*> clients;
  std::uint64_t numbers = 0;
  std::vector<int> subscribers;  // by channel
  std::vector<Message> latched;  // by channel
  std::vector<Answer> answers;   // of orders
};

class Hub::Session : public WebSession {
 public:
  Session(std::shared_ptr<Hub> hub, WebOpening opening);
  ~Session() override;

  void received(std::string_view message, bool text) override;
  [[nodiscard]] std::optional<WebFrame> next() override;
  [[nodiscard]] std::optional<std::string> end() const override;

 private:
  // All with the mutex locked.
  void carry_out(const Malformed& request);
  void carry_out(const Unsupported& request);
  void carry_out(const Subscribe& request);
  void carry_out(const Unsubscribe& request);
  void carry_out(const GetParameters& request);
  void carry_out(const SetParameters& request);
  void carry_out(const WatchParameters&) {}
  void carry_out(const FetchAsset& request);
  void carry_out(const CallService& request);
  [[nodiscard]] Json values(const std::vector<std::string>& names) const;
  void subscribe(const Subscribe::Subscription& wish);
  void unsubscribe(std::size_t channel);
  void warn(const std::string& sentence) { send(status(Level::kWarning, sentence), true); }
  void send(std::string answer, bool text) { Hub::send(client_, std::move(answer), text); }
  [[nodiscard]] std::optional<WebFrame> waiting_message();
  [[nodiscard]] std::optional<WebFrame> asset_frame();

  /// Begins to read the next asset, unless another one is being read. Locks the mutex.
  void read_asset();

  std::shared_ptr<Hub> hub_;
  Client client_;
  std::function<bool(std::function<void()> job)> background_;
  std::shared_ptr<AssetReading> reading_;  // empty: none
  std::function<void()> order_;            // to carry out without the mutex
};

// --- Hub

Hub::Hub(HubOptions options) : options_(std::move(options)), state_(std::make_shared<State>()) {
  state_->subscribers.resize(options_.channels.size());
  state_->latched.resize(options_.channels.size());
  ServerInfo info = options_.info;
  info.capabilities = {"time", "parameters", "assets"};
  info.session = session_id();
  greeting_.info = server_info(info);
  info.capabilities.emplace_back("services");
  info.encodings = {std::string(kCdr)};
  greeting_.info_with_services = server_info(info);
  greeting_.services = advertise_services(services_of(options_));
  greeting_.channels = advertise(channels_of(options_));
}

Hub::~Hub() = default;

bool Hub::wanted(std::size_t channel) const {
  const std::scoped_lock lock(state_->mutex);
  return state_->subscribers[channel] > 0;
}

int Hub::clients() const {
  return state_->client_count;
}

std::uint64_t Hub::skipped() const {
  return state_->skipped;
}

void Hub::publish(std::size_t channel, std::uint64_t unix_ns, std::string message) {
  const Message newest{unix_ns, std::make_shared<const std::string>(std::move(message))};
  const std::scoped_lock lock(state_->mutex);
  if (options_.channels[channel].latched) state_->latched[channel] = newest;
  for (const auto& [number, client] : state_->clients) {
    if (!client->subscriptions[channel] || client->end) continue;
    if (client->waiting[channel].bytes) ++state_->skipped;
    client->waiting[channel] = newest;
    client->wake();
  }
}

void Hub::publish_time(std::uint64_t unix_ns) {
  const std::scoped_lock lock(state_->mutex);
  for (const auto& [number, client] : state_->clients) {
    if (client->end) continue;
    client->time = unix_ns;
    client->wake();
  }
}

void Hub::deliver_answers() {
  const std::scoped_lock lock(state_->mutex);
  for (const Answer& answer : std::exchange(state_->answers, {})) {
    const auto found = state_->clients.find(answer.client);
    if (found == state_->clients.end()) continue;
    Client& client = *found->second;
    --client.calls;
    const ros2::Bytes bytes = ros2::encoded(ros2::TriggerResponse{answer.result.done, answer.result.text});
    send(client,
         service_response(answer.service, answer.call, kCdr,
                          {reinterpret_cast<const char*>(bytes.data()), bytes.size()}),
         false);
    client.wake();
  }
}

std::unique_ptr<WebSession> Hub::open(WebOpening opening) {
  return std::make_unique<Session>(shared_from_this(), std::move(opening));
}

void Hub::send(Client& client, std::string answer, bool text) {
  if (client.end) return;
  client.answer_memory += answer.size();
  if (client.answers.size() >= kMostAnswers || client.answer_memory > kAnswerMemory) {
    return finish(client, "more than 256 answers or 1 MiB of them wait unread");
  }
  client.answers.push_back({std::move(answer), nullptr, text});
}

void Hub::finish(Client& client, const std::string& reason) {
  if (client.end) return;
  client.answers.clear();
  client.assets.clear();
  client.time.reset();
  std::fill(client.waiting.begin(), client.waiting.end(), Message{});
  client.answers.push_back({status(Level::kError, reason + "; the server closes the connection"), nullptr, true});
  client.end = reason;
}

// --- Session

Hub::Session::Session(std::shared_ptr<Hub> hub, WebOpening opening) : hub_(std::move(hub)) {
  const HubOptions& options = hub_->options_;
  client_.wake = std::move(opening.wake);
  client_.who = std::move(opening.client);
  background_ = std::move(opening.background);
  client_.may_order = options.orders.accepts && options.orders.accepts(opening.token);
  client_.subscriptions.resize(options.channels.size());
  client_.waiting.resize(options.channels.size());
  // The greeting is as long as the cell has it, and no answer that is counted.
  const auto greet = [&](std::string text) { client_.answers.push_back({std::move(text), nullptr, true}); };
  greet(client_.may_order ? hub_->greeting_.info_with_services : hub_->greeting_.info);
  greet(hub_->greeting_.channels);
  if (client_.may_order) greet(hub_->greeting_.services);
  if (!client_.may_order && !opening.token.empty()) {
    warn("the token in the address is not that of this view, or it takes no orders: this client only watches");
  }
  const std::scoped_lock lock(hub_->state_->mutex);
  client_.number = ++hub_->state_->numbers;
  hub_->state_->clients.emplace(client_.number, &client_);
  ++hub_->state_->client_count;
}

Hub::Session::~Session() {
  const std::scoped_lock lock(hub_->state_->mutex);
  for (std::size_t channel = 0; channel < client_.subscriptions.size(); ++channel) unsubscribe(channel);
  hub_->state_->clients.erase(client_.number);
  --hub_->state_->client_count;
}

void Hub::Session::received(std::string_view message, bool text) {
  const Request request = text ? decode_text(message) : decode_binary(message);
  {
    const std::scoped_lock lock(hub_->state_->mutex);
    if (client_.end) return;
    std::visit([this](const auto& asked) { carry_out(asked); }, request);
  }
  if (order_) std::exchange(order_, nullptr)();
}

std::optional<std::string> Hub::Session::end() const {
  const std::scoped_lock lock(hub_->state_->mutex);
  return client_.end;
}

std::optional<WebFrame> Hub::Session::next() {
  read_asset();
  const std::scoped_lock lock(hub_->state_->mutex);
  if (!client_.answers.empty()) {
    WebFrame frame = std::move(client_.answers.front());
    client_.answers.pop_front();
    client_.answer_memory -= std::min(client_.answer_memory, frame.head.size());
    return frame;
  }
  if (client_.time) return WebFrame{time(*std::exchange(client_.time, std::nullopt)), nullptr, false};
  if (client_.end) return std::nullopt;
  // Assets and messages take turns.
  if (client_.asset_next) {
    if (auto asset = asset_frame()) return asset;
  }
  if (auto message = waiting_message()) return message;
  return asset_frame();
}

void Hub::Session::read_asset() {
  std::function<void()> job;
  {
    const std::scoped_lock lock(hub_->state_->mutex);
    if (reading_ || client_.assets.empty()) return;
    FetchAsset asked = std::move(client_.assets.front());
    client_.assets.pop_front();
    reading_ = std::make_shared<AssetReading>();
    reading_->request = asked.request;
    job = [hub = hub_, reading = reading_, uri = std::move(asked.uri), wake = client_.wake] {
      std::shared_ptr<const std::string> content;
      try {
        if (hub->options_.asset) content = hub->options_.asset(uri);
      } catch (const std::exception&) {
        // as one that is gone: it may be too large for the memory
      }
      {
        const std::scoped_lock locked(hub->state_->mutex);
        reading->content = std::move(content);
        reading->done = true;
      }
      wake();
    };
  }
  if (!background_) return job();
  if (background_(std::move(job))) return;
  const std::scoped_lock lock(hub_->state_->mutex);
  reading_->done = true;  // as one that is gone: the client asks again
}

/// The asset that was read; empty: none.
std::optional<WebFrame> Hub::Session::asset_frame() {
  if (!reading_ || !reading_->done) return std::nullopt;
  client_.asset_next = false;
  const auto read = std::exchange(reading_, nullptr);
  if (read->content) return WebFrame{asset(read->request), read->content, false};
  return WebFrame{asset_failure(read->request,
                                "the cell's robot descriptions name no such file, or it is gone, or too many files "
                                "wait to be read"),
                  nullptr, false};
}

std::optional<WebFrame> Hub::Session::waiting_message() {
  const std::size_t count = client_.waiting.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t channel = (client_.turn + i) % count;
    if (!client_.waiting[channel].bytes) continue;
    client_.turn = channel + 1;
    client_.asset_next = true;
    Message message = std::exchange(client_.waiting[channel], Message{});
    return WebFrame{message_data(*client_.subscriptions[channel], message.unix_ns), std::move(message.bytes), false};
  }
  return std::nullopt;
}

void Hub::Session::carry_out(const Malformed& request) {
  Hub::finish(client_, request.reason);
}

void Hub::Session::carry_out(const Unsupported& request) {
  warn("this server does not offer '" + request.operation + "'");
}

void Hub::Session::carry_out(const Subscribe& request) {
  for (const auto& wish : request.subscriptions) subscribe(wish);
}

void Hub::Session::subscribe(const Subscribe::Subscription& wish) {
  const std::string name = "subscription " + std::to_string(wish.id);
  if (wish.channel == 0 || wish.channel > client_.subscriptions.size()) {
    return warn(name + ": there is no channel " + std::to_string(wish.channel));
  }
  const std::size_t channel = wish.channel - 1;
  if (client_.subscriptions[channel]) {
    return warn(name + ": channel " + std::to_string(wish.channel) + " has subscription " +
                std::to_string(*client_.subscriptions[channel]) + " already");
  }
  if (!client_.channel_of.try_emplace(wish.id, channel).second) return warn(name + " is in use");
  client_.subscriptions[channel] = wish.id;
  ++hub_->state_->subscribers[channel];
  client_.waiting[channel] = hub_->state_->latched[channel];
}

void Hub::Session::unsubscribe(std::size_t channel) {
  if (!client_.subscriptions[channel]) return;
  client_.channel_of.erase(*client_.subscriptions[channel]);
  client_.subscriptions[channel].reset();
  client_.waiting[channel] = {};
  --hub_->state_->subscribers[channel];
}

void Hub::Session::carry_out(const Unsubscribe& request) {
  for (const std::uint32_t id : request.ids) {
    const auto found = client_.channel_of.find(id);
    if (found == client_.channel_of.end()) {
      warn("there is no subscription " + std::to_string(id));
    } else {
      unsubscribe(found->second);
    }
  }
}

Json Hub::Session::values(const std::vector<std::string>& names) const {
  const Json& all = hub_->options_.parameters;
  if (names.empty()) return all;
  Json some = Json::array();
  for (const Json& parameter : all) {
    const auto& name = parameter.at("name").get_ref<const std::string&>();
    if (std::find(names.begin(), names.end(), name) != names.end()) some.push_back(parameter);
  }
  return some;
}

void Hub::Session::carry_out(const GetParameters& request) {
  send(parameter_values(values(request.names), request.id), true);
}

void Hub::Session::carry_out(const SetParameters& request) {
  warn("parameters show settings of the cell file and cannot be set here");
  if (!request.names.empty() && request.id) send(parameter_values(values(request.names), request.id), true);
}

void Hub::Session::carry_out(const FetchAsset& request) {
  if (client_.assets.size() >= kMostAssets) {
    return Hub::finish(client_, "more than 256 requests for assets wait for an answer");
  }
  client_.assets.push_back(request);
}

void Hub::Session::carry_out(const CallService& request) {
  const HubOptions& options = hub_->options_;
  const auto refuse = [&](const std::string& reason) {
    send(service_call_failure(request.service, request.call, reason), true);
  };
  if (!client_.may_order) return refuse("this client gives no orders: its address has no token of the view");
  if (request.service == 0 || request.service > kOrders.size() * (1 + options.arms.size())) {
    return refuse("there is no such service");
  }
  if (request.encoding != kCdr) return refuse("the encoding of a call must be 'cdr'");
  if (client_.calls >= kMostCalls) return refuse("16 calls wait for an answer already");
  ++client_.calls;
  const std::size_t index = request.service - 1;
  const std::size_t subject = index / kOrders.size();
  Order order{kOrders[index % kOrders.size()].first, subject == 0 ? std::string() : options.arms[subject - 1],
              client_.who};
  std::function<void(OrderResult)> answer = [state = hub_->state_, client = client_.number, service = request.service,
                                             call = request.call](OrderResult result) {
    const std::scoped_lock lock(state->mutex);
    state->answers.push_back({client, service, call, std::move(result)});
  };
  order_ = [hub = hub_, order = std::move(order), answer = std::move(answer)] {
    hub->options_.orders.carry_out(order, answer);
  };
}

}  // namespace hecaton::services::foxglove
