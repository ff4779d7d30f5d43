#include <algorithm>
#include <cmath>
#include <set>

#include "lidar_mapping/back_end/marginal_covariance.hpp"
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

/// Key frames that a believed loop or a GNSS position holds.
std::set<KeyFrameIndex> held_ones(const ReportInput& input, const back_end::BackEnd& back_end,
                                  bool use_gnss) {
  std::set<KeyFrameIndex> held;
  for (const auto& [loop, used] : back_end.loops()) {
    if (used) held.insert({loop.from, loop.to});
  }
  if (!use_gnss) return held;
  std::set<Stamp> stamps;
  for (const GnssPosition& gnss : input.session.gnss()) stamps.insert(gnss.stamp);
  for (const KeyFramePose& pose : input.poses.poses) {
    if (stamps.count(pose.stamp) > 0) held.insert(pose.index);
  }
  return held;
}

/// The longest way on odometry alone.
Json longest_gap(const ReportInput& input, const std::set<KeyFrameIndex>& held) {
  const auto ways = ways_of(input.poses);
  double begin = 0.0;
  double longest = 0.0;
  double at = 0.0;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (ways[i] - begin > longest) {
      longest = ways[i] - begin;
      at = begin;
    }
    if (held.count(input.poses.poses[i].index) > 0) begin = ways[i];
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

Json hold_figures(const ReportInput& input, const back_end::BackEnd& back_end) {
  const auto problem = back_end.problem(true);
  const auto ways = ways_of(input.poses);
  Json rows = Json::array();
  double worst = 0.0;
  for (std::size_t i = 0; i < ways.size(); i += ways.size() / kSamples + 1) {
    const auto covariance = back_end::marginal_covariance(*problem, input.poses.poses[i].index);
    if (!covariance) continue;
    const double metres = std::sqrt(covariance->topLeftCorner<3, 3>().trace());
    const double degrees = std::sqrt(covariance->bottomRightCorner<3, 3>().trace()) * kDegrees;
    rows.push_back({ways[i], metres, degrees});
    worst = std::max(worst, metres);
  }
  return {
      {"largest_sigma_m", worst},
      {"longest_without_constraint",
       longest_gap(input, held_ones(input, back_end, configuration_of(input.session).use_gnss))},
      {"columns", {"way", "sigma_m", "sigma_deg"}},
      {"rows", rows}};
}

}  // namespace lidar_mapping::tools
