/// Messages as columns of text, from bytes that are written by hand.

#include "services/recorder/cdr_columns.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <idl/common.h>

#include "services/recorder/bag.hpp"
#include "services/recorder/mcap_writer.hpp"
#include "tests/support/cdr_writer.hpp"
#include "tests/support/full_disk.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hecaton::test {
namespace {

using namespace services::recorder;

constexpr std::uint32_t kSchema = msg::SCHEMA_VERSION;

Bytes arm_command(bool little, const std::vector<double>& q) {
  return CdrWriter(little)
      .number(kSchema)
      .text("north")
      .number(std::uint64_t{3})
      .number(std::uint64_t{41})
      .number(std::int64_t{-5})
      .text("planner/north")
      .number(0.01)
      .numbers(q)
      .numbers({})
      .bytes();
}

using Cells = std::vector<std::string>;

TEST(CdrColumns, GivesEachElementOfAShortSequenceItsColumn) {
  CdrColumns columns(*bus::topic_rule("ArmCommand"));
  const Bytes shorter = arm_command(true, {0.1});
  const Bytes longer = arm_command(false, {1.0 / 3.0, -2.0});  // of a big-endian machine
  EXPECT_EQ(columns.measure(shorter), std::nullopt);
  EXPECT_EQ(columns.measure(longer), std::nullopt);
  EXPECT_EQ(columns.header(),
            (Cells{"schema", "arm", "term", "sequence_number", "stamp_ns", "node", "period", "q[0]", "q[1]"}));
  const std::string version = std::to_string(kSchema);
  EXPECT_EQ(columns.row(shorter), (Cells{version, "north", "3", "41", "-5", "planner/north", "0.01", "0.1", ""}));
  EXPECT_EQ(columns.row(longer),
            (Cells{version, "north", "3", "41", "-5", "planner/north", "0.01", "0.3333333333333333", "-2"}));
}

TEST(CdrColumns, GivesAListOfStructuresOneColumnInJson) {
  const Bytes message = CdrWriter()
                            .number(kSchema)
                            .text("a")
                            .number(std::uint64_t{1})
                            .number(std::int64_t{2})
                            .number(std::uint32_t{2})
                            .text("b")
                            .number(0.5F)
                            .text("c \"d\"")
                            .number(-1.0F)
                            .bytes();
  CdrColumns columns(*bus::topic_rule("Reachability"));
  ASSERT_EQ(columns.measure(message), std::nullopt);
  EXPECT_EQ(columns.header(), (Cells{"schema", "host", "sequence_number", "stamp_ns", "heard"}));
  EXPECT_EQ(columns.row(message).back(), R"([{"host":"b","age":0.5},{"host":"c \"d\"","age":-1.0}])");
}

TEST(CdrColumns, RefusesWhatBreaksARule) {
  CdrColumns columns(*bus::topic_rule("ArmCommand"));
  EXPECT_NE(columns.measure(arm_command(true, {1e9})).value_or("").find("q[0]"), std::string::npos);
  Bytes cut = arm_command(true, {0.1});
  cut.resize(30);
  EXPECT_TRUE(columns.measure(cut));
  EXPECT_TRUE(columns.measure({}));
  Bytes older = arm_command(true, {0.1});
  older[4] = kSchema - 1;
  EXPECT_NE(columns.measure(older).value_or("").find("version"), std::string::npos);
}

TEST(CsvLine, QuotesWhatNeedsIt) {
  EXPECT_EQ(csv_line({"a", "b c", "d,e", "f \"g\"", "h\ni", ""}), "a,b c,\"d,e\",\"f \"\"g\"\"\",\"h\ni\",\r\n");
}

