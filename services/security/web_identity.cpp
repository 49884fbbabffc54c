#include "services/security/web_identity.hpp"

#include <array>
#include <chrono>
#include <cstdio>
#include <system_error>

#include <arpa/inet.h>
#include <sys/stat.h>

#include "services/security/certificate.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::days kValidity{365};
constexpr std::chrono::days kRenewed{30};  // before the end

std::string fingerprint_of(const X509* certificate, const fs::path& file) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
  unsigned int size = 0;
  if (X509_digest(certificate, EVP_sha256(), hash.data(), &size) != 1) pki::fail(file, "has no digest");
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    std::array<char, 4> byte{};
    std::snprintf(byte.data(), byte.size(), "%s%02X", i == 0 ? "" : ":", hash.at(i));
    text += byte.data();
  }
  return text;
}

/// In the notation of OpenSSL.
std::string alternative_names(const std::vector<std::string>& addresses) {
  std::string names;
  for (const std::string& address : addresses) {
    in_addr parsed{};
    const bool is_ip = inet_pton(AF_INET, address.c_str(), &parsed) == 1;
    names += (names.empty() ? "" : ",") + std::string(is_ip ? "IP:" : "DNS:") + address;
  }
  return names;
}

}  // namespace

WebIdentity read_web_identity(const fs::path& certificate, const fs::path& key) {
  const pki::Certificate read = pki::read_certificate(certificate);
  const pki::Key secret = pki::read_key(key);
  if (X509_check_private_key(read.get(), secret.get()) != 1) {
    pki::fail(key, "is not the private key of " + certificate.string());
  }
  if (pki::end_of(read.get()) < std::chrono::system_clock::now()) pki::fail(certificate, "has expired");
  return {pki::read_file(certificate), pki::read_file(key), fingerprint_of(read.get(), certificate)};
}

WebIdentity self_signed_web_identity(const fs::path& folder, const std::vector<std::string>& addresses) {
  const fs::path certificate = folder / "page-certificate.pem";
  const fs::path key = folder / "page-key.pem";
  std::error_code error;
  if (fs::exists(certificate, error) && fs::exists(key, error) &&
      pki::end_of(pki::read_certificate(certificate).get()) > std::chrono::system_clock::now() + kRenewed) {
    return read_web_identity(certificate, key);
  }
  const mode_t before = ::umask(077);
  fs::create_directories(folder, error);
  ::umask(before);
  if (error) pki::fail(folder, "cannot be made: " + error.message());
  const pki::Key made = pki::new_key(key);
  static_cast<void>(pki::new_certificate(certificate, made.get(), "Hecaton page of " + addresses.front(), nullptr,
                                         made.get(), kValidity, alternative_names(addresses)));
  return read_web_identity(certificate, key);
}

}  // namespace hecaton::services
