#include "services/view/web_server.hpp"

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <memory>
#include <new>
#include <optional>
#include <semaphore>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/security/web_identity.hpp"
#include "services/view/token_file.hpp"
#include "services/view/web_pace.hpp"
#include "services/view/web_protection.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/view/web_client.hpp"

namespace hecaton::services {
namespace {

using test::request;
using test::WebSocketClient;
namespace http = boost::beast::http;

class WebServerTest : public testing::Test {
 protected:
  static WebServerOptions options() {
    WebServerOptions options;
    options.file = [](std::string_view path) -> std::optional<WebFile> {
      if (path != "/page.js") return std::nullopt;
      return WebFile{"text/javascript", std::make_shared<const std::string>("let x;")};
    };
    return options;
  }
  WebServer server_{options()};
};

std::string status_of(const std::function<void()>& refused) {
  try {
    refused();
  } catch (const boost::system::system_error& error) {
    return error.code().message();  // what() also has the place in the source from Boost 1.83 on
  }
  return "accepted";
}

TEST_F(WebServerTest, ServesFilesOnly) {
  const auto file = request(server_.port(), "/page.js?v=1");
  EXPECT_EQ(file.result(), http::status::ok);
  EXPECT_EQ(file.body(), "let x;");
  EXPECT_EQ(file[http::field::content_type], "text/javascript");
  const auto head = request(server_.port(), "/page.js", http::verb::head);
  EXPECT_EQ(head[http::field::content_length], "6");
  EXPECT_EQ(request(server_.port(), "/../etc/passwd").result(), http::status::not_found);
  EXPECT_EQ(request(server_.port(), "/page.js", http::verb::post).result(), http::status::method_not_allowed);
  EXPECT_EQ(request(server_.port(), "/live").result(), http::status::upgrade_required);
}

TEST_F(WebServerTest, RefusesNamesOfOtherSites) {
  const auto status = [&](const std::string& host) {
    return request(server_.port(), "/page.js", http::verb::get, host).result();
  };
  EXPECT_EQ(status("127.0.0.1:8042"), http::status::ok);
  EXPECT_EQ(status("localhost:8042"), http::status::ok);
  EXPECT_EQ(status("evil.example:8042"), http::status::forbidden) << "a name that resolves to this machine";
  EXPECT_EQ(status("127.0.0.1.evil.example"), http::status::forbidden);
  const std::uint16_t port = server_.port();
  EXPECT_EQ(status_of([port] { WebSocketClient(port, "http://evil.example"); }),
            "The WebSocket handshake was declined by the remote peer");
  EXPECT_EQ(status_of([port] { WebSocketClient(port, "", "evil.example"); }),
            "The WebSocket handshake was declined by the remote peer");
  EXPECT_EQ(status_of([port] { WebSocketClient(port, "http://localhost"); }), "accepted");
}

/// Connects and sends nothing.
struct IdleConnection {
  explicit IdleConnection(std::uint16_t port) : socket(context) { socket.connect(test::local(port)); }
  /// Until the server has closed it.
  void await_end() {
    char byte = 0;
    boost::system::error_code end;
    EXPECT_EQ(socket.read_some(boost::asio::buffer(&byte, 1), end), 0U);
  }
  boost::asio::io_context context;
  boost::asio::ip::tcp::socket socket;
};

// One program on the network opens connections and sends no token.
TEST(WebServerUnadmitted, DoNotKeepPeopleFromThePage) {
  WebServerOptions options;
  options.admits = [](std::string_view token) { return token == "secret"; };
  options.file = [](std::string_view) { return WebFile{"text/plain", std::make_shared<const std::string>("page")}; };
  options.most_unadmitted_of_address = 3;
  WebServer server(options);
  const std::uint16_t port = server.port();
  const auto began = std::chrono::steady_clock::now();
  std::vector<std::unique_ptr<IdleConnection>> idle;
  for (int i = 0; i < 3; ++i) idle.push_back(std::make_unique<IdleConnection>(port));
  IdleConnection(port).await_end();  // there is no place for it
  EXPECT_LT(std::chrono::steady_clock::now() - began, options.admission) << "it is closed at once";
  for (const auto& one : idle) one->await_end();
  EXPECT_EQ(request(port, "/?token=secret").result(), http::status::ok);

  // Those that are admitted take no place, and others end with their answer.
  std::vector<std::unique_ptr<IdleConnection>> admitted;
  for (int i = 0; i < 10; ++i) {
    auto& kept = *admitted.emplace_back(std::make_unique<IdleConnection>(port));
    http::request<http::empty_body> own(http::verb::get, "/?token=secret", 11);
    own.set(http::field::host, "localhost");
    http::write(kept.socket, own);
    http::response<http::string_body> page;
    boost::beast::flat_buffer buffer;
    http::read(kept.socket, buffer, page);
    EXPECT_EQ(page.body(), "page");
    EXPECT_TRUE(page.keep_alive());
  }
  for (int i = 0; i < 10; ++i) {
    const auto refused = request(port, "/page");
    EXPECT_EQ(refused.result(), http::status::unauthorized);
    EXPECT_FALSE(refused.keep_alive());
  }
}

TEST(WebServerPlaces, OfOneAddressAreBoundedWithItsWebSockets) {
  WebServerOptions options;
  options.most_of_address = 3;
  WebServer server(options);
  const std::uint16_t port = server.port();
  std::vector<std::unique_ptr<WebSocketClient>> open;
  for (int i = 0; i < 3; ++i) open.push_back(std::make_unique<WebSocketClient>(port));
  const auto is_refused = [port] { return status_of([port] { WebSocketClient another(port); }) != "accepted"; };
  EXPECT_TRUE(is_refused());
  open.pop_back();
  // The server notices the end of a connection when it reads or writes next.
  bool refused = true;
  for (int i = 0; refused && i < 1000; ++i) {
    server.publish(Channel::kCell, std::to_string(i));
    for (const auto& one : open) static_cast<void>(one->read());
    refused = is_refused();
  }
  EXPECT_FALSE(refused) << "its place is free";
}

TEST(WebServerTokens, WaitBeforeTheAnswerToAWrongOne) {
  using Clock = std::chrono::steady_clock;
  WebServerOptions options;
  options.admits = [](std::string_view token) { return token == "secret"; };
  options.file = [](std::string_view) { return WebFile{"text/plain", std::make_shared<const std::string>("page")}; };
  options.wrong_token_pause = std::chrono::milliseconds(300);
  WebServer server(options);
  for (const char* target : {"/?token=wrong", "/?watch=wrong"}) {
    const auto began = Clock::now();
    EXPECT_EQ(request(server.port(), target).result(), http::status::unauthorized);
    EXPECT_GE(Clock::now() - began, options.wrong_token_pause) << target;
  }
  EXPECT_EQ(request(server.port(), "/?token=secret").result(), http::status::ok);
}

TEST(WebPaceTest, LetsABurstThroughAndThenSoManyASecond) {
  WebPace pace;
  WebPace::Clock::time_point now{std::chrono::hours(1)};
  for (int i = 0; i < 512; ++i) EXPECT_EQ(pace.after_message(now).count(), 0) << i;
  for (int i = 0; i < 100; ++i) {
    const auto wait = pace.after_message(now);
    EXPECT_NEAR(std::chrono::duration<double>(wait).count(), 0.01, 1e-6);
    now += wait;
  }
  now += std::chrono::seconds(2);
  for (int i = 0; i < 199; ++i) EXPECT_EQ(pace.after_message(now).count(), 0) << i;
}

TEST_F(WebServerTest, SaysWhyItCannotListen) {
  WebServerOptions taken = options();
  taken.port = server_.port();
  try {
    const WebServer second(taken);
    ADD_FAILURE() << "two servers at one port";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(),
              "the page cannot listen on 127.0.0.1:" + std::to_string(server_.port()) + ": Address already in use");
  }
}

TEST_F(WebServerTest, GivesLateClientsTheNewestOfEachChannel) {
  server_.publish(Channel::kCell, "cell");
  server_.publish(Channel::kFrame, "frame 1");
  server_.publish(Channel::kFrame, "frame 2");
  WebSocketClient client(server_.port());
  EXPECT_EQ(client.read(), "cell");
  EXPECT_EQ(client.read(), "frame 2");
  server_.publish(Channel::kStatus, "status");
  EXPECT_EQ(client.read(), "status");
}

TEST_F(WebServerTest, KeepsOnlyTheNewestStateForASlowClient) {
  WebSocketClient slow(server_.port());
  WebSocketClient quick(server_.port());
  server_.publish(Channel::kCell, "begin");
  EXPECT_EQ(slow.read(), "begin");
  EXPECT_EQ(quick.read(), "begin");
  constexpr int kStates = 400;
  const std::string padding(100'000, '.');
  // Each waits until the quick client has it: the slow one reads nothing meanwhile.
  for (int i = 0; i < kStates; ++i) {
    server_.publish(Channel::kFrame, std::to_string(i) + padding);
    ASSERT_EQ(std::stoi(quick.read()), i);
  }
  EXPECT_GT(server_.skipped(), 0U);
  int received = 0;
  int last = -1;
  while (last != kStates - 1) {
    const int number = std::stoi(slow.read());
    ASSERT_GT(number, last) << "states arrive in order";
    last = number;
    ++received;
  }
  EXPECT_LT(received, kStates / 2) << "40 MB do not fit into the buffers of a socket";
}

TEST_F(WebServerTest, DropsClientsThatLeaveOrSendTooMuch) {
  {
    WebSocketClient leaves(server_.port());
    WebSocketClient talks(server_.port());
    server_.publish(Channel::kCell, "cell");
    EXPECT_EQ(leaves.read(), "cell");
    EXPECT_EQ(talks.read(), "cell");
    EXPECT_EQ(server_.clients(), 2);
    talks.write("orders are not read");
    talks.write(std::string(5000, 'x'));
    EXPECT_THROW(static_cast<void>(talks.read()), boost::system::system_error);
  }
  WebSocketClient stays(server_.port());
  EXPECT_EQ(stays.read(), "cell");
  // The server notices the end of a connection when it reads or writes next.
  for (int i = 0; server_.clients() > 1 && i < 1000; ++i) {
    server_.publish(Channel::kCell, std::to_string(i));
    EXPECT_EQ(stays.read(), std::to_string(i));
  }
  EXPECT_EQ(server_.clients(), 1);
}

// The mesh comes from a slow disk: it is read when the test says so.
TEST(WebServerFiles, AreReadWhileOrdersAreAnswered) {
  std::binary_semaphore begun{0};
  std::binary_semaphore readable{0};
  std::optional<WebServer> server;
  WebServerOptions options;
  options.file = [&](std::string_view path) -> std::optional<WebFile> {
    if (path == "/") return WebFile{"text/html", std::make_shared<const std::string>("page")};
    return WebFile{"model/stl", nullptr, false, [&]() -> std::optional<std::string> {
                     begun.release();
                     return readable.try_acquire_for(std::chrono::seconds(60)) ? "mesh" : "mesh, too late";
                   }};
  };
  options.received = [&](const WebClient& client, std::string_view order) {
    server->send(client.number, std::string(order));
  };
  server.emplace(options);
  const std::uint16_t port = server->port();
  auto mesh = std::async(std::launch::async, [port] { return request(port, "/tip.stl"); });
  begun.acquire();
  WebSocketClient page(port);
  page.write("stop");
  EXPECT_EQ(page.read(), "stop");
  EXPECT_EQ(request(port, "/").body(), "page");
  readable.release();
  const auto answer = mesh.get();
  EXPECT_EQ(answer.result(), http::status::ok);
  EXPECT_EQ(answer.body(), "mesh") << "the order did not wait for it";
  EXPECT_EQ(answer[http::field::content_type], "model/stl");
  EXPECT_EQ(answer[http::field::content_length], "4");
}

TEST(WebServerFiles, ThatCannotBeReadAreNone) {
  WebServerOptions options;
  options.file = [](std::string_view path) {
    return WebFile{"model/stl", nullptr, false, [large = path == "/large"]() -> std::optional<std::string> {
                     if (large) throw std::bad_alloc();
                     return std::nullopt;
                   }};
  };
  const WebServer server(options);
  EXPECT_EQ(request(server.port(), "/gone").result(), http::status::not_found);
  EXPECT_EQ(request(server.port(), "/large").result(), http::status::not_found);
}

TEST(WebServerFiles, ThatWaitToBeReadAreBounded) {
  constexpr int kRequests = 66;  // one is read, 64 wait, and one is refused
  std::counting_semaphore<> begun{0};
  std::counting_semaphore<> asked{0};
  std::counting_semaphore<> readable{0};
  WebServerOptions options;
  options.most_of_address = 2 * kRequests;
  options.most_connections = 2 * kRequests;
  options.most_unadmitted_of_address = 2 * kRequests;
  options.most_unadmitted = 2 * kRequests;
  options.file = [&](std::string_view path) -> std::optional<WebFile> {
    if (path == "/") return WebFile{"text/html", std::make_shared<const std::string>("page")};
    asked.release();
    return WebFile{"model/stl", nullptr, false, [&]() -> std::optional<std::string> {
                     begun.release();
                     readable.acquire();
                     return "mesh";
                   }};
  };
  const WebServer server(options);
  std::vector<std::unique_ptr<IdleConnection>> clients;
  for (int i = 0; i < kRequests; ++i) {
    auto& client = *clients.emplace_back(std::make_unique<IdleConnection>(server.port()));
    http::request<http::empty_body> mesh(http::verb::get, "/tip.stl", 11);
    mesh.set(http::field::host, "localhost");
    http::write(client.socket, mesh);
    asked.acquire();
    if (i == 0) begun.acquire();
  }
  EXPECT_EQ(request(server.port(), "/").body(), "page") << "the server has queued them all";
  readable.release(kRequests);
  int refused = 0;
  for (const auto& client : clients) {
    http::response<http::string_body> answer;
    boost::beast::flat_buffer buffer;
    http::read(client->socket, buffer, answer);
    if (answer.result() == http::status::ok) continue;
    EXPECT_EQ(answer.result(), http::status::service_unavailable);
    EXPECT_EQ(answer.body(), "Too many files wait to be read; ask again.\n");
    ++refused;
  }
  EXPECT_EQ(refused, 1);
}

/// A server that answers each message with it, and counts the clients that have gone.
class EchoTest : public testing::Test {
 protected:
  EchoTest() {
    WebServerOptions options;
    options.received = [this](const WebClient& client, std::string_view message) {
      addresses_.push_back(client.address);
      server_->send(client.number, std::string(message));
    };
    options.left = [this](const WebClient&) { gone_.release(); };
    server_.emplace(options);
  }

  std::vector<std::string> addresses_;  // written before the answer is sent
  std::counting_semaphore<> gone_{0};
  std::optional<WebServer> server_;
};

TEST_F(EchoTest, AnswersTheClientThatAskedAndNoOther) {
  WebSocketClient first(server_->port());
  WebSocketClient second(server_->port());
  first.write("a");
  EXPECT_EQ(first.read(), "a");
  second.write("b");
  second.write("c");
  EXPECT_EQ(second.read(), "b");
  EXPECT_EQ(second.read(), "c");
  server_->publish(Channel::kCell, "cell");
  EXPECT_EQ(first.read(), "cell");
  EXPECT_TRUE(addresses_.front().starts_with("127.0.0.1:")) << addresses_.front();
}

TEST_F(EchoTest, ReadsTheMessagesOfAFastClientLater) {
  constexpr int kMessages = 700;
  WebSocketClient fast(server_->port());
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < kMessages; ++i) {
    fast.write(std::to_string(i));
    ASSERT_EQ(fast.read(), std::to_string(i)) << "none is lost";
  }
  const double least = (kMessages - WebPace::kAtOnce - 2.0) / WebPace::kPerSecond;
  EXPECT_GE(std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(), least);
}

TEST_F(EchoTest, SaysWhenAClientHasGone) {
  { const WebSocketClient short_lived(server_->port()); }
  EXPECT_TRUE(gone_.try_acquire_for(std::chrono::seconds(60)));
}

TEST_F(EchoTest, GivesAForeignPageNoWayToSend) {
  const std::uint16_t port = server_->port();
  EXPECT_NE(status_of([port] { WebSocketClient(port, "http://evil.example"); }), "accepted");
  EXPECT_NE(status_of([port] { WebSocketClient(port, "null"); }), "accepted") << "a file, or a frame in a sandbox";
  EXPECT_NE(status_of([port] { WebSocketClient(port, "http://evil.example", "evil.example"); }), "accepted")
      << "a name that was made to resolve to this machine";
  EXPECT_NE(status_of([port] { WebSocketClient(port, "https://localhost"); }), "accepted");
}

/// A server that other machines can reach: encrypted, for holders of a token.
class ProtectedServerTest : public testing::Test {
 protected:
  ProtectedServerTest() {
    config::View view;
    view.listen = "0.0.0.0";
    ::setenv("STATE_DIRECTORY", folder_.path().c_str(), 1);
    protection_ = protection_of(view);
    WebServerOptions options;
    options.file = [](std::string_view path) -> std::optional<WebFile> {
      if (path != "/") return std::nullopt;
      return WebFile{"text/html", std::make_shared<const std::string>("page")};
    };
    options.received = [this](const WebClient& client, std::string_view message) {
      server_->send(client.number, std::string(message));
    };
    protect(options, protection_, control_);
    server_.emplace(options);
    cookie_ = "hecaton_" + std::to_string(port()) + "=" + protection_->token;
  }
  ~ProtectedServerTest() override { ::unsetenv("STATE_DIRECTORY"); }
  [[nodiscard]] std::uint16_t port() const { return server_->port(); }

