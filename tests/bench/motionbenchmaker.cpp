#include "tests/bench/motionbenchmaker.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include <CLI/CLI.hpp>

#include "planner/global/plan.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/terminal.hpp"
#include "services/runtime/options.hpp"
#include "tests/bench/ompl_peer.hpp"
#include "tests/bench/problem_set.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
using namespace planner::global;
using services::ExitCode;
using services::cli::Json;

constexpr int kFiner = 10;     ///< FCL looks at paths so many times as finely as the planners do
constexpr int kRepeats = 5;    ///< calls of ours, of which the fastest counts
constexpr int kBlocks = 64;    ///< of kWidth configurations, timed at once
constexpr int kFclStates = 8;  ///< configurations that FCL checks for its time

struct Options {
  ProblemSetFiles files;
  double step = 1.0 / 32.0;
  int per_family = 0;  ///< 0: all
  int peer_per_family = 5;
  double limit = 10.0;      ///< of a search of ours [s]
  double peer_limit = 2.0;  ///< of one search, and of one shortening [s]
  int states = kFclStates;
  int edges = 2;
  std::uint64_t seed = 1;
  std::string output = "table";
};

enum class Planner { kProven, kSampled, kPeer };
constexpr Planner kPlanners[] = {Planner::kProven, Planner::kSampled, Planner::kPeer};

const char* name_of(Planner planner) {
  return planner == Planner::kProven ? "proven" : planner == Planner::kSampled ? "at steps" : "OMPL + FCL";
}

/// One planner's answer to one problem.
struct Answer {
  bool solved = false;
  double plan_us = 0.0;
  double simplify_us = 0.0;
  double samples = 0.0;
  double length = 0.0;
  bool touches = false;
  std::string reason;  ///< if not solved
  bool invalid_end = false;
};

/// Costs of single checks in the world of one problem [ns].
struct Costs {
  double state = 0.0;
  double fcl_state = 0.0;
  double proven_edge = 0.0;
  double sampled_edge = 0.0;
  double states = 0.0, edges = 0.0;                        ///< compared with FCL
  double permissive_states = 0.0, permissive_edges = 0.0;  ///< free here, colliding in FCL
};

struct Measured {
  std::map<Planner, Answer> answers;
  Costs costs;
};

double length_of(const std::vector<std::vector<double>>& path) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < path[i].size(); ++j) sum += std::pow(path[i + 1][j] - path[i][j], 2);
    length += std::sqrt(sum);
  }
  return length;
}

class Bench {
 public:
  Bench(const Options& options, const ProblemSet& set)
      : options_(options), validity_(make_validity(set, options.step)), random_(options.seed) {}

  Measured measure(const Problem& problem, bool with_peer) {
    validity_.set_world(problem.world);
    test::FclCollisionChecker checker(validity_, problem.world);
    Measured measured;
    for (const Planner planner : {Planner::kProven, Planner::kSampled}) {
      measured.answers[planner] = solve(problem, checker, planner == Planner::kProven);
    }
    if (with_peer && !measured.answers[Planner::kProven].invalid_end) {
      measured.answers[Planner::kPeer] = solve_by_peer(problem, checker);
    }
    measured.costs = costs(problem, checker);
    return measured;
  }

