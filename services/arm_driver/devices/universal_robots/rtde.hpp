#pragma once
/// The wire format of RTDE, the Real-Time Data Exchange of Universal Robots. All numbers are big-endian. Pure.
///
///     package = uint16 size (of the whole package), uint8 type, payload

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::device::universal_robots {

enum class PackageType : std::uint8_t {
  kProtocolVersion = 'V',
  kControllerVersion = 'v',
  kText = 'M',
  kData = 'U',
  kOutputs = 'O',
  kInputs = 'I',
  kStart = 'S',
  kPause = 'P',
};

struct Package {
  PackageType type{};
  std::string_view payload;
};

/// Adds big-endian numbers to a text of bytes.
void put_u8(std::string& bytes, std::uint8_t value);
void put_u16(std::string& bytes, std::uint16_t value);
void put_u32(std::string& bytes, std::uint32_t value);
void put_f64(std::string& bytes, double value);

[[nodiscard]] std::string package(PackageType type, std::string_view payload);

/// Reads big-endian numbers one after another. A value that is not complete is empty, and so are all after it.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : left_(bytes) {}
  [[nodiscard]] std::optional<std::uint8_t> u8();
  [[nodiscard]] std::optional<std::uint16_t> u16();
  [[nodiscard]] std::optional<std::uint32_t> u32();
  [[nodiscard]] std::optional<std::uint64_t> u64();
  [[nodiscard]] std::optional<std::int32_t> i32();
  [[nodiscard]] std::optional<double> f64();
  [[nodiscard]] std::optional<std::string_view> text(std::size_t size);
  [[nodiscard]] std::string_view rest() const { return left_; }

 private:
  template <class Unsigned>
  [[nodiscard]] std::optional<Unsigned> number();
  std::string_view left_;
};

/// Takes the first complete package from the front of `bytes`.
struct Framing {
  std::optional<Package> package;  ///< empty: incomplete; its payload is valid until `bytes` changes
  std::size_t size = 0;            ///< bytes of the package, to be erased
  bool broken = false;             ///< the bytes are not RTDE
};
[[nodiscard]] Framing next_package(std::string_view bytes);

/// A message of the controller for people.
struct TextMessage {
  std::string message, source;
  int level = 0;
};
/// `version`: of the protocol, 1 or 2. Empty: malformed.
[[nodiscard]] std::optional<TextMessage> text_message(std::string_view payload, int version);

/// `text` of a controller for a sentence: at most 200 bytes, with "?" for each byte that is no printable UTF-8.
[[nodiscard]] std::string readable(std::string_view text);

/// Words between commas.
[[nodiscard]] std::vector<std::string> split(std::string_view words);

}  // namespace hecaton::device::universal_robots
