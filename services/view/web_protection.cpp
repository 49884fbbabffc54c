#include "services/view/web_protection.hpp"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <unistd.h>

#include "services/security/web_identity.hpp"
#include "services/view/token_file.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;

fs::path state_folder() {
  constexpr std::array<std::pair<const char*, const char*>, 3> kPlaces = {
      {{"STATE_DIRECTORY", ""}, {"XDG_STATE_HOME", "hecaton"}, {"HOME", ".local/state/hecaton"}}};
  for (const auto& [variable, below] : kPlaces) {
    const char* folder = std::getenv(variable);
    if (folder != nullptr && *folder == '/') return fs::path(folder) / below;
  }
  throw std::runtime_error(
      "the page has no folder for its certificate: set HOME, or give certificate and key in the section view of the "
      "cell file");
}

/// By which browsers may reach the page.
std::vector<std::string> addresses_of(const std::string& listen) {
  std::array<char, 256> name{};
  std::vector<std::string> addresses;
  if (::gethostname(name.data(), name.size() - 1) == 0 && name.front() != '\0') addresses.emplace_back(name.data());
  addresses.emplace_back("localhost");
  if (listen != "0.0.0.0") {
    addresses.push_back(listen);
    return addresses;
  }
  ifaddrs* interfaces = nullptr;
  if (::getifaddrs(&interfaces) != 0) return addresses;
  for (const ifaddrs* one = interfaces; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    const auto* address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
    addresses.emplace_back(text.data());
  }
  ::freeifaddrs(interfaces);
  return addresses;
}

}  // namespace

std::optional<WebProtection> protection_of(const config::View& view, const std::string& token) {
  if (!config::is_reachable_by_others(view)) return std::nullopt;
  const bool own = view.certificate.empty();
  const WebIdentity identity = own ? self_signed_web_identity(state_folder(), addresses_of(view.listen))
                                   : read_web_identity(view.certificate, view.key);
  return WebProtection{
      {identity.chain, identity.key}, identity.fingerprint, own, token.empty() ? random_token() : token};
}

void protect(WebServerOptions& web, const std::optional<WebProtection>& protection, const std::string& control_token) {
  if (!protection) return;
  web.certificate = protection->certificate;
  web.admits = [token = protection->token, control_token](std::string_view shown) {
    return same_token(shown, token) || (!control_token.empty() && same_token(shown, control_token));
  };
}

std::string admitting_url(const std::string& url, const std::optional<WebProtection>& protection) {
  return protection ? url + std::string(kWatchMarker) + protection->token : url;
}

std::optional<std::string> certificate_note(const std::optional<WebProtection>& protection) {
  if (!protection || !protection->self_signed) return std::nullopt;
  return "the browser will warn of a certificate that signs itself; its SHA-256 fingerprint must be " +
         protection->fingerprint;
}

}  // namespace hecaton::services
