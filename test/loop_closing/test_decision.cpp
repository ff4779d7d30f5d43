// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "lidar_mapping/config/load.hpp"

#include "decision/decision.hpp"
#include "toy_world.hpp"

namespace lidar_mapping::loop_closing::test {
namespace {

Match good_match() {
  Match match;
  match.alignment.converged = true;
  match.alignment.T_target_source = planar(1.0, 0.5, 0.1);
  match.alignment.covariance = diagonal_covariance(0.01, 0.001);
  match.figures = {1000, 0.9, 0.01, 0.2, 0.05, 40.0};
  return match;
}

Prior certain_prior() {
  Prior prior;
  prior.anchored = true;
  prior.T_from_to = planar(1.0, 0.0, 0.1);
  prior.sigma_horizontal = 0.5;
  prior.sigma_vertical = 0.1;
  prior.sigma_rotation = 0.02;
  return prior;
}

Decision decision_on(const Match& match, const Prior& prior = certain_prior(),
                     const LoopClosingConfig& config = {}) {
  return decide(match, prior, config);
}

/// Expects this verdict, and that the reason names `parameter`.
void expect(const Decision& decision, Verdict verdict, const std::string& parameter) {
  EXPECT_EQ(decision.verdict, verdict) << decision.reason;
  EXPECT_NE(decision.reason.find(parameter), std::string::npos) << decision.reason;
}

TEST(Decide, AcceptsAMatchThatPassesAllChecks) {
  expect(decision_on(good_match()), Verdict::kAccepted, "overlap_margin_limit");
}

// Storeys look alike, and the estimate does not determine the storey of the vehicle.
TEST(Decide, IsUndecidedUnderARoofAfterAJumpInHeight) {
  Match match = good_match();
  match.figures.roofed = 0.6;
  Prior prior = certain_prior();
  EXPECT_EQ(decision_on(match, prior).verdict, Verdict::kAccepted);
  prior.height_jumps = 2.5;
  expect(decision_on(match, prior), Verdict::kUndecided, "storey");
  match.figures.roofed = 0.05;
  EXPECT_EQ(decision_on(match, prior).verdict, Verdict::kAccepted) << "under the open sky";
}

TEST(Decide, IsUnambiguousIfTheEstimateIsCertain) {
  EXPECT_TRUE(is_unambiguous(good_match(), certain_prior()));
  Match astray = good_match();
  astray.alignment.T_target_source = planar(4.0, 0.0, 0.1);
  EXPECT_FALSE(is_unambiguous(astray, certain_prior()));
}

TEST(Decide, IsAmbiguousIfTwoLocationsArePossible) {
  const std::vector<std::pair<std::string, void (*)(Prior&)>> doubts = {
      {"segments that nothing joins", [](Prior& prior) { prior.anchored = false; }},
      {"storeys after a jump", [](Prior& prior) { prior.height_jumps = 2.5; }},
      {"neighbouring streets", [](Prior& prior) { prior.sigma_horizontal = 1.5; }},
      {"storeys after a long way", [](Prior& prior) { prior.sigma_vertical = 1.0; }},
      {"opposite headings", [](Prior& prior) { prior.sigma_rotation = 1.0; }}};
  for (const auto& [what, worsen] : doubts) {
    Prior prior = certain_prior();
    worsen(prior);
    EXPECT_FALSE(is_unambiguous(good_match(), prior)) << what;
  }
}

// Each figure can refuse a match.
TEST(Decide, EachCheckCanRefuseAndNamesItsParameter) {
  Match match = good_match();
  match.alignment.converged = false;
  expect(decision_on(match), Verdict::kRefused, "converge");
  match = good_match();
  match.figures.tested_points = 299;
  expect(decision_on(match), Verdict::kUndecided, "min_tested_points");
  match = good_match();
  match.figures.overlap = 0.5;
  expect(decision_on(match), Verdict::kRefused, "overlap_margin_limit");
  match = good_match();
  match.figures.free_space_violation = 0.25;
  expect(decision_on(match), Verdict::kRefused, "overlap_margin_limit");
  match = good_match();
  match.figures.horizontal_eigenvalue = 0.019;
  expect(decision_on(match), Verdict::kRefused, "eigenvalue_limit");
  match = good_match();
  match.alignment.T_target_source = planar(1.0, 7.5, 0.1);
  expect(decision_on(match), Verdict::kRefused, "max_loop_distance");
  match = good_match();
  match.alignment.T_target_source = planar(1.0, 4.0, 0.1);
  expect(decision_on(match), Verdict::kRefused, "innovation_limit");
  match = good_match();
  match.alignment.T_target_source = planar(1.0, 0.0, 0.1, 1.2);
  expect(decision_on(match), Verdict::kRefused, "vertical_drift");
}

/// A match at 9 m, as the estimate has it too; both see 40 m, so that 5 m are close.
Decision decision_at_nine_metres(const Match& changed, double max_loop_distance = -1.0) {
  Match match = changed;
  match.alignment.T_target_source = planar(9.0, 0.0, 0.1);
  Prior prior = certain_prior();
  prior.T_from_to = planar(9.0, 0.0, 0.1);
  LoopClosingConfig config;
  config.max_loop_distance = max_loop_distance;
  return decide(match, prior, config);
}

TEST(Decide, AcceptsAFarMatchInSight) {
  expect(decision_at_nine_metres(good_match()), Verdict::kAccepted, "");
  Match match = good_match();
  match.figures.sight = 8.9;
  expect(decision_at_nine_metres(match), Verdict::kRefused, "by sight");
}

TEST(Decide, AFarMatchNeedsMoreOverlapThanACloseOne) {
  Match match = good_match();
  match.figures.overlap = 0.66;  // margin 0.64
  expect(decision_on(match), Verdict::kAccepted, "");
  expect(decision_at_nine_metres(match), Verdict::kRefused, "not close");
  match.figures.overlap = 0.68;
  expect(decision_at_nine_metres(match), Verdict::kAccepted, "");
}

// Through a door a scan fits at many angles.
TEST(Decide, AFarMatchHasToDetermineTheRotation) {
  Match match = good_match();
  match.alignment.covariance = diagonal_covariance(0.01, 0.006);
  expect(decision_on(match), Verdict::kAccepted, "");
  expect(decision_at_nine_metres(match), Verdict::kRefused, "rotation");
  expect(decision_at_nine_metres(match, 10.0), Verdict::kRefused, "rotation");
}

TEST(Decide, ALimitOfTheDistanceThatIsSetReplacesTheRangeOfSight) {
  Match match = good_match();
  match.figures.overlap = 0.6;
  match.figures.sight = 3.0;
  expect(decision_at_nine_metres(match, 10.0), Verdict::kAccepted, "");
  expect(decision_at_nine_metres(match, 8.0), Verdict::kRefused, "max_loop_distance");
}

TEST(Decide, TheLimitOfTheFitnessIsConfigurable) {
  const auto config_of = [](const std::string& limit) {
    return config::load<LoopClosingConfig>(
        {config::parse_yaml("fitness_score_thresh: " + limit + "\n", "hdl")});
  };
  Match match = good_match();
  match.figures.fitness = 0.4;  // larger than in any true loop of the simulated drives
  expect(decision_on(match), Verdict::kAccepted, "");
  match.figures.fitness = 2.0;
  expect(decision_on(match), Verdict::kRefused, "fitness_score_limit");
  expect(decision_on(match, certain_prior(), config_of("2.5")), Verdict::kAccepted, "");
  expect(decision_on(match, certain_prior(), config_of("0.0")), Verdict::kAccepted, "");
}

TEST(LoopClosingConfig, ReadsTheUnanchoredPathLengthUnderItsOldName) {
  const auto config = config::load<LoopClosingConfig>(
      {config::parse_yaml("unanchored_stretch: 60.0\n", "an older session")});
  EXPECT_EQ(config.unanchored_path_length, 60.0);
}

TEST(Decide, GnssCanContradict) {
  Prior prior = certain_prior();
  prior.sigma_horizontal = 100.0;
  prior.gnss = Distance{30.0, 2.0};
  expect(decision_on(good_match(), prior), Verdict::kRefused, "GNSS");
  prior.gnss = Distance{4.0, 2.0};
  expect(decision_on(good_match(), prior), Verdict::kAccepted, "");
}

TEST(Decide, RefusesWithoutAMatchWhatTheViewsContradict) {
  const auto refused = refused_at_start(0.4);
  ASSERT_TRUE(refused);
  expect(*refused, Verdict::kRefused, "starting pose");
  EXPECT_FALSE(refused_at_start(0.02));
}

TEST(AdmitsOtherPlaces, IfTheEstimateIsUncertainByMoreThanLocationsAreApart) {
  Prior prior = certain_prior();
  EXPECT_FALSE(admits_other_places(prior));
  prior.sigma_horizontal = 3.0;
  EXPECT_FALSE(admits_other_places(prior)) << "of a walk without loops";
  prior.sigma_horizontal = 12.0;
  EXPECT_TRUE(admits_other_places(prior));
  EXPECT_FALSE(admits_other_places(Prior())) << "nothing is known";
}

TEST(Decide, AcceptsAMatchFarFromAnUncertainEstimate) {
  Prior prior = certain_prior();
  prior.T_from_to = planar(25.0, -10.0, 0.5, 6.0);
  prior.sigma_horizontal = 12.0;
  prior.sigma_vertical = 6.0;
  prior.sigma_rotation = 0.3;
  expect(decision_on(good_match(), prior), Verdict::kAccepted, "");
}

TEST(LoopClosingConfig, AcceptsTheNamesOfBothPredecessors) {
  const auto config = config::load<LoopClosingConfig>({config::parse_yaml(
      "loop_step: 5\ndiff_num: 100\ndetect_area: 10.0\nextend_frame_num: 5\n"
      "fitness_score_limit: 0.2\nmap_filter: voxel_filter\nscan_filter: no_filter\n"
      "voxel_filter: {map: {leaf_size: 0.3}, scan: {leaf_size: 0.3}}\n"
      "distance_thresh: 15.0\naccum_distance_thresh: 25.0\nmin_edge_interval: 15.0\n",
      "lidar_localization")});
  EXPECT_EQ(config.diff_num, 100);
  EXPECT_EQ(config.scan_filter, FilterMethod::kNone);
  EXPECT_EQ(config.map_leaf_size, 0.3);
}

}  // namespace
}  // namespace lidar_mapping::loop_closing::test