 private:
  Answer solve(const Problem& problem, test::FclCollisionChecker& checker, bool proven) {
    PlanOptions options;
    options.seed = options_.seed;
    options.simplify = false;
    options.check.proven = proven;
    Answer answer;
    answer.plan_us = answer.simplify_us = HUGE_VAL;
    Plan shorter;
    for (int call = 0; call < kRepeats; ++call) {
      const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options_.limit);
      options.budget.ended = [end] { return std::chrono::steady_clock::now() > end; };
      Plan found;
      answer.plan_us = std::min(
          answer.plan_us, processor_time_once([&] { found = plan(validity_, problem.start, problem.goal, options); }));
      answer.samples = static_cast<double>(found.iterations);
      shorter = std::move(found);
      if (!shorter.solved()) {
        answer.reason = shorter.reason;
        answer.invalid_end = shorter.status != PlanStatus::kBudgetEnded;
        return answer;
      }
      answer.simplify_us =
          std::min(answer.simplify_us, processor_time_once([&] { simplify(validity_, options, shorter); }));
    }
    answer.solved = true;
    answer.length = shorter.length;
    answer.touches = checker.collisions_on(shorter.path, options_.step / kFiner) > 0;
    return answer;
  }

  Answer solve_by_peer(const Problem& problem, test::FclCollisionChecker& checker) {
    const OmplPlan found =
        plan_with_ompl(validity_, checker, problem.start, problem.goal, options_.peer_limit, OmplShortening::kSimplify);
    Answer answer;
    answer.solved = found.solved;
    answer.plan_us = found.plan_us;
    answer.simplify_us = found.simplify_us;
    answer.length = length_of(found.path);
    answer.touches = found.solved && checker.collisions_on(found.path, options_.step / kFiner) > 0;
    return answer;
  }

  Costs costs(const Problem& problem, test::FclCollisionChecker& checker) {
    const Space space = space_of(validity_, problem.start, problem.goal);
    const int stride = space.stride;
    std::vector<float> q(static_cast<std::size_t>(kBlocks) * kWidth * stride);
    const auto at = [&](int i) { return q.data() + static_cast<std::ptrdiff_t>(i) * stride; };
    const auto sample = [&] {
      for (int i = 0; i < kBlocks * kWidth; ++i) space.sample(random_, at(i));
    };
    sample();
    Costs costs;
    costs.state = fastest([&] {
                    for (int i = 0; i < kBlocks; ++i) {
                      benchmark::DoNotOptimize(validity_.collisions(at(i * kWidth)));
                    }
                  }) /
                  (kBlocks * kWidth);
    std::vector<float> ends(q.size());
    for (int i = 0; i < kBlocks * kWidth; ++i) {
      const float* to = at((i + 1) % (kBlocks * kWidth));
      space.interpolate(at(i), to, std::min(1.0F, 1.0F / space.distance(at(i), to)), ends.data() + i * stride);
    }
    const auto edge = [&](bool proven) {
      EdgeCheck check;
      check.proven = proven;
      return fastest([&] {
               for (int i = 0; i < kBlocks; ++i) {
                 benchmark::DoNotOptimize(validity_.edge_free(at(i), ends.data() + i * stride, check));
               }
             }) /
             kBlocks;
    };
    costs.proven_edge = edge(true);
    costs.sampled_edge = edge(false);
    compare_states(space, checker, costs);
    compare_edges(space, checker, costs);
    return costs;
  }

  void compare_states(const Space& space, test::FclCollisionChecker& checker, Costs& costs) {
    std::vector<float> q(static_cast<std::size_t>(kWidth) * space.stride);
    double us = 0.0;
    for (int i = 0; i < options_.states; i += kWidth) {
      for (int lane = 0; lane < kWidth; ++lane) space.sample(random_, q.data() + lane * space.stride);
      unsigned fcl = 0;
      us += processor_time_once([&] {
        for (int lane = 0; lane < kWidth; ++lane) {
          fcl |= checker.collides(q.data() + lane * space.stride) ? 1U << lane : 0U;
        }
      });
      costs.permissive_states += __builtin_popcount(fcl & ~validity_.collisions(q.data()));
      costs.states += kWidth;
    }
    costs.fcl_state = 1e3 * us / std::max(1.0, costs.states);
  }

  void compare_edges(const Space& space, test::FclCollisionChecker& checker, Costs& costs) {
    std::vector<float> a(space.stride), b(space.stride);
    for (int i = 0; i < options_.edges; ++i) {
      space.sample(random_, a.data());
      space.sample(random_, b.data());
      space.interpolate(a.data(), b.data(), std::min(1.0F, 1.0F / space.distance(a.data(), b.data())), b.data());
      ++costs.edges;
      if (!validity_.edge_free(a.data(), b.data())) continue;
      const std::vector<std::vector<double>> way{{a.begin(), a.begin() + space.dimensions},
                                                 {b.begin(), b.begin() + space.dimensions}};
      costs.permissive_edges += checker.collisions_on(way, options_.step / kFiner) > 0 ? 1.0 : 0.0;
    }
  }

  /// [ns]
  template <typename Work>
  static double fastest(const Work& work) {
    double us = HUGE_VAL;
    for (int call = 0; call < kRepeats; ++call) us = std::min(us, processor_time_once(work));
    return 1e3 * us;
  }

  const Options& options_;
  Validity validity_;
  Random random_;
};

