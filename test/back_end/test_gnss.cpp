// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include "lidar_mapping/common/units.hpp"

#include "back_end_fixture.hpp"
#include "gnss/gnss_alignment.hpp"
#include "near.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::add_lap_loops;
using test::aligned_rmse;
using test::DriveSettings;
using test::feed;
using test::optimize;
using test::SyntheticDrive;
using test::true_rmse;

struct MappedDrive {
  SyntheticDrive drive;
  BackEnd back_end;
  std::mt19937 engine{5};

  explicit MappedDrive(const DriveSettings& settings = {}, const BackEndConfig& config = {})
      : drive(test::make_drive(settings)), back_end(config) {
    feed(back_end, drive);
  }
  int size() const { return static_cast<int>(drive.truth.size()); }
  GnssPosition gnss(int at, double sigma_m = 0.02) {
    return test::make_gnss(drive, at, engine, sigma_m);
  }
};

TEST(Gnss, ThirtyMetresDetermineTheHeadingWithoutAnImu) {
  for (const double yaw : {0.0, 1.0, 2.5, -3.0}) {
    DriveSettings settings;
    settings.start_yaw = yaw;
    MappedDrive run(settings);
    BackEnd back_end(BackEndConfig{});
    for (int i = 0; i <= 30; ++i) {
      back_end.add_key_frame(run.drive.key_frames[i]);
      back_end.add_gnss(run.gnss(i));
    }
    optimize(back_end);
    const Pose& last = back_end.poses().poses.back().T_map_base;
    EXPECT_LT(std::abs(yaw_of(run.drive.truth[30].rotation.conjugate() * last.rotation)),
              1.0 * kRadPerDeg);
  }
}

/// Adds the first `metres` of a drive with fixes of this quality, and optimises.
void drive_shortly(MappedDrive& run, int metres, double sigma_m, BackEnd& back_end) {
  for (int i = 0; i <= metres; ++i) {
    back_end.add_key_frame(run.drive.key_frames[i]);
    back_end.add_gnss(run.gnss(i, sigma_m));
  }
  EXPECT_TRUE(optimize(back_end).success);
}

// Until the heading is known, the poses of the map are those of odometry.
TEST(Gnss, TheMapFollowsOdometryWhileTheTrackIsTooShort) {
  DriveSettings settings;
  settings.start_yaw = 2.0;
  MappedDrive run(settings);
  BackEnd few_metres(BackEndConfig{});
  drive_shortly(run, 4, 0.02, few_metres);
  EXPECT_TRUE(test::near(few_metres.T_map_odom().translation, Eigen::Vector3d::Zero(), 1e-6));
  BackEnd rough_fixes(BackEndConfig{});
  drive_shortly(run, 15, 2.0, rough_fixes);
  EXPECT_TRUE(test::near(rough_fixes.T_map_odom().translation, Eigen::Vector3d::Zero(), 1e-6));
}

// Accurate fixes need only a short track.
TEST(Gnss, TenMetresSufficeForAccurateFixes) {
  for (const double yaw : {0.0, 2.0, -3.0}) {
    DriveSettings settings;
    settings.start_yaw = yaw;
    MappedDrive run(settings);
    BackEnd back_end(BackEndConfig{});
    drive_shortly(run, 10, 0.02, back_end);
    const auto poses = back_end.poses().poses;
    const Eigen::Quaterniond& rotation = poses.back().T_map_base.rotation;
    EXPECT_LT(std::abs(yaw_of(run.drive.truth[10].rotation.conjugate() * rotation)),
              2.0 * kRadPerDeg);
    EXPECT_LT(test::position_rmse(poses, run.drive.truth, false), 0.1);
  }
}

TEST(Gnss, AKeyFrameUsesItsFirstPositionOnly) {
  MappedDrive run;
  BackEnd back_end(BackEndConfig{});
  drive_shortly(run, 40, 0.02, back_end);
  const std::size_t once = optimize(back_end).gnss_used;
  for (int i = 0; i <= 40; ++i) back_end.add_gnss(run.gnss(i));
  EXPECT_GT(once, 0U);
  EXPECT_EQ(optimize(back_end).gnss_used, once);
}

