#pragma once
/// The text of idl/ as schemas of a recording. All functions are pure.

#include <span>
#include <string_view>

namespace hecaton::services::recorder {

/// Each file of idl/ without preprocessor lines, with the files that it includes before it. embed_idl.cmake writes this
/// function.
[[nodiscard]] std::span<const std::string_view> message_files();

/// The file that defines the structure `type`: "ArmState". Empty: none does.
[[nodiscard]] std::string_view message_schema(std::string_view type);

}  // namespace hecaton::services::recorder
