// SPDX-License-Identifier: BSD-3-Clause
// A simulated town on two days with other parked cars: what has gone leaves the map, what stands
// stays, and each listed change is one.
#include <cstdio>
#include <set>

#include <gtest/gtest.h>

#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/moving_objects/current_clouds.hpp"
#include "lidar_mapping/simulation/ray_caster.hpp"

#include "simulated_key_frames.hpp"

namespace lidar_mapping::moving_objects {
namespace {

using simulation::Drive;

/// What is nearer than this to a surface of the other day stands there, too, m.
constexpr float kSame = 0.1F;
/// What is further from one has gone, m.
constexpr float kGone = 0.6F;
/// Key frames that have to look through the place of a point before it counts as gone: fewer are
/// glimpses between other cars.
constexpr int kViews = 10;
/// Range within which a view counts, m: that of the votes.
constexpr double kReach = 40.0;

Drive drive_of_day(const std::string& lidar, std::uint64_t day) {
  simulation::DriveOptions options;
  options.undistorted = true;
  options.lidar = lidar;
  options.seed = 4;
  options.duration = 27.0;
  options.pass = day;
  options.parked = day;
  return Drive(options);
}

/// The world of a day without what moves, and which of its surfaces another day has.
class FixedWorld {
 public:
  explicit FixedWorld(const Drive& drive)
      : world_(drive.world()), caster_(without_movers(world_)) {}

  /// Distance to the first surface beyond a point as seen from the sensor, m: about 0 if the point
  /// is on a surface of this world, positive if nothing is there, negative if it is hidden.
  std::vector<float> beyond(const Eigen::Vector3d& p_map_sensor,
                            const PointCloud& cloud_map) const {
    std::vector<simulation::Ray> rays;
    std::vector<float> ranges;
    for (const Point& point : cloud_map.points) {
      const Eigen::Vector3f origin = p_map_sensor.cast<float>();
      ranges.push_back((point.position() - origin).norm());
      rays.push_back({origin, (point.position() - origin).normalized(), 0.0F});
    }
    std::vector<simulation::Hit> hits;
    caster_.cast(rays, 0.0, 0.0, 0.1F, kFar, hits);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      ranges[i] = (hits[i].range < 0.0F ? kFar : hits[i].range) - ranges[i];
    }
    return ranges;
  }

 private:
  static constexpr float kFar = 300.0F;

  static const simulation::World& without_movers(simulation::World& world) {
    world.movers.clear();
    return world;
  }

  simulation::World world_;
  simulation::RayCaster caster_;
};

/// Two days of the town, one after the other.
class TwoDays : public CloudSource {
 public:
  TwoDays(const std::string& lidar, std::size_t thinning)
      : drives_{drive_of_day(lidar, 0), drive_of_day(lidar, 1)},
        worlds_{FixedWorld(drives_[0]), FixedWorld(drives_[1])},
        days_{{drives_[0], 2.0, 26.0, 1.5, thinning}, {drives_[1], 2.0, 26.0, 1.5, thinning}} {
    for (auto& day : days_) {
      for (KeyFramePose pose : day.poses.poses) {
        pose.index = static_cast<KeyFrameIndex>(poses.poses.size());
        poses.poses.push_back(pose);
      }
    }
  }

  PointCloudPtr cloud(KeyFrameIndex index) override {
    const std::size_t day = day_of(index);
    const KeyFrameIndex own = own_index(index);
    // Without what moves: removing that is another class's task.
    const PointCloudPtr all = days_[day].cloud(own);
    const auto& moving = days_[day].moving(own);
    auto standing = std::make_shared<PointCloud>();
    for (std::size_t i = 0; i < all->size(); ++i) {
      if (moving[i] == 0) standing->points.push_back(all->points[i]);
    }
    return standing;
  }

  std::size_t day_of(KeyFrameIndex index) const {
    return index < days_[0].poses.poses.size() ? 0 : 1;
  }
  Eigen::Vector3d p_base_sensor() const { return drives_[0].mounting().T_base_lidar.translation; }

  /// FixedWorld::beyond() of the points of a key frame on the other day.
  std::vector<float> beyond_on_other_day(KeyFrameIndex index) {
    const Pose& pose = poses.poses[index].T_map_base;
    return worlds_[1 - day_of(index)].beyond(pose * p_base_sensor(),
                                             transformed(*cloud(index), pose));
  }

