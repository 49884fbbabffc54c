/// Structures of one version become those of another, from IDL texts and bytes that are written by hand.

#include "services/recorder/message_conversion.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <idl/common.h>

#include "services/bus/topics.hpp"
#include "services/recorder/message_schema.hpp"
#include "tests/support/cdr_writer.hpp"

namespace hecaton::test {
namespace {

using namespace services::recorder;

std::string idl_error(const std::string& text) {
  try {
    const IdlTypes types(text);
  } catch (const IdlError& error) {
    return error.what();
  }
  return "";
}

/// Both structures are called S.
struct Versions {
  Versions(const std::string& old_text, const std::string& new_text, std::size_t most_bytes = 1000)
      : from(old_text), to(new_text), conversion(*from.structure("S"), *to.structure("S"), most_bytes) {}

  Bytes convert(const Bytes& message) {
    const ByteSpan converted = conversion.convert(message);
    return {converted.begin(), converted.end()};
  }

  IdlTypes from;
  IdlTypes to;
  MessageConversion conversion;
};

template <class Function>
std::string conversion_error(const Function& function) {
  try {
    function();
  } catch (const ConversionError& error) {
    return error.what();
  }
  return "";
}

TEST(IdlTypes, ReadsAllMessagesOfThisProgram) {
  ASSERT_FALSE(message_files().empty());
  for (const std::string_view text : message_files()) EXPECT_EQ(idl_error(std::string(text)), "");
  for (const bus::TopicInfo& topic : bus::kTopics) {
    const IdlTypes types(message_schema(topic.type));
    EXPECT_NE(types.structure(topic.type), nullptr) << topic.type;
    EXPECT_EQ(types.constant("SCHEMA_VERSION"), msg::SCHEMA_VERSION) << topic.type;
  }
  const IdlTypes types(message_schema("ArmState"));
  const IdlType* state = types.structure("ArmState");
  ASSERT_NE(state, nullptr);
  EXPECT_EQ(state->field("q")->type->text(), "sequence of double");
  EXPECT_EQ(state->field("mode")->type->text(), "enumeration ArmMode");
  EXPECT_EQ(state->field("cause")->type->text(), "structure Cause");
  EXPECT_EQ(state->field("speed_scaling")->otherwise, IdlValue(1.0));
  EXPECT_EQ(state->field("none"), nullptr);
  EXPECT_EQ(types.structure("ArmMode"), nullptr) << "an enumeration";
  EXPECT_EQ(types.constant("NONE"), std::nullopt);
}

TEST(IdlTypes, ReadsWhatTheLanguageHasForSuchTypes) {
  const IdlTypes types(R"(
    #define LINES of the preprocessor
    module a { module b {
      const short N = 3; /* a comment
                            of two lines */
      const string TEXT = "text";
      typedef double Row[2][N];
      enum E { A, @value(7) B, C };
    }; };
    @appendable struct T { @unit("m") octet byte; int16 small; };
    @nested struct S {
      @key @default("x") string<N> name;
      long long a, b[2];
      ::a::b::Row rows;
      sequence<sequence<a::b::E, 4>, N> lists;
      @default(B) a::b::E letter;
      @default(-2.5e-1) float real;
      @default(TRUE) boolean yes;
      T nested;
    };)");
  const IdlType* letters = types.structure("S")->field("letter")->type;
  EXPECT_EQ(letters->labels, (std::vector<std::pair<std::string, std::uint32_t>>{{"A", 0}, {"B", 7}, {"C", 8}}));
  std::string fields;
  for (const IdlField& field : types.structure("S")->fields) fields += field.name + ": " + field.type->text() + "\n";
  EXPECT_EQ(fields,
            "name: string\na: long long\nb: array of 2 long long\nrows: array of 2 array of 3 double\n"
            "lists: sequence of sequence of enumeration E\nletter: enumeration E\nreal: float\nyes: boolean\n"
            "nested: structure T\n");
  EXPECT_EQ(types.structure("S")->field("name")->otherwise, IdlValue(std::string("x")));
  EXPECT_EQ(types.structure("S")->field("letter")->otherwise, IdlValue(IdlLabel{"B"}));
  EXPECT_EQ(types.structure("S")->field("real")->otherwise, IdlValue(-0.25));
  EXPECT_EQ(types.structure("S")->field("yes")->otherwise, IdlValue(true));
  EXPECT_EQ(types.constant("N"), 3);
  EXPECT_EQ(types.constant("TEXT"), std::nullopt) << "no number";
}

TEST(IdlTypes, RefusesWithALine) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"struct S { long a; }", "line 1: ';' is expected, and the end stands there"},
      {"struct S {\n};", "line 2: structure 'S' has no fields"},
      {"struct S { Other a; };", "line 1: the type 'Other' is not known"},
      {"struct S { S a; };", "line 1: the type 'S' is not known"},
      {"struct S { sequence<S> a; };", "line 1: the type 'S' is not known"},
      {"struct S;", "line 1: '{' is expected, and ';' stands there"},
      {"union U switch (long) {};", "line 1: a structure, enumeration, constant or typedef is expected, and 'union'"},
      {"struct S { @optional long a; };", "line 1: the annotation 'optional' is not known"},
      {"@mutable struct S { long a; };", "line 1: the annotation 'mutable' is not known"},
      {"@bit_bound(8) enum E { A };", "line 1: the annotation 'bit_bound' is not known"},
      {"struct S { long a; double a; };", "line 1: field 'a' is defined twice"},
      {"struct S { long a; }; struct S { long a; };", "line 1: 'S' is defined twice"},
      {"const long S = 1; enum S { A };", "line 1: 'S' is defined twice"},
      {"enum E { A, A };", "line 1: label 'A' or its number is defined twice"},
      {"enum E { A, @value(0) B };", "line 1: label 'B' or its number is defined twice"},
      {"enum E { @value(4294967295) A, B };", "line 1: label 'B' or its number is defined twice"},
      {"enum E { @value(-1) A };", "line 1: @value needs a number from 0 to 4294967295"},
      {"enum E { };", "line 1: a name is expected, and '}' stands there"},
      {"struct S { long a[0]; };", "line 1: a number of elements from 1 to 4294967295 is expected"},
      {"struct S { long a[\"3\"]; };", "line 1: a number of elements from 1 to 4294967295 is expected"},
      {"struct S { long a[-3]; };", "line 1: a number of elements from 1 to 4294967295 is expected"},
      {"const double X = 1.2.3;", "line 1: '1.2.3' is no number that is known"},
      {"const long X = 99999999999999999999x;", "line 1: '99999999999999999999x' is no number that is known"},
      {"const string X = \"a\nb\";", "line 1: a text must end on its line and have no backslash"},
      {"const string X = \"a", "line 1: a text must end on its line and have no backslash"},
      {"/* never ends", "line 1: a comment has no end"},
      {"struct S { long double a; };", "line 1: the type 'long double' is not known"},
      {"@key(", "line 1: an annotation has no end"},
      {std::string("\n\x01\xff"), "line 2: a structure, enumeration, constant or typedef is expected, and '?' stands"},
      {"const long " + std::string(201, 'x') + " = 1;", "line 1: a name is longer than 200 characters"},
      {std::string(IdlTypes::kLongest + 1, ' '), "it has 262145 bytes, at most 262144 are read"}};
  for (const auto& [text, phrase] : cases) {
    EXPECT_TRUE(idl_error(text).starts_with(phrase)) << text.substr(0, 80) << "\n" << idl_error(text);
  }
}

