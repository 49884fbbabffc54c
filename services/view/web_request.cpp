#include "services/view/web_request.hpp"

#include <algorithm>

#include <boost/asio/ip/address_v4.hpp>
#include <boost/asio/ip/host_name.hpp>

namespace hecaton::services {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Error = beast::error_code;

constexpr std::string_view kProtocolTarget = "/";
constexpr std::string_view kTokenTarget = "/?token=";
constexpr std::string_view kWatchTarget = "/?watch=";

/// The Host header without its port.
std::string_view name_in(std::string_view host) {
  return host.substr(0, host.rfind(':'));
}

std::string_view behind(std::string_view beginning, std::string_view target) {
  return target.starts_with(beginning) ? target.substr(beginning.size()) : std::string_view();
}

}  // namespace

std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}

bool is_own_host(std::string_view host) {
  const std::string_view name = name_in(host);
  if (name == "localhost") return true;
  Error not_an_address;
  static_cast<void>(asio::ip::make_address_v4(std::string(name), not_an_address));
  if (!not_an_address) return true;
  Error unknown;
  return name == asio::ip::host_name(unknown) && !unknown;
}

bool is_same_origin(const Request& request, std::string_view scheme) {
  const auto origin = request.find(http::field::origin);
  if (origin == request.end()) return true;
  const std::string_view text = view_of(origin->value());
  return text.starts_with(scheme) && text.substr(scheme.size()) == view_of(request[http::field::host]);
}

bool is_protocol_target(std::string_view target) {
  return target == kProtocolTarget || target.starts_with(kTokenTarget);
}

std::string token_in(std::string_view target) {
  return std::string(behind(kTokenTarget, target));
}

std::string_view watch_token_in(std::string_view target) {
  return behind(kWatchTarget, target);
}

std::string cookie_name(std::uint16_t port) {
  return "hecaton_" + std::to_string(port);
}

std::string_view cookie_in(const Request& request, std::string_view name) {
  std::string_view cookies = view_of(request[http::field::cookie]);
  while (!cookies.empty()) {
    const std::string_view cookie = cookies.substr(0, cookies.find(';'));
    cookies.remove_prefix(std::min(cookies.size(), cookie.size() + 1));
    const std::string_view pair = cookie.substr(std::min(cookie.size(), cookie.find_first_not_of(' ')));
    const std::size_t equals = pair.find('=');
    if (equals != std::string_view::npos && pair.substr(0, equals) == name) return pair.substr(equals + 1);
  }
  return {};
}

std::string offered(const Request& request, const std::vector<std::string>& names) {
  const beast::string_view field = request[http::field::sec_websocket_protocol];
  const http::token_list tokens{field};
  for (const std::string& name : names) {
    if (std::any_of(tokens.begin(), tokens.end(), [&](const auto& token) { return view_of(token) == name; }))
      return name;
  }
  return {};
}

}  // namespace hecaton::services
