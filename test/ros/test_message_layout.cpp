// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sensor_msgs/PointCloud2.h>

#include "bags/message_layout.hpp"

namespace lidar_mapping::ros_border {
namespace {

using Kind = MessageField::Kind;
using Count = MessageField::Count;

MessageField only_field(const std::string& definition) {
  const MessageLayout layout = message_layout(definition);
  EXPECT_EQ(layout.fields.size(), 1U) << definition;
  return layout.fields.at(0);
}

TEST(MessageLayout, KnowsTheSizeOfEveryNumber) {
  const std::vector<std::pair<std::string, std::size_t>> numbers = {
      {"bool", 1},   {"byte", 1},    {"char", 1},   {"int8", 1},   {"uint8", 1},
      {"int16", 2},  {"uint16", 2},  {"int32", 4},  {"uint32", 4}, {"int64", 8},
      {"uint64", 8}, {"float32", 4}, {"float64", 8}};
  for (const auto& [type, size] : numbers) {
    const MessageField field = only_field(type + " x\n");
    EXPECT_EQ(field.kind, Kind::kNumber) << type;
    EXPECT_EQ(field.count, Count::kOne) << type;
    EXPECT_EQ(field.size, size) << type;
  }
}

TEST(MessageLayout, ReadsTextsTimesAndMessages) {
  EXPECT_EQ(only_field("string name\n").kind, Kind::kText);
  EXPECT_EQ(only_field("time stamp\n").kind, Kind::kTime);
  EXPECT_EQ(only_field("duration lifetime\n").kind, Kind::kTime);
  const MessageField field = only_field("geometry_msgs/Vector3 linear\n");
  EXPECT_EQ(field.kind, Kind::kMessage);
  EXPECT_EQ(field.type, "Vector3") << "without the package";
}

TEST(MessageLayout, CountsTheElementsOfArrays) {
  const MessageField fixed = only_field("float64[36] covariance\n");
  EXPECT_EQ(fixed.count, Count::kFixed);
  EXPECT_EQ(fixed.elements, 36U);
  EXPECT_EQ(fixed.size, 8U);
  const MessageField any = only_field("sensor_msgs/PointField[] fields\n");
  EXPECT_EQ(any.count, Count::kAny);
  EXPECT_EQ(any.elements, 0U);
  EXPECT_EQ(any.type, "PointField");
}

TEST(MessageLayout, LeavesCommentsConstantsAndEmptyLinesOut) {
  const MessageLayout layout = message_layout(
      "# a comment of three words\n"
      "\n"
      "uint8 FLOAT32=7\n"
      "uint8 FLOAT64 = 8\n"
      "  uint8 datatype  # of the field, in int8 steps\n");
  ASSERT_EQ(layout.fields.size(), 1U);
  EXPECT_EQ(layout.fields[0].size, 1U);
}

TEST(MessageLayout, KeepsTheMessagesInAMessage) {
  const MessageLayout layout =
      message_layout(ros::message_traits::definition<sensor_msgs::PointCloud2>());
  ASSERT_EQ(layout.fields.size(), 9U);
  EXPECT_EQ(layout.fields[0].type, "Header");
  EXPECT_EQ(layout.fields[3].type, "PointField");
  EXPECT_EQ(layout.fields[3].count, Count::kAny);
  ASSERT_EQ(layout.messages.size(), 2U);
  EXPECT_EQ(layout.messages.at("PointField").size(), 4U) << "its constants are none of its fields";
  const auto& header = layout.messages.at("Header");
  ASSERT_EQ(header.size(), 3U);
  EXPECT_EQ(header[0].kind, Kind::kSequenceNumber);
  EXPECT_EQ(header[1].kind, Kind::kTime);
  EXPECT_EQ(header[2].kind, Kind::kText);
}

/// Only that of a header is unknown to ROS 2.
TEST(MessageLayout, TakesOtherSequenceNumbersAsNumbers) {
  EXPECT_EQ(only_field("uint32 seq\n").kind, Kind::kNumber);
}

}  // namespace
}  // namespace lidar_mapping::ros_border
