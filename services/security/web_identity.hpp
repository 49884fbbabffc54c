#pragma once
/// Certificate and private key with which a page that other machines can reach proves its name.

#include <filesystem>
#include <string>
#include <vector>

namespace hecaton::services {

struct WebIdentity {
  std::string chain;        ///< the certificate and those that lead to its authority, PEM
  std::string key;          ///< private, PEM
  std::string fingerprint;  ///< SHA-256 of the certificate, as browsers show it: "AB:CD:…"
};

/// Reads files of the user. Throws KeystoreError with a sentence when they do not belong together, or have expired.
[[nodiscard]] WebIdentity read_web_identity(const std::filesystem::path& certificate, const std::filesystem::path& key);

/// Reads the identity that `folder` keeps. Makes one, signed by itself, when there is none, or when its certificate
/// ends within 30 days. `addresses`: under which the page is reached, host names and IPv4 addresses. Files and folder
/// are for their user only. Throws KeystoreError with a sentence.
[[nodiscard]] WebIdentity self_signed_web_identity(const std::filesystem::path& folder,
                                                   const std::vector<std::string>& addresses);

}  // namespace hecaton::services