// The first alignment does not wait for a hundred fixes.
TEST(Gnss, TheFirstAlignmentIsDueEarly) {
  MappedDrive run;
  BackEnd back_end(BackEndConfig{});
  for (int i = 0; i < 12; ++i) {
    back_end.add_key_frame(run.drive.key_frames[i]);
    back_end.add_gnss(run.gnss(i));
  }
  EXPECT_TRUE(back_end.optimization_due());
  optimize(back_end);
  EXPECT_FALSE(back_end.optimization_due());
}

// Loops bring a new segment to East-North-Up before it is aligned by its own positions.
TEST(Gnss, ASegmentThatLoopsConnectIsNotSolvedMoreOften) {
  MappedDrive run;
  BackEndConfig config;
  config.optimize_step_with_key_frame = 10000;
  BackEnd back_end(config);
  const auto drive_on = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      KeyFrame key_frame = run.drive.key_frames[i];
      key_frame.segment = i < 400 ? 0 : 1;
      back_end.add_key_frame(key_frame);
    }
  };
  drive_on(0, 400);
  for (int i = 0; i < 400; ++i) back_end.add_gnss(run.gnss(i));
  optimize(back_end);
  drive_on(400, 420);
  for (const int i : {400, 405, 410}) {
    EXPECT_TRUE(back_end.add_loop(test::make_loop(run.drive, i - 400, i, run.engine)));
  }
  EXPECT_EQ(optimize(back_end).loops_used, 3U);
  drive_on(420, 440);
  for (int i = 420; i < 426; ++i) back_end.add_gnss(run.gnss(i));
  EXPECT_FALSE(back_end.optimization_due());
}

TEST(Gnss, TheMapDoesNotDependOnTheStartHeading) {
  double reference = 0.0;
  for (const double yaw_deg : {0.0, 170.0}) {
    DriveSettings settings;
    settings.start_yaw = yaw_deg * kRadPerDeg;
    MappedDrive run(settings);
    for (int i = 0; i < run.size(); ++i) run.back_end.add_gnss(run.gnss(i));
    optimize(run.back_end);
    const double error = true_rmse(run.back_end, run.drive);
    EXPECT_LT(error, 0.1);
    if (yaw_deg == 0.0) reference = error;
    EXPECT_NEAR(error, reference, 0.02);
  }
}

/// The prior of the first node moves to East-North-Up with the map: where it was before, the start
/// heading would contradict it by 25 standard deviations.
TEST(Gnss, TheAnchorOfTheFirstNodeMovesWithTheMap) {
  DriveSettings settings;
  settings.start_yaw = 2.5;
  BackEndConfig config;
  config.fix_first_node = true;
  config.fix_first_node_stddev = {1.0, 1.0, 1.0, 0.1, 0.1, 0.1};
  MappedDrive run(settings, config);
  for (int i = 0; i < run.size(); ++i) run.back_end.add_gnss(run.gnss(i));
  const OptimizationReport report = optimize(run.back_end);
  EXPECT_EQ(report.gnss_refused, 0U);
  EXPECT_LT(true_rmse(run.back_end, run.drive), 0.15);
}

TEST(Gnss, TheLeverArmIsPartOfTheModel) {
  MappedDrive with_arm;
  MappedDrive without_arm;
  const Eigen::Vector3d lever(1.5, 0.3, 1.0);
  for (int i = 0; i < with_arm.size(); ++i) {
    GnssPosition position = test::make_gnss(with_arm.drive, i, with_arm.engine, 0.01, lever);
    with_arm.back_end.add_gnss(position);
    position.p_base_antenna.setZero();
    without_arm.back_end.add_gnss(position);
  }
  optimize(with_arm.back_end);
  optimize(without_arm.back_end);
  EXPECT_LT(true_rmse(with_arm.back_end, with_arm.drive), 0.1);
  EXPECT_GT(true_rmse(without_arm.back_end, without_arm.drive), 1.0);
}

