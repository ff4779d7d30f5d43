// SPDX-License-Identifier: BSD-3-Clause
#include "preprocessing/preprocessing_figures.hpp"

#include <string>
#include <utility>
#include <vector>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Of what is left out, the numbers by their reasons. Empty if they are all 0.
std::string left_out(const std::string& what,
                     const std::vector<std::pair<std::size_t, const char*>>& numbers) {
  std::vector<std::string> reasons;
  for (const auto& [count, reason] : numbers) {
    if (count > 0) reasons.push_back(std::to_string(count) + " " + reason);
  }
  return reasons.empty() ? "" : what + ": " + joined(reasons);
}

std::string dropped_scans(const preprocessing::PreprocessingCounters& counters) {
  return left_out("scans dropped", {{counters.scans_without_extrinsic, "without transform"},
                                    {counters.scans_without_points, "without points"},
                                    {counters.scans_out_of_order, "out of order"}});
}

std::string packets_left_out(const OusterLosses& packets) {
  return left_out("packets left out", {{packets.without_metadata, "before the metadata"},
                                       {packets.damaged, "damaged"},
                                       {packets.late, "late"},
                                       {packets.unfinished, "of an unfinished turn"}});
}

/// All that is left out. Empty if that is nothing.
std::string losses_of(const PreprocessingFigures& figures) {
  const std::string scans = dropped_scans(figures.counters);
  const std::string packets = packets_left_out(figures.packets);
  return scans + (scans.empty() || packets.empty() ? "" : "; ") + packets;
}

}  // namespace

void show(const PreprocessingFigures& figures, Diagnostics& diagnostics) {
  const std::string lost = losses_of(figures);
  diagnostics.set_state(lost.empty() ? Diagnostics::Level::kOk : Diagnostics::Level::kWarning,
                        lost.empty() ? "synchronising" : lost);
  const preprocessing::PreprocessingCounters& counters = figures.counters;
  diagnostics.set("scans in", counters.scans_in);
  diagnostics.set("scans out", counters.scans_out);
  diagnostics.set("scans deskewed here", counters.scans_deskewed);
  diagnostics.set("scans without transform", counters.scans_without_extrinsic);
  diagnostics.set("scans without points", counters.scans_without_points);
  diagnostics.set("scans out of order", counters.scans_out_of_order);
  diagnostics.set("scans discarded when time went back", counters.scans_discarded);
  diagnostics.set("scans completed early", counters.scans_waiting_too_long);
  diagnostics.set("points not finite", counters.points_not_finite);
  diagnostics.set("packets damaged", figures.damaged_packets + figures.packets.damaged);
  diagnostics.set("clouds of other LiDARs left out", figures.other_clouds_left_out);
  diagnostics.set("samples refused", counters.samples_refused);
  diagnostics.set("GNSS fixes refused", counters.gnss_refused);
  diagnostics.set("resets", counters.resets);
}

}  // namespace lidar_mapping::ros_border