TEST(IdlTypes, BoundsNesting) {
  std::string sequences = "double";
  std::string modules;
  std::string structures = "struct S0 { long a; };\n";
  std::string aliases = "typedef sequence<long> A0;\n";
  for (int i = 1; i <= 20; ++i) {
    const std::string former = std::to_string(i - 1);
    sequences = "sequence<" + sequences + ">";
    modules += "module m { ";
    structures += "struct S" + std::to_string(i) + " { S" + former + " a, b; };\n";
    aliases += "typedef sequence<A" + former + "> A" + std::to_string(i) + ";\n";
  }
  EXPECT_NE(idl_error("struct S { " + sequences + " a; };"), "");
  EXPECT_NE(idl_error(modules), "");
  EXPECT_NE(idl_error(structures), "");
  EXPECT_NE(idl_error(aliases), "");
}

TEST(MessageConversion, MatchesFieldsByTheirNames) {
  Versions versions(
      "enum E { A, B, C };\n"
      "struct P { double x; double gone; double y; };\n"
      "struct S { unsigned long schema; string name; sequence<P> points; E letter; long small; string gone; float f; "
      "};",
      "enum E { NEW, C, B, A };\n"
      "struct Q { @default(2.5) double z; double y; double x; };\n"
      "struct S { @default(13) unsigned long schema; double f; E letter; string name; @default(B) E other;\n"
      "           long long small; sequence<Q> points; @default(\"none\") string added; boolean flag; sequence<Q> "
      "more; };");
  EXPECT_FALSE(versions.conversion.is_same());
  EXPECT_EQ(versions.conversion.added(), (std::vector<std::string>{"S.other", "Q.z", "S.added", "S.flag", "S.more"}));
  EXPECT_EQ(versions.conversion.removed(), (std::vector<std::string>{"P.gone", "S.gone"}));
  for (const bool little : {true, false}) {
    const Bytes old = CdrWriter(little)
                          .number(std::uint32_t{12})
                          .text("north")
                          .number(std::uint32_t{2})
                          .numbers_of({1.0, 99.0, 2.0, 3.0, 99.0, 4.0})
                          .number(std::uint32_t{2})
                          .number(std::int32_t{-5})
                          .text("removed")
                          .number(0.5F)
                          .bytes();
    const Bytes expected = CdrWriter()
                               .number(std::uint32_t{13})
                               .number(0.5)
                               .number(std::uint32_t{1})
                               .text("north")
                               .number(std::uint32_t{2})
                               .number(std::int64_t{-5})
                               .number(std::uint32_t{2})
                               .numbers_of({2.5, 2.0, 1.0, 2.5, 4.0, 3.0})
                               .text("none")
                               .number(std::uint8_t{0})
                               .number(std::uint32_t{0})
                               .bytes();
    EXPECT_EQ(versions.convert(old), expected);
  }
}

