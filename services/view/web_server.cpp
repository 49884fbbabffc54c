#include "services/view/web_server.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <exception>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/core/detect_ssl.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "services/view/file_thread.hpp"
#include "services/view/web_pace.hpp"
#include "services/view/web_request.hpp"
#include "services/view/web_stream.hpp"

namespace hecaton::services {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Error = beast::error_code;
using Response = http::response<http::string_body>;
using Message = std::shared_ptr<const std::string>;
using Messages = std::array<Message, kChannels>;

constexpr const char* kLivePath = "/live";
constexpr std::size_t kLongestRequest = 16 * 1024;  // [byte]
constexpr std::size_t kLongestMessage = 4096;       // from a client [byte]
constexpr std::size_t kMostUnread = 64;             // messages to one client
constexpr std::chrono::seconds kRequestTimeout{30};
/// Of a client that answers no ping. A browser on a busy machine reads for long what it has received before.
constexpr std::chrono::seconds kSilenceTimeout{120};
/// What the kernel holds for a slow client is old when it arrives [byte].
constexpr int kSendBuffer = 64 * 1024;

Response answer(const Request& request, http::status status, std::string body) {
  Response response(status, request.version());
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  response.body() = std::move(body);
  return response;
}

Response moved(const Request& request, http::status status, const std::string& address) {
  Response response = answer(request, status, "The page is at " + address + "\n");
  response.set(http::field::location, address);
  return response;
}

/// State that the thread of the server owns, unless a member says otherwise.
struct Shared;

/// Counts one connection of an address, also as a WebSocket.
class Place {
 public:
  Place(Shared& shared, std::string address);
  ~Place();
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

 private:
  Shared& shared_;
  const std::string address_;
};

/// One WebSocket. It keeps itself alive as long as an operation is under way.
class LiveClient : public std::enable_shared_from_this<LiveClient> {
 public:
  LiveClient(WebStream stream, std::unique_ptr<Place> place, Shared& shared);
  void accept(Request request);
  void offer(std::size_t channel, const Message& message);
  void send(const Message& message);
  [[nodiscard]] std::uint64_t number() const { return who_.number; }
  void close() { beast::get_lowest_layer(stream_).close(); }

 private:
  void read();
  void write();
  void write(Message message);
  void leave();

  websocket::stream<WebStream> stream_;
  std::unique_ptr<Place> place_;
  asio::steady_timer pause_{stream_.get_executor()};
  WebPace pace_;
  Shared& shared_;
  WebClient who_;
  Request request_;
  beast::flat_buffer incoming_;
  Messages pending_;
  std::deque<Message> unsent_;  // to this client alone
  Message sending_;
  bool writing_ = false;
};

/// One WebSocket of the sub-protocol. It keeps itself alive as long as an operation is under way.
class ProtocolClient : public std::enable_shared_from_this<ProtocolClient> {
 public:
  ProtocolClient(WebStream stream, std::unique_ptr<Place> place, Shared& shared);
  void accept(Request request, const std::string& name);
  void close() { beast::get_lowest_layer(stream_).close(); }

 private:
  void open();
  void read();
  void write();
  void end(const std::string& reason);
  void leave();

  websocket::stream<WebStream> stream_;
  std::unique_ptr<Place> place_;
  asio::steady_timer pause_{stream_.get_executor()};
  WebPace pace_;
  Shared& shared_;
  WebClient who_;
  Request request_;
  beast::flat_buffer incoming_;
  WebFrame sending_;
  bool writing_ = false;
  bool ending_ = false;
  std::unique_ptr<WebSession> session_;
};

/// One HTTP connection, until it becomes a WebSocket.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(tcp::socket socket, std::string address, Shared& shared);
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;
  void begin();

 private:
  void begin_tls();
  void read();
  void respond();
  void read_content();
  void complete();
  void write();
  bool upgrade();
  [[nodiscard]] Response response();
  [[nodiscard]] Response file(std::string_view target);
  [[nodiscard]] bool is_admitted() const;
  [[nodiscard]] bool shows_token() const;
  /// It counts as admitted from now on.
  void admit();
  void close() { stream_.next_layer().close(); }

