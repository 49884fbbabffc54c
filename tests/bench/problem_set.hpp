#pragma once
/// Planning problems of one robot as MotionBenchMaker's files give them [Chamzas21].

#include <string>
#include <vector>

#include "planner/global/validity.hpp"

namespace hecaton::bench {

/// One pair of sceneNNNN.yaml and requestNNNN.yaml.
struct Problem {
  std::string name;    ///< path of the scene
  std::string family;  ///< name of its folder
  std::vector<planner::global::WorldBody> world;
  std::vector<double> start;  ///< of all arms, in their order [rad | m]
  std::vector<double> goal;
};

struct ProblemSetFiles {
  std::string urdf;
  std::string srdf;
  std::string folder;                   ///< with folders of scenes and requests, at any depth
  std::vector<std::string> tool_links;  ///< of the arms; empty: the links that the last joints of the requests carry
};

struct ProblemSet {
  std::vector<planner::Arm> arms;  ///< several for a robot with two arms
  std::vector<Problem> problems;   ///< by path
  std::vector<std::string> notes;  ///< decisions about the robot, a sentence each
};

/// Reads the robot and all problems. The requests' goals name the joints to plan for. Others stay where the first
/// request starts them. Limits grow to contain all starts and goals, because controllers stop a hair before joints do.
/// Throws std::runtime_error with one sentence that names the file.
[[nodiscard]] ProblemSet read_problem_set(const ProblemSetFiles& files);

/// All arms as one robot, in an empty world.
[[nodiscard]] planner::global::Validity make_validity(const ProblemSet& set, double step);

}  // namespace hecaton::bench
