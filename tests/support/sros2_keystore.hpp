#pragma once
/// Keys as `ros2 security` makes them, by the command line of OpenSSL: one authority, and enclaves with its governance.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace hecaton::test {

class Sros2Keystore {
 public:
  /// `rtps_protection`: of the governance; SROS2 writes SIGN.
  explicit Sros2Keystore(std::filesystem::path folder, const std::string& rtps_protection = "SIGN",
                         const std::string& unauthenticated = "false")
      : folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_ / "enclaves");
    openssl(
        "req -x509 -sha256 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 3650 -subj /CN=sros2CA "
        "-keyout ca.key.pem -out ca.cert.pem");
    std::ofstream(folder_ / "governance.xml") << R"(<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>)" << unauthenticated
                                              << R"(</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>)" << rtps_protection
                                              << R"(</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";
    sign("governance");
  }

  /// Makes the enclave "/NAME" with the permission to publish and subscribe all topics of ROS. Returns its folder.
  std::filesystem::path add(const std::string& name) {
    const std::filesystem::path enclave = folder_ / "enclaves" / name;
    std::filesystem::create_directories(enclave);
    const std::string to = "enclaves/" + name + "/";
    openssl("req -new -sha256 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj '/CN=\\/" + name +
            "' -keyout " + to + "key.pem -out request.pem");
    openssl("x509 -req -sha256 -days 3650 -in request.pem -CA ca.cert.pem -CAkey ca.key.pem -CAcreateserial -out " +
            to + "cert.pem");
    const std::string topics =
        "<topics><topic>ros_discovery_info</topic><topic>rt/*</topic><topic>rq/*</topic>"
        "<topic>rr/*</topic></topics>";
    std::ofstream(folder_ / "permissions.xml") << R"(<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
  xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="/)" << name << R"(">
      <subject_name>CN=/)" << name << R"(</subject_name>
      <validity><not_before>2020-01-01T00:00:00</not_before><not_after>2099-01-01T00:00:00</not_after></validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
        <publish>)" << topics << "</publish>\n        <subscribe>"
                                               << topics << R"(</subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
)";
    sign("permissions");
    const auto copy = [&](const char* from, const char* as) {
      std::filesystem::copy_file(folder_ / from, enclave / as, std::filesystem::copy_options::overwrite_existing);
    };
    copy("permissions.p7s", "permissions.p7s");
    copy("governance.p7s", "governance.p7s");
    copy("ca.cert.pem", "identity_ca.cert.pem");
    copy("ca.cert.pem", "permissions_ca.cert.pem");
    return enclave;
  }

 private:
  void sign(const std::string& document) const {
    openssl("smime -sign -text -in " + document + ".xml -out " + document +
            ".p7s -signer ca.cert.pem -inkey ca.key.pem");
  }
  void openssl(const std::string& words) const {
    const std::string command = "cd '" + folder_.string() + "' && openssl " + words + " 2> openssl.log";
    if (std::system(command.c_str()) != 0) throw std::runtime_error("openssl fails: " + command);
  }

  std::filesystem::path folder_;
};

}  // namespace hecaton::test
