#include "services/security/keystore.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <system_error>

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include "services/bus/topics.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;
using Time = std::chrono::system_clock::time_point;

template <auto kFree>
struct Free {
  template <class T>
  void operator()(T* object) const {
    kFree(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Bio = std::unique_ptr<BIO, Free<BIO_free_all>>;
using Signed = std::unique_ptr<PKCS7, Free<PKCS7_free>>;

constexpr const char* kAuthority = "hecaton authority";
/// Clocks of hosts may differ: certificates begin this long before they are made.
constexpr std::chrono::hours kBefore{1};

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  char reason[256] = "";
  if (const unsigned long code = ERR_peek_last_error(); code != 0) ERR_error_string_n(code, reason, sizeof reason);
  ERR_clear_error();
  throw KeystoreError(file.string() + ": " + what + (*reason == '\0' ? "" : std::string(" (") + reason + ")"));
}

fs::path private_key_file(const fs::path& keystore) {
  return keystore / "private" / "ca.key.pem";
}
fs::path authority_file(const fs::path& keystore) {
  return keystore / "public" / "ca.cert.pem";
}
fs::path governance_file(const fs::path& keystore) {
  return keystore / "enclaves" / "governance.p7s";
}

/// Files of keys are for their owner only. A file is replaced as a whole.
void write_file(const fs::path& file, std::string_view content) {
  const fs::path next = file.string() + ".new";
  const mode_t before = ::umask(077);
  std::ofstream out(next, std::ios::binary | std::ios::trunc);
  out << content;
  out.close();
  ::umask(before);
  std::error_code error;
  if (out) fs::rename(next, file, error);
  if (!out || error) fail(file, "cannot be written");
}

std::string read_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in || content.empty()) fail(file, "is missing, empty or not readable for this user");
  return content;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) fs::permissions(folder, fs::perms::owner_all, error);
  if (error) fail(folder, "cannot be made: " + error.message());
}

Bio memory(const std::string& content) {
  return Bio(BIO_new_mem_buf(content.data(), static_cast<int>(content.size())));
}

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(size)};
}

std::string pem(const std::function<int(BIO*)>& write, const fs::path& file) {
  const Bio bio(BIO_new(BIO_s_mem()));
  if (write(bio.get()) != 1) fail(file, "cannot be encoded");
  return text_of(bio.get());
}

Key new_key(const fs::path& file) {
  Key key(EVP_EC_gen("P-256"));
  if (key == nullptr) fail(file, "no key can be made");
  write_file(file, pem(
                       [&](BIO* bio) {
                         return PEM_write_bio_PKCS8PrivateKey(bio, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
                       },
                       file));
  return key;
}

Key read_key(const fs::path& file) {
  const std::string content = read_file(file);
  Key key(PEM_read_bio_PrivateKey(memory(content).get(), nullptr, nullptr, nullptr));
  if (key == nullptr) fail(file, "is no private key");
  return key;
}

Certificate read_certificate(const fs::path& file) {
  const std::string content = read_file(file);
  Certificate certificate(PEM_read_bio_X509(memory(content).get(), nullptr, nullptr, nullptr));
  if (certificate == nullptr) fail(file, "is no certificate");
  return certificate;
}

/// A certificate of `key`; `issuer` null: signed by itself, for an authority.
Certificate new_certificate(const fs::path& file, EVP_PKEY* key, const std::string& name, X509* issuer,
                            EVP_PKEY* issuer_key, std::chrono::days validity) {
  Certificate made(X509_new());
  X509* const one = made.get();
  unsigned char serial[8];
  bool done = RAND_bytes(serial, sizeof serial) == 1;
  serial[0] = static_cast<unsigned char>((serial[0] & 0x7FU) | 0x40U);  // positive
  const std::unique_ptr<BIGNUM, Free<BN_free>> number(BN_bin2bn(serial, sizeof serial, nullptr));
  done = done && BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(one)) != nullptr;
  done = done && X509_set_version(one, 2) == 1;
  constexpr std::chrono::seconds kEarlier = kBefore;
  done = done && X509_gmtime_adj(X509_getm_notBefore(one), -kEarlier.count()) != nullptr;
  done = done && X509_time_adj_ex(X509_getm_notAfter(one), static_cast<int>(validity.count()), 0, nullptr) != nullptr;
  X509_NAME* const subject = X509_get_subject_name(one);
  done = done && X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8,
                                            reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0) == 1;
  done = done && X509_set_issuer_name(one, issuer == nullptr ? subject : X509_get_subject_name(issuer)) == 1;
  done = done && X509_set_pubkey(one, key) == 1;
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer == nullptr ? one : issuer, one, nullptr, nullptr, 0);
  const char* const kind = issuer == nullptr ? "critical,CA:TRUE,pathlen:0" : "critical,CA:FALSE";
  const std::unique_ptr<X509_EXTENSION, Free<X509_EXTENSION_free>> constraints(
      X509V3_EXT_conf_nid(nullptr, &context, NID_basic_constraints, kind));
  done = done && constraints != nullptr && X509_add_ext(one, constraints.get(), -1) == 1;
  done = done && X509_sign(one, issuer_key, EVP_sha256()) > 0;
  if (!done) fail(file, "no certificate can be made");
  write_file(file, pem([&](BIO* bio) { return PEM_write_bio_X509(bio, one); }, file));
  return made;
}

