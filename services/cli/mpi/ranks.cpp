/// The only file that knows MPI: a library of its own, which `hecaton` loads when mpirun has started it.

#include "services/cli/ranks.hpp"

#include <algorithm>
#include <list>
#include <numeric>

#include <mpi.h>

namespace hecaton::services::cli {
namespace {

constexpr int kToldTag = 1;

/// Errors of MPI end all ranks with a message of its own: its default.
class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    // Threads of a search call it in turn.
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    if (provided < MPI_THREAD_SERIALIZED) MPI_Abort(MPI_COMM_WORLD, 1);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    MPI_Comm host = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &host);
    MPI_Comm_size(host, &on_host_);
    MPI_Comm_free(&host);
  }
  ~MpiRanks() override {
    for (Sent& sent : sent_) MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
    MPI_Finalize();
  }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;
  MpiRanks(MpiRanks&&) = delete;
  MpiRanks& operator=(MpiRanks&&) = delete;

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int count() const override { return count_; }
  [[nodiscard]] int on_host() const override { return on_host_; }

  void tell_first(const std::string& text) override {
    sent_.remove_if([](Sent& sent) {
      int done = 0;
      MPI_Test(&sent.request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
    Sent& sent = sent_.emplace_back(Sent{text, MPI_REQUEST_NULL});
    MPI_Isend(sent.text.data(), static_cast<int>(sent.text.size()), MPI_CHAR, 0, kToldTag, MPI_COMM_WORLD,
              &sent.request);
  }

  std::optional<std::string> told(bool wait) override {
    int there = 1;
    MPI_Status status;
    if (wait) {
      MPI_Probe(MPI_ANY_SOURCE, kToldTag, MPI_COMM_WORLD, &status);
    } else {
      MPI_Iprobe(MPI_ANY_SOURCE, kToldTag, MPI_COMM_WORLD, &there, &status);
    }
    if (there == 0) return std::nullopt;
    int size = 0;
    MPI_Get_count(&status, MPI_CHAR, &size);
    std::string text(static_cast<std::size_t>(size), '\0');
    MPI_Recv(text.data(), size, MPI_CHAR, status.MPI_SOURCE, kToldTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return text;
  }

  std::vector<std::string> all_of(const std::string& own) override {
    const int size = static_cast<int>(own.size());
    std::vector<int> sizes(static_cast<std::size_t>(count_));
    MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD);
    std::vector<int> begins(sizes.size());
    std::exclusive_scan(sizes.begin(), sizes.end(), begins.begin(), 0);
    std::string all(static_cast<std::size_t>(begins.back() + sizes.back()), '\0');
    MPI_Allgatherv(own.data(), size, MPI_CHAR, all.data(), sizes.data(), begins.data(), MPI_CHAR, MPI_COMM_WORLD);
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < sizes.size(); ++i) texts.push_back(all.substr(begins[i], sizes[i]));
    return texts;
  }

  std::string first_of(const std::string& own) override {
    int size = static_cast<int>(own.size());
    MPI_Bcast(&size, 1, MPI_INT, 0, MPI_COMM_WORLD);
    std::string text = own;
    text.resize(static_cast<std::size_t>(size));
    MPI_Bcast(text.data(), size, MPI_CHAR, 0, MPI_COMM_WORLD);
    return text;
  }

 private:
  /// Stays where it is until it has gone.
  struct Sent {
    std::string text;
    MPI_Request request;
  };
  int rank_ = 0;
  int count_ = 1;
  int on_host_ = 1;
  std::list<Sent> sent_;
};

}  // namespace
}  // namespace hecaton::services::cli

extern "C" hecaton::services::cli::Ranks* hecaton_join_ranks() {
  return new hecaton::services::cli::MpiRanks();
}
