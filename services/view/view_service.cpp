#include "services/view/view_service.hpp"

#include <algorithm>
#include <iostream>
#include <stdexcept>

#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"

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

}  // namespace

ViewService::ViewService(const config::CellFile& file, const ServiceOptions& options, const config::View& view,
                         const ShutdownSignal& shutdown)
    : file_(file),
      web_(web_options(file, options, view)),
      participant_(make_participant(file, options, Role::kViewer, view_node(), &mailbox_)),
      loop_(std::min<std::chrono::nanoseconds>(kLoopPeriod, file.supervision.heartbeat_period), shutdown),
      drawings_(file),
      feed_(file, participant_, mailbox_) {
  if (options.heartbeat_fd >= 0) {
    const NodeIdentity identity{view_node(), msg::NodeKind::NODE_OTHER, "", view.host};
    heartbeat_.emplace(participant_, identity, heartbeat_timing(file, options));
  }
  for (const view::ArmDrawing& arm : drawings_.arms()) {
    if (!arm.note.empty()) log_warning("an arm is not drawn as its URDF describes it", {{"reason", arm.note}});
  }
  listen(bus::Clock::now());
}

std::string ViewService::url() const {
  config::View listening;
  listening.listen = web_.address;
  listening.port = web_.port;
  return config::view_url(listening, file_.network.domain);
}

void ViewService::run() {
  while (loop_.next()) {
    static_cast<void>(mailbox_.take_events());
    feed_.update(loop_.now());
    if (!server_) listen(loop_.now());
    if (server_) server_->publish(loop_.now());
    if (heartbeat_ && heartbeat_->due(loop_.now(), loop_.period() / 2)) publish_heartbeat();
  }
  log_info("view shuts down", {{"skipped_messages", server_ ? server_->skipped() : 0}});
}

void ViewService::listen(bus::Clock::time_point now) {
  if (now < listen_at_) return;
  listen_at_ = now + kListenPeriod;
  try {
    server_ = std::make_unique<PageServer>(feed_, file_, drawings_, web_);
    web_.port = server_->port();
    log_info("view started", {{"url", url()}});
    refusal_.clear();
    if (!heartbeat_) std::cout << url() << std::endl;
  } catch (const std::runtime_error& error) {
    if (!heartbeat_) throw;
    if (refusal_.empty()) log_warning("the page cannot be served yet", {{"reason", error.what()}});
    refusal_ = error.what();
  }
}

void ViewService::publish_heartbeat() {
  HealthReport report;
  report.term = feed_.state().mode().term();
  if (!refusal_.empty()) {
    report.state = msg::NodeState::NODE_DEGRADED;
    report.cause = make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, view_node(), refusal_);
  }
  heartbeat_->publish(loop_.now(), report, loop_.statistics());
}

}  // namespace hecaton::services