/// Signs a document as S/MIME with the text beside its signature, as DDS Security wants it.
void write_signed(const fs::path& file, const std::string& document, X509* signer, EVP_PKEY* key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const Bio input = memory(document);
  const Signed pkcs7(PKCS7_sign(signer, key, nullptr, input.get(), kFlags));
  if (pkcs7 == nullptr) fail(file, "cannot be signed");
  if (BIO_reset(input.get()) != 1) fail(file, "cannot be signed");
  write_file(file, pem([&](BIO* bio) { return SMIME_write_PKCS7(bio, pkcs7.get(), input.get(), kFlags); }, file));
}

/// All traffic is encrypted, no participant joins without an identity, and permissions decide about each topic.
std::string governance_xml() {
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
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
}

/// The words of the table of topics that mean this role.
std::vector<std::string_view> words_of(Role role) {
  if (role == Role::kOperator) return {"all", "cli", "clients", "perception"};
  if (role == Role::kViewer) return {"all"};
  return {"all", role_name(role)};
}

/// `kinds`: of the table of topics, separated by spaces.
bool has_any(std::string_view kinds, const std::vector<std::string_view>& words) {
  while (!kinds.empty()) {
    const std::string_view one = kinds.substr(0, kinds.find(' '));
    if (std::find(words.begin(), words.end(), one) != words.end()) return true;
    kinds.remove_prefix(std::min(kinds.size(), one.size() + 1));
  }
  return false;
}

std::string xml_time(Time time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  return text;
}

std::string rule_xml(const std::string& element, const std::vector<std::string>& topics) {
  if (topics.empty()) return {};
  std::string text = "        <" + element + ">\n          <topics>\n";
  for (const std::string& topic : topics) text += "            <topic>" + topic + "</topic>\n";
  return text + "          </topics>\n          <partitions><partition>*</partition></partitions>\n        </" +
         element + ">\n";
}

Time time_of(const ASN1_TIME* time) {
  std::tm utc{};
  ASN1_TIME_to_tm(time, &utc);
  return std::chrono::system_clock::from_time_t(timegm(&utc));
}