  /// How many key frames of the second day look through each of these points (map frame), with half
  /// a metre to spare.
  std::vector<int> views_through(const PointCloud& points_map) const {
    std::vector<int> views(points_map.size());
    for (const KeyFramePose& pose : days_[1].poses.poses) {
      const Eigen::Vector3d sensor = pose.T_map_base * p_base_sensor();
      PointCloud near;
      std::vector<std::size_t> indices;
      for (std::size_t i = 0; i < views.size(); ++i) {
        const Eigen::Vector3d p = points_map.points[i].position().cast<double>();
        if ((p - sensor).norm() >= kReach) continue;
        near.points.push_back(points_map.points[i]);
        indices.push_back(i);
      }
      const std::vector<float> beyond = worlds_[1].beyond(sensor, near);
      for (std::size_t i = 0; i < indices.size(); ++i) {
        views[indices[i]] += beyond[i] > kGone + 0.5F ? 1 : 0;
      }
    }
    return views;
  }

  KeyFramePoses poses;

 private:
  KeyFrameIndex own_index(KeyFrameIndex index) const {
    return day_of(index) == 0 ? index
                              : index - static_cast<KeyFrameIndex>(days_[0].poses.poses.size());
  }

  Drive drives_[2];
  FixedWorld worlds_[2];
  test::SimulatedKeyFrames days_[2];
};

struct Figures {
  double gone_left_out = 0.0;
  double standing_left_out = 0.0;
  std::size_t listed = 0;
  std::size_t invented = 0;
};

VoxelKey voxel_of(const Eigen::Vector3f& p_map) {
  return voxel_key(voxel_index(p_map / static_cast<float>(ChangeList::kVoxel)));
}

/// The voxels in which a point of one day is on no surface of the other.
std::set<VoxelKey> truly_changed(TwoDays& town) {
  std::set<VoxelKey> voxels;
  for (const KeyFramePose& pose : town.poses.poses) {
    const PointCloud points = transformed(*town.cloud(pose.index), pose.T_map_base);
    const std::vector<float> beyond = town.beyond_on_other_day(pose.index);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (beyond[i] > kGone) voxels.insert(voxel_of(points.points[i].position()));
    }
  }
  return voxels;
}

bool is_invented(const Change& change, const std::set<VoxelKey>& changed) {
  return std::none_of(
      change.points.points.begin(), change.points.points.end(),
      [&](const Point& point) { return changed.count(voxel_of(point.position())) > 0; });
}

Figures measured(TwoDays& town) {
  CurrentClouds current(town, town, town.poses, town.p_base_sensor(), {}, testing::TempDir());
  double gone = 0.0, gone_kept = 0.0, standing = 0.0, standing_kept = 0.0;
  for (const KeyFramePose& pose : town.poses.poses) {
    if (town.day_of(pose.index) == 1) continue;
    const PointCloudPtr all = town.cloud(pose.index);
    const PointCloudPtr kept = current.cloud(pose.index);
    const std::vector<float> beyond = town.beyond_on_other_day(pose.index);
    PointCloud away;  // on no surface of the other day
    std::vector<double> away_kept;
    std::size_t next = 0;
    for (std::size_t i = 0; i < all->size(); ++i) {
      const bool is_kept =
          next < kept->size() && kept->points[next].position() == all->points[i].position();
      if (is_kept) ++next;
      if (std::abs(beyond[i]) < kSame) {
        standing += 1.0;
        standing_kept += is_kept ? 1.0 : 0.0;
      } else if (beyond[i] > kGone) {
        away.points.push_back(all->points[i]);
        away_kept.push_back(is_kept ? 1.0 : 0.0);
      }
    }
    const std::vector<int> views = town.views_through(transformed(away, pose.T_map_base));
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (views[i] < kViews) continue;
      gone += 1.0;
      gone_kept += away_kept[i];
    }
  }
  Figures figures{1.0 - gone_kept / gone, 1.0 - standing_kept / standing, 0, 0};
  const std::set<VoxelKey> changed = truly_changed(town);
  for (const Change& change : current.changes()) {
    ++figures.listed;
    figures.invented += is_invented(change, changed) ? 1 : 0;
  }
  std::printf(
      "gone: %.0f points, %.4f left out; standing: %.0f, %.5f left out; %zu changes, %zu "
      "invented\n",
      gone, figures.gone_left_out, standing, figures.standing_left_out, figures.listed,
      figures.invented);
  return figures;
}

TEST(SimulatedChanges, AreFoundWithSixtyFourBeams) {
  TwoDays town("os1_64", 1);
  const Figures figures = measured(town);
  EXPECT_GT(figures.gone_left_out, 0.92);
  EXPECT_LT(figures.standing_left_out, 0.001);
  EXPECT_GT(figures.listed, 10U);
  EXPECT_EQ(figures.invented, 0U);
}

TEST(SimulatedChanges, AreFoundWithSixteenBeams) {
  TwoDays town("vlp16", 1);
  const Figures figures = measured(town);
  EXPECT_GT(figures.gone_left_out, 0.9);
  EXPECT_LT(figures.standing_left_out, 0.001);
  EXPECT_EQ(figures.invented, 0U);
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
