#pragma once
/// A cell that runs under `hecaton up` during a test, in a free domain.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cell/cli/process.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton::test {

using Json = nlohmann::json;

inline const std::string kThreePuma = std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml";

class LiveCell : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<std::string> words{std::string(HECATON_BIN_DIR) + "/hecaton",
                                   "up",
                                   cell_file(),
                                   "--headless",
                                   "--domain",
                                   domain(),
                                   "--start-timeout",
                                   "100s"};
    for (const std::string& option : up_options()) words.push_back(option);
    up_ = std::make_unique<Process>(words);
    ASSERT_TRUE(up_->wait_for_message("the cell is up")) << up_->err();
  }

  [[nodiscard]] virtual std::string cell_file() const { return kThreePuma; }

  /// Further options of `hecaton up`.
  [[nodiscard]] virtual std::vector<std::string> up_options() const { return {}; }

  void TearDown() override {
    if (!up_) return;
    up_->signal(SIGINT);
    EXPECT_EQ(up_->wait(), 0) << up_->err();
  }

  [[nodiscard]] std::string domain() const { return std::to_string(domain_.number()); }
  /// Runs hecaton in the domain of the cell.
  [[nodiscard]] Ran run(std::vector<std::string> words) const {
    words.insert(words.end(), {"--domain", domain(), "--connect-timeout", "20s"});
    return run_hecaton(std::move(words));
  }
  [[nodiscard]] std::unique_ptr<Process> start(std::vector<std::string> words) const {
    words.insert(words.begin(), std::string(HECATON_BIN_DIR) + "/hecaton");
    words.insert(words.end(), {"--domain", domain(), "--connect-timeout", "20s"});
    return std::make_unique<Process>(words);
  }
  /// The output of a command with -o json; fails the test when its exit code is not 0.
  [[nodiscard]] Json json(std::vector<std::string> words) const {
    words.insert(words.end(), {"-o", "json"});
    const Ran ran = run(words);
    EXPECT_EQ(ran.code, 0) << ran.err;
    return Json::parse(ran.out, nullptr, false);
  }
  /// The entry of a list whose `key` is `value`; null when there is none.
  [[nodiscard]] static Json entry(const Json& list, const char* key, const std::string& value) {
    for (const Json& item : list) {
      if (item.at(key) == value) return item;
    }
    return nullptr;
  }
  /// Processes of the cell, by node.
  [[nodiscard]] std::map<std::string, pid_t> processes() const {
    std::map<std::string, pid_t> pids;
    const Json status = json({"status"});
    for (const Json& node : status.at("nodes")) {
      pids[node.at("node").get<std::string>()] = node.at("pid").get<pid_t>();
    }
    return pids;
  }

  FreeDomain domain_;
  std::unique_ptr<Process> up_;
};

}  // namespace hecaton::test
