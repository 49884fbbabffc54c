#pragma once
/// Where a host's part of a cell keeps what it must remember while it is up. In memory (/dev/shm) unless TMPDIR names
/// another folder: drivers keep theirs in a mapped file every period, and a page that is being written to a disk would
/// make them wait.
///
/// A run begins with an agent and ends when that is asked to end. An agent that is killed does not end it: who takes
/// its place finds the folder by its name, which says what there may be one of on a machine at a time: a host of a cell
/// in a DDS domain.

#include <chrono>
#include <filesystem>
#include <string>

namespace hecaton::services {

struct RunName {
  std::string cell;
  int domain = 0;  ///< of DDS
  std::string host;
};

class RunFolder {
 public:
  /// Of runs whose agents were killed and never started again, folders as old as this are removed by the next agent.
  static constexpr std::chrono::hours kAbandoned{7 * 24};

  /// `origin`: what the memory in it is of, see run_origin(); what was remembered of anything else is removed, and so
  /// is everything when `anew`. Throws std::runtime_error with a sentence when the folder cannot be had, also when
  /// another process has it.
  RunFolder(const RunName& run, const std::string& origin, bool anew = false);
  /// Removes the folder unless it was kept.
  ~RunFolder();
  RunFolder(RunFolder&& other) noexcept;
  RunFolder& operator=(RunFolder&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// There is a memory of the same origin in it.
  [[nodiscard]] bool goes_on() const { return goes_on_; }
  /// There was one of another origin.
  [[nodiscard]] bool forgot() const { return forgot_; }

  /// The run has begun: from now on the folder outlives us, however we end.
  void keep() { kept_ = true; }
  /// The run is over.
  void end() { kept_ = false; }
  /// Now and then from an agent that lives: else its folder could be taken for abandoned.
  void touch() const;

 private:
  void take(const RunName& run);
  void begin(const std::string& origin, bool anew);
  void remove_abandoned() const;
  void give_back();

  std::filesystem::path path_;
  int folder_ = -1;  ///< a descriptor of it, which holds the lock
  bool goes_on_ = false;
  bool forgot_ = false;
  bool kept_ = false;
};

/// What a run has left whose agent was killed, and shall not go on. Nothing happens when there is no such folder, or
/// somebody has it.
void remove_run(const RunName& run);

}  // namespace hecaton::services
