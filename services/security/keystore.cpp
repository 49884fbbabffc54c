#include "services/security/keystore.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <set>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

#include <fcntl.h>
#include <openssl/err.h>

#include "services/security/certificate.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;
using namespace pki;

constexpr const char* kAuthority = "hecaton authority";

fs::path private_key_file(const fs::path& keystore) {
  return keystore / "private" / "ca.key.pem";
}
fs::path authority_file(const fs::path& keystore) {
  return keystore / "public" / "ca.cert.pem";
}
fs::path issued_file(const fs::path& keystore) {
  return keystore / "private" / "issued";
}
fs::path governance_file(const fs::path& keystore) {
  return keystore / "enclaves" / "governance.p7s";
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) fs::permissions(folder, fs::perms::owner_all, error);
  if (error) fail(folder, "cannot be made: " + error.message());
}

/// `of`: "a host". The name of a host becomes a folder and a part of a subject, that of an arm a partition.
void require_name(const fs::path& folder, const std::string& of, const std::string& name) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.'; };
  if (!name.empty() && name.size() <= 63 && name.front() != '.' && std::all_of(name.begin(), name.end(), allowed))
    return;
  throw KeystoreError(folder.string() + ": the name of " + of +
                      " has 1 to 63 letters, digits, '-', '_' and '.', and begins with no dot; it is \"" + name + "\"");
}

void require_names(const fs::path& folder, const std::string& host, const std::vector<Duty>& duties) {
  require_name(folder, "a host", host);
  for (const Duty& duty : duties) {
    for (const std::string& arm : duty.arms) require_name(folder, "an arm", arm);
  }
}

struct Authority {
  Certificate certificate;
  Key key;
};

Authority read_authority(const fs::path& keystore) {
  Authority authority{read_certificate(authority_file(keystore)), read_key(private_key_file(keystore))};
  if (X509_check_private_key(authority.certificate.get(), authority.key.get()) != 1) {
    fail(private_key_file(keystore), "is not the key of " + authority_file(keystore).string());
  }
  return authority;
}

void replicate(const fs::path& from, const fs::path& to) {
  write_file(to, read_file(from));
}

/// What the identities of a host are for.
std::vector<Duty> duties_of(const fs::path& keystore, const std::string& host) {
  std::vector<Duty> duties;
  for (const Role role : kRoles) {
    const fs::path enclave = enclave_folder(keystore, host, role);
    if (!fs::exists(enclave)) continue;
    const fs::path permissions = enclave / "permissions.xml";
    duties.push_back({role, fs::exists(permissions) ? arms_in(read_file(permissions)) : std::vector<std::string>()});
  }
  return duties;
}

[[noreturn]] void fail_without_host(const fs::path& keystore, const std::string& host) {
  throw KeystoreError(keystore.string() + ": has no identities of host " + host +
                      "; `hecaton keystore check` lists the hosts, and `hecaton keystore add` makes identities");
}

/// "SERIAL HOST/ROLE" of each certificate, a line each.
void note_issued(const fs::path& keystore, const std::vector<std::string>& lines) {
  const fs::path file = issued_file(keystore);
  std::string content = fs::exists(file) ? read_file(file) : std::string();
  for (const std::string& line : lines) content += line + "\n";
  write_file(file, content);
}

/// Serial numbers, hexadecimal.
std::set<std::string> issued_for(const fs::path& keystore, const std::string& host) {
  std::set<std::string> serials;
  if (fs::exists(issued_file(keystore))) {
    std::istringstream lines(read_file(issued_file(keystore)));
    std::string serial;
    std::string identity;
    while (lines >> serial >> identity) {
      if (identity.substr(0, identity.find('/')) == host) serials.insert(serial);
    }
  }
  for (const Duty& duty : duties_of(keystore, host)) {
    const Certificate certificate = read_certificate(enclave_folder(keystore, host, duty.role) / "cert.pem");
    serials.insert(serial_of(certificate.get()));
  }
  return serials;
}

