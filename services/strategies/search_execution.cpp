#include "services/strategies/search_execution.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <list>
#include <numeric>
#include <optional>
#include <sstream>
#include <thread>

#include <mpi.h>

#include "planner/model/fnv1a.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {
namespace {

constexpr int kEvaluationTag = 1;

/// Open MPI's mpirun sets the first variable; srun and prun set PMIX_RANK.
bool started_by_mpirun() {
  return std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr || std::getenv("PMIX_RANK") != nullptr;
}

constexpr auto kFlushInterval = std::chrono::milliseconds(200);

/// A hash of the bits of all values added.
class Fingerprint {
 public:
  void add(double value) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(value + 0.0);  // −0 is 0
    for (int byte = 0; byte < 8; ++byte, bits >>= 8U) hash_.add(bits & 0xFFU);
  }
  template <std::size_t N>
  void add(const double (&values)[N]) {
    for (const double value : values) add(value);
  }
  [[nodiscard]] std::uint64_t value() const { return hash_.value(); }

 private:
  planner::Fnv1a hash_;
};

/// Of the motion problem, the candidates and the first tasks. It differs on a machine that draws other tasks.
std::uint64_t fingerprint(const planner::StrategyProblem& problem, const planner::SearchPlan& plan,
                          const std::vector<planner::SystemStrategy>& candidates) {
  Fingerprint print;
  for (const planner::SystemStrategy& candidate : candidates) {
    for (int arm = 0; arm < problem.arms(); ++arm) {
      print.add(candidate[arm].direction);
      for (int k = 0; k < problem.coefficients(arm); ++k) print.add(candidate[arm].coefficients[k]);
    }
  }
  const planner::FlatProblem& flat = problem.flat();
  for (const double value : {flat.step, flat.distance, flat.self_distance, static_cast<double>(flat.timeout_factor),
                             static_cast<double>(flat.basis), static_cast<double>(flat.nearest_first)})
    print.add(value);
  for (int i = 0; i < flat.boxes; ++i) {
    print.add(flat.box[i].R);
    print.add(flat.box[i].c);
    print.add(flat.box[i].half);
  }
  const planner::TaskSet tasks = problem.draw(plan.seed, plan.screening_tasks);
  for (int i = 0; i < problem.arms(); ++i) {
    const planner::FlatArm& arm = flat.arm[i];
    for (int j = 0; j < arm.joints; ++j) {
      print.add(arm.joint[j].R);
      print.add(arm.joint[j].p);
      for (const double value : {arm.joint[j].lower, arm.joint[j].upper}) print.add(value);
    }
    for (int k = 0; k < arm.bodies; ++k) {
      print.add(arm.body[k].p);
      print.add(arm.body[k].d);
      print.add(arm.body[k].radius);
    }
    for (const double value : tasks.goals[i]) print.add(value);
    for (const double value : tasks.starts[i]) print.add(value);
    for (const std::int32_t value : tasks.waits[i]) print.add(value);
  }
  return print.value();
}

}  // namespace

