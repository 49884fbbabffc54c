#pragma once
/// Processes that `mpirun` started together, perhaps on several machines.

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace hecaton::services::cli {

/// Those processes, as one of them sees them. Destroying it waits until the others do so, too. Not for two threads at a
/// time. What goes wrong between them ends them all: mpirun sees to that.
class Ranks {
 public:
  virtual ~Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  Ranks(Ranks&&) = delete;
  Ranks& operator=(Ranks&&) = delete;

  [[nodiscard]] virtual int rank() const = 0;     ///< of this one, 0 … count − 1
  [[nodiscard]] virtual int count() const = 0;    ///< of all
  [[nodiscard]] virtual int on_host() const = 0;  ///< of those on this machine

  /// From another rank to rank 0; does not wait until it is received.
  virtual void tell_first(const std::string& text) = 0;
  /// At rank 0: what another has told, each other's in the order in which it told. Waits for it, or returns nothing
  /// when there is nothing yet.
  virtual std::optional<std::string> told(bool wait) = 0;
  /// Everyone's text, by rank; waits for all of them.
  virtual std::vector<std::string> all_of(const std::string& own) = 0;
  /// Rank 0's text, on every rank.
  virtual std::string first_of(const std::string& own) = 0;

 protected:
  Ranks() = default;
};

/// Nothing when this process was not started by mpirun: MPI is then neither loaded nor needed. Throws Failure (bad
/// input) when it was and Open MPI cannot be used.
[[nodiscard]] std::unique_ptr<Ranks> join_ranks();

/// What the loaded library (services/cli/mpi/ranks.cpp) has under the name kRanksEntry.
using RanksEntry = Ranks* (*)();
inline constexpr const char* kRanksEntry = "hecaton_join_ranks";

}  // namespace hecaton::services::cli
