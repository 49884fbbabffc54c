// A damaged URDF either loads or is refused with a sentence.

#include <array>
#include <sstream>

#include "planner/model/kinematics.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

std::string read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

class Mutator {
 public:
  explicit Mutator(std::string original) : original_(std::move(original)) {}

  std::string next() {
    std::string text = original_;
    const std::size_t rounds = 1 + random_() % 3;
    for (std::size_t i = 0; i < rounds && !text.empty(); ++i) mutate(text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : random_() % n; }

  void mutate(std::string& text) {
    static constexpr std::array kValues{"nan", "-inf", "1e999", "-1", "0", "", "1 2", "x", "1e-320", "1e308", "${x}"};
    static constexpr std::array kPieces{"<link name=\"link9\"/>",
                                        "<joint name=\"j\" type=\"fixed\"/>",
                                        "<mimic joint=\"joint1\"/>",
                                        "<collision/>",
                                        "<geometry><mesh filename=\"x.stl\"/></geometry>",
                                        "<limit/>",
                                        "<axis xyz=\"0 0 0\"/>",
                                        "</link>",
                                        "<!--",
                                        "&#0;",
                                        "]]>"};
    const std::size_t at = below(text.size());
    switch (below(6)) {
      case 0:
        text[at] = static_cast<char>(random_());
        break;
      case 1:
        text.erase(at, below(200));
        break;
      case 2:
        text.insert(at, text.substr(below(text.size()), below(300)));
        break;
      case 3: {  // another attribute value
        const std::size_t open = text.find('"', at);
        const std::size_t close = open == text.npos ? open : text.find('"', open + 1);
        if (close != text.npos) text.replace(open + 1, close - open - 1, kValues[below(kValues.size())]);
        break;
      }
      case 4: {  // between two elements
        const std::size_t end = text.find('>', at);
        if (end != text.npos) text.insert(end + 1, kPieces[below(kPieces.size())]);
        break;
      }
      default: {  // a name that another element has
        const std::size_t open = text.find("=\"", at);
        const std::size_t close = open == text.npos ? open : text.find('"', open + 2);
        const std::size_t other = text.find("=\"", below(text.size()));
        const std::size_t other_end = other == text.npos ? other : text.find('"', other + 2);
        if (close != text.npos && other_end != text.npos) {
          text.replace(open + 2, close - open - 2, text.substr(other + 2, other_end - other - 2));
        }
      }
    }
  }

  std::string original_;
  std::mt19937_64 random_{2026};
};

void expect_sound(const RobotModel& model) {
  ASSERT_GE(model.joints(), 1);
  ASSERT_EQ(model.limits.lower.size(), model.joints());
  ASSERT_TRUE((model.limits.lower.array() < model.limits.upper.array()).all());
  ASSERT_TRUE((model.limits.velocity.array() > 0.0).all());
  const JointVector q = model.limits.lower.cwiseMax(-1.0).cwiseMin(model.limits.upper);
  Kinematics kinematics;
  forward_kinematics(model, Pose::Identity(), q, kinematics);
  ASSERT_TRUE(kinematics.X_WT.matrix().allFinite());
  for (const LinkGeometry& geometry : model.geometry) {
    ASSERT_TRUE(geometry.X_LS.matrix().allFinite());
    ASSERT_GT(world::bounding_sphere(geometry.shape).radius, 0.0);
  }
}

TEST(UrdfMutation, LoadsOrRefusesTwoThousandDamagedCopies) {
  std::string text = read(test::kPuma);
  text.erase(0, text.find("<robot"));  // mutations of the comment teach nothing
  Mutator mutator(text);
  const test::TemporaryFolder folder;
  int loaded = 0;
  int refused = 0;
  for (int i = 0; i < 2000; ++i) {
    const std::string path = folder.write("damaged.urdf", mutator.next());
    try {
      const auto model = load_urdf(path);
      ++loaded;
      expect_sound(*model);
    } catch (const ModelError& error) {
      ++refused;
      const std::string sentence = error.what();
      ASSERT_NE(sentence.find("damaged.urdf"), std::string::npos) << sentence;
      ASSERT_EQ(sentence.find('\n'), std::string::npos) << sentence;
    }
  }
  EXPECT_GT(loaded, 100);  // else the mutations are too coarse to reach the model
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace hecaton::planner