class Ranks::Mpi {
 public:
  Mpi() {
    int provided = 0;
    // The threads of a search call MPI one at a time.
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

  /// Sends a text to rank 0 without waiting for its receipt.
  void send_to_first(const std::string& text) {
    sent_.remove_if([](Sent& sent) {
      int done = 0;
      MPI_Test(&sent.request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
    Sent& sent = sent_.emplace_back(Sent{text, MPI_REQUEST_NULL});
    MPI_Isend(sent.text.data(), static_cast<int>(sent.text.size()), MPI_CHAR, 0, kEvaluationTag, MPI_COMM_WORLD,
              &sent.request);
  }

  /// On rank 0: the next text of another rank, in the order of its sending. Empty if there is none and `wait` is false.
  std::optional<std::string> receive(bool wait) {
    int there = 1;
    MPI_Status status;
    if (wait) {
      MPI_Probe(MPI_ANY_SOURCE, kEvaluationTag, MPI_COMM_WORLD, &status);
    } else {
      MPI_Iprobe(MPI_ANY_SOURCE, kEvaluationTag, MPI_COMM_WORLD, &there, &status);
    }
    if (there == 0) return std::nullopt;
    int size = 0;
    MPI_Get_count(&status, MPI_CHAR, &size);
    std::string text(static_cast<std::size_t>(size), '\0');
    MPI_Recv(text.data(), size, MPI_CHAR, status.MPI_SOURCE, kEvaluationTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return text;
  }

  /// The texts of all ranks; waits for them.
  std::vector<std::string> all_gather(const std::string& own) {
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

  /// The text of rank 0, on all ranks.
  std::string broadcast(const std::string& own) {
    int size = static_cast<int>(own.size());
    MPI_Bcast(&size, 1, MPI_INT, 0, MPI_COMM_WORLD);
    std::string text = own;
    text.resize(static_cast<std::size_t>(size));
    MPI_Bcast(text.data(), size, MPI_CHAR, 0, MPI_COMM_WORLD);
    return text;
  }

 private:
  /// Must not move until it is sent.
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

std::string Ranks::broadcast(const std::string& own) {
  return mpi_ ? mpi_->broadcast(own) : own;
}

int Ranks::threads() const {
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return mpi_ ? std::max(1, processors / mpi_->on_host()) : processors;
}

void Ranks::together(const std::function<void()>& work) {
  if (!mpi_) return work();
  std::optional<std::string> error_text;
  ExitCode code = ExitCode::kBadInput;
  try {
    work();
  } catch (const Failure& failure) {
    error_text = failure.what();
    code = failure.code();
  } catch (const std::exception& error) {
    error_text = error.what();
  }
  // Each rank sends kFailed and its message, or an empty text.
  constexpr char kFailed = '!';
  const std::vector<std::string> all = mpi_->all_gather(error_text ? kFailed + *error_text : std::string());
  const auto failed = std::find_if(all.begin(), all.end(), [](const std::string& text) { return text[0] == kFailed; });
  if (failed == all.end()) return;
  if (!first()) throw Failure(code, "");
  const std::string rank = failed == all.begin() ? "" : "rank " + std::to_string(failed - all.begin()) + ": ";
  throw Failure(code, rank + failed->substr(1));
}

void Ranks::require_same(const std::string& text) {
  if (!mpi_) return;
  const std::vector<std::string> all = mpi_->all_gather(text);
  const auto other =
      std::find_if(all.begin(), all.end(), [&](const std::string& other_text) { return other_text != all[0]; });
  if (other == all.end()) return;
  if (!first()) throw Failure(ExitCode::kBadInput, "");
  throw Failure(ExitCode::kBadInput, "rank " + std::to_string(other - all.begin()) +
                                         " differs from rank 0 in cell file, options or version");
}

void Ranks::divide(planner::SearchHooks& hooks) {
  if (!mpi_) return;
  hooks.part = mpi_->rank();
  hooks.parts = mpi_->count();
  evaluated_ = std::move(hooks.evaluated);
  hooks.evaluated = [this](const planner::Round& round, std::size_t index, std::size_t all,
                           const planner::Evaluation& evaluation) {
    if (!first()) return mpi_->send_to_first(std::to_string(index) + ' ' + text_of(evaluation));
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
  const std::optional<std::string> text = mpi_->receive(wait);
  if (!text) return false;
  --missing_;
  const std::size_t cut = text->find(' ');
  const std::optional<planner::Evaluation> evaluation = planner::evaluation_of(text->substr(cut + 1));
  if (evaluation) evaluated_(round_, std::stoul(text->substr(0, cut)), all_, *evaluation);
  return true;
}

void Ranks::exchange(std::vector<std::string>& texts) {
  const auto parts = static_cast<std::size_t>(mpi_->count());
  std::string own;
  for (auto i = static_cast<std::size_t>(mpi_->rank()); i < texts.size(); i += parts) own += texts[i] + '\n';
  const std::vector<std::string> all = mpi_->all_gather(own);
  for (std::size_t part = 0; part < parts; ++part) {
    std::istringstream lines(all[part]);
    for (std::size_t i = part; i < texts.size(); i += parts) std::getline(lines, texts[i]);
  }
}

std::string search_title(const planner::StrategyProblem& problem, const planner::SearchPlan& plan,
                         const std::vector<planner::SystemStrategy>& candidates) {
  std::ostringstream out;
  out.precision(17);
  out << "hecaton-strategies, seed " << plan.seed << ", tasks " << plan.screening_tasks << ' ' << plan.confirm_tasks
      << ' ' << plan.confirm_sets << ", complete " << plan.complete << ", halving " << plan.halving << ", refine "
      << plan.refine << ", strategies " << candidates.size();
  out << ", arms";
  for (int arm = 0; arm < problem.arms(); ++arm) out << ' ' << problem.name_of(arm);
  out << ", problem " << std::hex << fingerprint(problem, plan, candidates);
  return out.str();
}

std::string read_progress(const std::string& path, const std::string& title) {
  std::ifstream file(path);
  std::string line;
  if (!file) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be read; --resume needs it");
  if (!std::getline(file, line) || line != title) {
    throw Failure(ExitCode::kBadInput, path + " is of another search or another cell; run without --resume");
  }
  std::ostringstream rest;
  rest << file.rdbuf();
  return rest.str();
}

StrategyProgress::StrategyProgress(bool lines)
    : progress_(lines ? Progress::Elsewhere::kLines : Progress::Elsewhere::kNothing) {}

void StrategyProgress::write_to(const std::string& path, const std::string& title) {
  file_.open(path, std::ios::trunc);
  file_ << title << '\n';
  file_.flush();
  if (!file_) throw Failure(ExitCode::kBadInput, "file '" + path + "' cannot be written");
}

void StrategyProgress::reuse(const std::string& evaluations) {
  std::istringstream lines(evaluations);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    Key key;
    std::string text;
    if (!(words >> key.first >> key.second) || !std::getline(words, text)) continue;
    // A truncated line is evaluated again.
    const auto evaluation = planner::evaluation_of(text);
    if (!evaluation) continue;
    known_[key] = *evaluation;
    if (file_.is_open()) file_ << key.first << ' ' << key.second << ' ' << planner::text_of(*evaluation) << '\n';
  }
  if (file_.is_open()) file_.flush();
}

void StrategyProgress::hook(planner::SearchHooks& hooks) {
  hooks.known = [this](const planner::Round& round, std::size_t index) {
    const auto found = known_.find({round.seed, index});
    return found == known_.end() ? nullptr : &found->second;
  };
  hooks.evaluated = [this](const planner::Round& round, std::size_t index, std::size_t all,
                           const planner::Evaluation& evaluation) {
    const bool is_new = known_.find({round.seed, index}) == known_.end();
    if (file_.is_open() && is_new) file_ << round.seed << ' ' << index << ' ' << planner::text_of(evaluation) << '\n';
    show(round, all);
  };
}

void StrategyProgress::show(const planner::Round& round, std::size_t all) {
  if (round.seed != seed_ || done_ == 0) {
    seed_ = round.seed;
    done_ = 0;
  }
  ++done_;
  const auto now = std::chrono::steady_clock::now();
  if (file_.is_open() && (now - flushed_ >= kFlushInterval || done_ == all)) {
    file_.flush();
    flushed_ = now;
  }
  progress_.show(round.name + " " + std::to_string(round.seed), static_cast<double>(done_), static_cast<double>(all),
                 "strategies");
}

void StrategyProgress::end() {
  progress_.clear();
  if (file_.is_open()) file_.flush();
}

}  // namespace hecaton::services::cli
