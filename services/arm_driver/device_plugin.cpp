#include "services/arm_driver/device_plugin.hpp"

#include <map>
#include <stdexcept>
#include <system_error>

#include <dlfcn.h>

#include "services/arm_driver/devices/plugin.hpp"
#include "services/config/text.hpp"

namespace hecaton::services {
namespace {

using Interface = const char*();
using Types = void(std::vector<device::DeviceType>&);

template <class Function>
Function* function(void* library, const char* name) {
  return reinterpret_cast<Function*>(::dlsym(library, name));
}

std::vector<device::DeviceType> types_of(const std::string& file, const std::string& where) {
  const auto fail = [&](const std::string& why) -> std::runtime_error {
    return std::runtime_error(where + " = " + file + " " + why);
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw fail("must be a shared library with devices: there is no such file");
  }
  // All symbols now: one that is missing must not end a driver while its arm moves.
  void* library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw fail(std::string("cannot be loaded: ") + ::dlerror());
  auto* interface = function<Interface>(library, "hecaton_device_plugin_interface");
  auto* types = function<Types>(library, "hecaton_device_plugin_types");
  if (interface == nullptr || types == nullptr) {
    throw fail("is no device plug-in: it does not export hecaton_device_plugin_" +
               std::string(interface == nullptr ? "interface" : "types") + "; see HECATON_DEVICE_PLUGIN");
  }
  const std::string own = device::plugin_interface();
  if (own != interface()) {
    throw fail("was built for another program: it has '" + config::printable(interface()) + "', this one has '" + own +
               "'; build it again with the headers of this release, and without -march options");
  }
  std::vector<device::DeviceType> found;
  types(found);
  return found;
}

}  // namespace

std::filesystem::path plugin_file(const std::string& plugin, const std::filesystem::path& cell_file) {
  const std::filesystem::path named(plugin);
  const std::filesystem::path beside = std::filesystem::absolute(cell_file).parent_path() / named;
  std::error_code error;
  if (named.has_parent_path() || std::filesystem::exists(beside, error)) return beside.lexically_normal();
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  return (program.parent_path() / kPluginFolder / named).lexically_normal();
}

const std::vector<device::DeviceType>& load_device_plugin(const std::filesystem::path& file, const std::string& where) {
  static std::map<std::string, std::vector<device::DeviceType>> loaded;
  const auto found = loaded.find(file.string());
  if (found != loaded.end()) return found->second;
  return loaded.emplace(file.string(), types_of(file.string(), where)).first->second;
}

}  // namespace hecaton::services