  WebStream stream_;
  std::unique_ptr<Place> place_;
  asio::steady_timer pause_{stream_.get_executor()};
  WebPace pace_;
  Shared& shared_;
  const std::string address_;
  bool unadmitted_ = true;
  bool unencrypted_ = false;  // where only TLS is spoken
  beast::flat_buffer incoming_;
  std::optional<http::request_parser<http::string_body>> parser_;
  Request request_;
  Response response_;
  std::function<std::optional<std::string>()> unread_;  // the body of the response; empty: it has its body
};

struct Shared {
  WebServerOptions options;
  std::uint16_t port = 0;
  FileThread* files = nullptr;
  std::optional<asio::ssl::context> tls;  // empty: connections are not encrypted
  Messages newest;
  std::set<std::shared_ptr<LiveClient>> clients;
  std::set<std::shared_ptr<ProtocolClient>> protocol_clients;
  int connections = 0;                    // HTTP and WebSockets
  std::map<std::string, int> places;      // the same by address
  std::map<std::string, int> unadmitted;  // of these, by address: not admitted yet
  std::uint64_t numbers = 0;              // given to WebSockets
  std::atomic<int> client_count{0};       // for any thread
  std::atomic<std::uint64_t> skipped{0};  // for any thread
};

int number_of(const std::map<std::string, int>& counts, const std::string& address) {
  const auto found = counts.find(address);
  return found == counts.end() ? 0 : found->second;
}

/// Calls `next` when the pace allows another message.
template <class Next>
void keep_pace(WebPace& pace, asio::steady_timer& pause, Next next) {
  const auto wait = pace.after_message(WebPace::Clock::now());
  if (wait == WebPace::Clock::duration::zero()) return next();
  pause.expires_after(wait);
  pause.async_wait([next = std::move(next)](Error error) {
    if (!error) next();
  });
}

Place::Place(Shared& shared, std::string address) : shared_(shared), address_(std::move(address)) {
  ++shared_.connections;
  ++shared_.places[address_];
}

Place::~Place() {
  --shared_.connections;
  const auto count = shared_.places.find(address_);
  if (--count->second == 0) shared_.places.erase(count);
}

WebClient next_client(Shared& shared, const tcp::socket& socket) {
  WebClient client{++shared.numbers, {}};
  Error gone;
  const auto peer = socket.remote_endpoint(gone);
  if (!gone) client.address = peer.address().to_string() + ":" + std::to_string(peer.port());
  return client;
}

// --- LiveClient

LiveClient::LiveClient(WebStream stream, std::unique_ptr<Place> place, Shared& shared)
    : stream_(std::move(stream)),
      place_(std::move(place)),
      shared_(shared),
      who_(next_client(shared, beast::get_lowest_layer(stream_).socket())) {}

void LiveClient::accept(Request request) {
  request_ = std::move(request);
  stream_.set_option(websocket::stream_base::timeout{kRequestTimeout, kSilenceTimeout, true});
  stream_.read_message_max(kLongestMessage);
  stream_.text(true);
  stream_.async_accept(request_, [self = shared_from_this()](Error error) {
    if (error) return;
    self->shared_.clients.insert(self);
    self->shared_.client_count = static_cast<int>(self->shared_.clients.size());
    for (std::size_t channel = 0; channel < kChannels; ++channel) {
      if (self->shared_.newest[channel]) self->offer(channel, self->shared_.newest[channel]);
    }
    self->read();
  });
}

void LiveClient::offer(std::size_t channel, const Message& message) {
  if (pending_[channel]) ++shared_.skipped;
  pending_[channel] = message;
  if (!writing_) write();
}

void LiveClient::send(const Message& message) {
  if (unsent_.size() >= kMostUnread) return leave();
  unsent_.push_back(message);
  if (!writing_) write();
}

void LiveClient::write() {
  if (!unsent_.empty()) {
    Message next = std::move(unsent_.front());
    unsent_.pop_front();
    return write(std::move(next));
  }
  for (Message& message : pending_) {
    if (message) return write(std::exchange(message, nullptr));
  }
}

