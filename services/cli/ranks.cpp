#include "services/cli/ranks.hpp"

#include <cstdlib>
#include <filesystem>

#include <dlfcn.h>

#include "services/cli/failure.hpp"

namespace hecaton::services::cli {
namespace {

/// Open MPI's mpirun tells so; PMIX_RANK: other starters (srun, prun) that speak to it.
bool started_by_mpirun() {
  return std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr || std::getenv("PMIX_RANK") != nullptr;
}

/// Beside the program as it was built, and as it is installed: bin/hecaton, lib/hecaton/hecaton-mpi.so.
std::filesystem::path library_path() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "lib" / "hecaton" /
         "hecaton-mpi.so";
}

}  // namespace

std::unique_ptr<Ranks> join_ranks() {
  if (!started_by_mpirun()) return nullptr;
  const std::filesystem::path path = library_path();
  if (!std::filesystem::exists(path)) {
    throw Failure(ExitCode::kBadInput, "mpirun started this, but " + path.string() +
                                           " is missing (Debian package hecaton-mpi; or build with libopenmpi-dev)");
  }
  // Global: Open MPI loads parts of itself, which look for its symbols there. Never closed: it may have left threads.
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_GLOBAL);
  void* entry = library != nullptr ? dlsym(library, kRanksEntry) : nullptr;
  if (entry == nullptr) {
    throw Failure(ExitCode::kBadInput, std::string("mpirun started this, but Open MPI cannot be loaded: ") + dlerror());
  }
  return std::unique_ptr<Ranks>(reinterpret_cast<RanksEntry>(entry)());
}

}  // namespace hecaton::services::cli
