#pragma once
/// What the driver reads on the primary port (30001) of Universal Robots. All numbers are big-endian. Pure.
///
///     package = int32 size (of the whole package), uint8 type, payload
///     part    = uint32 size (of the whole part), uint8 type, payload; the payload of a package of type 16 is parts
///
/// A controller sends its calibrated kinematics (a part of type 5) after a connection, when it has them.

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace hecaton::device::universal_robots {

/// Denavit-Hartenberg parameters of a robot, with its calibration. Joint i moves frame i − 1 to frame i: a turn of
/// theta + q about z, d along z, a along x, and a turn of alpha about x.
struct DhParameters {
  std::array<double, 6> theta{};  ///< [rad]
  std::array<double, 6> a{};      ///< [m]
  std::array<double, 6> d{};      ///< [m]
  std::array<double, 6> alpha{};  ///< [rad]
};

/// The first package of some bytes.
struct PrimaryPackage {
  std::size_t size = 0;                    ///< bytes of the package, to be erased; 0: incomplete or broken
  std::string_view broken;                 ///< what the controller sends instead of a package; empty: nothing is wrong
  std::optional<DhParameters> kinematics;  ///< all finite; empty: the package has none
};
[[nodiscard]] PrimaryPackage next_primary_package(std::string_view bytes);

}  // namespace hecaton::device::universal_robots
