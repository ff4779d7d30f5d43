// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/scan_pairing.hpp"

#include <utility>

namespace lidar_mapping::pipeline {

namespace {

/// Scans that wait for their step. Chosen: two seconds of them; the front end sends both within
/// milliseconds.
constexpr std::size_t kMostWaitingScans = 20;
/// Steps that are kept while no scan comes. Chosen: more than a minute of them; bounds the memory.
constexpr std::size_t kMostSteps = 1000;

}  // namespace

/// Steps come in the order of their stamps, so that later ones are from before time went back.
void ScanPairing::add(const OdometryStep& step) {
  steps_.erase(steps_.lower_bound(step.stamp), steps_.end());
  steps_.emplace(step.stamp, step);
  if (steps_.size() <= kMostSteps) return;
  steps_.erase(steps_.begin());
  motion_.interrupt();
}

void ScanPairing::add(Scan scan) {
  const Stamp stamp = scan.stamp;
  scans_[stamp] = std::move(scan);
}

std::vector<PairedScan> ScanPairing::take_ready() {
  std::vector<PairedScan> ready;
  for (auto scan = scans_.begin(); scan != scans_.end();) {
    if (steps_.count(scan->first) > 0) {
      ready.push_back(paired(std::move(scan->second)));
    } else if (scans_.size() <= kMostWaitingScans &&
               (steps_.empty() || steps_.rbegin()->first < scan->first)) {
      ++scan;
      continue;
    } else {
      ++given_up_;
    }
    scan = scans_.erase(scan);
  }
  return ready;
}

/// The motion over all steps up to this scan, whose scans may have been lost.
PairedScan ScanPairing::paired(Scan&& scan) {
  PairedScan result;
  while (!steps_.empty() && steps_.begin()->first <= scan.stamp) {
    const OdometryStep step = steps_.begin()->second;
    steps_.erase(steps_.begin());
    motion_.add(step);
    result.T_odom_base = step.T_odom_base;
    result.twist = step.twist;
  }
  result.input = motion_.input_of(std::move(scan));
  return result;
}

}  // namespace lidar_mapping::pipeline
