#pragma once
/// Data for programs: one value tree, written as JSON or YAML. Keys keep their order.

#include <string>

#include <nlohmann/json.hpp>

#include "services/command_line/settings.hpp"

namespace hecaton::services::cli {

using Json = nlohmann::ordered_json;

/// Numbers in the shortest form that reads back the same; not finite ones become null. Ends with a newline.
[[nodiscard]] std::string json_text(const Json& value);

/// The same tree as YAML 1.2, block style; lists of numbers on one line. Ends with a newline. Not by yaml-cpp's
/// emitter: it writes numbers with a fixed count of digits, and would need the same walk over the tree.
[[nodiscard]] std::string yaml_text(const Json& value);

/// On stdout, in the format asked for; `table` is what people get.
void print(const Settings& settings, const Json& value, const std::string& table);

}  // namespace hecaton::services::cli
