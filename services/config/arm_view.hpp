#pragma once
/// An arm's map in the cell file together with the `defaults` behind it.

#include <optional>

#include "services/config/yaml_view.hpp"

namespace hecaton::config {

struct ArmView {
  MapView own;
  std::optional<MapView> defaults;

  /// The arm's own value, else the default one.
  [[nodiscard]] std::optional<YamlView> find(std::string_view key) const {
    if (auto view = own.find(key)) return view;
    return defaults ? defaults->find(key) : std::nullopt;
  }
  /// The same; in neither is an error.
  [[nodiscard]] YamlView at(std::string_view key) const {
    if (const auto view = find(key)) return *view;
    return own.at(key);
  }
  /// The same for the key `inner` of the map at `key`: an arm may override one entry of a map alone.
  [[nodiscard]] std::optional<YamlView> find(std::string_view key, const Section& section,
                                             std::string_view inner) const {
    if (const auto map = own.find(key)) {
      if (auto view = map->map(section).find(inner)) return view;
    }
    if (!defaults) return std::nullopt;
    const auto map = defaults->find(key);
    return map ? map->map(section).find(inner) : std::nullopt;
  }
};

}  // namespace hecaton::config