// No fix, NaN and jumps of 30 m, 5 s each.
TEST(Gnss, BadFixesHardlyChangeTheMap) {
  MappedDrive good;
  MappedDrive spoiled;
  for (int i = 0; i < good.size(); ++i) {
    const GnssPosition position = good.gnss(i);
    GnssPosition bad = position;
    if (i >= 100 && i < 150) bad.p_enu_antenna.x() = std::numeric_limits<double>::quiet_NaN();
    if (i >= 250 && i < 300) bad.covariance *= 1e8;
    if (i >= 450 && i < 500) bad.p_enu_antenna += Eigen::Vector3d(20.0, -22.0, 5.0);
    good.back_end.add_gnss(position);
    spoiled.back_end.add_gnss(bad);
  }
  optimize(good.back_end);
  const OptimizationReport report = optimize(spoiled.back_end);
  EXPECT_GE(report.gnss_refused, 150U);
  EXPECT_LT(true_rmse(spoiled.back_end, spoiled.drive),
            true_rmse(good.back_end, good.drive) + 0.05);
}

TEST(Gnss, InvalidCovariancesAreRefused) {
  MappedDrive run;
  GnssPosition position = run.gnss(0);
  position.covariance.setZero();
  run.back_end.add_gnss(position);
  position = run.gnss(1);
  position.covariance(0, 1) = position.covariance(1, 0) = 1e6;
  run.back_end.add_gnss(position);
  const OptimizationReport report = optimize(run.back_end);
  EXPECT_EQ(report.gnss_used, 0U);
  EXPECT_EQ(report.gnss_refused, 2U);
}

TEST(Gnss, HorizontalPositionsAreUsedWithoutValidAltitudes) {
  MappedDrive run;
  for (int i = 0; i < run.size(); ++i) {
    GnssPosition position = run.gnss(i);
    if (i % 2 == 0) position.p_enu_antenna.z() = std::numeric_limits<double>::quiet_NaN();
    if (i > 500 && i < 560) position.p_enu_antenna.z() += 15.0;
    run.back_end.add_gnss(position);
  }
  const OptimizationReport report = optimize(run.back_end);
  EXPECT_EQ(report.gnss_refused, 0U);
  EXPECT_LT(true_rmse(run.back_end, run.drive), 0.15);
}

TEST(Gnss, AFirstHalfWithoutGnssIsConnectedSmoothly) {
  MappedDrive run;
  for (int i = 400; i < run.size(); ++i) run.back_end.add_gnss(run.gnss(i));
  add_lap_loops(run.back_end, run.drive, 400, 10, run.engine);
  optimize(run.back_end);
  EXPECT_LT(true_rmse(run.back_end, run.drive), 0.15);
  const auto poses = run.back_end.poses().poses;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose step = poses[i - 1].T_map_base.inverse() * poses[i].T_map_base;
    const Pose odometry =
        run.drive.key_frames[i - 1].T_odom_base.inverse() * run.drive.key_frames[i].T_odom_base;
    EXPECT_TRUE(test::near(step.translation, odometry.translation, 0.05)) << "at key frame " << i;
  }
}

// Positions on a line do not observe the roll about it.
TEST(Gnss, AStraightRoadDoesNotRoll) {
  DriveSettings settings;
  settings.side = 500.0;
  settings.laps = 1;
  settings.hill = 0.0;
  settings.odometry_stddev_deg = 0.001;
  SyntheticDrive drive = test::make_drive(settings);
  drive.key_frames.resize(480);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  std::mt19937 engine(1);
  for (int i = 0; i < 480; ++i) {
    back_end.add_gnss(test::make_gnss(drive, i, engine, 0.02, Eigen::Vector3d::Zero()));
  }
  optimize(back_end);
  for (const KeyFramePose& pose : back_end.poses().poses) {
    const Eigen::Vector3d left = pose.T_map_base.rotation * Eigen::Vector3d::UnitY();
    EXPECT_LT(std::abs(std::asin(left.z())), 0.1 * kRadPerDeg);
  }
}

