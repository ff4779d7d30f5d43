// SPDX-License-Identifier: BSD-3-Clause
// A street that was passed twice appears once in the map, and a displaced pass is found.
#include <random>

#include <gtest/gtest.h>

#include "lidar_mapping/back_end/back_end.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/loop_closing/loop_closer.hpp"
#include "lidar_mapping/map_quality/map_quality.hpp"

#include "simulated_key_frames.hpp"

namespace lidar_mapping {
namespace {

constexpr double kBegin = 6.0;      // s, first pass of the street
constexpr double kFirstEnd = 11.5;  // s
constexpr double kSecondBegin =
    56.0;                            // s, second pass of the street, after a drive round the block
constexpr double kEnd = 61.0;        // s
constexpr double kGnssError = 0.12;  // m, standard deviation; correlated over 50 m of path

/// A drive round a block with its odometry and GNSS positions.
class TwicePassedStreet {
 public:
  TwicePassedStreet() : drive_(options()), frames_(drive_, kBegin, kEnd, 2.0, 4) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) { return sigma * normal(random); };
    Pose T_odom_base;
    Eigen::Vector3d gnss_error(noise(kGnssError), noise(kGnssError), noise(kGnssError));
    for (std::size_t i = 0; i < truth().size(); ++i) {
      if (i > 0) {
        const Pose motion = truth()[i - 1].T_map_base.inverse() * truth()[i].T_map_base;
        Vector6d odometry_error;
        odometry_error << noise(0.004), noise(0.004), noise(0.002), noise(1e-4), noise(1e-4),
            noise(2e-4);
        T_odom_base = T_odom_base * perturbed(motion, odometry_error);
        const double correlation = std::exp(-motion.translation.norm() / 50.0);
        const double new_error = kGnssError * std::sqrt(1.0 - correlation * correlation);
        gnss_error = correlation * gnss_error +
                     Eigen::Vector3d(noise(new_error), noise(new_error), noise(new_error));
      }
      add(truth()[i], T_odom_base, gnss_error);
    }
  }

  struct Mapped {
    KeyFramePoses poses;
    std::size_t loops = 0;
  };

  Mapped mapped(bool with_gnss, bool with_loops) {
    back_end::BackEndConfig config;
    config.use_gnss = with_gnss;
    config.use_loop_close = with_loops;
    back_end::BackEnd back_end(config);
    loop_closing::LoopCloser closer({}, frames_);
    closer.set_sensor_origin(sensor());
    Mapped result;
    for (std::size_t i = 0; i < key_frames_.size(); ++i) {
      back_end.add_key_frame(key_frames_[i]);
      if (with_gnss) back_end.add_gnss(gnss_[i]);
      if (!with_loops) continue;
      KeyFrame key_frame = key_frames_[i];
      key_frame.cloud = frames_.cloud(key_frame.index);
      for (const Loop& loop : closer.process(key_frame).loops) {
        back_end.add_loop(loop);
        ++result.loops;
      }
    }
    result.poses = back_end.apply(*back_end::solve(*back_end.problem(true)));
    return result;
  }

  /// 90 % quantile of the thickness of the walls of the street, m.
  double wall_thickness(const KeyFramePoses& poses, bool second_pass) {
    return map_quality::local_thickness(in_street(poses, second_pass), frames_, config())
        .walls.percentile_90;
  }

  double error(const KeyFramePoses& poses) const {
    double squares = 0.0;
    for (std::size_t i = 0; i < poses.poses.size(); ++i) {
      squares +=
          (poses.poses[i].T_map_base.translation - truth()[i].T_map_base.translation).squaredNorm();
    }
    return std::sqrt(squares / static_cast<double>(poses.poses.size()));
  }

  map_quality::LocalThickness true_thickness() {
    return map_quality::local_thickness(in_street(frames_.poses, true), frames_, config());
  }