/// `folder` comes in place of `replaced`, which may exist. A reader finds the one or the other.
void put_in_place(const fs::path& folder, const fs::path& replaced) {
  std::error_code error;
  if (fs::exists(replaced)) {
    if (::renameat2(AT_FDCWD, folder.c_str(), AT_FDCWD, replaced.c_str(), RENAME_EXCHANGE) == 0) {
      fs::remove_all(folder, error);
      return;
    }
    // A file system that cannot exchange folders.
    const fs::path old = folder.string() + ".old";
    fs::remove_all(old, error);
    fs::rename(replaced, old, error);
    if (error) fail(replaced, "cannot be replaced: " + error.message());
    fs::rename(folder, replaced, error);
    if (error) fs::rename(old, replaced);
    std::error_code ignored;
    fs::remove_all(old, ignored);
  } else {
    fs::rename(folder, replaced, error);
  }
  if (error) fail(replaced, "cannot be replaced: " + error.message());
}

/// A name of an identity that no revoked certificate has. Running services refuse revoked names for good.
std::string unrevoked_name(const fs::path& keystore, const std::string& host, Role role, X509_CRL* revoked) {
  const std::vector<GuidBeginning> all = beginnings_in(revoked);
  const std::string first = "/" + host + "/" + std::string(role_name(role));
  for (int generation = 1;; ++generation) {
    std::string name = generation == 1 ? first : first + "/" + std::to_string(generation);
    if (std::find(all.begin(), all.end(), beginning_of(name, keystore)) == all.end()) return name;
  }
}

/// Makes an identity in `folder`. Returns its line for note_issued().
std::string make_identity(const fs::path& folder, const fs::path& keystore, const Authority& authority,
                          const std::string& host, const Duty& duty, std::chrono::days validity, X509_CRL* revoked) {
  make_folder(folder);
  const Key key = new_key(folder / "key.pem");
  const Certificate certificate =
      new_certificate(folder / "cert.pem", key.get(), unrevoked_name(keystore, host, duty.role, revoked),
                      authority.certificate.get(), authority.key.get(), validity);
  const std::string permissions = permissions_xml(duty.role, subject_of(certificate.get()), begin_of(certificate.get()),
                                                  end_of(certificate.get()), duty.arms);
  write_file(folder / "permissions.xml", permissions);
  write_signed(folder / "permissions.p7s", permissions, authority.certificate.get(), authority.key.get());
  replicate(authority_file(keystore), folder / "identity_ca.cert.pem");
  replicate(authority_file(keystore), folder / "permissions_ca.cert.pem");
  replicate(governance_file(keystore), folder / "governance.p7s");
  return serial_of(certificate.get()) + " " + host + "/" + std::string(role_name(duty.role));
}

/// New identities in place of the present ones of the same roles.
void make_identities(const fs::path& keystore, const std::string& host, std::chrono::days validity,
                     const std::vector<Duty>& duties) {
  const Authority authority = read_authority(keystore);
  if (end_of(authority.certificate.get()) < std::chrono::system_clock::now() + validity) {
    throw KeystoreError(authority_file(keystore).string() +
                        ": expires before the new identities would; give fewer --days");
  }
  const RevocationList revoked = read_revocations(revocations_file(keystore), authority.certificate.get());
  const auto next = [&](Role role) {
    return keystore / "enclaves" / host / ("." + std::string(role_name(role)) + ".new");
  };
  make_folder(keystore / "enclaves" / host);
  std::vector<std::string> issued;
  for (const Duty& duty : duties) {
    std::error_code error;
    fs::remove_all(next(duty.role), error);  // of a run that was interrupted
    issued.push_back(make_identity(next(duty.role), keystore, authority, host, duty, validity, revoked.get()));
  }
  note_issued(keystore, issued);
  for (const Duty& duty : duties) put_in_place(next(duty.role), enclave_folder(keystore, host, duty.role));
}

void require_valid_now(const fs::path& file, Time begins, Time ends) {
  const Time now = std::chrono::system_clock::now();
  if (now >= ends) {
    throw KeystoreError(file.string() + ": has expired on " + xml_time(ends) +
                        " UTC; `hecaton keystore renew` makes new identities");
  }
  if (now < begins) {
    throw KeystoreError(file.string() + ": is valid from " + xml_time(begins) +
                        " UTC on; is the clock of this machine right?");
  }
}

}  // namespace

