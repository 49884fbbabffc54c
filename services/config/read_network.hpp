#pragma once
/// The cell file's sections `network`, `hosts` and `supervision`, and references to hosts.

#include "services/config/cell_file.hpp"
#include "services/config/yaml_view.hpp"

namespace hecaton::config {

[[nodiscard]] Network read_network(const MapView& root);

/// Without the section: one host "localhost".
[[nodiscard]] std::vector<Host> read_hosts(const MapView& root);

/// The declared host that `key` names. Without the key: the only declared host; with several it is an error.
[[nodiscard]] std::string read_host(const MapView& map, std::string_view key, const std::vector<Host>& hosts);

/// The declared host that `key` names, which must differ from `active`; empty without the key.
[[nodiscard]] std::string read_standby_host(const MapView& map, std::string_view key, const std::vector<Host>& hosts,
                                            const std::string& active);

[[nodiscard]] Supervision read_supervision(const MapView& root, const std::vector<Host>& hosts);

}  // namespace hecaton::config
