#include "services/view/view_service.hpp"

#include <algorithm>
#include <iostream>
#include <stdexcept>
#include <utility>

#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_folder.hpp"
#include "services/runtime/thread_priority.hpp"
#include "services/view/token_file.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

constexpr auto kListenPeriod = 1s;
constexpr auto kLoopPeriod = 10ms;

WebServerOptions web_options(const config::CellFile& file, const ServiceOptions& options, const config::View& view) {
  WebServerOptions web;
  web.address = view.listen;
  const int port = view.port.value_or(config::view_port(choose_domain(options, file.network.domain)));
  web.port = static_cast<std::uint16_t>(port);
  return web;
}

/// Throws std::runtime_error when the cell is secured and has no identity that may give orders.
std::unique_ptr<Orders> make_orders(const config::CellFile& file, const ServiceOptions& options,
                                    const ViewOrders& wanted, const std::string& token) {
  OrderOptions allowed{wanted.stop, token, {}};
  if (!wanted.control && !wanted.stop) return std::make_unique<Orders>(file, allowed, nullptr);
  try {
    const int domain = choose_domain(options, file.network.domain);
    return std::make_unique<Orders>(file, allowed, client::Connection::make(client::join(file, domain, options.host)));
  } catch (const std::runtime_error& error) {
    allowed.refused_as = std::string("orders of pages need an identity of the role operator: ") + error.what();
    const bool of_agent = options.heartbeat_fd >= 0;  // which would start it again and again
    if ((wanted.control && !of_agent) || file.keystore.empty()) throw std::runtime_error(allowed.refused_as);
    log_warning("pages give no orders", {{"reason", allowed.refused_as}});
    return std::make_unique<Orders>(file, allowed, nullptr);
  }
}

/// Of a service of an agent, which has a folder of the run. Empty: it shall have no token.
std::filesystem::path token_file(const ServiceOptions& options, const config::View& view, const ViewOrders& wanted) {
  const bool has_tokens = wanted.control || config::is_reachable_by_others(view);
  if (!has_tokens || options.heartbeat_fd < 0 || options.checkpoint.empty()) return {};
  return std::filesystem::path(options.checkpoint).replace_filename(kViewTokenFile);
}

/// The one that the view had before its restart, otherwise a new one.
std::string make_token(const std::filesystem::path& file, std::string_view marker) {
  return file.empty() ? random_token() : token_in_file(file, marker).value_or(random_token());
}

}  // namespace

ViewService::ViewService(const config::CellFile& file, const ServiceOptions& options, const config::View& view,
                         const ViewOrders& orders, std::vector<std::string> foxglove_origins,
                         const ShutdownSignal& shutdown)
    : file_(file),
      web_(web_options(file, options, view)),
      participant_(make_watching_participant(file, options, Role::kViewer, view_node(), &mailbox_)),
      loop_(std::min<std::chrono::nanoseconds>(kLoopPeriod, file.supervision.heartbeat_period), shutdown),
      drawings_(file),
      feed_(file, participant_, mailbox_),
      foxglove_(feed_, file, drawings_, {std::move(foxglove_origins), foxglove_orders()}),
      token_file_(token_file(options, view, orders)),
      token_(orders.control ? make_token(token_file_, kControlMarker) : std::string()),
      protection_(protection_of(view, make_token(token_file_, kWatchMarker))),
      orders_(make_orders(file, options, orders, token_)) {
  if (orders.control) preview_.emplace(file.cell);
  web_.received = [this](const WebClient& page, std::string_view message) { orders_->received(page, message); };
  web_.left = [this](const WebClient& page) { orders_->left(page); };
  web_.protocol = foxglove_.protocol();
  protect(web_, protection_, token_);
  if (options.heartbeat_fd >= 0) {
    const NodeIdentity identity{view_node(), msg::NodeKind::NODE_OTHER, "", view.host};
    heartbeat_.emplace(participant_, identity, heartbeat_timing(file, options));
  }
  for (const view::ArmDrawing& arm : drawings_.arms()) {
    if (!arm.note.empty()) log_warning("an arm is not drawn as its URDF describes it", {{"reason", arm.note}});
  }
  listen(bus::Clock::now());
}

