// The table of limits against the idl files, and every field of every message at its extremes.
#include "services/bus/wire_rules.hpp"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/bus/type_support.hpp"

namespace hecaton::bus {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// One value in a serialised sample.
struct Leaf {
  std::string path;
  FieldRule rule;
  std::size_t at;  ///< of its number or length
};

/// Writes a sample that keeps its rules, little-endian, with two elements in each sequence and two bytes in each text.
class SampleWriter {
 public:
  explicit SampleWriter(const TopicRule& rule) { write(rule.sample, ""); }

  [[nodiscard]] const Bytes& bytes() const { return bytes_; }
  [[nodiscard]] const std::vector<Leaf>& leaves() const { return leaves_; }

 private:
  template <class T>
  void put(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    const auto* raw = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof(T));
  }
  template <class T>
  void leaf(const std::string& path, const FieldRule& rule, T value) {
    put(value);
    leaves_.push_back({path, rule, bytes_.size() - sizeof(T)});
  }
  void text(const std::string& path, const FieldRule& rule) {
    leaf<std::uint32_t>(path, rule, 3);
    for (const char c : {'a', 'b', '\0'}) bytes_.push_back(static_cast<std::uint8_t>(c));
  }
  void write(const StructRule& of, const std::string& prefix) {
    for (const FieldRule& field : of.fields) write(field, prefix + std::string(field.name));
  }
  void write(const FieldRule& field, const std::string& path) {
    switch (field.kind) {
      case FieldKind::kBool:
        return leaf<std::uint8_t>(path, field, 1);
      case FieldKind::kInt32:
        return leaf<std::int32_t>(path, field, 7);
      case FieldKind::kUint32:
        return leaf<std::uint32_t>(path, field, static_cast<std::uint32_t>(field.low));
      case FieldKind::kEnum:
        return leaf<std::uint32_t>(path, field, static_cast<std::uint32_t>(field.high));
      case FieldKind::kInt64:
        return leaf<std::int64_t>(path, field, 7);
      case FieldKind::kUint64:
      case FieldKind::kTerm:
        return leaf<std::uint64_t>(path, field, 7);
      case FieldKind::kFloat:
        return leaf<float>(path, field, 0.5F);
      case FieldKind::kDouble:
        return leaf<double>(path, field, 0.5);
      case FieldKind::kName:
      case FieldKind::kText:
        return text(path, field);
      case FieldKind::kStruct:
        return write(*field.of, path + ".");
      case FieldKind::kDoubles:
      case FieldKind::kUint32s:
      case FieldKind::kNames:
      case FieldKind::kStructs:
        leaf<std::uint32_t>(path, field, 2);
        for (int i = 0; i < 2; ++i) element(field, path + "[" + std::to_string(i) + "]");
        return;
    }
  }
  void element(const FieldRule& field, const std::string& path) {
    FieldRule one = field;
    if (field.kind == FieldKind::kStructs) return write(*field.of, path + ".");
    if (field.kind == FieldKind::kNames) {
      one.kind = FieldKind::kName;
      one.most = kLongestName;
    }
    if (field.kind == FieldKind::kDoubles) one.kind = FieldKind::kDouble;
    if (field.kind == FieldKind::kUint32s) one.kind = FieldKind::kUint32;
    write(one, path);
  }

  Bytes bytes_{0, 1, 0, 0};
  std::vector<Leaf> leaves_;
};

template <class T>
Bytes with(const Bytes& bytes, std::size_t at, T value) {
  Bytes changed = bytes;
  std::memcpy(changed.data() + at, &value, sizeof(T));
  return changed;
}

