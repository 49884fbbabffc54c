#pragma once
/// The file from which a person learns the token of a view that an agent started. It is in the folder of the run, which
/// other users cannot read, and ends with it.

#include <filesystem>
#include <optional>
#include <string>

namespace hecaton::services {

/// The token of a view: 256 bits of the kernel, as 64 hexadecimal digits. Throws std::runtime_error with a sentence.
[[nodiscard]] std::string random_token();

/// The token in a file of write_token_file(). Empty when there is no such file, when another user owns it, and when
/// other users may read it.
[[nodiscard]] std::optional<std::string> token_in_file(const std::filesystem::path& path);

/// Replaces the file with one that only this user can read and write (mode 0600). Its one line is `url`, the address of
/// the page, with the token. Throws std::runtime_error with a sentence that has no token.
void write_token_file(const std::filesystem::path& path, const std::string& url);

}  // namespace hecaton::services