foxglove::OrderReceiver ViewService::foxglove_orders() {
  using foxglove::OrderKind;
  foxglove::OrderReceiver receiver;
  receiver.accepts = [this](std::string_view token) { return !token_.empty() && same_token(token, token_); };
  receiver.carry_out = [this](const foxglove::Order& order, const std::function<void(foxglove::OrderResult)>& answer) {
    using client::ModeOrder;
    const ModeOrder mode = order.kind == OrderKind::kHold   ? ModeOrder::kHold
                           : order.kind == OrderKind::kStop ? ModeOrder::kStop
                                                            : ModeOrder::kResume;
    const std::vector<std::string> arms = order.arm.empty() ? std::vector<std::string>{} : std::vector{order.arm};
    orders_->give(order.client, mode, arms, [answer](bool done, const std::string& text) { answer({done, text}); });
  };
  return receiver;
}

std::string ViewService::url() const {
  config::View listening;
  listening.listen = web_.address;
  listening.port = web_.port;
  return config::view_url(listening, file_.network.domain);
}

std::string ViewService::url_with_tokens() const {
  const std::string admitting = admitting_url(url(), protection_);
  return token_.empty() ? admitting : admitting + std::string(kControlMarker) + token_;
}

void ViewService::run() {
  give_way();  // the threads of orders and of the web server stay as they are: a stop is not late
  while (loop_.next()) {
    static_cast<void>(mailbox_.take_events());
    feed_.update(loop_.now());
    if (!server_) listen(loop_.now());
    if (server_) server_->publish(loop_.now());
    foxglove_.publish(loop_.now());
    answer_pages();
    if (heartbeat_ && heartbeat_->due(loop_.now(), loop_.period() / 2)) publish_heartbeat();
  }
  log_info("view shuts down", {{"skipped_messages", (server_ ? server_->skipped() : 0) + foxglove_.skipped()}});
}

void ViewService::answer_pages() {
  orders_->update(loop_.now());
  if (!server_) return;
  for (const auto& [page, reply] : orders_->take_replies()) server_->send(page, reply);
  if (const auto control = orders_->take_control_change()) server_->publish(Channel::kControl, *control);
  if (preview_) answer_previews();
}

void ViewService::answer_previews() {
  if (const auto answer = preview_->take_answer()) server_->send(answer->page, preview_json(file_.cell, *answer));
  if (!preview_->ready(loop_.now())) return;  // the question waits, and a newer one replaces it
  if (auto question = orders_->take_preview()) preview_->ask(std::move(*question), PreviewScene::of(feed_.state()));
}

void ViewService::listen(bus::Clock::time_point now) {
  if (now < listen_at_) return;
  listen_at_ = now + kListenPeriod;
  try {
    auto server = std::make_unique<PageServer>(feed_, file_, drawings_, web_, orders_->began());
    web_.port = server->port();
    if (!token_file_.empty()) write_token_file(token_file_, url_with_tokens());
    server_ = std::move(server);
    orders_->announce_control();
    log_info("view started", {{"url", url()}});
    if (!token_file_.empty()) log_info("address with token written", {{"file", token_file_.string()}});
    refusal_.reset();
    const auto note = certificate_note(protection_);
    if (note) log_info("the page signs its certificate itself", {{"fingerprint", protection_->fingerprint}});
    if (!heartbeat_) std::cout << url_with_tokens() << std::endl;
    if (!heartbeat_ && note) std::cerr << *note << std::endl;
  } catch (const std::runtime_error& error) {
    if (!heartbeat_) throw;
    if (!refusal_) log_warning("the page cannot be served yet", {{"reason", error.what()}});
    refusal_ = error.what();
  }
}

void ViewService::publish_heartbeat() {
  HealthReport report;
  report.term = feed_.state().mode().term();
  if (refusal_) {
    report.state = msg::NodeState::NODE_DEGRADED;
    report.cause = make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, view_node(), *refusal_);
  }
  heartbeat_->publish(loop_.now(), report, loop_.statistics());
}

}  // namespace hecaton::services