void LiveClient::write(Message message) {
  sending_ = std::move(message);
  writing_ = true;
  stream_.async_write(asio::buffer(*sending_), [self = shared_from_this()](Error error, std::size_t) {
    self->writing_ = false;
    if (error) return self->leave();
    self->write();
  });
}

void LiveClient::read() {
  stream_.async_read(incoming_, [self = shared_from_this()](Error error, std::size_t) {
    if (error) return self->leave();
    if (self->shared_.options.received) {
      const auto bytes = self->incoming_.data();
      self->shared_.options.received(self->who_, {static_cast<const char*>(bytes.data()), bytes.size()});
    }
    self->incoming_.clear();
    keep_pace(self->pace_, self->pause_, [self] { self->read(); });
  });
}

void LiveClient::leave() {
  close();
  const bool first = shared_.clients.erase(shared_from_this()) > 0;
  shared_.client_count = static_cast<int>(shared_.clients.size());
  if (first && shared_.options.left) shared_.options.left(who_);
}

// --- ProtocolClient

ProtocolClient::ProtocolClient(WebStream stream, std::unique_ptr<Place> place, Shared& shared)
    : stream_(std::move(stream)),
      place_(std::move(place)),
      shared_(shared),
      who_(next_client(shared, beast::get_lowest_layer(stream_).socket())) {}

void ProtocolClient::accept(Request request, const std::string& name) {
  request_ = std::move(request);
  stream_.set_option(websocket::stream_base::timeout{kRequestTimeout, kSilenceTimeout, true});
  stream_.set_option(websocket::stream_base::decorator(
      [name](websocket::response_type& response) { response.set(http::field::sec_websocket_protocol, name); }));
  stream_.read_message_max(shared_.options.protocol.longest_message);
  shared_.protocol_clients.insert(shared_from_this());
  stream_.async_accept(request_, [self = shared_from_this()](Error error) {
    if (error) return self->leave();
    self->open();
  });
}

void ProtocolClient::open() {
  WebOpening opening;
  // Another thread never holds the client, so that none but the server's destroys it.
  opening.wake = [weak = weak_from_this(), executor = stream_.get_executor()] {
    asio::post(executor, [weak] {
      const auto client = weak.lock();
      if (client) client->write();
    });
  };
  opening.client = who_;
  opening.token = token_in(view_of(request_.target()));
  opening.background = [files = shared_.files](std::function<void()> job) { return files->run(std::move(job)); };
  session_ = shared_.options.protocol.open(std::move(opening));
  write();
  read();
}

void ProtocolClient::write() {
  if (writing_ || ending_ || !session_) return;
  auto frame = session_->next();
  if (!frame) {
    if (const auto reason = session_->end()) end(*reason);
    return;
  }
  sending_ = std::move(*frame);
  writing_ = true;
  stream_.text(sending_.text);
  const std::array<asio::const_buffer, 2> buffers{asio::buffer(sending_.head),
                                                  sending_.body ? asio::buffer(*sending_.body) : asio::const_buffer()};
  stream_.async_write(buffers, [self = shared_from_this()](Error error, std::size_t) {
    self->writing_ = false;
    if (error) return self->leave();
    self->write();
  });
}

void ProtocolClient::read() {
  stream_.async_read(incoming_, [self = shared_from_this()](Error error, std::size_t) {
    if (error) return self->leave();
    if (!self->session_) return;
    const auto bytes = self->incoming_.data();
    self->session_->received({static_cast<const char*>(bytes.data()), bytes.size()}, self->stream_.got_text());
    self->incoming_.clear();
    self->write();
    keep_pace(self->pace_, self->pause_, [self] { self->read(); });
  });
}

/// The closing handshake; what the client sends meanwhile is read and ignored.
void ProtocolClient::end(const std::string& reason) {
  ending_ = true;
  constexpr std::size_t kLongestReason = 120;  // a close frame holds 123 bytes
  const websocket::close_reason why(websocket::close_code::policy_error, reason.substr(0, kLongestReason));
  stream_.async_close(why, [self = shared_from_this()](Error) { self->leave(); });
}

