#pragma once
/// A cell of two arms on slides along x, y and z, each with two fingers that slide along y. The inner face of a finger
/// is at its joint's position from the middle. The tool frame is between the finger tips, 0.08 m below the hand.

#include <fstream>
#include <string>

#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {

/// Width of the opening when a finger is at this position [m].
inline constexpr double kOpened = 0.05;

inline std::string gripper_urdf() {
  const auto link = [](const std::string& name, const std::string& size, const std::string& at) {
    return "<link name=\"" + name + "\"><collision><origin xyz=\"" + at + "\"/><geometry><box size=\"" + size +
           "\"/></geometry></collision></link>";
  };
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child,
                        const std::string& axis, const std::string& limits, const std::string& inside = "") {
    return "<joint name=\"" + name + "\" type=\"prismatic\"><parent link=\"" + parent + "\"/><child link=\"" + child +
           "\"/><axis xyz=\"" + axis + "\"/><limit effort=\"1\" velocity=\"0.5\" " + limits + "/>" + inside +
           "</joint>";
  };
  return "<robot name=\"slides\">" + link("base", "0.04 0.04 0.04", "0 0 1.5") +
         link("across", "0.04 0.04 0.04", "0 0 1.4") + link("along", "0.04 0.04 0.04", "0 0 1.3") +
         link("hand", "0.06 0.24 0.04", "0 0 0") + link("left", "0.02 0.01 0.08", "0 0.005 -0.06") +
         link("right", "0.02 0.01 0.08", "0 -0.005 -0.06") +
         joint("x", "base", "across", "1 0 0", "lower=\"-0.5\" upper=\"0.5\"") +
         joint("y", "across", "along", "0 1 0", "lower=\"-0.5\" upper=\"0.5\"") +
         joint("z", "along", "hand", "0 0 1", "lower=\"0.2\" upper=\"0.9\"") +
         joint("grip", "hand", "left", "0 1 0", "lower=\"0\" upper=\"0.05\"") +
         joint("other", "hand", "right", "0 -1 0", "lower=\"0\" upper=\"0.05\"", "<mimic joint=\"grip\"/>") +
         "</robot>";
}

/// `arm`: further keys of the first arm, lines of four blanks. The crate of 40 mm is at x = 0.3, y = 0, z = 0.3.
inline std::string gripper_cell(const std::string& arm) {
  return "name: grippers\n"
         "defaults:\n"
         "  urdf: slides.urdf\n"
         "  tool_link: hand\n"
         "  tool: {xyz: [0, 0, -0.08]}\n"
         "  joints: {grip: [0, 0.05]}\n"
         "  limits: {velocity: 0.4, acceleration: 4}\n"
         "  damper: {security_distance: 0.004, influence_distance: 0.02}\n"
         "  poses: {home: [0, 0, 0.7], crate: [0.3, 0, 0.38], lifted: [0.3, 0, 0.6], away: [0.3, 0.3, 0.6],\n"
         "          below: [-0.4, 0, 0.3]}\n"
         "arms:\n"
         "  - name: north\n" +
         arm +
         "  - {name: south, base: {xyz: [0, -1.2, 0]}}\n"
         "obstacles:\n"
         "  - name: crate\n"
         "    shapes: [{type: box, size: [0.04, 0.04, 0.04]}]\n"
         "    pose: {xyz: [0.3, 0, 0.3]}\n";
}

inline const std::string kGripperKeys =
    "    gripper: {joint: grip, closed: 0, opened: 0.05, width: 0.1, speed: 0.1}\n"
    "    signals: {part: digital_input, lamp: digital_output, pressure: analog_input 1}\n";

/// Writes the robot beside the cell file, and returns the path of the latter.
inline std::string write_gripper_cell(const TemporaryFolder& folder, const std::string& arm = kGripperKeys) {
  std::ofstream(folder.path() / "slides.urdf") << gripper_urdf();
  const auto path = folder.path() / "cell.yaml";
  std::ofstream(path) << gripper_cell(arm);
  return path.string();
}

}  // namespace hecaton::test
