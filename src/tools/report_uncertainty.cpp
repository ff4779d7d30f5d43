#include <algorithm>
#include <cmath>
#include <set>

#include "lidar_mapping/back_end/marginal_covariance.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

#include "report_figures.hpp"
#include "report_statistics.hpp"

namespace lidar_mapping::tools {

namespace {

constexpr std::size_t kSamples = 40;  // poses whose covariance is asked for

back_end::BackEndConfig configuration_of(const session::Session& session) {
  return config::load<back_end::BackEndConfig>(
      {pipeline::stored_configuration<back_end::BackEndConfig>(session)});
}

/// Key frames that a believed loop or a GNSS position constrains.
std::set<KeyFrameIndex> constrained_ones(const ReportInput& input,
                                         const back_end::BackEnd& back_end, bool use_gnss) {
  std::set<KeyFrameIndex> constrained;
  for (const auto& [loop, used] : back_end.loops()) {
    if (used) constrained.insert({loop.from, loop.to});
  }
  if (!use_gnss) return constrained;
  std::set<Stamp> stamps;
  for (const GnssPosition& gnss : input.session.gnss()) stamps.insert(gnss.stamp);
  for (const KeyFramePose& pose : input.poses.poses) {
    if (stamps.count(pose.stamp) > 0) constrained.insert(pose.index);
  }
  return constrained;
}

/// The longest part of the path on odometry alone.
Json longest_gap(const ReportInput& input, const std::set<KeyFrameIndex>& constrained) {
  const auto distances = distances_of(input.poses);
  double begin = 0.0;
  double longest = 0.0;
  double at = 0.0;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (distances[i] - begin > longest) {
      longest = distances[i] - begin;
      at = begin;
    }
    if (constrained.count(input.poses.poses[i].index) > 0) begin = distances[i];
  }
  return {{"length_m", longest}, {"begin_m", at}};
}

}  // namespace

std::unique_ptr<back_end::BackEnd> solved_graph(const session::Session& session) {
  auto back_end = std::make_unique<back_end::BackEnd>(configuration_of(session));
  pipeline::replay(session, *back_end);
  back_end->apply(*back_end::solve(*back_end->problem(true)));
  return back_end;
}

Json uncertainty_figures(const ReportInput& input, const back_end::BackEnd& back_end) {
  const auto problem = back_end.problem(true);
  const auto distances = distances_of(input.poses);
  Json rows = Json::array();
  double worst = 0.0;
  for (std::size_t i = 0; i < distances.size(); i += distances.size() / kSamples + 1) {
    const auto covariance = back_end::marginal_covariance(*problem, input.poses.poses[i].index);
    if (!covariance) continue;
    const double metres = std::sqrt(covariance->topLeftCorner<3, 3>().trace());
    const double degrees = std::sqrt(covariance->bottomRightCorner<3, 3>().trace()) * kDegPerRad;
    rows.push_back({distances[i], metres, degrees});
    worst = std::max(worst, metres);
  }
  return {{"largest_sigma_m", worst},
          {"longest_without_constraint",
           longest_gap(
               input, constrained_ones(input, back_end, configuration_of(input.session).use_gnss))},
          {"columns", {"distance", "sigma_m", "sigma_deg"}},
          {"rows", rows}};
}

}  // namespace lidar_mapping::tools