/// Values that break the rule of this leaf.
std::vector<Bytes> broken(const Bytes& bytes, const Leaf& leaf) {
  const auto doubles = [&](auto zero) {
    using T = decltype(zero);
    std::vector<Bytes> all;
    for (const T value :
         {std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity(), -std::numeric_limits<T>::infinity(),
          std::numeric_limits<T>::max(), std::numeric_limits<T>::lowest(), static_cast<T>(leaf.rule.high * 1.01 + 1.0),
          static_cast<T>(leaf.rule.low - std::abs(leaf.rule.low) * 0.01 - 1.0)}) {
      all.push_back(with(bytes, leaf.at, value));
    }
    return all;
  };
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  switch (leaf.rule.kind) {
    case FieldKind::kBool:
      return {with<std::uint8_t>(bytes, leaf.at, 2), with<std::uint8_t>(bytes, leaf.at, 255)};
    case FieldKind::kEnum:
      return {with(bytes, leaf.at, static_cast<std::uint32_t>(leaf.rule.high) + 1), with(bytes, leaf.at, kMost),
              with(bytes, leaf.at, std::uint32_t{1} << 31U)};
    case FieldKind::kInt32:
      return {with(bytes, leaf.at, std::numeric_limits<std::int32_t>::max()),
              with(bytes, leaf.at, std::numeric_limits<std::int32_t>::min()),
              with(bytes, leaf.at, static_cast<std::int32_t>(leaf.rule.high) + 1),
              with(bytes, leaf.at, static_cast<std::int32_t>(leaf.rule.low) - 1)};
    case FieldKind::kUint32: {
      std::vector<Bytes> all;
      if (leaf.rule.high < kMost) all.push_back(with(bytes, leaf.at, kMost));
      return all;
    }
    case FieldKind::kInt64:
      return {with(bytes, leaf.at, std::numeric_limits<std::int64_t>::max()),
              with(bytes, leaf.at, std::numeric_limits<std::int64_t>::min())};
    case FieldKind::kUint64:
    case FieldKind::kTerm:
      return {with(bytes, leaf.at, std::numeric_limits<std::uint64_t>::max()),
              with(bytes, leaf.at, std::uint64_t{1} << 63U)};
    case FieldKind::kFloat:
      return doubles(float{});
    case FieldKind::kDouble:
      return doubles(double{});
    case FieldKind::kName:
    case FieldKind::kText: {
      std::vector<Bytes> all{with(bytes, leaf.at, kMost), with(bytes, leaf.at, leaf.rule.most + 2),
                             with<std::uint32_t>(bytes, leaf.at, 2)};
      for (const int byte : {0x00, 0x07, 0x1B, 0x7F, 0x80, 0xC0, 0xFF}) {
        all.push_back(with(bytes, leaf.at + 4, static_cast<std::uint8_t>(byte)));
      }
      if (leaf.rule.kind == FieldKind::kName) all.push_back(with<std::uint8_t>(bytes, leaf.at + 4, '\n'));
      return all;
    }
    default:
      return {with(bytes, leaf.at, kMost), with(bytes, leaf.at, leaf.rule.most + 1)};
  }
}

// The rules leave out nothing and keep the order of the messages: sizes, alignment and fields agree with the generated
// serialisation.
template <class T>
void expect_decodes(const SampleWriter& sample) {
  T decoded;
  GuardedType<T>().read({sample.bytes().begin(), sample.bytes().end()}, decoded);
  EXPECT_EQ(decoded.schema(), msg::SCHEMA_VERSION);
  EXPECT_EQ(GuardedType<T>().bytes_of(decoded), std::string(sample.bytes().begin(), sample.bytes().end()));
}