TEST(Gnss, GeoreferencingMovesTheMapWithoutBendingIt) {
  BackEndConfig config;
  config.georeference_only = true;
  DriveSettings settings;
  settings.start_yaw = 1.0;
  MappedDrive run(settings, config);
  BackEndConfig without_gnss;
  without_gnss.use_gnss = false;
  BackEnd without(without_gnss);
  feed(without, run.drive);
  for (int i = 0; i < run.size(); ++i) run.back_end.add_gnss(run.gnss(i, i == 300 ? 50.0 : 0.5));
  add_lap_loops(run.back_end, run.drive, 400, 10, run.engine);
  for (const auto& [loop, used] : run.back_end.loops()) without.add_loop(loop);
  const OptimizationReport report = optimize(run.back_end);
  optimize(without);
  EXPECT_GT(report.gnss_rms, 0.1);
  EXPECT_NE(report.message.find("without a change of its shape"), std::string::npos)
      << report.message;
  EXPECT_GT(report.gnss_used, 790U);
  EXPECT_GE(report.gnss_refused, 1U);
  EXPECT_EQ(report.gnss_used + report.gnss_refused, static_cast<std::size_t>(run.size()));
  EXPECT_LT(true_rmse(run.back_end, run.drive), aligned_rmse(run.back_end, run.drive) + 0.3);
  const auto a = run.back_end.poses().poses;
  const auto b = without.poses().poses;
  const Pose moved = a.front().T_map_base * b.front().T_map_base.inverse();
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(test::near(moved * b[i].T_map_base.translation, a[i].T_map_base.translation, 1e-3));
  }
}

TEST(Gnss, ReportsThatATrackIsTooShortForGeoreferencing) {
  BackEndConfig config;
  config.georeference_only = true;
  MappedDrive run;
  BackEnd back_end(config);
  for (int i = 0; i < 3; ++i) {
    back_end.add_key_frame(run.drive.key_frames[i]);
    back_end.add_gnss(run.gnss(i));
  }
  const OptimizationReport report = optimize(back_end);
  EXPECT_NE(report.message.find("not placed"), std::string::npos) << report.message;
  EXPECT_EQ(report.gnss_used, 0U);
  EXPECT_EQ(report.gnss_refused, 3U);
}

TEST(Gnss, DoesNotMakeTheMapWorse) {
  // Fixes of 3 m whose error changes slowly, and a drift that loops have removed.
  MappedDrive with;
  std::normal_distribution<double> normal(0.0, 0.3);
  Eigen::Vector3d wander = Eigen::Vector3d::Zero();
  for (int i = 0; i < with.size(); ++i) {
    wander = 0.99 * wander +
             Eigen::Vector3d(normal(with.engine), normal(with.engine), normal(with.engine));
    GnssPosition position = with.gnss(i, 0.02);
    position.p_enu_antenna += wander;
    position.covariance = 9.0 * Eigen::Matrix3d::Identity();
    with.back_end.add_gnss(position);
  }
  MappedDrive without;
  add_lap_loops(with.back_end, with.drive, 400, 5, with.engine);
  for (const auto& [loop, used] : with.back_end.loops()) without.back_end.add_loop(loop);
  optimize(with.back_end);
  optimize(without.back_end);
  EXPECT_LT(aligned_rmse(with.back_end, with.drive),
            aligned_rmse(without.back_end, without.drive) + 0.3);
}