/// Sums of some problems by planner.
class Row {
 public:
  void add(const Answer& answer) {
    ++problems_;
    touching_ += answer.touches ? 1.0 : 0.0;
    if (!answer.solved) return;
    ++solved_;
    plan_.add(answer.plan_us);
    simplify_.add(answer.simplify_us);
    both_.add(answer.plan_us + answer.simplify_us);
    samples_ += answer.samples;
    length_ += answer.length;
  }
  /// For ratios, a search that its limit ended took at least that long.
  void add_as_peer(const Answer& answer) {
    peer_plan_.add(answer.plan_us);
    peer_both_.add(answer.plan_us + answer.simplify_us);
  }
  [[nodiscard]] double ratio(const Row& other, double fraction, bool both) const {
    const auto of = [&](const Row& row) { return (both ? row.peer_both_ : row.peer_plan_).percentile(fraction); };
    return of(*this) / of(other);
  }
  [[nodiscard]] Json json() const {
    return {{"problems", problems_},
            {"solved", solved_},
            {"plan_p50_us", plan_.percentile(0.5)},
            {"plan_p95_us", plan_.percentile(0.95)},
            {"simplify_p50_us", simplify_.percentile(0.5)},
            {"simplify_p95_us", simplify_.percentile(0.95)},
            {"both_p50_us", both_.percentile(0.5)},
            {"both_p95_us", both_.percentile(0.95)},
            {"samples", solved_ > 0 ? samples_ / solved_ : NAN},
            {"length", solved_ > 0 ? length_ / solved_ : NAN},
            {"touching", touching_}};
  }

 private:
  double problems_ = 0.0, solved_ = 0.0, touching_ = 0.0;
  double samples_ = 0.0, length_ = 0.0;  ///< sums
  Timings plan_, simplify_, both_;       ///< of solved problems
  Timings peer_plan_, peer_both_;        ///< of the problems that the peer was asked, too
};

/// Medians over problems, and sums of counts.
struct CostRow {
  Timings state, fcl_state, proven_edge, sampled_edge;
  double states = 0.0, edges = 0.0, permissive_states = 0.0, permissive_edges = 0.0;

  void add(const Costs& costs) {
    state.add(costs.state);
    fcl_state.add(costs.fcl_state);
    proven_edge.add(costs.proven_edge);
    sampled_edge.add(costs.sampled_edge);
    states += costs.states;
    edges += costs.edges;
    permissive_states += costs.permissive_states;
    permissive_edges += costs.permissive_edges;
  }
  [[nodiscard]] Json json() const {
    return {{"state_ns", state.percentile(0.5)},
            {"fcl_state_ns", fcl_state.percentile(0.5)},
            {"state_ratio", fcl_state.percentile(0.5) / state.percentile(0.5)},
            {"proven_edge_ns", proven_edge.percentile(0.5)},
            {"sampled_edge_ns", sampled_edge.percentile(0.5)},
            {"states", states},
            {"permissive_states", permissive_states},
            {"edges", edges},
            {"permissive_edges", permissive_edges}};
  }
};

struct Summary {
  std::map<Planner, Row> rows;
  CostRow costs;

  void add(const Measured& measured) {
    const bool asked_peer = measured.answers.contains(Planner::kPeer);
    for (const auto& [planner, answer] : measured.answers) {
      rows[planner].add(answer);
      if (asked_peer) rows[planner].add_as_peer(answer);
    }
    costs.add(measured.costs);
  }
  [[nodiscard]] Json json() const {
    Json result;
    for (const auto& [planner, row] : rows) {
      Json& entry = result[name_of(planner)] = row.json();
      if (!rows.contains(Planner::kPeer)) continue;
      const Row& peer = rows.at(Planner::kPeer);
      entry["ratio_plan_p50"] = peer.ratio(row, 0.5, false);
      entry["ratio_plan_p95"] = peer.ratio(row, 0.95, false);
      entry["ratio_both_p50"] = peer.ratio(row, 0.5, true);
      entry["ratio_both_p95"] = peer.ratio(row, 0.95, true);
    }
    result["checks"] = costs.json();
    return result;
  }
};

