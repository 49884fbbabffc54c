#pragma once
/// The keys of a secured cell: a folder in the layout of SROS2, with one identity for each role on each host
/// (docs/explanation/security.md).
///
///     DIR/public/ca.cert.pem             the certificate of the authority, which signs everything below
///     DIR/private/ca.key.pem             its private key; no host of the cell needs it
///     DIR/private/issued                 the serial number and the identity of each certificate that it has signed
///     DIR/enclaves/governance.{xml,p7s}  what the middleware protects
///     DIR/enclaves/crl.pem               the list of revoked certificates, once there is one; each host needs it
///     DIR/enclaves/HOST/ROLE/            an identity: key.pem, cert.pem, permissions.{xml,p7s}, and copies of files
///                                        above as governance.p7s, identity_ca.cert.pem and permissions_ca.cert.pem
///
/// The serial number of a certificate begins with its GuidBeginning. So the list of revoked certificates, which has
/// only serial numbers, also names the participants.
///
/// Functions throw KeystoreError. They are not thread-safe for one folder.

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "services/security/permissions.hpp"

namespace hecaton::services {

/// A sentence that names the file.
struct KeystoreError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The first six bytes of the GUIDs of an identity's participants, see bus::GuidBeginning.
using GuidBeginning = std::array<std::uint8_t, 6>;

/// In place of a host: the identities of persons who use `hecaton`. No service uses them.
inline constexpr const char* kPeople = "people";

/// Makes the authority of a new keystore. `folder` must not exist, or be empty.
void create_keystore(const std::filesystem::path& folder, std::chrono::days validity);

/// Makes identities of all roles on a host, or new ones in place of present ones. `host`: its name in the cell file. A
/// host whose identities were revoked gets another subject. Needs the private key of the authority, as renew_host() and
/// revoke_host() do. An identity is replaced as a whole, and none before all new ones are complete. `arms`: the
/// planners and drivers of this host may command, or obey for, these arms only. Empty: all arms. A host with identities
/// for some arms only is refused then: they must be named.
void add_host(const std::filesystem::path& folder, const std::string& host, std::chrono::days validity,
              const std::vector<std::string>& arms = {});

/// Makes identities for these duties only, and replaces none: see require_addable(). Each role at most once.
void add_identities(const std::filesystem::path& folder, const std::string& host, std::chrono::days validity,
                    const std::vector<Duty>& duties);

/// Throws when add_identities() would refuse these duties: the host or an arm has a name that identities cannot have,
/// or the host has an identity of one of these roles. Writes nothing.
void require_addable(const std::filesystem::path& folder, const std::string& host, const std::vector<Duty>& duties);

/// Makes new keys and certificates for the identities that a host has, for the same arms. The old ones stay valid until
/// they expire.
void renew_host(const std::filesystem::path& folder, const std::string& host, std::chrono::days validity);

/// Enters all certificates of a host into the list of revoked certificates, and removes its identities.
void revoke_host(const std::filesystem::path& folder, const std::string& host);

/// The hosts that have an identity, sorted.
[[nodiscard]] std::vector<std::string> hosts_in(const std::filesystem::path& keystore);

/// The list of revoked certificates. The file need not exist.
[[nodiscard]] std::filesystem::path revocations_file(const std::filesystem::path& keystore);
/// The keystore of an identity, from its folder.
[[nodiscard]] std::filesystem::path keystore_of(const std::filesystem::path& enclave);

/// Follows the list of revoked certificates of an identity while a process runs. For one thread.
class RevocationWatch {
 public:
  explicit RevocationWatch(std::filesystem::path enclave);
  /// Looks at the file and returns all participants that it has ever named. A file that is incomplete or not signed by
  /// the authority changes nothing: see problem().
  const std::vector<GuidBeginning>& update();
  /// Why the last update() could not use the file: a sentence; empty: it could, or there is no file.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::filesystem::path enclave_;
  std::filesystem::file_time_type written_{};
  std::uintmax_t size_ = 0;
  std::vector<GuidBeginning> revoked_;
  std::string problem_;
};

/// The folder of an identity.
[[nodiscard]] std::filesystem::path enclave_folder(const std::filesystem::path& keystore, const std::string& host,
                                                   Role role);

/// Throws when the identity in this folder cannot be used now. A file is missing or unreadable; the permissions have
/// expired; or a certificate has expired, is not valid yet, is not signed by the authority, is revoked, or belongs to
/// another key.
void require_identity(const std::filesystem::path& enclave);

/// What this program needs and the permissions of the identity in this folder do not allow: a sentence. They were made
/// by an older program. Empty: nothing.
[[nodiscard]] std::optional<std::string> outdated_permissions(const std::filesystem::path& enclave);

/// When the first of its certificates and permissions expires.
[[nodiscard]] std::chrono::system_clock::time_point expiry_of(const std::filesystem::path& enclave);

/// The state of an identity.
struct IdentityState {
  std::string host;
  std::string role;
  std::chrono::system_clock::time_point expires;
  std::vector<std::string> arms;        ///< that it may command or obey for; empty: all, or its role concerns no arm
  std::optional<std::string> problem;   ///< a sentence; empty: it can be used
  std::optional<std::string> outdated;  ///< see outdated_permissions(), of one that can be used
};

/// All identities of a keystore, sorted by host and role.
[[nodiscard]] std::vector<IdentityState> identities_in(const std::filesystem::path& keystore);

}  // namespace hecaton::services
