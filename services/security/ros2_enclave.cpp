#include "services/security/ros2_enclave.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <openssl/err.h>

#include "services/security/certificate.hpp"
#include "services/security/permissions.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;
using namespace pki;

constexpr std::string_view kRemedy = "; `ros2 security create_enclave` makes an enclave";

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw KeystoreError(file.string() + ": " + what);
}

void require_not_expired(const fs::path& file, Time begins, Time ends) {
  const Time now = std::chrono::system_clock::now();
  if (now >= ends) refuse(file, "has expired on " + xml_time(ends) + " UTC" + std::string(kRemedy));
  if (now < begins) refuse(file, "is valid from " + xml_time(begins) + " UTC on; is the clock of this machine right?");
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kSpace);
  return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

/// The contents of all elements of this name.
std::vector<std::string_view> contents(std::string_view document, std::string_view element) {
  const std::string tag = std::string(element) + ">";
  std::vector<std::string_view> all;
  for (std::size_t at = document.find("<" + tag); at != std::string_view::npos; at = document.find("<" + tag, at + 1)) {
    const std::size_t begin = at + tag.size() + 1;
    const std::size_t end = document.find("</" + tag, begin);
    if (end == std::string_view::npos) break;
    all.push_back(trimmed(document.substr(begin, end - begin)));
  }
  return all;
}

/// Otherwise participants without keys could send what the service reads.
void require_protection(const fs::path& file, std::string_view governance) {
  const auto check = [&](std::string_view element, const auto& allowed, const char* what) {
    const auto found = contents(governance, element);
    if (found.empty()) refuse(file, "has no " + std::string(element) + ", which must be " + what);
    for (const std::string_view value : found) {
      if (!allowed(value)) {
        refuse(file, std::string(element) + " = " + std::string(value.substr(0, 64)) + " must be " + what);
      }
    }
  };
  check(
      "allow_unauthenticated_participants", [](std::string_view value) { return value == "false" || value == "0"; },
      "false");
  check(
      "rtps_protection_kind",
      [](std::string_view value) { return value.starts_with("SIGN") || value.starts_with("ENCRYPT"); },
      "SIGN or ENCRYPT, because the service discards datagrams that are neither");
}

std::string common_name(const std::string& subject) {
  constexpr std::string_view kPrefix = "CN=";
  const std::size_t at = subject.find(kPrefix);
  return at == std::string::npos ? subject : subject.substr(at + kPrefix.size(), subject.find(',', at) - at - 3);
}

}  // namespace

Ros2Enclave read_ros2_enclave(const fs::path& folder) {
  if (!fs::is_directory(folder)) refuse(folder, "is no folder" + std::string(kRemedy));
  const fs::path certificate_file = folder / "cert.pem";
  const Certificate certificate = read_certificate(certificate_file);
  const Key key = read_key(folder / "key.pem");
  const Certificate authority = read_certificate(folder / "identity_ca.cert.pem");
  const Certificate permissions_authority = read_certificate(folder / "permissions_ca.cert.pem");
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    ERR_clear_error();
    refuse(folder / "key.pem", "is not the key of cert.pem beside it");
  }
  const Key of_authority(X509_get_pubkey(authority.get()));
  if (X509_verify(certificate.get(), of_authority.get()) != 1) {
    ERR_clear_error();
    refuse(certificate_file, "is not signed by identity_ca.cert.pem beside it");
  }
  const std::vector<std::pair<const char*, X509*>> all{{"cert.pem", certificate.get()},
                                                       {"identity_ca.cert.pem", authority.get()},
                                                       {"permissions_ca.cert.pem", permissions_authority.get()}};
  Ros2Enclave enclave;
  enclave.expires = end_of(certificate.get());
  for (const auto& [name, one] : all) {
    require_not_expired(folder / name, begin_of(one), end_of(one));
    enclave.expires = std::min(enclave.expires, end_of(one));
  }
  const fs::path governance_file = folder / "governance.p7s";
  require_protection(governance_file, read_signed(governance_file, permissions_authority.get()));
  const fs::path permissions_file = folder / "permissions.p7s";
  const std::string permissions = read_signed(permissions_file, permissions_authority.get());
  const std::string subject = subject_of(certificate.get());
  const auto subjects = contents(permissions, "subject_name");
  if (std::find(subjects.begin(), subjects.end(), subject) == subjects.end()) {
    refuse(permissions_file, "has no grant for " + subject + ", the subject of cert.pem beside it");
  }
  if (const auto permitted = permissions_expiry(permissions)) {
    require_not_expired(permissions_file, Time(), *permitted);
    enclave.expires = std::min(enclave.expires, *permitted);
  }
  if (const fs::path revocations = folder / "crl.pem"; fs::exists(revocations)) {
    static_cast<void>(read_revocations(revocations, authority.get()));
    enclave.revocations = fs::absolute(revocations);
  }
  enclave.name = common_name(subject);
  return enclave;
}

}  // namespace hecaton::services