void create_keystore(const fs::path& folder, std::chrono::days validity) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    throw KeystoreError(folder.string() + ": exists and is not empty; choose another folder, or remove it first");
  }
  make_folder(folder);
  for (const char* part : {"public", "private", "enclaves"}) make_folder(folder / part);
  const Key key = new_key(private_key_file(folder));
  const Certificate certificate =
      new_certificate(authority_file(folder), key.get(), kAuthority, nullptr, key.get(), validity);
  write_file(folder / "enclaves" / "governance.xml", governance_xml());
  write_signed(governance_file(folder), governance_xml(), certificate.get(), key.get());
}

void require_addable(const fs::path& folder, const std::string& host, const std::vector<Duty>& duties) {
  require_names(folder, host, duties);
  for (const Duty& duty : duties) {
    const fs::path enclave = enclave_folder(folder, host, duty.role);
    if (!fs::exists(enclave)) continue;
    throw KeystoreError(enclave.string() + ": exists already; `hecaton keystore renew` makes new keys for " + host +
                        "; for other roles or arms, use `hecaton keystore revoke` first");
  }
}

void add_identities(const fs::path& folder, const std::string& host, std::chrono::days validity,
                    const std::vector<Duty>& duties) {
  require_addable(folder, host, duties);
  make_identities(folder, host, validity, duties);
}

void add_host(const fs::path& folder, const std::string& host, std::chrono::days validity,
              const std::vector<std::string>& arms) {
  const std::vector<Duty> all = all_duties(arms);
  require_names(folder, host, all);
  for (const Duty& present : duties_of(folder, host)) {
    if (!arms.empty() || present.arms.empty()) continue;
    std::string list;
    for (const std::string& arm : present.arms) list += (list.empty() ? "" : ", ") + arm;
    throw KeystoreError(folder.string() + ": " + host + " may command " + list +
                        " only; name the arms of its new identities with --arms, or make the same anew with `hecaton "
                        "keystore renew`");
  }
  make_identities(folder, host, validity, all);
}

void renew_host(const fs::path& folder, const std::string& host, std::chrono::days validity) {
  require_name(folder, "a host", host);
  const std::vector<Duty> duties = duties_of(folder, host);
  if (duties.empty()) fail_without_host(folder, host);
  make_identities(folder, host, validity, duties);
}

void revoke_host(const fs::path& folder, const std::string& host) {
  require_name(folder, "a host", host);
  const Authority authority = read_authority(folder);
  const fs::path file = revocations_file(folder);
  const std::set<std::string> serials = issued_for(folder, host);
  if (serials.empty()) fail_without_host(folder, host);
  write_revocations(file, read_revocations(file, authority.certificate.get()), {serials.begin(), serials.end()},
                    authority.certificate.get(), authority.key.get());
  std::error_code error;
  fs::remove_all(folder / "enclaves" / host, error);
  if (error) fail(folder / "enclaves" / host, "is revoked, but cannot be removed: " + error.message());
}

std::vector<std::string> hosts_in(const fs::path& keystore) {
  std::vector<std::string> hosts;
  for (const IdentityState& one : identities_in(keystore)) {
    if (hosts.empty() || hosts.back() != one.host) hosts.push_back(one.host);
  }
  return hosts;
}

fs::path revocations_file(const fs::path& keystore) {
  return keystore / "enclaves" / "crl.pem";
}

fs::path keystore_of(const fs::path& enclave) {
  return enclave.parent_path().parent_path().parent_path();
}

RevocationWatch::RevocationWatch(fs::path enclave) : enclave_(std::move(enclave)) {}

const std::vector<GuidBeginning>& RevocationWatch::update() {
  const fs::path file = revocations_file(keystore_of(enclave_));
  std::error_code error;
  const auto written = fs::last_write_time(file, error);
  const auto size = error ? 0 : fs::file_size(file, error);
  if (error || (written == written_ && size == size_)) return revoked_;
  try {
    const Certificate authority = read_certificate(enclave_ / "identity_ca.cert.pem");
    for (const GuidBeginning& one : beginnings_in(read_revocations(file, authority.get()).get())) {
      if (std::find(revoked_.begin(), revoked_.end(), one) == revoked_.end()) revoked_.push_back(one);
    }
    written_ = written;
    size_ = size;
    problem_.clear();
  } catch (const KeystoreError& unusable) {
    problem_ = unusable.what();  // it may be incomplete: read again
  }
  return revoked_;
}