  /// The clouds of the drive; those of the first pass contain a parked car.
  class WithParkedCar : public CloudSource {
   public:
    explicit WithParkedCar(TwicePassedStreet& street) : street_(street) {
      const std::size_t middle = street.key_frames_of_first_pass() / 2;
      T_map_car_ = street.truth()[middle].T_map_base;
    }
    PointCloudPtr cloud(KeyFrameIndex index) override {
      const KeyFramePose& pose = street_.truth()[index];
      auto cloud = std::make_shared<PointCloud>(*street_.frames_.cloud(index));
      if (street_.seconds(pose) > kFirstEnd) return cloud;
      const Pose T_base_car = pose.T_map_base.inverse() * T_map_car_;
      for (int i = 0; i < 2000; ++i) {  // side and back of the car, 3 m to the right
        const double along = 0.05 * (i % 80);
        const double up = 0.2 + 0.05 * (i / 80);
        for (const Eigen::Vector3d& p :
             {Eigen::Vector3d(along, -3.0, up), Eigen::Vector3d(0.0, -3.0 - 0.45 * along, up)}) {
          const Eigen::Vector3f in_base = (T_base_car * p).cast<float>();
          cloud->points.push_back({in_base.x(), in_base.y(), in_base.z(), 0.0F});
        }
      }
      return cloud;
    }

   private:
    TwicePassedStreet& street_;
    Pose T_map_car_;
  };

  std::size_t key_frames_of_first_pass() const {
    std::size_t count = 0;
    while (seconds(truth()[count]) < kFirstEnd) ++count;
    return count;
  }

  /// Misalignments of the second pass when it is displaced like this in its own axes.
  std::vector<map_quality::PassMisalignment> misalignments_of(const Pose& displacement) {
    return misalignments_of(displacement, frames_);
  }
  std::vector<map_quality::PassMisalignment> misalignments_of(const Pose& displacement,
                                                              CloudSource& clouds) {
    KeyFramePoses poses = frames_.poses;
    for (KeyFramePose& pose : poses.poses) {
      if (seconds(pose) < kSecondBegin) continue;
      const Eigen::Quaterniond heading = exp_so3({0.0, 0.0, yaw_of(pose.T_map_base.rotation)});
      pose.T_map_base.translation += heading * displacement.translation;
      pose.T_map_base.rotation = displacement.rotation * pose.T_map_base.rotation;
    }
    std::vector<map_quality::PassMisalignment> in_second_pass;
    for (const map_quality::PassMisalignment& misalignment :
         map_quality::pass_misalignments(poses, clouds, config())) {
      if (seconds(truth()[misalignment.key_frame]) > kSecondBegin + 1.0)
        in_second_pass.push_back(misalignment);
    }
    return in_second_pass;
  }

 private:
  static simulation::DriveOptions options() {
    simulation::DriveOptions options;
    options.undistorted = true;
    options.duration = kEnd + 1.0;
    return options;
  }

  const std::vector<KeyFramePose>& truth() const { return frames_.poses.poses; }
  Eigen::Vector3d sensor() const { return drive_.mounting().T_base_lidar.translation; }
  map_quality::QualityConfig config() const {
    map_quality::QualityConfig config;
    config.p_base_sensor = sensor();
    return config;
  }
  double seconds(const KeyFramePose& pose) const {
    return to_seconds(pose.stamp - drive_.trajectory().begin());
  }

  void add(const KeyFramePose& pose, const Pose& T_odom_base, const Eigen::Vector3d& gnss_error) {
    KeyFrame key_frame;
    key_frame.index = pose.index;
    key_frame.stamp = pose.stamp;
    key_frame.T_odom_base = T_odom_base;
    key_frame.motion_covariance = diagonal_covariance(0.005, 2e-4);
    key_frames_.push_back(key_frame);
    GnssPosition gnss;
    gnss.stamp = pose.stamp;
    gnss.p_base_antenna = drive_.mounting().p_base_antenna;
    gnss.p_enu_antenna = pose.T_map_base * gnss.p_base_antenna + gnss_error;
    gnss.covariance = kGnssError * kGnssError * Eigen::Matrix3d::Identity();
    gnss_.push_back(gnss);
  }

