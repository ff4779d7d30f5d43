// SPDX-License-Identifier: BSD-3-Clause
#include "drive_consistency.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace lidar_mapping::city {

namespace {

// Standard deviations. Chosen: claimed ones are often too small, and the median over loops is wrong
// by as much as neighbouring fixes err together.
constexpr double kAllowedStddevs = 4.0;
// m. Chosen: above the error of loops and of a drive's own bending between two of them.
constexpr double kAllowedError = 2.0;
// Loops. Chosen: one or two may be false without the drive being wrong.
constexpr std::size_t kMinRefused = 3;

struct Votes {
  std::size_t contradicted = 0;
  std::size_t confirmed = 0;
};

std::map<std::size_t, Votes> count_votes(const std::vector<GnssDisagreement>& disagreements) {
  std::map<std::size_t, Votes> votes;
  for (const GnssDisagreement& pair : disagreements) {
    for (const std::size_t drive : {pair.a, pair.b}) {
      ++(pair.is_contradiction() ? votes[drive].contradicted : votes[drive].confirmed);
    }
  }
  return votes;
}

/// The contradiction of this drive to whom it contradicts most.
const GnssDisagreement& largest_of(std::size_t drive, const std::vector<GnssDisagreement>& pairs) {
  const auto size = [drive](const GnssDisagreement& pair) {
    return pair.a == drive || pair.b == drive ? pair.offset.norm() : -1.0;
  };
  return *std::max_element(
      pairs.begin(), pairs.end(),
      [&](const GnssDisagreement& a, const GnssDisagreement& b) { return size(a) < size(b); });
}

}  // namespace

double allowed_offset(double stddev_a, double stddev_b) {
  return kAllowedError + kAllowedStddevs * std::hypot(stddev_a, stddev_b);
}

std::vector<ContradictingGnss> contradicting_gnss(std::vector<GnssDisagreement> disagreements) {
  std::vector<ContradictingGnss> result;
  while (true) {
    const auto votes = count_votes(disagreements);
    const auto worst =
        std::max_element(votes.begin(), votes.end(), [](const auto& one, const auto& other) {
          return std::make_tuple(one.second.contradicted, other.second.confirmed, one.first) <
                 std::make_tuple(other.second.contradicted, one.second.confirmed, other.first);
        });
    if (worst == votes.end() || worst->second.contradicted == 0) return result;
    const std::size_t drive = worst->first;
    const GnssDisagreement& largest = largest_of(drive, disagreements);
    result.push_back({drive, largest.a == drive ? largest.b : largest.a, largest.offset.norm(),
                      worst->second.contradicted, worst->second.confirmed});
    const auto is_of_drive = [drive](const GnssDisagreement& pair) {
      return pair.a == drive || pair.b == drive;
    };
    disagreements.erase(std::remove_if(disagreements.begin(), disagreements.end(), is_of_drive),
                        disagreements.end());
  }
}

std::size_t contradicting_drive(const std::vector<LoopUsage>& usages) {
  std::size_t worst = usages.size();
  std::size_t largest_excess = 0;
  for (std::size_t drive = 0; drive < usages.size(); ++drive) {
    const auto [used, refused] = usages[drive];
    if (refused < kMinRefused || refused <= used || refused - used < largest_excess) continue;
    worst = drive;  // the later one if it is a draw
    largest_excess = refused - used;
  }
  return worst;
}

}  // namespace lidar_mapping::city