void ProtocolClient::leave() {
  close();
  session_.reset();
  const bool first = shared_.protocol_clients.erase(shared_from_this()) > 0;
  if (first && shared_.options.left) shared_.options.left(who_);
}

// --- HttpConnection

HttpConnection::HttpConnection(tcp::socket socket, std::string address, Shared& shared)
    : stream_(std::move(socket)),
      place_(std::make_unique<Place>(shared, address)),
      shared_(shared),
      address_(std::move(address)) {
  ++shared_.unadmitted[address_];
}

HttpConnection::~HttpConnection() {
  admit();
}

void HttpConnection::admit() {
  if (!std::exchange(unadmitted_, false)) return;
  const auto count = shared_.unadmitted.find(address_);
  if (--count->second == 0) shared_.unadmitted.erase(count);
}

void HttpConnection::begin() {
  stream_.next_layer().expires_after(shared_.options.admission);  // of the handshake and the first request together
  if (!shared_.tls) return read();
  beast::async_detect_ssl(stream_.next_layer(), incoming_, [self = shared_from_this()](Error error, bool encrypted) {
    if (error) return self->close();
    self->unencrypted_ = !encrypted;
    if (encrypted) return self->begin_tls();
    self->read();
  });
}

void HttpConnection::begin_tls() {
  stream_.begin_tls(*shared_.tls, incoming_.data(), [self = shared_from_this()](Error error, std::size_t used) {
    if (error) return self->close();
    self->incoming_.consume(used);
    self->read();
  });
}

void HttpConnection::read() {
  parser_.emplace();
  parser_->body_limit(kLongestRequest);
  parser_->header_limit(kLongestRequest);
  if (!unadmitted_) stream_.next_layer().expires_after(kRequestTimeout);
  http::async_read(stream_, incoming_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
    if (error) return self->close();
    self->request_ = self->parser_->release();
    self->respond();
  });
}

/// A browser keeps the token of the address in a cookie; Foxglove has it in the address of its WebSocket.
bool HttpConnection::is_admitted() const {
  const auto& admits = shared_.options.admits;
  return !admits || admits(cookie_in(request_, cookie_name(shared_.port))) ||
         admits(token_in(view_of(request_.target())));
}

bool HttpConnection::shows_token() const {
  const std::string_view target = view_of(request_.target());
  return !cookie_in(request_, cookie_name(shared_.port)).empty() || !token_in(target).empty() ||
         !watch_token_in(target).empty();
}

/// False: the request is none for a WebSocket, or it is refused.
bool HttpConnection::upgrade() {
  if (unencrypted_ || !websocket::is_upgrade(request_) || !is_own_host(view_of(request_[http::field::host])) ||
      !is_admitted()) {
    return false;
  }
  const bool own_page = is_same_origin(request_, shared_.tls ? "https://" : "http://");
  if (request_.target() == kLivePath && own_page) {
    stream_.next_layer().expires_never();
    std::make_shared<LiveClient>(std::move(stream_), std::move(place_), shared_)->accept(std::move(request_));
    return true;
  }
  const WebProtocol& protocol = shared_.options.protocol;
  const std::string name = offered(request_, protocol.names);
  if (!is_protocol_target(view_of(request_.target())) || name.empty()) return false;
  if (!own_page && !protocol.allows(view_of(request_[http::field::origin]))) return false;
  stream_.next_layer().expires_never();
  std::make_shared<ProtocolClient>(std::move(stream_), std::move(place_), shared_)->accept(std::move(request_), name);
  return true;
}

void HttpConnection::respond() {
  if (is_admitted()) admit();
  if (upgrade()) return;
  response_ = response();
  if (unread_) return read_content();
  complete();
}