std::string subject_of(X509* certificate) {
  const Bio bio(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(bio.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253);
  return text_of(bio.get());
}

/// A name that is a folder and a part of a subject.
void require_host_name(const fs::path& folder, const std::string& host) {
  const auto allowed = [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.'; };
  if (!host.empty() && host.size() <= 63 && host.front() != '.' && std::all_of(host.begin(), host.end(), allowed))
    return;
  throw KeystoreError(folder.string() +
                      ": the name of a host has 1 to 63 letters, digits, '-', '_' and '.', and begins with no dot");
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

void add_identity(const fs::path& keystore, const Authority& authority, const std::string& host, Role role,
                  std::chrono::days validity) {
  const fs::path folder = enclave_folder(keystore, host, role);
  make_folder(folder.parent_path());
  make_folder(folder);
  const Key key = new_key(folder / "key.pem");
  const Certificate certificate =
      new_certificate(folder / "cert.pem", key.get(), "/" + host + "/" + std::string(role_name(role)),
                      authority.certificate.get(), authority.key.get(), validity);
  const std::string permissions =
      permissions_xml(role, subject_of(certificate.get()), time_of(X509_get0_notBefore(certificate.get())),
                      time_of(X509_get0_notAfter(certificate.get())));
  write_file(folder / "permissions.xml", permissions);
  write_signed(folder / "permissions.p7s", permissions, authority.certificate.get(), authority.key.get());
  replicate(authority_file(keystore), folder / "identity_ca.cert.pem");
  replicate(authority_file(keystore), folder / "permissions_ca.cert.pem");
  replicate(governance_file(keystore), folder / "governance.p7s");
}

}  // namespace

std::string_view role_name(Role role) {
  constexpr std::array<std::string_view, kRoles.size()> kNames{"agent",   "supervisor", "world", "driver",
                                                               "planner", "operator",   "viewer"};
  return kNames[static_cast<std::size_t>(role)];
}

std::string permissions_xml(Role role, const std::string& subject, Time from, Time until) {
  std::vector<std::string> publishes;
  std::vector<std::string> subscribes;
  const bool reads_all = role == Role::kOperator || role == Role::kViewer;
  for (const bus::TopicInfo& topic : bus::kTopics) {
    if (has_any(topic.writers, words_of(role))) publishes.emplace_back(topic.name);
    if (reads_all || has_any(topic.readers, words_of(role))) subscribes.emplace_back(topic.name);
  }
  return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <permissions>
    <grant name=")" +
         std::string(role_name(role)) + R"(">
      <subject_name>)" +
         subject + R"(</subject_name>
      <validity><not_before>)" +
         xml_time(from) + "</not_before><not_after>" + xml_time(until) + R"(</not_after></validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
)" + rule_xml("publish", publishes) +
         rule_xml("subscribe", subscribes) + R"(      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
)";
}

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

void add_host(const fs::path& folder, const std::string& host, std::chrono::days validity) {
  require_host_name(folder, host);
  const Authority authority = read_authority(folder);
  if (time_of(X509_get0_notAfter(authority.certificate.get())) < std::chrono::system_clock::now() + validity) {
    throw KeystoreError(authority_file(folder).string() +
                        ": expires before the new identities would; give fewer --days");
  }
  for (const Role role : kRoles) add_identity(folder, authority, host, role, validity);
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
  const Time now = std::chrono::system_clock::now();
  for (const auto& [one, name] :
       {std::pair(certificate.get(), "cert.pem"), std::pair(authority.get(), "identity_ca.cert.pem")}) {
    const Time begins = time_of(X509_get0_notBefore(one));
    const Time ends = time_of(X509_get0_notAfter(one));
    if (now >= ends) {
      throw KeystoreError((enclave / name).string() + ": has expired on " + xml_time(ends) +
                          " UTC; `hecaton keystore add` makes new identities");
    }
    if (now < begins) {
      throw KeystoreError((enclave / name).string() + ": is valid from " + xml_time(begins) +
                          " UTC on; is the clock of this machine right?");
    }
  }
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
          IdentityState{host.path().filename().string(), std::string(role_name(role)), {}, std::nullopt});
      try {
        state.expires = time_of(X509_get0_notAfter(read_certificate(enclave / "cert.pem").get()));
        require_identity(enclave);
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
