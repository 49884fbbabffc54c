#pragma once
/// Tokens of a page, and the file from which a person learns those of a view that an agent started. It is in the folder
/// of the run, which other users cannot read, and ends with it.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace hecaton::services {

/// What stands before a token in the address of a page: of the right to see it, and of the right to control the cell.
inline constexpr std::string_view kWatchMarker = "?watch=";
inline constexpr std::string_view kControlMarker = "#token=";

/// 256 bits of the kernel, as 64 hexadecimal digits. Throws std::runtime_error with a sentence.
[[nodiscard]] std::string random_token();

/// Takes the same time for all tokens of the same length.
[[nodiscard]] bool same_token(std::string_view a, std::string_view b);

/// The token behind `marker` in a file of write_token_file(). Empty when there is none, when another user owns the
/// file, and when other users may read it.
[[nodiscard]] std::optional<std::string> token_in_file(const std::filesystem::path& path, std::string_view marker);

/// Replaces the file with one that only this user can read and write (mode 0600). Its one line is `url`, the address of
/// the page, with its tokens. Throws std::runtime_error with a sentence that has no token.
void write_token_file(const std::filesystem::path& path, const std::string& url);

}  // namespace hecaton::services
