#pragma once
/// What a browser's request to web_server.cpp tells about the page that sends it, and about its tokens.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <boost/beast/core/string.hpp>
#include <boost/beast/http.hpp>

namespace hecaton::services {

using Request = boost::beast::http::request<boost::beast::http::string_body>;

[[nodiscard]] std::string_view view_of(boost::beast::string_view text);

/// The Host header is an IPv4 address, localhost, or this machine's name.
[[nodiscard]] bool is_own_host(std::string_view host);

/// A browser sends the Origin of the page that opens a WebSocket; other programs send none. `scheme`: "https://".
[[nodiscard]] bool is_same_origin(const Request& request, std::string_view scheme);

/// Of WebSockets with a sub-protocol: "/" or "/?token=TOKEN".
[[nodiscard]] bool is_protocol_target(std::string_view target);
/// That token; empty: there is none.
[[nodiscard]] std::string token_in(std::string_view target);
/// The token of "/?watch=TOKEN", the address of a page; empty: there is none.
[[nodiscard]] std::string_view watch_token_in(std::string_view target);

/// Browsers send cookies to all ports of a host.
[[nodiscard]] std::string cookie_name(std::uint16_t port);
/// The value of this cookie; empty: the browser sends none.
[[nodiscard]] std::string_view cookie_in(const Request& request, std::string_view name);

/// The first of `names` of sub-protocols that the client offers; empty: none.
[[nodiscard]] std::string offered(const Request& request, const std::vector<std::string>& names);

}  // namespace hecaton::services