/// The thread of files gives its reference to the connection back: it must not destroy it.
void HttpConnection::read_content() {
  auto job = [self = shared_from_this(), read = std::exchange(unread_, nullptr)]() mutable {
    std::optional<std::string> content;
    try {
      content = read();
    } catch (const std::exception&) {
      // as a file that is gone: it may be too large for the memory
    }
    const auto executor = self->stream_.get_executor();
    asio::post(executor, [self = std::move(self), content = std::move(content)]() mutable {
      if (content) {
        self->response_.body() = std::move(*content);
      } else {
        self->response_ = answer(self->request_, http::status::not_found, "There is no such file.\n");
      }
      self->complete();
    });
  };
  if (shared_.files->run(std::move(job))) return;
  response_ = answer(request_, http::status::service_unavailable, "Too many files wait to be read; ask again.\n");
  complete();
}

void HttpConnection::complete() {
  response_.keep_alive(request_.keep_alive() && !unadmitted_);
  response_.set(http::field::server, "hecaton-view");
  // The page changes with the program only; a browser asks each time whether it is the same.
  response_.set(http::field::cache_control, "no-cache");
  response_.set("X-Content-Type-Options", "nosniff");
  response_.set("Content-Security-Policy",
                "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
                "connect-src 'self' blob: data:; frame-ancestors 'none'");
  response_.prepare_payload();
  if (request_.method() == http::verb::head) response_.body().clear();
  if (response_.result() != http::status::unauthorized || !shows_token()) return write();
  pause_.expires_after(shared_.options.wrong_token_pause);
  pause_.async_wait([self = shared_from_this()](Error error) {
    if (!error) self->write();
  });
}

void HttpConnection::write() {
  stream_.next_layer().expires_after(kRequestTimeout);
  http::async_write(stream_, response_, [self = shared_from_this()](Error error, std::size_t) {
    if (error || !self->response_.keep_alive()) return self->close();
    keep_pace(self->pace_, self->pause_, [self] { self->read(); });
  });
}

Response HttpConnection::response() {
  if (!is_own_host(view_of(request_[http::field::host]))) {
    return answer(request_, http::status::forbidden,
                  "The view answers to its address, to localhost and to this machine's name only.\n");
  }
  if (unencrypted_) {
    return moved(
        request_, http::status::permanent_redirect,
        "https://" + std::string(view_of(request_[http::field::host])) + std::string(view_of(request_.target())));
  }
  const std::string_view target = view_of(request_.target());
  const std::string_view shown = watch_token_in(target);
  if (!shown.empty() && shared_.options.admits && shared_.options.admits(shown)) {
    Response response = moved(request_, http::status::see_other, "/");
    response.set(http::field::set_cookie,
                 cookie_name(shared_.port) + "=" + std::string(shown) + "; Path=/; HttpOnly; Secure; SameSite=Lax");
    return response;
  }
  if (!is_admitted()) {
    return answer(
        request_, http::status::unauthorized,
        "This page needs the token of its address. Its program has printed that address, or has written it to "
        "the file view-token.\n");
  }
  if (request_.target() == kLivePath) {
    return websocket::is_upgrade(request_)
               ? answer(request_, http::status::forbidden, "The stream is for the page of this server only.\n")
               : answer(request_, http::status::upgrade_required, "This is the stream of the page: a WebSocket.\n");
  }
  if (websocket::is_upgrade(request_) && is_protocol_target(view_of(request_.target())) &&
      !shared_.options.protocol.names.empty()) {
    if (!offered(request_, shared_.options.protocol.names).empty()) {
      return answer(request_, http::status::forbidden,
                    "Pages of this origin may not connect; hecaton view --allow-origin allows another one.\n");
    }
    std::string names;
    for (const std::string& name : shared_.options.protocol.names) names += (names.empty() ? "" : " or ") + name;
    return answer(request_, http::status::bad_request, "Here a WebSocket must offer the sub-protocol " + names + ".\n");
  }
  if (request_.method() != http::verb::get && request_.method() != http::verb::head) {
    return answer(request_, http::status::method_not_allowed, "The view takes GET and HEAD only.\n");
  }
  return file(target);
}

