#include "services/security/certificate.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <system_error>

#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

namespace hecaton::services::pki {
namespace {

namespace fs = std::filesystem;

Bio memory(const std::string& content) {
  return Bio(BIO_new_mem_buf(content.data(), static_cast<int>(content.size())));
}

std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(size)};
}

bool add_common_name(X509_NAME* subject, const std::string& name) {
  return X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8, reinterpret_cast<const unsigned char*>(name.c_str()),
                                    -1, -1, 0) == 1;
}

GuidBeginning beginning_of_subject(const X509_NAME* subject, const fs::path& file) {
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

bool add_extension(X509* certificate, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, Free<X509_EXTENSION_free>> extension(
      X509V3_EXT_conf_nid(nullptr, &context, kind, value));
  return extension != nullptr && X509_add_ext(certificate, extension.get(), -1) == 1;
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

Time time_of(const ASN1_TIME* time) {
  std::tm utc{};
  ASN1_TIME_to_tm(time, &utc);
  return std::chrono::system_clock::from_time_t(timegm(&utc));
}

/// Enters a certificate, unless the list has it. False: OpenSSL has failed.
bool revoke(X509_CRL* list, const std::string& serial, const ASN1_TIME* now) {
  BIGNUM* hexadecimal = nullptr;
  BN_hex2bn(&hexadecimal, serial.c_str());
  const Number number(hexadecimal);
  const std::unique_ptr<ASN1_INTEGER, Free<ASN1_INTEGER_free>> integer(BN_to_ASN1_INTEGER(number.get(), nullptr));
  X509_REVOKED* known = nullptr;
  if (X509_CRL_get0_by_serial(list, &known, integer.get()) != 0) return true;
  std::unique_ptr<X509_REVOKED, Free<X509_REVOKED_free>> entry(X509_REVOKED_new());
  const bool done = X509_REVOKED_set_serialNumber(entry.get(), integer.get()) == 1 &&
                    X509_REVOKED_set_revocationDate(entry.get(), const_cast<ASN1_TIME*>(now)) == 1 &&
                    X509_CRL_add0_revoked(list, entry.get()) == 1;
  if (done) static_cast<void>(entry.release());
  return done;
}

}  // namespace

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  char reason[256] = "";
  if (const unsigned long code = ERR_peek_last_error(); code != 0) ERR_error_string_n(code, reason, sizeof reason);
  ERR_clear_error();
  throw KeystoreError(file.string() + ": " + what + (*reason == '\0' ? "" : std::string(" (") + reason + ")"));
}

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

Certificate new_certificate(const fs::path& file, EVP_PKEY* key, const std::string& name, X509* issuer,
                            EVP_PKEY* issuer_key, std::chrono::days validity, const std::string& addresses) {
  Certificate made(X509_new());
  X509* const one = made.get();
  bool done = X509_set_version(one, 2) == 1;
  constexpr std::chrono::seconds kEarlier = kBefore;
  done = done && X509_gmtime_adj(X509_getm_notBefore(one), -kEarlier.count()) != nullptr;
  done = done && X509_time_adj_ex(X509_getm_notAfter(one), static_cast<int>(validity.count()), 0, nullptr) != nullptr;
  X509_NAME* const subject = X509_get_subject_name(one);
  done = done && add_common_name(subject, name);
  done = done && set_serial(one, beginning_of_subject(subject, file));
  done = done && X509_set_issuer_name(one, issuer == nullptr ? subject : X509_get_subject_name(issuer)) == 1;
  done = done && X509_set_pubkey(one, key) == 1;
  const bool of_authority = issuer == nullptr && addresses.empty();
  done = done &&
         add_extension(one, NID_basic_constraints, of_authority ? "critical,CA:TRUE,pathlen:0" : "critical,CA:FALSE");
  done = done && (addresses.empty() || add_extension(one, NID_subject_alt_name, addresses.c_str()));
  done = done && X509_sign(one, issuer_key, EVP_sha256()) > 0;
  if (!done) fail(file, "no certificate can be made");
  write_file(file, pem([&](BIO* bio) { return PEM_write_bio_X509(bio, one); }, file));
  return made;
}

