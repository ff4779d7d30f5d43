// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>

#include <pcl/io/pcd_io.h>

#include "lidar_mapping/common/voxel_filter.hpp"

#include "method_test.hpp"
#include "near.hpp"
#include "recorded_scans.hpp"
#include "test_data.hpp"

namespace lidar_mapping::registration {
namespace {

namespace fs = std::filesystem;

// Spacing of the points that are matched, m.
constexpr double kTargetSpacing = 0.3;
constexpr double kSourceSpacing = 0.8;

/// Without the empty returns, which this sensor puts into its origin.
PointCloud read_pcd(const fs::path& path) {
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::io::loadPCDFile(path.string(), points);
  PointCloud cloud;
  for (const pcl::PointXYZ& p : points) {
    if (p.getVector3fMap().norm() > 0.5F) cloud.points.push_back({p.x, p.y, p.z, 0.0F});
  }
  return cloud;
}

/// Two scans of a recording and how they lie to each other.
struct RecordedPair {
  PointCloud first;
  PointCloud second;
  Pose T_first_second;
};

RecordedPair read_pair(const fs::path& folder, const std::string& ending, std::size_t first,
                       std::size_t second) {
  const auto read = [&](std::size_t index) {
    if (ending == ".bin") return test::recorded_scan(folder, index);
    const std::string digits = std::to_string(index);
    return read_pcd(folder / (std::string(6 - digits.size(), '0') + digits + ending));
  };
  const auto poses = test::recorded_poses(folder);
  return {read(first), read(second), poses[first].inverse() * poses[second]};
}

class RecordedPairs : public MethodTest {
 protected:
  /// Matches both ways from a disturbed start, up to what the reference poses are good for.
  static void expect_found(const RecordedPair& pair, const Pose& disturbance, double tolerance_m,
                           double tolerance_rad) {
    const RegistrationResult forward = aligned(voxel_filtered(pair.first, kTargetSpacing),
                                               voxel_filtered(pair.second, kSourceSpacing),
                                               pair.T_first_second * disturbance, config());
    EXPECT_TRUE(
        test::near(forward.T_target_source, pair.T_first_second, tolerance_m, tolerance_rad));
    EXPECT_GT(forward.inlier_fraction, 0.6);

    const Pose T_second_first = pair.T_first_second.inverse();
    const RegistrationResult back =
        aligned(voxel_filtered(pair.second, kTargetSpacing),
                voxel_filtered(pair.first, kSourceSpacing), T_second_first * disturbance, config());
    EXPECT_TRUE(test::near(back.T_target_source, T_second_first, tolerance_m, tolerance_rad));
    const Pose loop = forward.T_target_source * back.T_target_source;
    EXPECT_TRUE(test::near(loop.translation, Eigen::Vector3d::Zero(), tolerance_m));
  }
};

// The reference poses of this drive scatter by 24 mm, and its sweeps are not deskewed.
TEST_P(RecordedPairs, OfACityStreet) {
  REQUIRE_RECORDED(folder, "kitti00_scans");
  for (const std::size_t first : {0U, 40U, 80U}) {
    SCOPED_TRACE(first);
    expect_found(read_pair(folder, ".bin", first, first + 1), pose_of(0.4, -0.2, 0, 0, 0, 0.03),
                 0.2, 0.02);
  }
}

TEST_P(RecordedPairs, OfAMotorway) {
  REQUIRE_RECORDED(folder, "kitti01_first10");
  expect_found(read_pair(folder, ".bin", 0, 1), pose_of(0.3, 0.2, 0, 0, 0, 0.02), 0.3, 0.02);
}

TEST_P(RecordedPairs, OfAnotherSensor) {
  REQUIRE_RECORDED(folder, "ouster_os1_128");
  expect_found(read_pair(folder, ".pcd", 0, 2), pose_of(0.3, 0.2, 0.05, 0, 0, -0.05), 0.1, 0.01);
}

INSTANTIATE_TEST_SUITE_P(All, RecordedPairs, testing::ValuesIn(kAllMethods), method_name);

}  // namespace
}  // namespace lidar_mapping::registration