  test::TemporaryFolder folder_;
  std::optional<WebProtection> protection_;
  const std::string control_ = random_token();
  std::optional<WebServer> server_;
  std::string cookie_;
};

TEST_F(ProtectedServerTest, ShowsThePageToHoldersOfTheToken) {
  EXPECT_EQ(test::encrypted_request(port(), "/").result(), http::status::unauthorized);
  EXPECT_EQ(test::encrypted_request(port(), "/?watch=" + random_token()).result(), http::status::unauthorized);

  const auto admitted = test::encrypted_request(port(), "/?watch=" + protection_->token);
  EXPECT_EQ(admitted.result(), http::status::see_other);
  EXPECT_EQ(admitted[http::field::location], "/") << "the token leaves the address";
  EXPECT_EQ(admitted[http::field::set_cookie], cookie_ + "; Path=/; HttpOnly; Secure; SameSite=Lax");

  const auto page = test::encrypted_request(port(), "/", {{http::field::cookie, "other=1; " + cookie_}});
  EXPECT_EQ(page.result(), http::status::ok);
  EXPECT_EQ(page.body(), "page");
}

TEST_F(ProtectedServerTest, OpensWebSocketsToHoldersOfAToken) {
  const std::uint16_t port = this->port();
  const auto refused = [port](const std::string& cookie, const std::string& origin = "") {
    return status_of([&] { test::EncryptedWebSocketClient(port, "/live", cookie, origin); });
  };
  const std::string declined = "The WebSocket handshake was declined by the remote peer";
  EXPECT_EQ(refused(""), declined);
  EXPECT_EQ(refused(cookie_.substr(0, cookie_.size() - 1)), declined);
  EXPECT_EQ(refused("hecaton_1=" + protection_->token), declined) << "of another port";
  EXPECT_EQ(refused(cookie_, "https://evil.example"), declined);
  EXPECT_EQ(refused(cookie_, "http://localhost:" + std::to_string(port)), declined) << "that page is not encrypted";

  test::EncryptedWebSocketClient page(port, "/live", cookie_, "https://localhost:" + std::to_string(port));
  const std::string long_message(4000, 'x');
  page.write(long_message);
  EXPECT_EQ(page.read(), long_message);
}

TEST_F(ProtectedServerTest, SendsRequestsThatAreNotEncryptedToItsAddress) {
  const auto answer = request(port(), "/?watch=" + protection_->token, http::verb::get, "localhost:8042");
  EXPECT_EQ(answer.result(), http::status::permanent_redirect);
  EXPECT_EQ(answer[http::field::location], "https://localhost:8042/?watch=" + protection_->token);
  const std::uint16_t port = this->port();
  EXPECT_NE(status_of([port] { WebSocketClient client(port); }), "accepted");
  EXPECT_EQ(test::encrypted_request(port, "/").result(), http::status::unauthorized) << "it serves on";
}

TEST_F(ProtectedServerTest, KeepsItsCertificateForTheNextStart) {
  config::View view;
  view.listen = "0.0.0.0";
  EXPECT_EQ(protection_of(view)->fingerprint, protection_->fingerprint);
  EXPECT_NE(protection_of(view)->token, protection_->token);
  EXPECT_FALSE(protection_of(config::View{})) << "127.0.0.1 is for this host";
  for (const auto& file : std::filesystem::directory_iterator(folder_.path())) {
    EXPECT_EQ(file.status().permissions() & std::filesystem::perms(0077), std::filesystem::perms::none) << file.path();
  }
}

TEST_F(ProtectedServerTest, SaysWhatIsWrongWithACertificateOfTheUser) {
  config::View view;
  view.listen = "10.0.0.2";
  view.certificate = folder_.path() / "page-certificate.pem";
  view.key = folder_.path() / "other.pem";
  const auto reason = [&]() -> std::string {
    try {
      static_cast<void>(protection_of(view));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(reason(), view.key + ": is missing, empty or not readable for this user");
  std::filesystem::create_directory(folder_.path() / "other");
  static_cast<void>(self_signed_web_identity(folder_.path() / "other", {"localhost"}));
  view.key = folder_.path() / "other" / "page-key.pem";
  EXPECT_TRUE(reason().starts_with(view.key + ": is not the private key of " + view.certificate)) << reason();
  view.key = folder_.path() / "page-key.pem";
  EXPECT_EQ(reason(), "accepted");
  EXPECT_FALSE(protection_of(view)->self_signed);
}

}  // namespace
}  // namespace hecaton::services