void write_signed(const fs::path& file, const std::string& document, X509* signer, EVP_PKEY* key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const Bio input = memory(document);
  const Signed pkcs7(PKCS7_sign(signer, key, nullptr, input.get(), kFlags));
  if (pkcs7 == nullptr) fail(file, "cannot be signed");
  if (BIO_reset(input.get()) != 1) fail(file, "cannot be signed");
  write_file(file, pem([&](BIO* bio) { return SMIME_write_PKCS7(bio, pkcs7.get(), input.get(), kFlags); }, file));
}

std::string read_signed(const fs::path& file, X509* authority) {
  const std::string content = read_file(file);
  BIO* detached = nullptr;
  const Signed pkcs7(SMIME_read_PKCS7(memory(content).get(), &detached));
  const Bio text(detached);
  if (pkcs7 == nullptr || text == nullptr) fail(file, "is no document with a signature (S/MIME)");
  const std::unique_ptr<STACK_OF(X509), void (*)(STACK_OF(X509)*)> signers(sk_X509_new_null(),
                                                                           [](auto* all) { sk_X509_free(all); });
  const Bio document(BIO_new(BIO_s_mem()));
  // As the middleware does it: only this certificate counts, not one that the document carries.
  constexpr int kFlags = PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN;
  if (sk_X509_push(signers.get(), authority) == 0 ||
      PKCS7_verify(pkcs7.get(), signers.get(), nullptr, text.get(), document.get(), kFlags) != 1) {
    ERR_clear_error();
    throw KeystoreError(file.string() + ": is not signed by permissions_ca.cert.pem beside it");
  }
  return text_of(document.get());
}

GuidBeginning beginning_of(const std::string& name, const fs::path& file) {
  const std::unique_ptr<X509_NAME, Free<X509_NAME_free>> subject(X509_NAME_new());
  if (!add_common_name(subject.get(), name)) fail(file, "no subject can be made");
  return beginning_of_subject(subject.get(), file);
}

std::string serial_of(const X509* certificate) {
  const Number number(ASN1_INTEGER_to_BN(X509_get0_serialNumber(certificate), nullptr));
  const std::unique_ptr<char, void (*)(char*)> text(BN_bn2hex(number.get()), [](char* one) { OPENSSL_free(one); });
  return text.get();
}

std::string subject_of(X509* certificate) {
  const Bio bio(BIO_new(BIO_s_mem()));
  X509_NAME_print_ex(bio.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253);
  return text_of(bio.get());
}

Time begin_of(const X509* certificate) {
  return time_of(X509_get0_notBefore(certificate));
}

Time end_of(const X509* certificate) {
  return time_of(X509_get0_notAfter(certificate));
}

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

void write_revocations(const fs::path& file, RevocationList list, const std::vector<std::string>& serials,
                       X509* authority, EVP_PKEY* key) {
  if (list == nullptr) list.reset(X509_CRL_new());
  X509_CRL* const one = list.get();
  const std::unique_ptr<ASN1_TIME, Free<ASN1_TIME_free>> now(ASN1_TIME_new());
  constexpr std::chrono::seconds kEarlier = kBefore;
  bool done = X509_gmtime_adj(now.get(), -kEarlier.count()) != nullptr && X509_CRL_set_version(one, 1) == 1 &&
              X509_CRL_set_issuer_name(one, X509_get_subject_name(authority)) == 1 &&
              X509_CRL_set1_lastUpdate(one, now.get()) == 1 &&
              // A list that expires would lock all participants out.
              X509_CRL_set1_nextUpdate(one, X509_get0_notAfter(authority)) == 1;
  for (const std::string& serial : serials) done = done && revoke(one, serial, now.get());
  done = done && X509_CRL_sort(one) == 1 && X509_CRL_sign(one, key, EVP_sha256()) > 0;
  if (!done) fail(file, "no list of revoked certificates can be made");
  write_file(file, pem([&](BIO* bio) { return PEM_write_bio_X509_CRL(bio, one); }, file));
}

}  // namespace hecaton::services::pki