// A street that is driven twice with independent errors of 12 cm stays one street.
TEST(Gnss, LoopsHaveMoreWeightThanFixesLocally) {
  MappedDrive run;
  std::normal_distribution<double> normal(0.0, 0.12);
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  for (int i = 0; i < run.size(); ++i) {
    // The errors are correlated over about 30 m.
    if (i % 30 == 0)
      error = Eigen::Vector3d(normal(run.engine), normal(run.engine), normal(run.engine));
    GnssPosition position = run.gnss(i, 0.01);
    position.p_enu_antenna += error;
    run.back_end.add_gnss(position);
  }
  const auto ghosting = [&] {
    const auto poses = run.back_end.poses().poses;
    double sum = 0.0;
    for (std::size_t i = 400; i < poses.size(); ++i) {
      const Pose apart = poses[i - 400].T_map_base.inverse() * poses[i].T_map_base;
      const Pose truly = run.drive.truth[i - 400].inverse() * run.drive.truth[i];
      sum += (apart.translation - truly.translation).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(poses.size() - 400));
  };
  optimize(run.back_end);
  const double before = ghosting();
  const double error_before = true_rmse(run.back_end, run.drive);
  add_lap_loops(run.back_end, run.drive, 400, 3, run.engine);
  optimize(run.back_end);
  // The registration itself has errors of 2 cm in each direction.
  EXPECT_LT(ghosting(), 0.035);
  EXPECT_LT(ghosting(), 0.3 * before);
  EXPECT_LT(true_rmse(run.back_end, run.drive), error_before + 0.02);
}

// The default configuration can be used as it is.
TEST(Gnss, DefaultsReachTwoDecimetresWithRtk) {
  MappedDrive run;
  for (int i = 0; i < run.size(); ++i) run.back_end.add_gnss(run.gnss(i, 0.02));
  optimize(run.back_end);
  EXPECT_LT(true_rmse(run.back_end, run.drive), 0.2);
}

/// Least extent in m, largest standard deviation of the heading in rad.
constexpr AlignmentLimits kAlignmentLimits = {20.0, 0.02};

TEST(Alignment, ToleratesNearlyHalfOfTheFixesAsOutliers) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal(0.0, 0.05);
  const Pose T_enu_map = {exp_so3({0.0, 0.0, 2.0}), {100.0, -50.0, 7.0}};
  std::vector<AlignmentSample> samples;
  for (int i = 0; i < 100; ++i) {
    AlignmentSample sample;
    sample.p_map = Eigen::Vector3d(i, 10.0 * std::sin(0.1 * i), 0.0);
    sample.p_enu = T_enu_map * sample.p_map + Eigen::Vector3d(normal(engine), normal(engine), 0.0);
    if (i % 5 < 2) sample.p_enu += Eigen::Vector3d(20.0 + i, -10.0, 30.0);
    sample.stddev_horizontal = 0.05;
    samples.push_back(sample);
  }
  const auto alignment = align_to_enu(samples, Eigen::Quaterniond::Identity(), kAlignmentLimits);
  ASSERT_TRUE(alignment);
  EXPECT_NEAR(yaw_of(alignment->T_enu_map.rotation), 2.0, 0.01);
  EXPECT_TRUE(test::near(alignment->T_enu_map.translation, T_enu_map.translation, 0.5));
  EXPECT_EQ(alignment->inliers, 60);
}

TEST(Alignment, NeedsATrackThatIsLongForTheErrorsOfTheFixes) {
  std::vector<AlignmentSample> samples;
  for (int i = 0; i < 30; ++i) {
    AlignmentSample sample;
    sample.p_map = sample.p_enu = Eigen::Vector3d(i, 0.0, 0.0);
    sample.stddev_horizontal = 3.0;
    samples.push_back(sample);
  }
  const auto is_aligned = [&](const AlignmentLimits& limits) {
    return align_to_enu(samples, Eigen::Quaterniond::Identity(), limits).has_value();
  };
  EXPECT_FALSE(is_aligned(kAlignmentLimits));
  AlignmentLimits any_heading = kAlignmentLimits;
  any_heading.max_heading_stddev = 1.0;
  EXPECT_TRUE(is_aligned(any_heading));
  any_heading.min_extent = 50.0;
  EXPECT_FALSE(is_aligned(any_heading)) << "the track has 29 m";
}

}  // namespace
}  // namespace lidar_mapping::back_end
