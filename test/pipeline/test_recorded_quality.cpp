// SPDX-License-Identifier: BSD-3-Clause
// On a recorded drive the measures rank better poses above worse ones, and static objects are not
// taken for moving.
#include <algorithm>

#include <gtest/gtest.h>

#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"
#include "lidar_mapping/moving_objects/moving_objects.hpp"
#include "lidar_mapping/pipeline/kitti_folder.hpp"

#include "test_data.hpp"

namespace lidar_mapping {
namespace {

/// The scans of a folder around a revisit, in the frame of the LiDAR.
class FolderClouds : public CloudSource {
 public:
  explicit FolderClouds(const std::filesystem::path& folder) : folder_(folder.string()) {}
  PointCloudPtr cloud(KeyFrameIndex index) override {
    return std::make_shared<PointCloud>(folder_.scan(index).cloud);
  }

 private:
  pipeline::KittiFolder folder_;
};

/// Key frames 40 to 90 and, much later, 610 to 660: the first street that is passed twice.
KeyFramePoses street(const std::filesystem::path& file) {
  const Trajectory trajectory = read_trajectory(file.string());
  KeyFramePoses poses;
  for (KeyFrameIndex index = 40; index < 660; ++index) {
    if (index >= 90 && index < 610) continue;
    poses.poses.push_back({index, Stamp{index}, trajectory.poses.at(index).pose});
  }
  return poses;
}

double median_distance(const KeyFramePoses& poses, CloudSource& clouds) {
  std::vector<double> sizes;
  for (const map_quality::PassMisalignment& misalignment :
       map_quality::pass_misalignments(poses, clouds, {})) {
    sizes.push_back(misalignment.distance());
  }
  EXPECT_GE(sizes.size(), 3U);
  std::sort(sizes.begin(), sizes.end());
  return sizes.empty() ? 0.0 : sizes[sizes.size() / 2];
}

TEST(RecordedQuality, RanksRegisteredPosesAboveGnssPoses) {
  REQUIRE_RECORDED(folder, "kitti00_keyframes");
  FolderClouds clouds(folder);
  const KeyFramePoses registered = street(folder / "poses.txt");
  const KeyFramePoses satellites = street(folder / "poses_gnss_ins.txt");
  EXPECT_LT(3.0 * median_distance(registered, clouds), median_distance(satellites, clouds));
  EXPECT_LT(map_quality::mean_map_entropy(registered, clouds).mean,
            map_quality::mean_map_entropy(satellites, clouds).mean);
}

// Nearly all cars in its streets are parked, and hedges and fences are partly transparent.
TEST(RecordedQuality, KeepsParkedCars) {
  REQUIRE_RECORDED(folder, "kitti00_keyframes");
  FolderClouds clouds(folder);
  const Trajectory trajectory = read_trajectory((folder / "poses.txt").string());
  KeyFramePoses poses;
  for (KeyFrameIndex index = 0; index < 300; ++index) {
    poses.poses.push_back({index, Stamp{index}, trajectory.poses.at(index).pose});
  }
  moving_objects::StaticClouds static_clouds(clouds, poses, Eigen::Vector3d::Zero());
  double removed = 0.0;
  double all = 0.0;
  for (KeyFrameIndex index = 10; index < 290; ++index) {
    removed += static_cast<double>(static_clouds.removed(index)->size());
    all += static_cast<double>(clouds.cloud(index)->size());
  }
  EXPECT_LT(removed / all, 0.0065);
}

}  // namespace
}  // namespace lidar_mapping
