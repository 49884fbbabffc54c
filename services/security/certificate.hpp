#pragma once
/// Keys, certificates, signed documents and lists of revoked certificates, as files. Private to services/security.
/// Functions throw KeystoreError with the file.

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include "services/security/keystore.hpp"

namespace hecaton::services::pki {

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

/// Clocks of hosts may differ: certificates begin this long before they are made.
inline constexpr std::chrono::hours kBefore{1};

/// Throws "FILE: WHAT", with the reason of OpenSSL if it has one.
[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what);

/// Files of keys are for their owner only. A file is replaced as a whole.
void write_file(const std::filesystem::path& file, std::string_view content);
[[nodiscard]] std::string read_file(const std::filesystem::path& file);
/// What `write` writes, for `file`.
[[nodiscard]] std::string pem(const std::function<int(BIO*)>& write, const std::filesystem::path& file);

/// Makes a key and writes it.
[[nodiscard]] Key new_key(const std::filesystem::path& file);
[[nodiscard]] Key read_key(const std::filesystem::path& file);

/// Makes a certificate of `key` and writes it; `issuer` null: signed by itself. Its serial number begins with the
/// GuidBeginning of its subject. `addresses`, "DNS:left-pc,IP:10.0.0.2": of a server; empty: of an authority when it is
/// signed by itself, otherwise of an identity.
[[nodiscard]] Certificate new_certificate(const std::filesystem::path& file, EVP_PKEY* key, const std::string& name,
                                          X509* issuer, EVP_PKEY* issuer_key, std::chrono::days validity,
                                          const std::string& addresses = {});
[[nodiscard]] Certificate read_certificate(const std::filesystem::path& file);
/// The GuidBeginning of an identity with this name. `file` is for the sentence of a failure.
[[nodiscard]] GuidBeginning beginning_of(const std::string& name, const std::filesystem::path& file);
/// Hexadecimal.
[[nodiscard]] std::string serial_of(const X509* certificate);
/// As in RFC 2253.
[[nodiscard]] std::string subject_of(X509* certificate);
[[nodiscard]] Time begin_of(const X509* certificate);
[[nodiscard]] Time end_of(const X509* certificate);

/// Signs a document as S/MIME with the text beside its signature, as DDS Security wants it.
void write_signed(const std::filesystem::path& file, const std::string& document, X509* signer, EVP_PKEY* key);

/// The document that the authority has signed, as write_signed() does.
[[nodiscard]] std::string read_signed(const std::filesystem::path& file, X509* authority);

/// The revoked certificates of the authority; empty: there is no list. Throws when the authority has not signed it.
[[nodiscard]] RevocationList read_revocations(const std::filesystem::path& file, X509* authority);
/// Signs and writes `list` with these serial numbers (hexadecimal) beside those that it has; null: a new list.
void write_revocations(const std::filesystem::path& file, RevocationList list, const std::vector<std::string>& serials,
                       X509* authority, EVP_PKEY* key);
/// Of the certificates in the list; null: none.
[[nodiscard]] std::vector<GuidBeginning> beginnings_in(X509_CRL* list);

}  // namespace hecaton::services::pki
