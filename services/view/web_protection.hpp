#pragma once
/// What protects a page that other machines can reach: encryption, and a token without which nothing is shown.

#include <optional>
#include <string>

#include "services/config/cell_file.hpp"
#include "services/view/web_server.hpp"

namespace hecaton::services {

struct WebProtection {
  WebCertificate certificate;
  std::string fingerprint;  ///< of the certificate (SHA-256); people compare it with what their browser shows
  bool self_signed = true;  ///< browsers warn of it
  std::string token;        ///< admits to the page
};

/// Empty: only programs of this host reach the page. Without a certificate of the user it takes one that it has made
/// itself, and keeps that in $STATE_DIRECTORY, which systemd sets, or in hecaton/ below $XDG_STATE_HOME or
/// ~/.local/state. `token`: of a view that had one before its restart; empty: a new one. Throws std::runtime_error with
/// a sentence.
[[nodiscard]] std::optional<WebProtection> protection_of(const config::View& view, const std::string& token = {});

/// Lets the server encrypt, and admit holders of the token and of `control_token` (empty: there is none) only. Does
/// nothing without protection.
void protect(WebServerOptions& web, const std::optional<WebProtection>& protection,
             const std::string& control_token = {});

/// The address that admits to the page at `url`.
[[nodiscard]] std::string admitting_url(const std::string& url, const std::optional<WebProtection>& protection);

/// What a person should know before the browser warns; empty: it does not.
[[nodiscard]] std::optional<std::string> certificate_note(const std::optional<WebProtection>& protection);

}  // namespace hecaton::services
