#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <arpa/inet.h>

#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/run_service.hpp"
#include "services/view/view_service.hpp"

namespace {

using namespace hecaton;

constexpr int kHighestPort = 65535;

struct Options {
  std::optional<std::string> listen;
  std::optional<int> port;
  services::ViewOrders orders;
  bool no_stop = false;
  std::string certificate;
  std::string key;
  std::vector<std::string> origins;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--listen", options.listen,
                 "IPv4 address of the page (the cell file's, or 127.0.0.1: this host alone)");
  CLI::Option* certificate =
      app.add_option("--certificate", options.certificate,
                     "certificate of a page that other machines can reach, PEM (the cell file's, "
                     "or one that the view makes itself)");
  certificate->needs(app.add_option("--key", options.key, "its private key, PEM")->needs(certificate));
  app.add_option("--port", options.port, "port of the page, 0: a free one (the cell file's, or 8000 + DDS domain)");
  app.add_flag("--control", options.orders.control,
               "one page at a time gives orders, with the token in the address that is printed; in a secured cell this "
               "needs an identity of the role operator");
  app.add_flag("--no-stop", options.no_stop, "pages without control cannot stop the cell");
  app.add_option("--allow-origin", options.origins,
                 "origin of further pages that may connect as Foxglove does, \"http://vis.example:8080\"");
}

/// The key `view` of the cell file with the options of the command line. Throws std::runtime_error with a sentence.
config::View view_of(const config::CellFile& file, const std::string& host, const Options& options) {
  config::View view = file.view.value_or(config::View{});
  if (view.host.empty()) view.host = file.hosts.front().name;
  if (!host.empty()) view.host = host;
  if (options.listen) {
    in_addr parsed{};
    if (inet_pton(AF_INET, options.listen->c_str(), &parsed) != 1) {
      throw std::runtime_error("--listen '" + config::printable(*options.listen) +
                               "' must be an IPv4 address of this host: 127.0.0.1 for this host alone, 0.0.0.0 for all "
                               "of its networks");
    }
    view.listen = *options.listen;
  }
  if (options.port) {
    if (*options.port < 0 || *options.port > kHighestPort) {
      throw std::runtime_error("--port " + std::to_string(*options.port) + " must be a whole number from 0 to " +
                               std::to_string(kHighestPort));
    }
    view.port = *options.port;
  }
  if (!options.certificate.empty()) {
    view.certificate = options.certificate;
    view.key = options.key;
  }
  return view;
}

}  // namespace

int main(int argc, char** argv) {
  Options own;
  return services::run_service(
      argc, argv, "Serves a page that shows a running cell", services::Subject::kCell,
      [&](const services::ServiceOptions& options, services::ShutdownSignal& shutdown) {
        const config::CellFile file = config::load_cell_file(options.cell, options.sources);
        const config::View view = view_of(file, options.host, own);
        const services::LogScope log(services::view_node(), options);
        services::start_exit_notifier(options.exit_fd);
        own.orders.control = own.orders.control || view.control;
        own.orders.stop = !own.no_stop && !view.no_stop;
        services::ViewService(file, options, view, own.orders, own.origins, shutdown).run();
      },
      [&](CLI::App& app) { add_options(app, own); });
}