fs::path enclave_folder(const fs::path& keystore, const std::string& host, Role role) {
  return keystore / "enclaves" / host / role_name(role);
}

void require_identity(const fs::path& enclave) {
  for (const char* file : {"governance.p7s", "permissions.p7s", "permissions_ca.cert.pem"}) {
    static_cast<void>(read_file(enclave / file));
  }
  const Certificate authority = read_certificate(enclave / "identity_ca.cert.pem");
  const fs::path file = enclave / "cert.pem";
  const Certificate certificate = read_certificate(file);
  const Key key = read_key(enclave / "key.pem");
  if (X509_check_private_key(certificate.get(), key.get()) != 1)
    fail(enclave / "key.pem", "is not the key of cert.pem");
  const Key of_authority(X509_get_pubkey(authority.get()));
  if (X509_verify(certificate.get(), of_authority.get()) != 1) {
    ERR_clear_error();
    fail(file, "is not signed by identity_ca.cert.pem beside it");
  }
  const RevocationList revoked = read_revocations(revocations_file(keystore_of(enclave)), authority.get());
  X509_REVOKED* entry = nullptr;
  if (revoked != nullptr && X509_CRL_get0_by_cert(revoked.get(), &entry, certificate.get()) != 0) {
    throw KeystoreError(file.string() + ": is revoked; `hecaton keystore add` makes new identities");
  }
  require_valid_now(enclave / "cert.pem", begin_of(certificate.get()), end_of(certificate.get()));
  require_valid_now(enclave / "identity_ca.cert.pem", begin_of(authority.get()), end_of(authority.get()));
  if (const auto permitted = permissions_expiry(read_file(enclave / "permissions.p7s"))) {
    require_valid_now(enclave / "permissions.p7s", Time(), *permitted);
  }
}

std::optional<std::string> outdated_permissions(const fs::path& enclave) {
  const auto role = std::find_if(kRoles.begin(), kRoles.end(),
                                 [&](Role one) { return role_name(one) == enclave.filename().string(); });
  if (role == kRoles.end()) return std::nullopt;
  const std::vector<std::string> missing = missing_permissions(*role, read_file(enclave / "permissions.p7s"));
  if (missing.empty()) return std::nullopt;
  const std::string more = missing.size() > 1 ? " and " + std::to_string(missing.size() - 1) + " more" : "";
  return "permissions are older than this program: the identity " + missing.front() + more +
         "; `hecaton keystore renew` makes new ones";
}

Time expiry_of(const fs::path& enclave) {
  Time first = end_of(read_certificate(enclave / "cert.pem").get());
  for (const char* authority : {"identity_ca.cert.pem", "permissions_ca.cert.pem"}) {
    first = std::min(first, end_of(read_certificate(enclave / authority).get()));
  }
  return std::min(first, permissions_expiry(read_file(enclave / "permissions.p7s")).value_or(first));
}

std::vector<IdentityState> identities_in(const fs::path& keystore) {
  std::error_code error;
  std::vector<IdentityState> found;
  for (const auto& host : fs::directory_iterator(keystore / "enclaves", error)) {
    if (!host.is_directory()) continue;
    for (const Role role : kRoles) {
      const fs::path enclave = enclave_folder(keystore, host.path().filename().string(), role);
      if (!fs::exists(enclave)) continue;
      IdentityState& state = found.emplace_back(
          IdentityState{host.path().filename().string(), std::string(role_name(role)), {}, {}, {}, {}});
      try {
        state.expires = end_of(read_certificate(enclave / "cert.pem").get());
        state.expires = expiry_of(enclave);  // of the certificate alone when other files are missing
        require_identity(enclave);
        state.arms = arms_in(read_file(enclave / "permissions.xml"));
        state.outdated = outdated_permissions(enclave);
      } catch (const KeystoreError& problem) {
        state.problem = problem.what();
      }
    }
  }
  if (error) throw KeystoreError((keystore / "enclaves").string() + ": " + error.message() + "; is this a keystore?");
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return std::tie(a.host, a.role) < std::tie(b.host, b.role); });
  return found;
}

}  // namespace hecaton::services
