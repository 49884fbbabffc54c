#include "services/strategies/ranks.hpp"

#include <algorithm>
#include <cstdlib>
#include <list>
#include <numeric>
#include <optional>
#include <sstream>
#include <thread>

#include <mpi.h>

#include "services/command_line/failure.hpp"

namespace hecaton::services::cli {
namespace {

constexpr int kToldTag = 1;

/// Open MPI's mpirun sets the first; PMIX_RANK: other starters (srun, prun) that speak to it.
bool started_by_mpirun() {
  return std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr || std::getenv("PMIX_RANK") != nullptr;
}

}  // namespace

class Ranks::Mpi {
 public:
  Mpi() {
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
  ~Mpi() {
    for (Sent& sent : sent_) MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
    MPI_Finalize();
  }
  Mpi(const Mpi&) = delete;
  Mpi& operator=(const Mpi&) = delete;
  Mpi(Mpi&&) = delete;
  Mpi& operator=(Mpi&&) = delete;

  [[nodiscard]] int rank() const { return rank_; }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] int on_host() const { return on_host_; }

  /// From another rank to rank 0; does not wait until it is received.
  void tell_first(const std::string& text) {
    sent_.remove_if([](Sent& sent) {
      int done = 0;
      MPI_Test(&sent.request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
    Sent& sent = sent_.emplace_back(Sent{text, MPI_REQUEST_NULL});
    MPI_Isend(sent.text.data(), static_cast<int>(sent.text.size()), MPI_CHAR, 0, kToldTag, MPI_COMM_WORLD,
              &sent.request);
  }

  /// At rank 0: a text of another rank, each rank's in its order. Nothing when none is there and `wait` is false.
  std::optional<std::string> told(bool wait) {
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

  /// The text of each rank; waits for all of them.
  std::vector<std::string> all_of(const std::string& own) {
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

  /// Rank 0's text, on every rank.
  std::string first_of(const std::string& own) {
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

Ranks::Ranks() : mpi_(started_by_mpirun() ? std::make_unique<Mpi>() : nullptr) {}

Ranks::~Ranks() = default;

bool Ranks::first() const {
  return !mpi_ || mpi_->rank() == 0;
}

int Ranks::count() const {
  return mpi_ ? mpi_->count() : 1;
}

std::string Ranks::first_of(const std::string& own) {
  return mpi_ ? mpi_->first_of(own) : own;
}

int Ranks::threads() const {
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return mpi_ ? std::max(1, processors / mpi_->on_host()) : processors;
}

void Ranks::together(const std::function<void()>& work) {
  if (!mpi_) return work();
  std::optional<std::string> trouble;
  ExitCode code = ExitCode::kBadInput;
  try {
    work();
  } catch (const Failure& failure) {
    trouble = failure.what();
    code = failure.code();
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  // What the ranks exchange: kFailed and the sentence, or nothing.
  constexpr char kFailed = '!';
  const std::vector<std::string> all = mpi_->all_of(trouble ? kFailed + *trouble : std::string());
  const auto failed = std::find_if(all.begin(), all.end(), [](const std::string& text) { return text[0] == kFailed; });
  if (failed == all.end()) return;
  if (!first()) throw Failure(code, "");
  const std::string who = failed == all.begin() ? "" : "rank " + std::to_string(failed - all.begin()) + ": ";
  throw Failure(code, who + failed->substr(1));
}

void Ranks::require_same(const std::string& what) {
  if (!mpi_) return;
  const std::vector<std::string> all = mpi_->all_of(what);
  const auto other = std::find_if(all.begin(), all.end(), [&](const std::string& text) { return text != all[0]; });
  if (other == all.end()) return;
  if (!first()) throw Failure(ExitCode::kBadInput, "");
  throw Failure(ExitCode::kBadInput, "rank " + std::to_string(other - all.begin()) +
                                         " has another cell file, other options or another version than rank 0");
}

void Ranks::divide(planner::SearchHooks& hooks) {
  if (!mpi_) return;
  hooks.part = mpi_->rank();
  hooks.parts = mpi_->count();
  evaluated_ = std::move(hooks.evaluated);
  hooks.evaluated = [this](const planner::Round& round, std::size_t index, std::size_t all,
                           const planner::Evaluation& evaluation) {
    if (!first()) return mpi_->tell_first(std::to_string(index) + ' ' + text_of(evaluation));
    if (!in_round_) {
      in_round_ = true;
      round_ = round;
      all_ = all;
      missing_ = all - own_count(all);
    }
    evaluated_(round, index, all, evaluation);
    while (receive(false)) continue;
  };
  hooks.share = [this](std::vector<std::string>& texts) {
    while (in_round_ && missing_ > 0) receive(true);
    in_round_ = false;
    exchange(texts);
  };
}

std::size_t Ranks::own_count(std::size_t all) const {
  const auto parts = static_cast<std::size_t>(mpi_->count());
  return (all + parts - 1 - static_cast<std::size_t>(mpi_->rank())) / parts;
}

bool Ranks::receive(bool wait) {
  const std::optional<std::string> told = mpi_->told(wait);
  if (!told) return false;
  --missing_;
  const std::size_t cut = told->find(' ');
  const std::optional<planner::Evaluation> evaluation = planner::evaluation_of(told->substr(cut + 1));
  if (evaluation) evaluated_(round_, std::stoul(told->substr(0, cut)), all_, *evaluation);
  return true;
}

void Ranks::exchange(std::vector<std::string>& texts) {
  const auto parts = static_cast<std::size_t>(mpi_->count());
  std::string own;
  for (auto i = static_cast<std::size_t>(mpi_->rank()); i < texts.size(); i += parts) own += texts[i] + '\n';
  const std::vector<std::string> all = mpi_->all_of(own);
  for (std::size_t part = 0; part < parts; ++part) {
    std::istringstream lines(all[part]);
    for (std::size_t i = part; i < texts.size(); i += parts) std::getline(lines, texts[i]);
  }
}

}  // namespace hecaton::services::cli