Response HttpConnection::file(std::string_view target) {
  auto file = shared_.options.file ? shared_.options.file(target.substr(0, target.find('?'))) : std::nullopt;
  if (!file) return answer(request_, http::status::not_found, "There is no such file.\n");
  Response response = answer(request_, http::status::ok, file->read ? std::string() : *file->content);
  unread_ = std::move(file->read);
  response.set(http::field::content_type, file->type);
  if (file->compressed) response.set(http::field::content_encoding, "gzip");
  return response;
}

}  // namespace

// --- WebServer

struct WebServer::Impl {
  explicit Impl(const WebServerOptions& options) : acceptor(context) {
    shared.options = options;
    try {
      const tcp::endpoint endpoint(asio::ip::make_address_v4(options.address), options.port);
      acceptor.open(endpoint.protocol());
      acceptor.set_option(tcp::acceptor::reuse_address(true));
      acceptor.bind(endpoint);
      acceptor.listen();
      shared.port = acceptor.local_endpoint().port();
    } catch (const boost::system::system_error& error) {
      throw std::runtime_error("the page cannot listen on " + options.address + ":" + std::to_string(options.port) +
                               ": " + error.code().message());
    }
    if (options.certificate) shared.tls.emplace(tls_context(*options.certificate));
    shared.files = &files;
    accept();
    thread = std::thread([this] { context.run(); });
  }

  void accept() {
    acceptor.async_accept([this](Error error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return retry();
      accept();
      if (shared.connections >= shared.options.most_connections) return;
      Error ignored;
      const std::string address = socket.remote_endpoint(ignored).address().to_string();
      if (is_crowded(address)) return;
      socket.set_option(tcp::no_delay(true), ignored);
      socket.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
      std::make_shared<HttpConnection>(std::move(socket), address, shared)->begin();
    });
  }

  /// One program on the network must not keep people from the page, and from its stop.
  [[nodiscard]] bool is_crowded(const std::string& address) const {
    int all = 0;
    for (const auto& [other, count] : shared.unadmitted) all += count;
    return all >= shared.options.most_unadmitted ||
           number_of(shared.unadmitted, address) >= shared.options.most_unadmitted_of_address ||
           number_of(shared.places, address) >= shared.options.most_of_address;
  }

  /// The kernel has no descriptor left, or the client has gone already.
  void retry() {
    pause.expires_after(std::chrono::milliseconds(100));
    pause.async_wait([this](Error error) {
      if (!error) accept();
    });
  }

  // The context outlives the operations, which it destroys; they refer to `shared`.
  Shared shared;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  asio::steady_timer pause{context};
  FileThread files;  // its jobs use the context and `shared`
  std::thread thread;
};

WebServer::WebServer(const WebServerOptions& options) : impl_(std::make_unique<Impl>(options)) {}

WebServer::~WebServer() {
  asio::post(impl_->context, [impl = impl_.get()] {
    Error ignored;
    impl->acceptor.close(ignored);
    for (const auto& client : impl->shared.clients) client->close();
    for (const auto& client : impl->shared.protocol_clients) client->close();
    impl->context.stop();
  });
  impl_->thread.join();
  impl_->shared.clients.clear();
  impl_->shared.protocol_clients.clear();
}

void WebServer::publish(Channel channel, std::string message) {
  asio::post(impl_->context, [impl = impl_.get(), index = static_cast<std::size_t>(channel),
                              shared = std::make_shared<const std::string>(std::move(message))] {
    impl->shared.newest[index] = shared;
    for (const auto& client : impl->shared.clients) client->offer(index, shared);
  });
}

void WebServer::send(std::uint64_t client, std::string message) {
  asio::post(impl_->context, [impl = impl_.get(), client,
                              shared = std::make_shared<const std::string>(std::move(message))] {
    const auto& all = impl->shared.clients;
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one->number() == client; });
    if (found == all.end()) return;
    const std::shared_ptr<LiveClient> receiver = *found;  // a client that leaves is no longer among them
    receiver->send(shared);
  });
}

int WebServer::clients() const {
  return impl_->shared.client_count;
}

std::uint64_t WebServer::skipped() const {
  return impl_->shared.skipped;
}

std::uint16_t WebServer::port() const {
  return impl_->shared.port;
}

}  // namespace hecaton::services
