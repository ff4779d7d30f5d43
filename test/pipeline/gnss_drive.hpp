// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <GeographicLib/LocalCartesian.hpp>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/evaluation/association.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/preprocessing/preprocessor.hpp"
#include "lidar_mapping/simulation/drive.hpp"

/// Effects of faults of GNSS on the poses of a drive whose odometry and loops are computed once.
namespace lidar_mapping::test {

/// Results of the front end and loop closing.
struct DriveOdometry {
  std::vector<KeyFrame> key_frames;
  std::vector<Loop> loops;
};

/// Fixes of a receiver, and the position of its antenna according to tf.
struct Receiver {
  std::vector<GnssFix> fixes;
  Eigen::Vector3d p_base_antenna = Eigen::Vector3d::Zero();
};

inline Receiver receiver_of(const simulation::Drive& drive) {
  return {drive.gnss(), drive.mounting().p_base_antenna};
}

/// Moves every fix by the `offset` (m, East-North-Up) at its stamp.
inline void move_fixes(Receiver& receiver, const simulation::Drive& drive,
                       const std::function<Eigen::Vector3d(Stamp)>& offset) {
  const GeodeticDatum datum = drive.datum();
  const GeographicLib::LocalCartesian geodesy(datum.latitude_deg, datum.longitude_deg,
                                              datum.altitude_m);
  for (GnssFix& fix : receiver.fixes) {
    if (fix.status < 0) continue;
    Eigen::Vector3d p;
    geodesy.Forward(fix.latitude_deg, fix.longitude_deg, fix.altitude_m, p.x(), p.y(), p.z());
    p += offset(fix.stamp);
    geodesy.Reverse(p.x(), p.y(), p.z(), fix.latitude_deg, fix.longitude_deg, fix.altitude_m);
  }
}

/// A receiver with more noise than the simulated one, and the right covariance.
inline Receiver noisy_receiver(const simulation::Drive& drive, double sigma) {
  Receiver receiver = receiver_of(drive);
  std::mt19937 engine(7);
  std::normal_distribution<double> normal(0.0, sigma);
  move_fixes(receiver, drive, [&](Stamp) {
    const double x = normal(engine), y = normal(engine), z = normal(engine);
    return Eigen::Vector3d(x, y, z);
  });
  for (GnssFix& fix : receiver.fixes) {
    if (fix.covariance) fix.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
  }
  return receiver;
}

inline Receiver with_outage(Receiver receiver, double begin_s, double end_s) {
  const Stamp first = receiver.fixes.front().stamp;
  for (GnssFix& fix : receiver.fixes) {
    const double seconds = to_seconds(fix.stamp - first);
    if (seconds >= begin_s && seconds < end_s) fix.status = -1;
  }
  return receiver;
}

/// A reflection: fixes `metres` beside the truth for ten seconds, with unchanged covariance.
inline Receiver with_jump(Receiver receiver, const simulation::Drive& drive, double at_s,
                          double metres) {
  const Stamp first = receiver.fixes.front().stamp;
  move_fixes(receiver, drive, [=](Stamp stamp) -> Eigen::Vector3d {
    const double seconds = to_seconds(stamp - first) - at_s;
    const bool jumps = seconds >= 0.0 && seconds < 10.0;
    return jumps ? Eigen::Vector3d(0.7 * metres, 0.7 * metres, 0.0) : Eigen::Vector3d(0, 0, 0);
  });
  return receiver;
}

inline Receiver with_covariance(Receiver receiver, double factor) {
  for (GnssFix& fix : receiver.fixes) {
    if (fix.covariance) *fix.covariance *= factor;
  }
  return receiver;
}

inline Receiver with_delay(Receiver receiver, double seconds) {
  for (GnssFix& fix : receiver.fixes) fix.stamp += from_seconds(seconds);
  return receiver;
}

/// Moves the antenna by `arm`; tf contains the change.
inline Receiver with_lever_arm(Receiver receiver, const simulation::Drive& drive,
                               const Eigen::Vector3d& arm) {
  move_fixes(receiver, drive, [&](Stamp stamp) -> Eigen::Vector3d {
    return drive.trajectory().pose(stamp).rotation * arm;
  });
  receiver.p_base_antenna += arm;
  return receiver;
}

/// Output of preprocessing at the stamps of all scans.
inline std::vector<preprocessing::SyncedScan> preprocessed_scans(
    const simulation::Drive& drive, const std::optional<Receiver>& receiver,
    const preprocessing::PreprocessingConfig& config) {
  const auto lookup = [&](const std::string& frame) -> std::optional<Pose> {
    if (frame == "imu") return drive.mounting().T_base_imu;
    if (frame == "gnss") return Pose{Eigen::Quaterniond::Identity(), receiver->p_base_antenna};
    return Pose::Identity();
  };
  preprocessing::Preprocessor stage(config, lookup);
  const auto imu = drive.imu();
  const auto velocity = drive.velocity();
  std::size_t next_imu = 0, next_velocity = 0, next_fix = 0;
  const auto deliver_until = [&](Stamp stamp) {
    for (; next_imu < imu.size() && imu[next_imu].stamp <= stamp; ++next_imu) {
      stage.add_imu(imu[next_imu], "imu");
    }
    for (; next_velocity < velocity.size() && velocity[next_velocity].stamp <= stamp;
         ++next_velocity) {
      stage.add_velocity(velocity[next_velocity], "imu");
    }
    if (!receiver) return;
    for (; next_fix < receiver->fixes.size() && receiver->fixes[next_fix].stamp <= stamp;
         ++next_fix) {
      stage.add_gnss(receiver->fixes[next_fix], "gnss");
    }
  };
  std::vector<preprocessing::SyncedScan> all;
  const auto append = [&](std::vector<preprocessing::SyncedScan> more) {
    for (auto& scan : more) all.push_back(std::move(scan));
  };
  for (std::size_t i = 0; i < drive.scan_count(); ++i) {
    preprocessing::RawScan scan;
    scan.stamp = drive.scan_stamp(i);
    scan.frame_id = "lidar";
    scan.cloud.points.assign(100, Point{5.0F, 0.0F, 0.0F, 0.0F});
    deliver_until(scan.stamp);
    append(stage.process(std::move(scan)));
  }
  deliver_until(drive.trajectory().end());
  append(stage.flush());
  return all;
}

inline std::vector<evaluation::PosePair> pairs_with_truth(const simulation::Drive& drive,
                                                          const KeyFramePoses& poses) {
  std::vector<evaluation::PosePair> pairs;
  for (const KeyFramePose& pose : poses.poses) {
    pairs.push_back({pose.stamp, drive.trajectory().pose(pose.stamp), pose.T_map_base});
  }
  return pairs;
}

/// Absolute error of the key frames after optimisation: RMS of the positions in m after rigid
/// alignment, because without GNSS the pose of the map is arbitrary.
inline double final_error(const simulation::Drive& drive, const DriveOdometry& odometry,
                          const std::optional<Receiver>& receiver) {
  back_end::BackEnd back_end{back_end::BackEndConfig{}};
  for (const KeyFrame& key_frame : odometry.key_frames) back_end.add_key_frame(key_frame);
  std::size_t next = 0;
  for (const auto& synced : preprocessed_scans(drive, receiver, {})) {
    while (next < odometry.key_frames.size() &&
           odometry.key_frames[next].stamp < synced.scan.stamp) {
      ++next;
    }
    if (next == odometry.key_frames.size()) break;
    if (odometry.key_frames[next].stamp != synced.scan.stamp) continue;
    if (synced.gnss) back_end.add_gnss(*synced.gnss);
    if (synced.imu) back_end.add_imu(*synced.imu);
  }
  for (const Loop& loop : odometry.loops) back_end.add_loop(loop);
  back_end.apply(*back_end::solve(*back_end.problem(true)));
  const auto pairs = pairs_with_truth(drive, back_end.poses());
  const Pose T_truth_map = evaluation::rigid_alignment(pairs);
  return evaluation::absolute_pose_error(evaluation::aligned(pairs, T_truth_map))
      .translation_m.rmse;
}

/// A faulty receiver and the faultless one to compare it with.
struct GnssFault {
  std::string name;
  Receiver faulty;
  const Receiver* clean;
};

/// The faults listed in doc/preprocessing.md; `rtk` and `single` must outlive the result.
inline std::vector<GnssFault> gnss_faults(const simulation::Drive& drive, const Receiver& rtk,
                                          const Receiver& single) {
  return {{"outage of 60 s", with_outage(rtk, 40.0, 100.0), &rtk},
          {"jumps of 5 m", with_jump(with_jump(rtk, drive, 40.0, 5.0), drive, 90.0, 5.0), &rtk},
          {"jumps of 50 m", with_jump(with_jump(rtk, drive, 40.0, 50.0), drive, 90.0, 50.0), &rtk},
          {"variance 100 times too small", with_covariance(rtk, 0.01), &rtk},
          {"variance 100 times too big", with_covariance(rtk, 100.0), &rtk},
          {"1 m, variance 100 times too small", with_covariance(single, 0.01), &single},
          {"1 m, variance 10 times too big", with_covariance(single, 10.0), &single},
          {"lever arm of 1.5 m", with_lever_arm(rtk, drive, {-1.2, 0.9, 0.0}), &rtk},
          {"stamps 50 ms late", with_delay(rtk, 0.05), &rtk},
          {"stamps 50 ms early", with_delay(rtk, -0.05), &rtk}};
}

}  // namespace lidar_mapping::test