std::string number(const Json& value) {
  const double x = value.get<double>();
  if (!std::isfinite(x)) return "–";
  const double size = std::abs(x);
  return services::cli::decimal_text(x, size >= 100.0 || x == std::round(x) ? 0 : size >= 10.0 ? 1 : 2);
}

std::string tables(const Json& families) {
  using services::cli::Align;
  using services::cli::Table;
  const auto columns = [](std::vector<std::string> left, const std::vector<std::string>& right) {
    std::vector<Table::Column> result;
    for (auto& title : left) result.push_back({title, Align::kLeft});
    for (const auto& title : right) result.push_back({title, Align::kRight});
    return result;
  };
  Table plans(columns({"family", "edges"}, {"solved", "plan", "p95", "simplify", "both", "p95", "samples", "length",
                                            "touch", "÷ plan", "÷ p95", "÷ both", "÷ p95"}));
  Table checks(columns(
      {"family"}, {"state", "FCL", "÷", "edge, proven", "at steps", "states", "permissive", "edges", "permissive"}));
  for (const auto& [family, entry] : families.items()) {
    std::string shown = family;
    for (const Planner planner : kPlanners) {
      if (!entry.contains(name_of(planner))) continue;
      const Json& row = entry[name_of(planner)];
      std::vector<std::string> cells{shown, name_of(planner), number(row["solved"]) + "/" + number(row["problems"])};
      for (const char* key : {"plan_p50_us", "plan_p95_us", "simplify_p50_us", "both_p50_us", "both_p95_us", "samples",
                              "length", "touching"}) {
        cells.push_back(number(row[key]));
      }
      for (const char* key : {"ratio_plan_p50", "ratio_plan_p95", "ratio_both_p50", "ratio_both_p95"}) {
        cells.push_back(planner != Planner::kPeer && row.contains(key) ? number(row[key]) : "");
      }
      plans.add(std::move(cells));
      shown.clear();
    }
    const Json& cost = entry["checks"];
    std::vector<std::string> cells{family};
    for (const char* key : {"state_ns", "fcl_state_ns", "state_ratio", "proven_edge_ns", "sampled_edge_ns", "states",
                            "permissive_states", "edges", "permissive_edges"}) {
      cells.push_back(number(cost[key]));
    }
    checks.add(std::move(cells));
  }
  const services::cli::Palette palette = services::cli::Palette::for_stream(stdout);
  return "Times of planning in µs of processor time: median and p95 of solved problems; ÷: of OMPL + FCL, of the\n"
         "problems that both were given.\n" +
         plans.text(palette, 200) +
         "\nTimes of one check in ns: medians over problems, of random configurations and of edges of at most 1 "
         "rad.\n" +
         checks.text(palette, 200);
}

/// `count` problems of each family, evenly spread; 0: all.
std::vector<bool> chosen(const std::vector<Problem>& problems, int count) {
  std::map<std::string, std::vector<std::size_t>> families;
  for (std::size_t i = 0; i < problems.size(); ++i) families[problems[i].family].push_back(i);
  std::vector<bool> result(problems.size(), count <= 0);
  for (const auto& [family, members] : families) {
    for (int k = 0; k < count; ++k) result[members[members.size() * static_cast<std::size_t>(k) / count]] = true;
  }
  return result;
}

