#include "campaign_run.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/evaluation/trajectory_errors.hpp"
#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/simulation/drive.hpp"

#include "campaign_imu.hpp"

namespace lidar_mapping::tools {

namespace {

using front_end::FrontEndResult;
using front_end::TrackingState;

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

front_end::FrontEndConfig make_config(const CampaignCase& c) {
  return config::load<front_end::FrontEndConfig>(
      {config::parse_yaml("registration_method: " + c.method, "case " + c.name)});
}

/// The last of the poses become what they are to stay.
void settle(const std::vector<FrontEndResult>& settled, std::vector<evaluation::PosePair>& pairs) {
  auto pair = pairs.end() - static_cast<std::ptrdiff_t>(settled.size());
  for (const FrontEndResult& result : settled) (pair++)->estimate = result.T_odom_base;
}

void count(TrackingState state, CampaignFigures& figures) {
  ++figures.scans;
  figures.lost += state == TrackingState::kLost ? 1 : 0;
  figures.degraded += state == TrackingState::kDegraded ? 1 : 0;
  figures.degenerate += state == TrackingState::kDegenerate ? 1 : 0;
}

}  // namespace

void StepChecker::take(const Pose& T_map_base, const Pose& T_odom_base, TrackingState state,
                       bool new_segment) {
  if (new_segment) last_.reset();
  const bool is_guess = state == TrackingState::kLost || state == TrackingState::kDegraded;
  if (is_guess && !new_segment) return;
  if (last_ && state == TrackingState::kTracking) {
    const Pose error = (last_->T_map_base.inverse() * T_map_base).inverse() *
                       (last_->T_odom_base.inverse() * T_odom_base);
    const double metres = error.translation.norm();
    const double degrees = rotation_angle(error.rotation) * 180.0 / M_PI;
    if (metres > kWrongStep || degrees > kWrongStepAngle) ++silent_;
    largest_error_ = std::max(largest_error_, metres);
    largest_error_deg_ = std::max(largest_error_deg_, degrees);
  }
  last_ = Claim{T_map_base, T_odom_base};
}

CampaignFigures run_case(const CampaignCase& c, double duration) {
  const simulation::Drive drive(drive_options(c, duration));
  front_end::FrontEnd front_end(make_config(c));
  front_end.set_sensor_origin(drive.mounting().T_base_lidar.translation);
  CampaignFigures figures;
  StepChecker steps;
  std::vector<evaluation::PosePair> pairs;
  std::uint32_t segment = 0;
  std::optional<ImuFeed> feed;
  if (c.imu != "none") feed.emplace(drive);
  for (std::size_t i = 0; i < drive.scan_count(); i += c.every) {
    std::pair<Scan, front_end::MotionPrior> input;
    if (auto fed = feed ? feed->next(i) : std::nullopt) {
      input = *std::move(fed);
    } else {
      input.first = drive.base_scan(i);
    }
    const double before = thread_cpu_ms();
    const FrontEndResult result = front_end.process(input.first, input.second);
    figures.cpu_ms += thread_cpu_ms() - before;
    const Pose T_map_base = drive.trajectory().pose(drive.scan_stamp(i));
    count(result.status.state, figures);
    steps.take(T_map_base, result.T_odom_base, result.status.state, result.segment != segment);
    segment = result.segment;
    settle(result.settled, pairs);
    pairs.push_back({drive.scan_stamp(i), T_map_base, result.T_odom_base});
  }
  settle(front_end.settle(), pairs);
  figures.cpu_ms /= static_cast<double>(std::max<std::size_t>(1, figures.scans));
  figures.silent = steps.silent();
  figures.largest_error = steps.largest_error();
  figures.largest_error_deg = steps.largest_error_deg();
  figures.way = evaluation::travelled_distances(pairs).back();
  const auto fitted = evaluation::aligned(pairs, evaluation::rigid_alignment(pairs));
  figures.ape = evaluation::absolute_pose_error(fitted).translation_m.rmse;
  const auto drift = evaluation::kitti_errors(pairs, evaluation::usual_segment_lengths(pairs), 1);
  if (drift.segments > 0) figures.drift_percent = drift.translation_percent;
  return figures;
}

}  // namespace lidar_mapping::tools
