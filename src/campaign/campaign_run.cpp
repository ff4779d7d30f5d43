// SPDX-License-Identifier: BSD-3-Clause
#include "campaign_run.hpp"

#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/thread_time.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/front_end/prior_of.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "campaign_imu.hpp"
#include "normalized_errors.hpp"

namespace lidar_mapping::campaign {

namespace {

using front_end::FrontEndResult;
using front_end::TrackingState;

front_end::FrontEndConfig make_config(const CampaignCase& c) {
  return config::load<front_end::FrontEndConfig>(
      {config::parse_yaml("registration_method: " + c.method, "case " + c.name)});
}

void count(TrackingState state, CampaignFigures& figures) {
  ++figures.scans;
  figures.lost += state == TrackingState::kLost ? 1 : 0;
  figures.degraded += state == TrackingState::kDegraded ? 1 : 0;
  figures.doubtful += state == TrackingState::kDoubtful ? 1 : 0;
  figures.degenerate += state == TrackingState::kDegenerate ? 1 : 0;
}

/// Brier's score of the probability.
void score(const CheckedStep& step, CampaignFigures& figures) {
  if (step.status.state == TrackingState::kLost) return;
  const double miss = step.status.probability - (step.is_right() ? 1.0 : 0.0);
  figures.squared_error += miss * miss;
  ++figures.steps;
}

/// The scan with what an IMU adds to it, if there is one.
std::pair<Scan, front_end::MotionPrior> input_at(const simulation::Drive& drive, std::size_t i,
                                                 std::optional<ImuFeed>& feed) {
  if (auto fed = feed ? feed->next(i) : std::nullopt) {
    return {std::move(fed->scan), front_end::prior_of(fed->imu, fed->velocity, fed->uneven_turning,
                                                      fed->felt, fed->fingerprint)};
  }
  simulation::SimulatedScan scan = drive.scan(i);
  return {{scan.stamp, std::move(scan.cloud)}, {}};
}

/// Errors of the whole trajectory.
void report(const std::vector<evaluation::PosePair>& pairs, CampaignFigures& figures) {
  figures.path_length = evaluation::travelled_distances(pairs).back();
  const auto fitted = evaluation::aligned(pairs, evaluation::rigid_alignment(pairs));
  figures.ape = evaluation::absolute_pose_error(fitted).translation_m.rmse;
  const auto drift = evaluation::kitti_errors(pairs, evaluation::usual_segment_lengths(pairs), 1);
  if (drift.segments > 0) figures.drift_percent = drift.translation_percent;
}

/// An alignment with the truth needs three poses.
void check_duration(const CampaignCase& c, const simulation::Drive& drive, double duration) {
  if (drive.scan_count() > 2 * c.every) return;
  throw ConfigError("case " + c.name + ": there are less than 3 scans in " +
                    formatted("%g s", duration) + "; ask for a longer duration");
}

/// Holds what the front end claims against the truth, scan by scan.
class Comparison {
 public:
  /// Every step goes into `checked` where that is given.
  explicit Comparison(std::vector<CheckedStep>* checked) : checked_(checked) {}

  /// The next scan: its result, the computing time for it in s, its stamp and its true pose.
  void add(const FrontEndResult& result, double seconds, Stamp stamp, const Pose& T_map_base) {
    figures_.cpu_ms += 1e3 * seconds;
    count(result.status.state, figures_);
    check_step(result, T_map_base);
    finalize(result.finalized);
    pairs_.push_back({stamp, T_map_base, result.T_odom_base});
    if (!result.provisional) errors_.add(result, T_map_base);
  }

  /// The last of the poses become what they are to stay.
  void finalize(const std::vector<FrontEndResult>& finalized) {
    auto pair = pairs_.end() - static_cast<std::ptrdiff_t>(finalized.size());
    for (const FrontEndResult& result : finalized) {
      pair->estimate = result.T_odom_base;
      errors_.add(result, pair->truth);
      ++pair;
    }
  }

  /// After all scans.
  CampaignFigures figures() const {
    CampaignFigures figures = figures_;
    figures.cpu_ms /= static_cast<double>(figures.scans);
    static_cast<StepCounts&>(figures) = steps_.counts();
    figures.nees_steps = errors_.steps().mean();
    figures.nees_edges = errors_.edges().mean();
    report(pairs_, figures);
    return figures;
  }

 private:
  void check_step(const FrontEndResult& result, const Pose& T_map_base) {
    const auto error =
        steps_.add(T_map_base, result.T_odom_base, result.status.state, result.segment != segment_);
    segment_ = result.segment;
    if (!error) return;
    score({result.stamp, result.status, *error}, figures_);
    if (checked_ != nullptr) checked_->push_back({result.stamp, result.status, *error});
  }

  std::vector<CheckedStep>* checked_;
  CampaignFigures figures_;
  StepChecker steps_;
  MotionErrors errors_;
  std::vector<evaluation::PosePair> pairs_;
  std::uint32_t segment_ = 0;
};

}  // namespace

CampaignFigures run_case(const CampaignCase& c, double duration,
                         std::vector<CheckedStep>* checked) {
  const simulation::Drive drive(drive_options(c, duration));
  check_duration(c, drive, duration);
  front_end::FrontEnd front_end(make_config(c));
  front_end.set_sensor_pose(drive.mounting().T_base_lidar);
  std::optional<ImuFeed> feed;
  if (c.imu != "none") feed.emplace(drive);
  Comparison comparison(checked);
  for (std::size_t i = 0; i < drive.scan_count(); i += c.every) {
    const auto [scan, prior] = input_at(drive, i, feed);
    const ThreadTime time;
    const FrontEndResult result = front_end.process(scan, prior);
    const double seconds = time.seconds();
    const Stamp stamp = drive.scan_stamp(i);
    comparison.add(result, seconds, stamp, drive.trajectory().pose(stamp));
  }
  comparison.finalize(front_end.finalize());
  return comparison.figures();
}

}  // namespace lidar_mapping::campaign