ExitCode run(const Options& options) {
  const ProblemSet set = read_problem_set(options.files);
  const std::vector<bool> taken = chosen(set.problems, options.per_family);
  std::vector<Problem> kept;
  for (std::size_t i = 0; i < set.problems.size(); ++i) {
    if (taken[i]) kept.push_back(set.problems[i]);
  }
  std::vector<bool> peer = chosen(kept, options.peer_per_family);
  if (options.peer_per_family <= 0) peer.assign(kept.size(), false);

  Bench bench(options, set);
  services::cli::Interruption interruption;
  services::cli::Progress progress;
  std::map<std::string, Summary> families;
  Summary all;
  std::vector<std::string> unsolved;
  bool bad = false;
  std::size_t done = 0;
  for (; done < kept.size() && !interruption.requested(); ++done) {
    progress.show("planning", static_cast<double>(done), static_cast<double>(kept.size()), "problems");
    const Measured measured = bench.measure(kept[done], peer[done]);
    const Answer& proven = measured.answers.at(Planner::kProven);
    if (!proven.solved) unsolved.push_back(kept[done].name + ": " + proven.reason);
    bad = bad || (!proven.solved && !proven.invalid_end) || proven.touches ||
          measured.costs.permissive_states + measured.costs.permissive_edges > 0.0;
    families[kept[done].family].add(measured);
    all.add(measured);
  }
  progress.clear();
  Json by_family;
  for (const auto& [family, summary] : families) by_family[family] = summary.json();
  if (done > 0) by_family["all"] = all.json();
  const auto interrupted = interruption.after(done, kept.size(), "problems");
  if (options.output == "json") {
    const Json document{{"robot", options.files.urdf},
                        {"lanes", fastest_validity().lanes},
                        {"step", options.step},
                        {"families", by_family},
                        {"unsolved", unsolved},
                        {"notes", set.notes},
                        {"interrupted", services::cli::to_json(interrupted)}};
    std::fputs(services::cli::json_text(document).c_str(), stdout);
  } else {
    std::printf("%s, %d joints, %d lanes, step %g\n", options.files.urdf.c_str(), make_validity(set, 1.0).dimensions(),
                fastest_validity().lanes, options.step);
    if (done > 0) std::fputs(tables(by_family).c_str(), stdout);
    for (const std::string& sentence : unsolved) std::printf("not solved: %s\n", sentence.c_str());
    if (interrupted) std::printf("%s\n", interrupted->text().c_str());
  }
  if (interrupted) return interrupted->exit_code();
  return bad ? ExitCode::kNegative : ExitCode::kDone;
}

}  // namespace

int run_motionbenchmaker(int count, const char* const* words) {
  Options options;
  CLI::App app(
      "RRT-Connect on the problems of MotionBenchMaker, with edges that are proven free and with edges checked "
      "at steps, beside OMPL's RRT-Connect with FCL");
  app.add_option("URDF", options.files.urdf, "the robot's description")->required();
  app.add_option("SRDF", options.files.srdf, "its pairs of links that need no check")->required();
  app.add_option("PROBLEMS", options.files.folder, "folder of pairs sceneNNNN.yaml and requestNNNN.yaml, at any depth")
      ->required();
  app.add_option("--tool-link", options.files.tool_links,
                 "tool link of each arm, separated by commas (the links that the last joints of the requests carry)")
      ->delimiter(',');
  app.add_option("--step", options.step, "between checked configurations of an edge [rad | m] (1/32)")
      ->check(CLI::Range(1e-4, 1.0));
  app.add_option("--problems", options.per_family, "problems of each family; 0: all (0)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--peer", options.peer_per_family, "problems of each family for OMPL and FCL; 0: none (5)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--limit", options.limit, "time limit of a search [s] (10)")->check(CLI::Range(0.001, 3600.0));
  app.add_option("--peer-limit", options.peer_limit, "the same for OMPL's search, and for its shortening [s] (2)")
      ->check(CLI::Range(0.001, 3600.0));
  app.add_option("--states", options.states, "random configurations of each problem compared with FCL (8)")
      ->check(CLI::Range(0, 1'000'000));
  app.add_option("--edges", options.edges, "random edges of each problem compared with FCL (2)")
      ->check(CLI::Range(0, 1'000'000));
  app.add_option("--seed", options.seed, "of all random choices (1)");
  app.add_option("-o,--output", options.output, "table or json (table)")->check(CLI::IsMember({"table", "json"}));
  app.footer(
      "Ours is the fastest of five calls, OMPL + FCL one call. touch: paths in which FCL finds a collision at a tenth "
      "of "
      "the step.\npermissive: free here, and colliding in FCL. Exit codes: 0 done, 1 a problem with valid ends was not "
      "solved, or a\nproven path touches, or a check was permissive, 2 usage, 3 bad input, 130 interrupted by Ctrl-C "
      "(143: by SIGTERM), with\nthe problems that are finished.");
  try {
    app.parse(count, words);
  } catch (const CLI::ParseError& error) {
    return static_cast<int>(app.exit(error) == 0 ? ExitCode::kDone : ExitCode::kUsage);
  }
  try {
    return static_cast<int>(run(options));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hecaton-bench-plan: %s\n", error.what());
    return static_cast<int>(ExitCode::kBadInput);
  }
}

}  // namespace hecaton::bench
