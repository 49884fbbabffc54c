#pragma once
/// Data for programs: one tree of values, printed as JSON or YAML. Keys keep their order.

#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "services/command_line/program.hpp"

namespace hecaton::config {
struct Finding;
}  // namespace hecaton::config

namespace hecaton::services::cli {

using Json = nlohmann::ordered_json;

/// Numbers in the shortest form that reads back the same; numbers that are not finite become null. Ends with a newline.
[[nodiscard]] std::string json_text(const Json& value);

/// YAML 1.2 in block style; lists of scalars on one line. Ends with a newline. (The emitter of yaml-cpp writes numbers
/// with a fixed count of digits.)
[[nodiscard]] std::string yaml_text(const Json& value);

/// The member `findings` of every document: [{severity: error | warning | note, sentence}].
[[nodiscard]] Json findings_json(std::span<const config::Finding> findings);

/// The same of sentences that a command prints as notes.
[[nodiscard]] Json notes_json(std::span<const std::string> notes);

/// Prints on stdout in the format of `settings`: `table` for people, or `value`. The output is valid UTF-8: bytes that
/// are not are replaced in values and escaped in tables.
void print(const Settings& settings, const Json& value, const std::string& table);

}  // namespace hecaton::services::cli
