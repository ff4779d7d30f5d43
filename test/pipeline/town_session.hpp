// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/session/session.hpp"

#include "toy_world.hpp"

namespace lidar_mapping::pipeline::test {

using loop_closing::test::along;
using loop_closing::test::drifting;
using loop_closing::test::make_town;
using loop_closing::test::seen_downwards;
using loop_closing::test::ToyWorld;

constexpr Stamp kStart = 1'700'000'000'000'000'000;

/// Records a drive in a session as a front end with this odometry does it, without loops.
inline session::Session record_drive(const std::filesystem::path& folder, const ToyWorld& world,
                                     const std::vector<Pose>& truth,
                                     const std::vector<Pose>& odometry, Stamp start = kStart) {
  session::Session session = session::Session::create_in(folder);
  session.set_sensor_origin(ToyWorld::sensor());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    KeyFrame key_frame;
    key_frame.index = static_cast<KeyFrameIndex>(i);
    key_frame.stamp = start + from_seconds(0.2 * static_cast<double>(i));
    key_frame.T_odom_base = odometry.front().inverse() * odometry[i];
    key_frame.motion_covariance = diagonal_covariance(0.02, 0.002);
    key_frame.cloud = std::make_shared<const PointCloud>(
        world.scan(truth[i], static_cast<std::uint32_t>(start % 1'000'003) + key_frame.index));
    session.add_key_frame(key_frame);
  }
  return session;
}

}  // namespace lidar_mapping::pipeline::test
