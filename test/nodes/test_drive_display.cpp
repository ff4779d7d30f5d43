// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <ros/serialization.h>

#include "display/drive_floors.hpp"
#include "display/drive_status.hpp"
#include "display/graph_markers.hpp"
#include "display/marker_feed.hpp"
#include "display/path_display.hpp"
#include "display/redraw_pace.hpp"

namespace lidar_mapping::ros_border {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

template <typename Message>
std::size_t bytes_of(const Message& message) {
  return ros::serialization::serializationLength(message);
}

/// A key frame of a drive that winds through a town, 2 m after the one before.
KeyFrame key_frame_at(KeyFrameIndex index) {
  KeyFrame key_frame;
  key_frame.index = index;
  key_frame.stamp = 400'000'000 * Stamp{index};
  const double along = 2.0 * index;
  key_frame.T_odom_base.translation = {along, 60.0 * std::sin(along / 90.0), 0.0};
  return key_frame;
}

map::KeyFrameTrack track_of(KeyFrameIndex count) {
  map::KeyFrameTrack track;
  for (KeyFrameIndex index = 0; index < count; ++index) track.add(key_frame_at(index));
  return track;
}

KeyFramePoses moved(const map::KeyFrameTrack& track, double shift) {
  KeyFramePoses poses = track.poses();
  for (KeyFramePose& pose : poses.poses) pose.T_map_base.translation.y() += shift;
  return poses;
}

/// A loop at every 50th key frame, and a candidate at every 20th.
Verdicts verdicts_at_every(KeyFrameIndex step, KeyFrameIndex count, Verdict verdict) {
  Verdicts verdicts;
  for (KeyFrameIndex to = step; to < count; to += step) {
    LoopVerdict loop;
    loop.to = to;
    loop.from = to / 2;
    loop.verdict = verdict;
    verdicts[{loop.from, loop.to}] = loop;
  }
  return verdicts;
}

Floor floor_of(Stamp stamp, double height) {
  Floor floor;
  floor.stamp = stamp;
  floor.found = true;
  floor.offset = height;
  return floor;
}

std::map<KeyFrameIndex, Floor> floors_of(KeyFrameIndex count) {
  std::map<KeyFrameIndex, Floor> floors;
  for (KeyFrameIndex i = 0; i < count; ++i) floors[i] = floor_of(key_frame_at(i).stamp, 1.8);
  return floors;
}

MarkerFeed::Markers markers_of(const map::KeyFrameTrack& track, KeyFrameIndex count) {
  MarkerFeed::Markers markers =
      graph_markers(track, verdicts_at_every(50, count, Verdict::kAccepted),
                    verdicts_at_every(20, count, Verdict::kRefused), "map");
  for (const MarkerFeed::Markers& more :
       {age_markers(track, "map"), floor_markers(track, floors_of(count), "map")}) {
    markers.insert(markers.end(), more.begin(), more.end());
  }
  return markers;
}

const Marker* find(const std::vector<Marker>& markers, const std::string& name, int id) {
  for (const Marker& marker : markers) {
    if (marker.ns == name && marker.id == id) return &marker;
  }
  return nullptr;
}

/// What rviz shows after the messages.
class Screen {
 public:
  void take(const MarkerArray& message) {
    for (const Marker& marker : message.markers) {
      if (marker.action == Marker::DELETEALL) shown.clear();
      if (marker.action == Marker::DELETE) shown.erase({marker.ns, marker.id});
      if (marker.action == Marker::ADD) shown[{marker.ns, marker.id}] = marker;
    }
  }
  bool shows(const std::vector<Marker>& markers) const {
    if (shown.size() != markers.size()) return false;
    return std::all_of(markers.begin(), markers.end(), [this](const Marker& marker) {
      const auto found = shown.find({marker.ns, marker.id});
      return found != shown.end() && found->second == marker;
    });
  }
  std::map<std::pair<std::string, int>, Marker> shown;
};

// At 5,000 key frames a message had 300 kB, for every key frame.
TEST(LiveMessages, DoNotGrowWithTheDrive) {
  for (const KeyFrameIndex count : {5000U, 10000U}) {
    map::KeyFrameTrack track = track_of(count);
    MarkerFeed feed;
    feed.whole(markers_of(track, count));
    std::size_t largest = 0;
    for (KeyFrameIndex index = count; index < count + 120; ++index) {
      track.add(key_frame_at(index));
      largest = std::max(largest, bytes_of(feed.changes(markers_of(track, index + 1))));
    }
    EXPECT_LT(largest, 30'000U) << "key frame " << count;
    EXPECT_GT(bytes_of(feed.whole(markers_of(track, count))), 8 * largest);
    EXPECT_LT(bytes_of(to_path(track.poses(), "map")), 40'000U);
    RecordProperty("marker_bytes_at_" + std::to_string(count), static_cast<int>(largest));
  }
}

TEST(LiveMessages, ACorrectionOfALongDriveGoesOutInPartsThatAreBounded) {
  constexpr KeyFrameIndex kCount = 5000;
  map::KeyFrameTrack track = track_of(kCount);
  MarkerFeed feed;
  Screen screen;
  screen.take(feed.whole(markers_of(track, kCount)));
  track.update(moved(track, 3.0));
  const MarkerFeed::Markers now = markers_of(track, kCount);
  int messages = 0;
  do {
    const MarkerArray message = feed.changes(now);
    EXPECT_LT(bytes_of(message), MarkerFeed::kMarkerBytes + 10'000);
    screen.take(message);
    ++messages;
  } while (feed.has_more() && messages < 100);
  EXPECT_GT(messages, 3);
  EXPECT_TRUE(screen.shows(now));
  EXPECT_TRUE(feed.changes(now).markers.empty());
}

TEST(LiveMessages, StepsThatAreNotVisibleAreNotSent) {
  map::KeyFrameTrack track = track_of(500);
  MarkerFeed feed;
  feed.whole(markers_of(track, 500));
  track.update(moved(track, 0.02));
  EXPECT_TRUE(feed.changes(markers_of(track, 500)).markers.empty());
  track.update(moved(track, 0.04));
  EXPECT_FALSE(feed.changes(markers_of(track, 500)).markers.empty()) << "small steps add up";
}

TEST(LiveMessages, WhatIsGoneIsDeleted) {
  const map::KeyFrameTrack track = track_of(300);
  MarkerFeed feed;
  Screen screen;
  const Verdicts candidates = verdicts_at_every(20, 300, Verdict::kUndecided);
  screen.take(feed.whole(graph_markers(track, {}, candidates, "map")));
  EXPECT_NE(screen.shown.count({"candidates", 2}), 0U);
  const MarkerFeed::Markers now = graph_markers(track, {}, {}, "map");
  screen.take(feed.changes(now));
  EXPECT_TRUE(screen.shows(now));
  EXPECT_EQ(screen.shown.count({"candidates", 2}), 0U);
}

TEST(LiveMessages, ALateSubscriberReceivesExactlyTheCurrentMarkers) {
  const map::KeyFrameTrack track = track_of(250);
  const MarkerFeed::Markers now = markers_of(track, 250);
  MarkerFeed feed;
  feed.changes(now);
  Screen late;
  late.shown[{"left over", 3}] = Marker();
  late.take(feed.whole(now));
  EXPECT_TRUE(late.shows(now));
}

TEST(RedrawPace, DrawsOnceASecondWhatIsQuick) {
  RedrawPace pace;
  EXPECT_TRUE(pace.is_due(100.0)) << "nothing is drawn yet";
  pace.drawn(100.0, 100.01);
  EXPECT_FALSE(pace.is_due(100.9));
  EXPECT_TRUE(pace.is_due(101.0));
}

TEST(RedrawPace, DrawsMoreSeldomWhatTakesLong) {
  RedrawPace pace;
  pace.drawn(100.0, 100.5);
  EXPECT_FALSE(pace.is_due(109.9));
  EXPECT_TRUE(pace.is_due(110.1)) << "a twentieth of the time";
}

TEST(PathDisplay, KeepsAllPosesOfAShortDrive) {
  const nav_msgs::Path path = to_path(track_of(100).poses(), "map", 100);
  ASSERT_EQ(path.poses.size(), 100U);
  EXPECT_EQ(path.header.frame_id, "map");
  EXPECT_EQ(path.header.stamp, path.poses.back().header.stamp);
}

TEST(PathDisplay, KeepsTheShapeOfALongOne) {
  const KeyFramePoses poses = track_of(5000).poses();
  const nav_msgs::Path path = to_path(poses, "map", 400);
  ASSERT_EQ(path.poses.size(), 400U);
  EXPECT_EQ(path.poses.front().pose.position.x, 0.0);
  EXPECT_EQ(path.poses.back().pose.position.x, 9998.0);
  double largest = 0.0;
  std::size_t next = 1;
  for (const KeyFramePose& pose : poses.poses) {
    const Eigen::Vector3d& p = pose.T_map_base.translation;
    while (path.poses[next].pose.position.x < p.x()) ++next;
    const auto& a = path.poses[next - 1].pose.position;
    const auto& b = path.poses[next].pose.position;
    largest = std::max(largest, std::abs(a.y + (p.x() - a.x) / (b.x - a.x) * (b.y - a.y) - p.y()));
  }
  EXPECT_LT(largest, 1.5) << "every 13th pose would be wrong by more";
}

/// The order in which a straight line is split must not take quadratic time.
TEST(PathDisplay, TakesStraightAndStandingDrives) {
  KeyFramePoses poses;
  for (KeyFrameIndex i = 0; i < 20000; ++i) {
    Pose pose;
    pose.translation.x() = i < 10000 ? 1.0 * i : 10000.0;
    poses.poses.push_back({i, Stamp{i}, pose});
  }
  EXPECT_EQ(to_path(poses, "map", 50).poses.size(), 50U);
  EXPECT_TRUE(to_path({}, "map").poses.empty());
}

TEST(GraphMarkers, ShowLoopsAsBridgesOverThePathInTheColourOfTheirFate) {
  const map::KeyFrameTrack track = track_of(250);
  Verdicts loops;
  loops[{3, 120}].verdict = Verdict::kAccepted;
  loops[{4, 121}].verdict = Verdict::kRefused;
  loops[{5, 999}].verdict = Verdict::kAccepted;
  const auto markers = graph_markers(track, loops, {}, "map");
  const Marker* bridges = find(markers, "loops", 1);
  ASSERT_NE(bridges, nullptr) << "in the piece of the newer key frame";
  ASSERT_EQ(bridges->points.size(), 12U) << "two of three loops: one end of the third is unknown";
  EXPECT_GT(bridges->points[2].z, bridges->points[0].z + 1.0);
  EXPECT_NE(bridges->colors[0], bridges->colors[6]);
  EXPECT_EQ(bridges->colors.size(), bridges->points.size());
}

TEST(GraphMarkers, ShowWhereOdometryDidNotSeeAllOfTheMotionAndNoLineOverAGap) {
  map::KeyFrameTrack track;
  for (KeyFrameIndex index = 0; index < 30; ++index) {
    KeyFrame key_frame = key_frame_at(index);
    if (index >= 10 && index < 14) key_frame.degenerate_directions = {Eigen::Vector3d::UnitX()};
    key_frame.segment = index < 20 ? 0 : 1;
    track.add(key_frame);
  }
  const auto markers = graph_markers(track, {}, {}, "map");
  ASSERT_NE(find(markers, "degenerate", 0), nullptr);
  EXPECT_EQ(find(markers, "degenerate", 0)->points.size(), 8U);
  EXPECT_EQ(find(markers, "odometry", 0)->points.size(), 2U * 28U);
  EXPECT_EQ(find(markers, "key_frames", 0)->points.size(), 30U);
  EXPECT_EQ(find(markers, "loops", 0), nullptr) << "rviz warns of markers without points";
}

TEST(GraphMarkers, ShowFixesInPieces) {
  const auto markers = gnss_markers(std::vector<Eigen::Vector3d>(150, {1.0, 2.0, 3.0}), "map");
  ASSERT_EQ(markers.size(), 2U);
  EXPECT_EQ(markers[1].points.size(), 50U);
  EXPECT_EQ(markers[1].ns, "gnss");
}

TEST(AgeMarkers, GoFromBlueToRedAndAreSentAgainOnlyWhenTheScaleDoubles) {
  const auto blue_of = [](const Marker& marker) { return marker.colors.front().b; };
  map::KeyFrameTrack track = track_of(140);  // 0.4 s between two: 55.6 s, of a scale of 60
  const auto markers = age_markers(track, "map");
  ASSERT_EQ(markers.size(), 2U);
  EXPECT_GT(blue_of(markers[0]), 0.99F);
  EXPECT_LT(markers[0].colors.front().r, 0.01F);
  EXPECT_GT(markers[1].colors.back().r, 0.99F);
  EXPECT_LT(markers[1].colors.back().b, 0.01F);
  track.add(key_frame_at(140));
  EXPECT_EQ(age_markers(track, "map")[0], markers[0]);
  for (KeyFrameIndex index = 141; index < 160; ++index) track.add(key_frame_at(index));
  EXPECT_NE(age_markers(track, "map")[0], markers[0]) << "the scale is two minutes now";
  EXPECT_TRUE(age_markers({}, "map").empty());
}

TEST(FloorMarkers, LieWhereTheFloorIsBelowItsKeyFrame) {
  DriveFloors floors;
  map::KeyFrameTrack track = track_of(3);
  EXPECT_FALSE(floors.add(floor_of(key_frame_at(0).stamp, 1.8))) << "before its key frame";
  EXPECT_FALSE(floors.add(floor_of(key_frame_at(0).stamp + 1, 1.8))) << "of no key frame";
  for (KeyFrameIndex i = 0; i < 3; ++i) floors.add_key_frame(i, key_frame_at(i).stamp);
  EXPECT_TRUE(floors.add(floor_of(key_frame_at(2).stamp, 1.5))) << "after it";
  Floor none = floor_of(key_frame_at(1).stamp, 1.8);
  none.found = false;
  EXPECT_FALSE(floors.add(none));
  ASSERT_EQ(floors.below().size(), 2U);
  const auto markers = floor_markers(track, floors.below(), "map");
  ASSERT_EQ(markers.size(), 1U);
  EXPECT_EQ(markers[0].ns, "floors");
  ASSERT_EQ(markers[0].points.size(), 20U);
  EXPECT_NEAR(markers[0].points[0].z, -1.8, 1e-9) << "the foot of the post";
  EXPECT_NEAR(markers[0].points[10].z, -1.5, 1e-9);
  EXPECT_NEAR(markers[0].points[2].z, -1.8, 1e-9) << "a corner of a level floor";
}

TEST(FloorMarkers, HaveTheTiltOfTheFloor) {
  const map::KeyFrameTrack track = track_of(1);
  Floor floor = floor_of(0, 1.8);
  floor.normal = Eigen::Vector3d(-0.1, 0.0, 1.0).normalized();  // rising ahead
  const auto markers = floor_markers(track, {{0, floor}}, "map");
  const auto& points = markers.at(0).points;
  for (std::size_t i = 2; i < points.size(); ++i) {
    const Eigen::Vector3d p(points[i].x, points[i].y, points[i].z);
    EXPECT_NEAR(floor.normal.dot(p) + floor.offset, 0.0, 1e-9) << i;
  }
}

TEST(StatusText, SaysThatItWaitsAndWhy) {
  DriveStatus status;
  EXPECT_EQ(status_text(status, "map", "base_link").text, "waiting for scans ...");
  status.problem = "nobody publishes /points";
  const Marker text = status_text(status, "map", "base_link");
  EXPECT_NE(text.text.find("nobody publishes /points"), std::string::npos);
  EXPECT_EQ(text.header.frame_id, "map") << "there is no vehicle yet";
}

TEST(StatusText, FollowsTheVehicleAndChangesItsColour) {
  DriveStatus status;
  status.state = "tracking";
  status.key_frames = 246;
  status.length = 1063.0;
  status.loops_used = 52;
  status.loops_refused = 3;
  const Marker good = status_text(status, "map", "base_link");
  EXPECT_EQ(good.text, "tracking\n1.06 km, 246 key frames, 52 loops (3 refused)");
  EXPECT_EQ(good.header.frame_id, "base_link");
  status.state = "degenerate";
  const Marker poor = status_text(status, "map", "base_link");
  EXPECT_NE(poor.text.find("degenerate"), std::string::npos);
  EXPECT_NE(poor.color, good.color);
  status.state = "lost";
  EXPECT_NE(status_text(status, "map", "base_link").color, poor.color);
  status.silent = true;
  EXPECT_NE(status_text(status, "map", "base_link").text.find("/optimize_map"), std::string::npos);
}

TEST(StatusText, NamesTheNextCallAfterTheOptimisation) {
  DriveStatus status;
  status.state = "tracking";
  status.key_frames = 246;
  status.silent = true;
  status.since_optimized = 0;
  std::string text = status_text(status, "map", "base_link").text;
  EXPECT_NE(text.find("/save_map"), std::string::npos) << text;
  EXPECT_EQ(text.find("/optimize_map"), std::string::npos) << text;
  status.state = "";  // a viewer that was started after the drive
  EXPECT_EQ(status_text(status, "map", "base_link").text, text);
}

/// The last scan leaves preprocessing late; its key frame may come after a hasty call.
TEST(StatusText, SaysHowManyKeyFramesHaveComeSinceTheOptimisation) {
  DriveStatus status;
  status.state = "tracking";
  status.key_frames = 246;
  status.silent = true;
  status.since_optimized = 1;
  status.optimize_map = "/second/optimize_map";
  status.save_map = "/second/save_map";
  const std::string text = status_text(status, "map", "base_link").text;
  for (const char* part :
       {"optimised; key frames since then: 1", "rosservice call /second/optimize_map",
        "rosservice call /second/save_map '{}'"}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace lidar_mapping::ros_border
