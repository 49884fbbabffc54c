#include "services/security/keystore.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <set>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

#include <fcntl.h>
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
using RevocationList = std::unique_ptr<X509_CRL, Free<X509_CRL_free>>;
using Number = std::unique_ptr<BIGNUM, Free<BN_free>>;
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
fs::path issued_file(const fs::path& keystore) {
  return keystore / "private" / "issued";
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

bool add_common_name(X509_NAME* subject, const std::string& name) {
  return X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8, reinterpret_cast<const unsigned char*>(name.c_str()),
                                    -1, -1, 0) == 1;
}

GuidBeginning beginning_of(const X509_NAME* subject, const fs::path& file) {
  unsigned char hash[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  if (X509_NAME_digest(subject, EVP_sha256(), hash, &size) != 1) fail(file, "its subject has no digest");
  GuidBeginning beginning{};
  unsigned int carried = 1;  // the first bit
  for (std::size_t i = 0; i < beginning.size(); ++i) {
    beginning[i] = static_cast<std::uint8_t>(carried << 7U | hash[i] >> 1U);
    carried = hash[i] & 1U;
  }
  return beginning;
}

constexpr std::size_t kSerialBytes = 14;

/// A GuidBeginning, which has its first bit set, and 64 random bits.
bool set_serial(X509* certificate, const GuidBeginning& beginning) {
  std::array<unsigned char, kSerialBytes> serial{};
  std::copy(beginning.begin(), beginning.end(), serial.begin());
  if (RAND_bytes(serial.data() + beginning.size(), static_cast<int>(serial.size() - beginning.size())) != 1)
    return false;
  const Number number(BN_bin2bn(serial.data(), static_cast<int>(serial.size()), nullptr));
  return number != nullptr && BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr;
}

/// Empty: the certificate is none of a keystore of Hecaton.
std::optional<GuidBeginning> beginning_in(const ASN1_INTEGER* serial) {
  const Number number(ASN1_INTEGER_to_BN(serial, nullptr));
  if (number == nullptr || BN_num_bytes(number.get()) != static_cast<int>(kSerialBytes)) return std::nullopt;
  std::array<unsigned char, kSerialBytes> bytes{};
  BN_bn2bin(number.get(), bytes.data());
  if ((bytes.front() & 0x80U) == 0) return std::nullopt;
  GuidBeginning beginning{};
  std::copy_n(bytes.begin(), beginning.size(), beginning.begin());
  return beginning;
}

std::string serial_text(const ASN1_INTEGER* serial) {
  const Number number(ASN1_INTEGER_to_BN(serial, nullptr));
  const std::unique_ptr<char, void (*)(char*)> text(BN_bn2hex(number.get()), [](char* one) { OPENSSL_free(one); });
  return text.get();
}

/// A certificate of `key`; `issuer` null: signed by itself, for an authority.
Certificate new_certificate(const fs::path& file, EVP_PKEY* key, const std::string& name, X509* issuer,
                            EVP_PKEY* issuer_key, std::chrono::days validity) {
  Certificate made(X509_new());
  X509* const one = made.get();
  bool done = X509_set_version(one, 2) == 1;
  constexpr std::chrono::seconds kEarlier = kBefore;
  done = done && X509_gmtime_adj(X509_getm_notBefore(one), -kEarlier.count()) != nullptr;
  done = done && X509_time_adj_ex(X509_getm_notAfter(one), static_cast<int>(validity.count()), 0, nullptr) != nullptr;
  X509_NAME* const subject = X509_get_subject_name(one);
  done = done && add_common_name(subject, name);
  done = done && set_serial(one, beginning_of(subject, file));
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

/// The revoked certificates of the authority; empty: there is no list. Throws when the authority has not signed it.
RevocationList read_revocations(const fs::path& file, X509* authority) {
  std::error_code error;
  if (!fs::exists(file, error)) return {};
  const std::string content = read_file(file);
  RevocationList list(PEM_read_bio_X509_CRL(memory(content).get(), nullptr, nullptr, nullptr));
  if (list == nullptr) fail(file, "is no list of revoked certificates");
  const Key key(X509_get_pubkey(authority));
  if (X509_CRL_verify(list.get(), key.get()) != 1) {
    ERR_clear_error();
    throw KeystoreError(file.string() + ": is not signed by the authority of this keystore; copy its enclaves/crl.pem");
  }
  return list;
}

std::vector<GuidBeginning> beginnings_in(X509_CRL* list) {
  std::vector<GuidBeginning> all;
  STACK_OF(X509_REVOKED)* const entries = list == nullptr ? nullptr : X509_CRL_get_REVOKED(list);
  for (int i = 0; entries != nullptr && i < sk_X509_REVOKED_num(entries); ++i) {
    const auto one = beginning_in(X509_REVOKED_get0_serialNumber(sk_X509_REVOKED_value(entries, i)));
    if (one) all.push_back(*one);
  }
  return all;
}

std::vector<Role> roles_of(const fs::path& keystore, const std::string& host) {
  std::vector<Role> roles;
  for (const Role role : kRoles) {
    if (fs::exists(enclave_folder(keystore, host, role))) roles.push_back(role);
  }
  return roles;
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
  for (const Role role : roles_of(keystore, host)) {
    const Certificate certificate = read_certificate(enclave_folder(keystore, host, role) / "cert.pem");
    serials.insert(serial_text(X509_get0_serialNumber(certificate.get())));
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
    const std::unique_ptr<X509_NAME, Free<X509_NAME_free>> subject(X509_NAME_new());
    if (!add_common_name(subject.get(), name)) fail(keystore, "no subject can be made");
    const GuidBeginning beginning = beginning_of(subject.get(), keystore);
    if (std::find(all.begin(), all.end(), beginning) == all.end()) return name;
  }
}

/// Makes an identity in `folder`. Returns its line for note_issued().
std::string make_identity(const fs::path& folder, const fs::path& keystore, const Authority& authority,
                          const std::string& host, Role role, std::chrono::days validity, X509_CRL* revoked) {
  make_folder(folder);
  const Key key = new_key(folder / "key.pem");
  const Certificate certificate =
      new_certificate(folder / "cert.pem", key.get(), unrevoked_name(keystore, host, role, revoked),
                      authority.certificate.get(), authority.key.get(), validity);
  const std::string permissions =
      permissions_xml(role, subject_of(certificate.get()), time_of(X509_get0_notBefore(certificate.get())),
                      time_of(X509_get0_notAfter(certificate.get())));
  write_file(folder / "permissions.xml", permissions);
  write_signed(folder / "permissions.p7s", permissions, authority.certificate.get(), authority.key.get());
  replicate(authority_file(keystore), folder / "identity_ca.cert.pem");
  replicate(authority_file(keystore), folder / "permissions_ca.cert.pem");
  replicate(governance_file(keystore), folder / "governance.p7s");
  return serial_text(X509_get0_serialNumber(certificate.get())) + " " + host + "/" + std::string(role_name(role));
}

/// New identities of these roles in place of the present ones.
void make_identities(const fs::path& keystore, const std::string& host, const std::vector<Role>& roles,
                     std::chrono::days validity) {
  const Authority authority = read_authority(keystore);
  if (time_of(X509_get0_notAfter(authority.certificate.get())) < std::chrono::system_clock::now() + validity) {
    throw KeystoreError(authority_file(keystore).string() +
                        ": expires before the new identities would; give fewer --days");
  }
  const RevocationList revoked = read_revocations(revocations_file(keystore), authority.certificate.get());
  const auto next = [&](Role role) {
    return keystore / "enclaves" / host / ("." + std::string(role_name(role)) + ".new");
  };
  make_folder(keystore / "enclaves" / host);
  std::vector<std::string> issued;
  for (const Role role : roles) {
    std::error_code error;
    fs::remove_all(next(role), error);  // of a run that was interrupted
    issued.push_back(make_identity(next(role), keystore, authority, host, role, validity, revoked.get()));
  }
  note_issued(keystore, issued);
  for (const Role role : roles) put_in_place(next(role), enclave_folder(keystore, host, role));
}

/// When permissions expire; the earliest of several grants. Empty: the file does not say.
std::optional<Time> permissions_expiry(const fs::path& file) {
  const std::string text = read_file(file);
  constexpr std::string_view kElement = "<not_after>";
  std::optional<Time> first;
  for (std::size_t at = text.find(kElement); at != std::string::npos; at = text.find(kElement, at + 1)) {
    std::tm utc{};
    if (::strptime(text.c_str() + at + kElement.size(), " %Y-%m-%dT%H:%M:%S", &utc) == nullptr) continue;
    const Time time = std::chrono::system_clock::from_time_t(timegm(&utc));
    first = std::min(first.value_or(time), time);
  }
  return first;
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
  make_identities(folder, host, {kRoles.begin(), kRoles.end()}, validity);
}

void renew_host(const fs::path& folder, const std::string& host, std::chrono::days validity) {
  require_host_name(folder, host);
  const std::vector<Role> roles = roles_of(folder, host);
  if (roles.empty()) fail_without_host(folder, host);
  make_identities(folder, host, roles, validity);
}

void revoke_host(const fs::path& folder, const std::string& host) {
  require_host_name(folder, host);
  const Authority authority = read_authority(folder);
  const fs::path file = revocations_file(folder);
  const std::set<std::string> serials = issued_for(folder, host);
  if (serials.empty()) fail_without_host(folder, host);
  RevocationList list = read_revocations(file, authority.certificate.get());
  if (list == nullptr) list.reset(X509_CRL_new());
  X509_CRL* const one = list.get();
  const std::unique_ptr<ASN1_TIME, Free<ASN1_TIME_free>> now(ASN1_TIME_new());
  constexpr std::chrono::seconds kEarlier = kBefore;
  bool done = X509_gmtime_adj(now.get(), -kEarlier.count()) != nullptr && X509_CRL_set_version(one, 1) == 1 &&
              X509_CRL_set_issuer_name(one, X509_get_subject_name(authority.certificate.get())) == 1 &&
              X509_CRL_set1_lastUpdate(one, now.get()) == 1 &&
              // A list that expires would lock all participants out.
              X509_CRL_set1_nextUpdate(one, X509_get0_notAfter(authority.certificate.get())) == 1;
  for (const std::string& serial : serials) {
    BIGNUM* hexadecimal = nullptr;
    BN_hex2bn(&hexadecimal, serial.c_str());
    const Number number(hexadecimal);
    const std::unique_ptr<ASN1_INTEGER, Free<ASN1_INTEGER_free>> integer(BN_to_ASN1_INTEGER(number.get(), nullptr));
    X509_REVOKED* known = nullptr;
    if (X509_CRL_get0_by_serial(one, &known, integer.get()) != 0) continue;
    std::unique_ptr<X509_REVOKED, Free<X509_REVOKED_free>> entry(X509_REVOKED_new());
    done = done && X509_REVOKED_set_serialNumber(entry.get(), integer.get()) == 1 &&
           X509_REVOKED_set_revocationDate(entry.get(), now.get()) == 1 && X509_CRL_add0_revoked(one, entry.get()) == 1;
    if (done) static_cast<void>(entry.release());
  }
  done = done && X509_CRL_sort(one) == 1 && X509_CRL_sign(one, authority.key.get(), EVP_sha256()) > 0;
  if (!done) fail(file, "no list of revoked certificates can be made");
  write_file(file, pem([&](BIO* bio) { return PEM_write_bio_X509_CRL(bio, one); }, file));
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
  const Time now = std::chrono::system_clock::now();
  for (const auto& [one, name] :
       {std::pair(certificate.get(), "cert.pem"), std::pair(authority.get(), "identity_ca.cert.pem")}) {
    const Time begins = time_of(X509_get0_notBefore(one));
    const Time ends = time_of(X509_get0_notAfter(one));
    if (now >= ends) {
      throw KeystoreError((enclave / name).string() + ": has expired on " + xml_time(ends) +
                          " UTC; `hecaton keystore renew` makes new identities");
    }
    if (now < begins) {
      throw KeystoreError((enclave / name).string() + ": is valid from " + xml_time(begins) +
                          " UTC on; is the clock of this machine right?");
    }
  }
  const auto permitted = permissions_expiry(enclave / "permissions.p7s");
  if (permitted && now >= *permitted) {
    throw KeystoreError((enclave / "permissions.p7s").string() + ": has expired on " + xml_time(*permitted) +
                        " UTC; `hecaton keystore renew` makes new identities");
  }
}

Time expiry_of(const fs::path& enclave) {
  Time first = time_of(X509_get0_notAfter(read_certificate(enclave / "cert.pem").get()));
  for (const char* authority : {"identity_ca.cert.pem", "permissions_ca.cert.pem"}) {
    first = std::min(first, time_of(X509_get0_notAfter(read_certificate(enclave / authority).get())));
  }
  return std::min(first, permissions_expiry(enclave / "permissions.p7s").value_or(first));
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
        state.expires = expiry_of(enclave);  // of the certificate alone when other files are missing
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
