#pragma once
/// The keys of a secured cell: a folder in the layout of SROS2, with one identity for each role on each host
/// (docs/explanation/security.md).
///
///     DIR/public/ca.cert.pem             the certificate of the authority, which signs everything below
///     DIR/private/ca.key.pem             its private key; no host of the cell needs it
///     DIR/enclaves/governance.{xml,p7s}  what the middleware protects
///     DIR/enclaves/HOST/ROLE/            an identity: key.pem, cert.pem, permissions.{xml,p7s}, and copies of the
///     files
///                                        above as governance.p7s, identity_ca.cert.pem and permissions_ca.cert.pem
///
/// Functions throw KeystoreError. They are not thread-safe for one folder.

#include <array>
#include <chrono>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::services {

/// A sentence that names the file.
struct KeystoreError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a participant may do. An operator gives goals and orders and edits obstacles. A viewer only reads.
enum class Role { kAgent, kSupervisor, kWorld, kDriver, kPlanner, kOperator, kViewer };
inline constexpr std::array kRoles{Role::kAgent,   Role::kSupervisor, Role::kWorld, Role::kDriver,
                                   Role::kPlanner, Role::kOperator,   Role::kViewer};
/// "planner"
[[nodiscard]] std::string_view role_name(Role role);

/// The permissions of a role (DDS Security 1.1, section 9.4.1.3) for the identity with this subject. They allow exactly
/// the topics that the table of topics has for the role.
[[nodiscard]] std::string permissions_xml(Role role, const std::string& subject,
                                          std::chrono::system_clock::time_point from,
                                          std::chrono::system_clock::time_point until);

/// Makes the authority of a new keystore. `folder` must not exist, or be empty.
void create_keystore(const std::filesystem::path& folder, std::chrono::days validity);

/// Makes identities of all roles on a host, or new ones in place of present ones. `host`: its name in the cell file.
/// Needs the private key of the authority.
void add_host(const std::filesystem::path& folder, const std::string& host, std::chrono::days validity);

/// The folder of an identity.
[[nodiscard]] std::filesystem::path enclave_folder(const std::filesystem::path& keystore, const std::string& host,
                                                   Role role);

/// Throws when the identity in this folder cannot be used now. A file is missing or unreadable; or a certificate has
/// expired, is not valid yet, is not signed by the authority, or belongs to another key.
void require_identity(const std::filesystem::path& enclave);

/// The state of an identity.
struct IdentityState {
  std::string host;
  std::string role;
  std::chrono::system_clock::time_point expires;
  std::optional<std::string> problem;  ///< a sentence; empty: it can be used
};

/// All identities of a keystore, sorted by host and role.
[[nodiscard]] std::vector<IdentityState> identities_in(const std::filesystem::path& keystore);

}  // namespace hecaton::services
