#pragma once
/// Kinds of devices in shared libraries, which `device: {type: …, plugin: FILE}` in the cell file names.

#include <filesystem>
#include <string>
#include <vector>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::services {

/// The file that `plugin` names: a path is relative to the folder of the cell file; a name without a folder is a file
/// of kPluginFolder, unless there is one beside the cell file.
[[nodiscard]] std::filesystem::path plugin_file(const std::string& plugin, const std::filesystem::path& cell_file);

/// Of installed plug-ins, relative to the folder of the programs.
inline constexpr const char* kPluginFolder = "../lib/hecaton/devices";

/// Loads the library, once in a process and for its lifetime. Throws std::runtime_error with a sentence that begins
/// with `where`, when the file cannot be loaded, is no plug-in, or was built for another interface. Not thread-safe.
[[nodiscard]] const std::vector<device::DeviceType>& load_device_plugin(const std::filesystem::path& file,
                                                                        const std::string& where);

}  // namespace hecaton::services
