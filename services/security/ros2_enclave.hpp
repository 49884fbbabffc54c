#pragma once
/// The identity of a program among nodes of ROS 2 with keys: the enclave that `ros2 security create_enclave` makes.

#include <chrono>
#include <filesystem>
#include <string>

namespace hecaton::services {

struct Ros2Enclave {
  std::string name;                               ///< "/hecaton": the common name of its certificate
  std::filesystem::path revocations;              ///< its list of revoked certificates; empty: it has none
  std::chrono::system_clock::time_point expires;  ///< the first of its certificates and permissions
};

/// The enclave in this folder, with the files key.pem, cert.pem, identity_ca.cert.pem, permissions_ca.cert.pem,
/// governance.p7s, permissions.p7s and perhaps crl.pem. Throws KeystoreError with a sentence that names the file: it is
/// missing or unreadable, has expired, is signed by another authority, belongs to another key, or its governance lets
/// participants without keys in.
[[nodiscard]] Ros2Enclave read_ros2_enclave(const std::filesystem::path& folder);

}  // namespace hecaton::services