TEST(ExportCsv, WritesOneFileForEachTopic) {
  const TemporaryFolder folder;
  const std::string path = folder.path("run.mcap");
  {
    McapWriter writer(path, "hecaton");
    const std::uint16_t schema = writer.add_schema("hecaton::msg::ArmCommand", "omgidl", "");
    const std::uint16_t channel =
        writer.add_channel(schema, "hecaton/ArmCommand", "cdr", {{"node", "planner/north"}, {"writer", "01ab"}});
    const std::uint16_t repeated = writer.add_channel(schema, "hecaton/ArmCommand", "cdr", {{"repeated", "true"}});
    const std::uint16_t json = writer.add_channel(0, "recorder/report", "json", {});
    for (const Bytes& data : {arm_command(true, {0.1}), arm_command(true, {1e9}), arm_command(true, {0.2, 0.3})}) {
      writer.write({channel, 1, 20, 10, data});
    }
    writer.write({repeated, 1, 20, 10, arm_command(true, {0.5})});
    writer.write({json, 1, 20, 10, Bytes{'{', '}'}});
    writer.close();
  }
  const ExportReport report = export_csv({path}, folder.path("out/csv"));
  ASSERT_EQ(report.topics.size(), 1U);
  const ExportedTopic& topic = report.topics.at("hecaton/ArmCommand");
  EXPECT_EQ(topic.rows, 2U);
  EXPECT_EQ(topic.skipped, 1U);
  EXPECT_NE(topic.reason.find("q[0]"), std::string::npos) << topic.reason;
  std::ifstream file(folder.path("out/csv/ArmCommand.csv"), std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const std::string version = std::to_string(kSchema);
  EXPECT_EQ(text,
            "log_time_ns,publish_time_ns,writer_node,writer_guid,schema,arm,term,sequence_number,stamp_ns,node,period,"
            "q[0],q[1]\r\n"
            "20,10,planner/north,01ab," +
                version +
                ",north,3,41,-5,planner/north,0.01,0.1,\r\n"
                "20,10,planner/north,01ab," +
                version + ",north,3,41,-5,planner/north,0.01,0.2,0.3\r\n");
  EXPECT_THROW(export_csv({path}, folder.path("out/csv")), RecordingError);
  EXPECT_TRUE(std::filesystem::exists(folder.path("out/csv/ArmCommand.csv"))) << "existing files stay";
}

TEST(ExportCsv, WritesOneTableFromTheFilesOfASplitRecording) {
  const TemporaryFolder folder;
  std::vector<std::string> paths;
  for (const std::vector<double>& q : {std::vector<double>{0.1}, std::vector<double>{0.2, 0.3}}) {
    paths.push_back(folder.path(std::to_string(paths.size()) + ".mcap"));
    McapWriter writer(paths.back(), "hecaton");
    const std::uint16_t schema = writer.add_schema("hecaton::msg::ArmCommand", "omgidl", "");
    const std::uint16_t channel = writer.add_channel(schema, "hecaton/ArmCommand", "cdr", {{"node", "planner/north"}});
    writer.write({channel, 1, paths.size(), 10, arm_command(true, q)});
    writer.close();
  }
  const ExportReport report = export_csv(paths, folder.path("csv"));
  EXPECT_EQ(report.files.size(), 2U);
  EXPECT_EQ(report.topics.at("hecaton/ArmCommand").rows, 2U);
  std::ifstream file(folder.path("csv/ArmCommand.csv"), std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(text.find(",q[0],q[1]\r\n1,10,"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with(",0.01,0.2,0.3\r\n")) << text;
}

TEST(ExportCsv, SaysThatTheDiskIsFullAndKeepsNoFile) {
  const TemporaryFolder folder;
  const std::string out = folder.path("csv");
  // Many rows meet the limit while they are written, few when their file is closed.
  for (const std::uint32_t rows : {300U, 3U}) {
    const std::string path = folder.path(std::to_string(rows) + ".mcap");
    McapWriter writer(path, "hecaton");
    const std::uint16_t schema = writer.add_schema("hecaton::msg::ArmCommand", "omgidl", "");
    const std::uint16_t channel = writer.add_channel(schema, "hecaton/ArmCommand", "cdr", {{"node", "planner/north"}});
    for (std::uint32_t i = 0; i < rows; ++i) writer.write({channel, i, 20, 10, arm_command(true, {0.1})});
    writer.close();
    const FullDisk full(100);
    try {
      export_csv({path}, out);
      ADD_FAILURE() << rows;
    } catch (const RecordingError& error) {
      EXPECT_NE(std::string(error.what()).find("ArmCommand.csv cannot be written: the disk is full"), std::string::npos)
          << error.what();
    }
    EXPECT_TRUE(std::filesystem::is_empty(out));
  }
}

}  // namespace
}  // namespace hecaton::test
