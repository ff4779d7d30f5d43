// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <set>
#include <sstream>

#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/pipeline/recorded_back_end.hpp"
#include "lidar_mapping/pipeline/stored_configuration.hpp"

#include "report_figures.hpp"

namespace lidar_mapping::report {

namespace {

using back_end::KeyFrameDeviation;

/// Key frames that are constrained by a loop or a GNSS position that the graph uses.
std::set<KeyFrameIndex> constrained_ones(const ReportInput& input,
                                         const back_end::BackEnd& back_end) {
  std::set<KeyFrameIndex> constrained;
  for (const auto& [loop, used] : back_end.loops()) {
    if (used) constrained.insert({loop.from, loop.to});
  }
  if (!is_in_enu(input.session)) return constrained;
  std::set<Stamp> stamps;
  for (const GnssPosition& gnss : back_end.positions()) stamps.insert(gnss.stamp);
  for (const KeyFramePose& pose : input.poses.poses) {
    if (stamps.count(pose.stamp) > 0) constrained.insert(pose.index);
  }
  return constrained;
}

/// The longest part of the path on odometry alone; each drive has its own path.
json::Json longest_gap(const ReportInput& input, const std::set<KeyFrameIndex>& constrained) {
  const std::vector<double>& distances = input.distances;
  double begin = 0.0;
  double longest = 0.0;
  double at = 0.0;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (i > 0 && input.drives[i] != input.drives[i - 1]) begin = distances[i];
    if (distances[i] - begin > longest) {
      longest = distances[i] - begin;
      at = begin;
    }
    if (constrained.count(input.poses.poses[i].index) > 0) begin = distances[i];
  }
  return {{"length_m", longest}, {"begin_m", at}};
}

/// A key frame of the map with its uncertainty by the graph.
struct KeyFrameUncertainty {
  const KeyFramePose* pose = nullptr;
  const KeyFrameDeviation* deviation = nullptr;
  double distance = 0.0;  ///< path length to it, m
};

std::vector<KeyFrameUncertainty> uncertainties_of(
    const ReportInput& input, const std::vector<KeyFrameDeviation>& deviations) {
  std::map<KeyFrameIndex, const KeyFrameDeviation*> by_index;
  for (const KeyFrameDeviation& deviation : deviations) by_index[deviation.index] = &deviation;
  std::vector<KeyFrameUncertainty> uncertainties;
  for (std::size_t i = 0; i < input.distances.size(); ++i) {
    const KeyFramePose& pose = input.poses.poses[i];
    const auto found = by_index.find(pose.index);
    if (found != by_index.end())
      uncertainties.push_back({&pose, found->second, input.distances[i]});
  }
  return uncertainties;
}

/// The largest known standard deviation of a position and its key frame; null if none is known.
json::Json largest(const std::vector<KeyFrameUncertainty>& uncertainties,
                   back_end::PoseDeviation KeyFrameDeviation::*which) {
  const KeyFrameUncertainty* worst = nullptr;
  for (const KeyFrameUncertainty& uncertainty : uncertainties) {
    const double sigma = (uncertainty.deviation->*which).position;
    if (!std::isfinite(sigma)) continue;
    if (worst == nullptr || sigma > (worst->deviation->*which).position) worst = &uncertainty;
  }
  if (worst == nullptr) return nullptr;
  const Eigen::Vector3d& p = worst->pose->T_map_base.translation;
  return {{"sigma_m", (worst->deviation->*which).position},
          {"key_frame", worst->deviation->index},
          {"x", p.x()},
          {"y", p.y()},
          {"distance_m", worst->distance}};
}

}  // namespace

std::unique_ptr<back_end::BackEnd> solved_graph(const session::Session& session) {
  auto back_end = std::make_unique<back_end::BackEnd>(
      pipeline::stored_config<back_end::BackEndConfig>(session));
  pipeline::replay(session, *back_end);
  back_end->apply(*back_end::solve(*back_end->problem(true)));
  return back_end;
}

json::Json uncertainty_figures(const ReportInput& input, const back_end::BackEnd& back_end,
                               const std::vector<back_end::KeyFrameDeviation>& deviations) {
  const std::vector<KeyFrameUncertainty> uncertainties = uncertainties_of(input, deviations);
  json::Json rows = json::Json::array();
  for (const KeyFrameUncertainty& uncertainty : uncertainties) {
    const back_end::PoseDeviation& sigma = uncertainty.deviation->from_first;
    if (!std::isfinite(sigma.position)) continue;
    rows.push_back({uncertainty.distance, sigma.position, sigma.angle * kDegPerRad});
  }
  const auto count = [&](const auto& is_so) {
    return std::count_if(deviations.begin(), deviations.end(), is_so);
  };
  return {{"largest", largest(uncertainties, &KeyFrameDeviation::from_first)},
          {"largest_step", largest(uncertainties, &KeyFrameDeviation::from_previous)},
          {"not_tied", count([](const auto& d) { return !std::isfinite(d.from_first.position); })},
          {"doubtful", count([](const auto& d) { return d.doubtful; })},
          {"longest_without_constraint", longest_gap(input, constrained_ones(input, back_end))},
          {"columns", {"distance", "sigma_m", "sigma_deg"}},
          {"rows", rows}};
}

std::string key_frame_table(const ReportInput& input,
                            const std::vector<back_end::KeyFrameDeviation>& deviations) {
  std::ostringstream text;
  text << "key_frame,stamp_ns,x,y,z,path_length_m,part,doubtful,sigma_first_m,sigma_first_deg,"
          "sigma_previous_m,sigma_previous_deg\n"
       << std::fixed << std::setprecision(6);
  for (const KeyFrameUncertainty& uncertainty : uncertainties_of(input, deviations)) {
    const Eigen::Vector3d& p = uncertainty.pose->T_map_base.translation;
    const back_end::KeyFrameDeviation& deviation = *uncertainty.deviation;
    text << deviation.index << ',' << uncertainty.pose->stamp << ',' << p.x() << ',' << p.y() << ','
         << p.z() << ',' << uncertainty.distance << ',' << deviation.part << ','
         << (deviation.doubtful ? "yes" : "no") << ',' << deviation.from_first.position << ','
         << deviation.from_first.angle * kDegPerRad << ',' << deviation.from_previous.position
         << ',' << deviation.from_previous.angle * kDegPerRad << '\n';
  }
  return text.str();
}

}  // namespace lidar_mapping::report
