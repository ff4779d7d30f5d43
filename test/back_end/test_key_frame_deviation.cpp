// How well the graph knows its key frames.

#include <cmath>

#include "lidar_mapping/back_end/key_frame_deviation.hpp"
#include "lidar_mapping/back_end/relative_covariance.hpp"

#include "back_end_fixture.hpp"
#include "optimization.hpp"

namespace lidar_mapping::back_end {
namespace {

using test::add_lap_loops;
using test::feed;
using test::make_loop;
using test::optimize;
using test::SyntheticDrive;

PoseDeviation deviation_of(const Covariance6& covariance) {
  return {std::sqrt(covariance.topLeftCorner<3, 3>().trace()),
          std::sqrt(covariance.bottomRightCorner<3, 3>().trace())};
}

TEST(KeyFrameDeviation, OfNoKeyFrameIsNone) {
  EXPECT_TRUE(key_frame_deviations(*BackEnd(BackEndConfig{}).problem(true)).empty());
}

TEST(KeyFrameDeviation, OfAChainIsThatOfComposedMotions) {
  const SyntheticDrive drive = test::make_drive({1});
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  const auto problem = back_end.problem(true);
  const auto deviations = key_frame_deviations(*problem);
  ASSERT_EQ(deviations.size(), drive.key_frames.size());
  EXPECT_EQ(deviations[0].from_first.position, 0.0);
  Covariance6 composed = Covariance6::Zero();
  for (std::size_t i = 1; i < deviations.size(); ++i) {
    const Covariance6 of_motion = motion_covariance_to(problem->drive, i, problem->config);
    composed = compose_covariance(composed, motion_to(problem->drive, i), of_motion);
    const PoseDeviation first = deviation_of(composed);
    const PoseDeviation previous = deviation_of(of_motion);
    EXPECT_EQ(deviations[i].index, drive.key_frames[i].index);
    EXPECT_EQ(deviations[i].part, 0);
    EXPECT_NEAR(deviations[i].from_first.position, first.position, 1e-3 * first.position);
    EXPECT_NEAR(deviations[i].from_first.angle, first.angle, 1e-3 * first.angle);
    EXPECT_NEAR(deviations[i].from_previous.position, previous.position, 1e-3 * previous.position);
    EXPECT_NEAR(deviations[i].from_previous.angle, previous.angle, 1e-3 * previous.angle);
  }
}

TEST(KeyFrameDeviation, IsThatOfTheWholeInverseBesideLoops) {
  const SyntheticDrive drive = test::make_drive();
  BackEnd back_end(BackEndConfig{});
  std::mt19937 engine(5);
  feed(back_end, drive);
  add_lap_loops(back_end, drive, 400, 20, engine);
  optimize(back_end, true);
  const auto problem = back_end.problem(true);
  const auto deviations = key_frame_deviations(*problem);
  for (const KeyFrameIndex index : {1U, 200U, 399U, 410U, 799U}) {
    const RelativeCovariance first(*problem, 0, RelativeCovariance::Given::kAll);
    const double expected = deviation_of(*first.of(index)).position;
    EXPECT_NEAR(deviations[index].from_first.position, expected, 5e-3 * expected) << index;
    const RelativeCovariance previous(*problem, index - 1, RelativeCovariance::Given::kAll);
    const double step = deviation_of(*previous.of(index)).position;
    // Beside the end of a lap, where loops begin, the two differ by up to 8 %.
    EXPECT_NEAR(deviations[index].from_previous.position, step, 0.1 * step) << index;
  }
}

TEST(KeyFrameDeviation, HasWhatADoubtfulStepAddsAndLoopsTakeAway) {
  SyntheticDrive drive = test::make_drive();
  drive.key_frames[200].doubtful = true;
  drive.key_frames[200].motion_covariance += diagonal_covariance(2.0, 0.01);
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  auto deviations = key_frame_deviations(*back_end.problem(true));
  EXPECT_TRUE(deviations[200].doubtful);
  EXPECT_FALSE(deviations[201].doubtful);
  const double added = std::sqrt(3.0) * 2.0;
  EXPECT_NEAR(deviations[200].from_previous.position, added, 0.01);
  EXPECT_NEAR(deviations[200].from_first.position,
              std::hypot(deviations[199].from_first.position, added),
              0.05 * deviations[200].from_first.position);
  EXPECT_LT(deviations[201].from_previous.position, 0.1);
  std::mt19937 engine(3);
  add_lap_loops(back_end, drive, 400, 5, engine);
  optimize(back_end, true);
  deviations = key_frame_deviations(*back_end.problem(true));
  EXPECT_LT(deviations[200].from_previous.position, 0.2 * added) << "the other lap knows better";
}

TEST(KeyFrameDeviation, IsInfiniteBehindABreakThatNothingJoins) {
  SyntheticDrive drive = test::make_drive({1});
  for (std::size_t i = 300; i < drive.key_frames.size(); ++i) drive.key_frames[i].segment = 1;
  BackEnd back_end(BackEndConfig{});
  feed(back_end, drive);
  auto deviations = key_frame_deviations(*back_end.problem(true));
  EXPECT_TRUE(std::isfinite(deviations[299].from_first.position));
  EXPECT_NE(deviations[300].part, deviations[299].part);
  EXPECT_TRUE(std::isinf(deviations[300].from_first.position));
  EXPECT_TRUE(std::isinf(deviations[300].from_previous.position));
  EXPECT_TRUE(std::isinf(deviations[350].from_first.position));
  EXPECT_LT(deviations[350].from_previous.position, 0.1) << "within the part all is well";
  std::mt19937 engine(3);
  back_end.add_loop(make_loop(drive, 298, 301, engine));
  optimize(back_end, true);
  deviations = key_frame_deviations(*back_end.problem(true));
  EXPECT_LT(deviations[300].from_previous.position, 0.5) << "by way of the loop";
  EXPECT_LT(deviations[300].from_first.position, deviations[299].from_first.position + 0.5);
}

}  // namespace
}  // namespace lidar_mapping::back_end
