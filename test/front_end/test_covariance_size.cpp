// SPDX-License-Identifier: BSD-3-Clause
// Whether reported covariances have the size of the errors.

#include <optional>

#include <gtest/gtest.h>

#include "evaluated_drive.hpp"
#include "normalised_error.hpp"

namespace lidar_mapping::front_end {
namespace {

class SizeOfCovariance : public testing::TestWithParam<const char*> {};

// The back end weights the motion from key frame to key frame with it. Smooth walls, rough fields
// and a person's gait differ in how well the points fit, and in how fast errors become independent.
TEST_P(SizeOfCovariance, AgreesWithTheErrors) {
  const simulation::Drive drive = make_drive(GetParam(), 45.0);
  FrontEnd front_end{FrontEndConfig{}};
  front_end.set_sensor_pose(drive.mounting().T_base_lidar);
  NormalisedError of_scans;
  NormalisedError of_key_frames;
  std::optional<FrontEndResult> last;
  std::optional<KeyFrame> last_key_frame;
  const auto way = [&](Stamp from, Stamp to) {
    return drive.trajectory().pose(from).inverse() * drive.trajectory().pose(to);
  };
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    const FrontEndResult result = front_end.process(lidar_scan(drive, i));
    if (last) {
      of_scans.add(last->T_odom_base.inverse() * result.T_odom_base, way(last->stamp, result.stamp),
                   result.covariance);
    }
    last = result;
    if (!result.key_frame) continue;
    if (last_key_frame) {
      of_key_frames.add(last_key_frame->T_odom_base.inverse() * result.T_odom_base,
                        way(last_key_frame->stamp, result.stamp),
                        result.key_frame->motion_covariance);
    }
    last_key_frame = result.key_frame;
  }
  EXPECT_GT(of_scans.mean(), 0.5);
  EXPECT_LT(of_scans.mean(), 2.0);
  EXPECT_GT(of_key_frames.mean(), 0.5);
  EXPECT_LT(of_key_frames.mean(), 2.0);
}

INSTANTIATE_TEST_SUITE_P(Drives, SizeOfCovariance,
                         testing::Values("town", "figure_eight", "car_park", "tunnel", "open_road",
                                         "walk"));

}  // namespace
}  // namespace lidar_mapping::front_end
