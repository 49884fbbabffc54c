#include "services/arm_driver/devices/universal_robots/primary.hpp"

#include <cmath>
#include <cstdint>

#include "services/arm_driver/devices/universal_robots/rtde.hpp"

namespace hecaton::device::universal_robots {
namespace {

constexpr std::uint32_t kPrimaryHeader = 5;  // bytes, of packages and of their parts
constexpr std::uint32_t kLargestPackage = 1 << 18;
constexpr std::uint8_t kRobotState = 16;
constexpr std::uint8_t kKinematicsInfo = 5;
/// Axes that are almost parallel have a common normal that is far away [m | rad].
constexpr double kLargestParameter = 1e6;

constexpr std::string_view kNoState = "bytes that are no state of a robot";
constexpr std::string_view kMalformed = "a malformed calibration";

bool read_parameters(ByteReader& reader, std::array<double, 6>& values) {
  for (double& value : values) {
    const auto next = reader.f64();
    // False for NaN, too.
    if (!next || !(std::abs(*next) <= kLargestParameter)) return false;
    value = *next;
  }
  return true;
}

// Later versions of a controller may append to it.
std::optional<DhParameters> read_kinematics(std::string_view payload) {
  ByteReader reader(payload);
  for (int joint = 0; joint < 6; ++joint) (void)reader.u32();  // checksums
  DhParameters dh;
  const bool complete = read_parameters(reader, dh.theta) && read_parameters(reader, dh.a) &&
                        read_parameters(reader, dh.d) && read_parameters(reader, dh.alpha);
  const auto status = reader.u32();  // of the calibration
  return complete && status ? std::optional(dh) : std::nullopt;
}

}  // namespace

PrimaryPackage next_primary_package(std::string_view bytes) {
  ByteReader reader(bytes);
  const auto size = reader.u32();
  if (size && (*size < kPrimaryHeader || *size > kLargestPackage)) return {0, kNoState, {}};
  const auto type = reader.u8();
  if (!type || bytes.size() < *size) return {};
  PrimaryPackage package{*size, {}, {}};
  if (*type != kRobotState) return package;
  std::string_view parts = bytes.substr(kPrimaryHeader, *size - kPrimaryHeader);
  while (!parts.empty()) {
    ByteReader part(parts);
    const auto part_size = part.u32();
    const auto part_type = part.u8();
    if (!part_type || *part_size < kPrimaryHeader || *part_size > parts.size()) return {0, kNoState, {}};
    if (*part_type == kKinematicsInfo) {
      package.kinematics = read_kinematics(parts.substr(kPrimaryHeader, *part_size - kPrimaryHeader));
      if (!package.kinematics) return {0, kMalformed, {}};
    }
    parts.remove_prefix(*part_size);
  }
  return package;
}

}  // namespace hecaton::device::universal_robots