  KeyFramePoses in_street(const KeyFramePoses& poses, bool second_pass) const {
    KeyFramePoses chosen;
    for (const KeyFramePose& pose : poses.poses) {
      const bool first = seconds(pose) < kFirstEnd;
      if (first || (second_pass && seconds(pose) > kSecondBegin)) chosen.poses.push_back(pose);
    }
    return chosen;
  }

  simulation::Drive drive_;
  test::SimulatedKeyFrames frames_;
  std::vector<KeyFrame> key_frames_;
  std::vector<GnssPosition> gnss_;
};

/// One drive for all tests, because its scans take seconds.
TwicePassedStreet& street() {
  static TwicePassedStreet street;
  return street;
}

TEST(PassAlignment, LoopsAlignPassesDespiteGnssErrors) {
  const auto without = street().mapped(true, false);
  const auto with = street().mapped(true, true);
  ASSERT_GT(with.loops, 3U);
  const double once = street().wall_thickness(with.poses, false);
  EXPECT_GT(street().wall_thickness(without.poses, true), 1.5 * once);
  EXPECT_LT(street().wall_thickness(with.poses, true), 1.3 * once);
  EXPECT_NEAR(street().error(with.poses), street().error(without.poses), 0.05);
}

TEST(PassAlignment, LoopsAlignPassesWithoutGnss) {
  const auto with = street().mapped(false, true);
  ASSERT_GT(with.loops, 3U);
  EXPECT_LT(street().wall_thickness(with.poses, true),
            1.3 * street().wall_thickness(with.poses, false));
}

TEST(PassAlignment, TrueMapHasThicknessOfNoise) {
  const map_quality::LocalThickness thickness = street().true_thickness();
  EXPECT_GT(thickness.walls.cells, 300U);
  EXPECT_GT(thickness.ground.cells, 1000U);
  EXPECT_NEAR(thickness.ground.median_ratio, 1.0, 0.1);
  EXPECT_NEAR(thickness.walls.median_ratio, 1.0, 0.1);
}

TEST(PassAlignment, SizeOfDisplacementIsFound) {
  const auto expect = [&](const Pose& displacement, double yaw_deg) {
    const auto misalignments = street().misalignments_of(displacement);
    ASSERT_GE(misalignments.size(), 3U);
    for (const map_quality::PassMisalignment& misalignment : misalignments) {
      EXPECT_NEAR(misalignment.left, displacement.translation.y(), 0.01) << misalignment.key_frame;
      EXPECT_NEAR(misalignment.up, displacement.translation.z(), 0.01) << misalignment.key_frame;
      EXPECT_NEAR(misalignment.yaw * kDegPerRad, yaw_deg, 0.05) << misalignment.key_frame;
    }
  };
  Pose displacement;
  expect(displacement, 0.0);
  displacement.translation.y() = 0.05;
  expect(displacement, 0.0);
  displacement.translation = Eigen::Vector3d(0.0, 0.0, 0.05);
  expect(displacement, 0.0);
  displacement.translation.setZero();
  displacement.rotation = exp_so3({0.0, 0.0, 0.2 * kRadPerDeg});
  expect(displacement, 0.2);
}

TEST(PassAlignment, RemovedParkedCarIsNoDisplacement) {
  TwicePassedStreet::WithParkedCar clouds(street());
  const auto misalignments = street().misalignments_of({}, clouds);
  ASSERT_GE(misalignments.size(), 3U);
  for (const map_quality::PassMisalignment& misalignment : misalignments) {
    EXPECT_NEAR(misalignment.left, 0.0, 0.01) << misalignment.key_frame;
    EXPECT_NEAR(misalignment.up, 0.0, 0.01) << misalignment.key_frame;
    EXPECT_NEAR(misalignment.yaw * kDegPerRad, 0.0, 0.05) << misalignment.key_frame;
  }
}

}  // namespace
}  // namespace lidar_mapping
