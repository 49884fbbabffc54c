#include "services/view/web_stream.hpp"

#include <stdexcept>

#include <boost/asio/buffer.hpp>
#include <boost/system/system_error.hpp>

namespace hecaton::services {

asio::ssl::context tls_context(const WebCertificate& certificate) {
  asio::ssl::context context(asio::ssl::context::tls_server);
  context.set_options(asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 |
                      asio::ssl::context::no_tlsv1_1);
  try {
    context.use_certificate_chain(asio::buffer(certificate.chain));
    context.use_private_key(asio::buffer(certificate.key), asio::ssl::context::pem);
  } catch (const boost::system::system_error& error) {
    throw std::runtime_error("the certificate of the page and its key cannot be used: " + error.code().message());
  }
  return context;
}

}  // namespace hecaton::services