TEST(MessageConversion, KeepsAMessageOfTheSameStructure) {
  const std::string text =
      "enum E { A, B };\n"
      "struct P { octet b; double x; };\n"
      "struct S { unsigned long schema; char c; short s; boolean yes; E e; string t; sequence<string> names;\n"
      "           P points[2]; unsigned long long last; };";
  Versions versions(text, "enum E { A, B, C };" + text.substr(text.find('\n')));
  EXPECT_TRUE(versions.conversion.is_same()) << "a label was added behind the others";
  EXPECT_TRUE(versions.conversion.added().empty() && versions.conversion.removed().empty());
  const auto message = [](std::uint32_t version) {
    return CdrWriter()
        .number(version)
        .number(std::uint8_t{'c'})
        .number(std::int16_t{-3})
        .number(std::uint8_t{1})
        .number(std::uint32_t{1})
        .text("text")
        .number(std::uint32_t{2})
        .text("")
        .text("b")
        .number(std::uint8_t{1})
        .number(std::numeric_limits<double>::infinity())
        .number(std::uint8_t{2})
        .number(-0.0)
        .number(std::numeric_limits<std::uint64_t>::max())
        .bytes();
  };
  EXPECT_EQ(versions.convert(message(7)), message(0)) << "the version has no default here";
}