TEST(WireRules, AgreeWithTheGeneratedSerialisationOfEachTopic) {
#define HECATON_EXPECT_DECODES(Type, ...)                                              \
  {                                                                                    \
    SCOPED_TRACE(#Type);                                                               \
    ASSERT_NE(topic_rule(#Type), nullptr);                                             \
    const SampleWriter sample(*topic_rule(#Type));                                     \
    EXPECT_EQ(check_sample(*topic_rule(#Type), sample.bytes()).refusal, std::nullopt); \
    expect_decodes<msg::Type>(sample);                                                 \
  }
  HECATON_TOPICS(HECATON_EXPECT_DECODES)
#undef HECATON_EXPECT_DECODES
  EXPECT_EQ(topic_rules().size(), kTopics.size());
}

/// Names of the fields of each structure in idl/, in their order.
std::map<std::string, std::vector<std::string>> idl_fields() {
  std::map<std::string, std::vector<std::string>> all;
  for (const char* file :
       {"common", "cause", "arm", "device", "goal", "health", "world", "planner", "recorder", "supervisor"}) {
    std::ifstream in(std::string(HECATON_SOURCE_DIR) + "/idl/" + file + ".idl");
    const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    const std::regex structure(R"(struct (\w+) \{([^}]*)\})");
    for (std::sregex_iterator found(text.begin(), text.end(), structure), end; found != end; ++found) {
      const std::string body = std::regex_replace((*found)[2].str(), std::regex("//[^\n]*"), "");
      const std::regex field(R"((\w+)\s*;)");
      auto& names = all[(*found)[1]];
      for (std::sregex_iterator one(body.begin(), body.end(), field); one != end; ++one) names.push_back((*one)[1]);
    }
  }
  return all;
}

TEST(WireRules, NameTheFieldsOfTheIdlFilesInTheirOrder) {
  const auto idl = idl_fields();
  std::function<void(const StructRule&)> compare = [&](const StructRule& rule) {
    std::vector<std::string> names;
    for (const FieldRule& field : rule.fields) names.emplace_back(field.name);
    ASSERT_TRUE(idl.contains(std::string(rule.name))) << rule.name;
    EXPECT_EQ(names, idl.at(std::string(rule.name))) << rule.name;
    for (const FieldRule& field : rule.fields) {
      if (field.of != nullptr) compare(*field.of);
    }
  };
  for (const TopicRule& rule : topic_rules()) compare(rule.sample);
}

TEST(WireRules, RefuseEachFieldBeyondItsLimits) {
  int refused = 0;
  for (const TopicRule& rule : topic_rules()) {
    const SampleWriter sample(rule);
    for (const Leaf& leaf : sample.leaves()) {
      if (leaf.path == "schema") continue;  // another version is dropped by its reader
      for (const Bytes& bytes : broken(sample.bytes(), leaf)) {
        const std::string refusal = check_sample(rule, bytes).refusal.value_or("");
        const std::string name = leaf.path.substr(0, leaf.path.find_first_of(".["));
        EXPECT_TRUE(refusal.starts_with(name)) << rule.sample.name << " " << leaf.path << ": \"" << refusal << "\"";
        ++refused;
      }
    }
  }
  std::printf("%d values refused\n", refused);
  EXPECT_GT(refused, 3000);
}

TEST(WireRules, RefuseEverySampleThatIsCutOffOrTooLong) {
  for (const TopicRule& rule : topic_rules()) {
    const SampleWriter sample(rule);
    for (std::size_t size = 0; size < sample.bytes().size(); ++size) {
      const Bytes cut(sample.bytes().begin(), sample.bytes().begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_TRUE(check_sample(rule, cut).refusal) << rule.sample.name << " of " << size << " bytes";
    }
    Bytes longer = sample.bytes();
    longer.resize(longer.size() + 9);
    EXPECT_TRUE(check_sample(rule, longer).refusal) << rule.sample.name;
    longer.resize(rule.most_bytes + 1);
    EXPECT_TRUE(check_sample(rule, longer).refusal) << rule.sample.name;
  }
}

TEST(WireRules, AcceptTheOtherByteOrder) {
  const TopicRule& rule = *topic_rule("SupervisorRequest");
  Bytes sample{0, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 2, 'a', 0, 0, 0, 0, 0,
               0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,   1, 0, 0, 0, 0};
  sample.insert(sample.end(), {0x3F, 0xF0, 0, 0, 0, 0, 0, 0});  // speed: 1
  sample[7] = static_cast<std::uint8_t>(msg::SCHEMA_VERSION);
  EXPECT_EQ(check_sample(rule, sample).refusal, std::nullopt);
  sample[31] = 9;
  EXPECT_TRUE(check_sample(rule, sample).refusal.value_or("").starts_with("kind = 9"));
}

TEST(WireRules, LeaveOtherSchemaVersionsToTheReader) {
  const SampleWriter sample(*topic_rule("ArmState"));
  const Bytes other = with<std::uint32_t>(sample.bytes(), 4, msg::SCHEMA_VERSION + 1);
  const CheckedSample checked = check_sample(*topic_rule("ArmState"), other);
  EXPECT_EQ(checked.refusal, std::nullopt);
  EXPECT_TRUE(checked.other_schema) << "it is not decoded";
}

TEST(WireRules, TellTheLargestTerm) {
  const SampleWriter sample(*topic_rule("CellMode"));
  for (const Leaf& leaf : sample.leaves()) {
    if (leaf.rule.kind != FieldKind::kTerm) continue;
    const Bytes bytes = with<std::uint64_t>(sample.bytes(), leaf.at, 1000);
    EXPECT_EQ(check_sample(*topic_rule("CellMode"), bytes).largest_term, 1000U) << leaf.path;
  }
}

TEST(WireRules, MakeTextPrintable) {
  EXPECT_EQ(printable("north \xC3\xA9\x1B[2J\xFF", 100), "north \xC3\xA9?[2J?");
  EXPECT_EQ(printable("ab\xC3\xA9", 3), "ab") << "no half character";
  EXPECT_EQ(unprintable("a\nb", true), std::nullopt);
  EXPECT_TRUE(unprintable("a\nb"));
  EXPECT_TRUE(unprintable("\xE2\x80\xAE")) << "right-to-left override";
  EXPECT_TRUE(unprintable("\xED\xA0\x80")) << "half of a surrogate pair";
}

}  // namespace
}  // namespace hecaton::bus