TEST(MessageConversion, WidensNumbersOnly) {
  const std::vector<std::string> types{
      "char",  "octet",  "int8",    "short",  "long", "unsigned long",  "long long", "unsigned long long",
      "float", "double", "boolean", "string", "E",    "sequence<long>", "P",         "long[2]"};
  const std::vector<std::string> allowed{"octet>short",
                                         "octet>long",
                                         "octet>unsigned long",
                                         "octet>long long",
                                         "octet>unsigned long long",
                                         "octet>float",
                                         "octet>double",
                                         "int8>short",
                                         "int8>long",
                                         "int8>long long",
                                         "int8>float",
                                         "int8>double",
                                         "short>long",
                                         "short>long long",
                                         "short>float",
                                         "short>double",
                                         "long>long long",
                                         "long>double",
                                         "unsigned long>long long",
                                         "unsigned long>unsigned long long",
                                         "unsigned long>double",
                                         "float>double"};
  const auto text_of = [](const std::string& type) {
    const bool array = type.ends_with("]");
    return "enum E { A }; struct P { long a; }; struct S { " + (array ? "long a[2]" : type + " a") + "; };";
  };
  for (const std::string& from : types) {
    for (const std::string& to : types) {
      const bool may = from == to || std::find(allowed.begin(), allowed.end(), from + ">" + to) != allowed.end();
      const std::string error = conversion_error([&] { const Versions versions(text_of(from), text_of(to)); });
      EXPECT_EQ(error.empty(), may) << from << " to " << to << ": " << error;
    }
  }
  EXPECT_EQ(conversion_error([] {
              const Versions versions("struct P { long long x; }; struct S { sequence<P> points; };",
                                      "struct P { long x; }; struct S { sequence<P> points; };");
            }),
            "points.x is long long in the recording, and long in this program, which is no wider form of it");
  EXPECT_NE(conversion_error([] { const Versions versions("struct S { long a[2]; };", "struct S { long a[3]; };"); }),
            "");
  Versions versions("struct S { unsigned long a; short b; };", "struct S { double a; float b; };");
  EXPECT_EQ(versions.convert(CdrWriter().number(std::uint32_t{4294967295}).number(std::int16_t{-32768}).bytes()),
            CdrWriter().number(4294967295.0).number(-32768.0F).bytes());
}

TEST(MessageConversion, RefusesAMessageWithItsField) {
  Versions versions("enum E { A, GONE }; struct P { E e; string t; }; struct S { sequence<P> points; };",
                    "enum E { A }; struct P { E e; string t; }; struct S { sequence<P> points; };");
  const auto message = [](std::uint32_t letter) {
    return CdrWriter().number(std::uint32_t{1}).number(letter).text("text").bytes();
  };
  EXPECT_EQ(versions.convert(message(0)), message(0));
  EXPECT_EQ(conversion_error([&] { versions.convert(message(1)); }),
            "points.e is GONE, which this program does not know");
  EXPECT_EQ(conversion_error([&] { versions.convert(message(2)); }),
            "points.e is 2, which enumeration E of the recording does not have");
  Bytes cut = message(0);
  cut.pop_back();
  EXPECT_EQ(conversion_error([&] { versions.convert(cut); }), "points.t is cut off");
  cut = message(0);
  cut.back() = 'x';
  EXPECT_EQ(conversion_error([&] { versions.convert(cut); }), "points.t does not end with 0");
  EXPECT_EQ(conversion_error([&] { versions.convert(Bytes(3)); }), "its encoding is not plain CDR");
  EXPECT_EQ(conversion_error([&] { versions.convert(Bytes{0, 7, 0, 0}); }), "its encoding is not plain CDR");
  Bytes longer = message(0);
  longer.resize(longer.size() + 9);
  EXPECT_EQ(conversion_error([&] { versions.convert(longer); }), "S has too many bytes");
  longer.resize(longer.size() - 1);
  EXPECT_EQ(versions.convert(longer), message(0)) << "middlewares pad";
}

// An element of one byte becomes one of 8 kB: the result is bounded, whatever the message says.
TEST(MessageConversion, BoundsItsResult) {
  Versions versions("struct P { octet a; }; struct S { sequence<P> points; };",
                    "struct P { double added[1000]; }; struct S { sequence<P> points; };", 100'000);
  const auto message = [](std::uint32_t count) {
    CdrWriter writer;
    writer.number(count);
    for (std::uint32_t i = 0; i < 100; ++i) writer.number(std::uint8_t{0});
    return writer.bytes();
  };
  EXPECT_EQ(conversion_error([&] { versions.convert(message(100)); }),
            "points.added makes the message longer than 100000 bytes, the most that is allowed");
  EXPECT_EQ(conversion_error([&] { versions.convert(message(4'000'000'000)); }), "points is cut off");
}

}  // namespace
}  // namespace hecaton::test
