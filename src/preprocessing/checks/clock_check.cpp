// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <optional>
#include <vector>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/text.hpp"

#include "checks/input_checks.hpp"

namespace lidar_mapping::preprocessing {

namespace {

// s between clocks. Chosen: no driver delivers so much later than another one; what differs by less
// is found from the motion (check_offset).
constexpr double kMaxDifference = 1.0;
// s between the quick and the slow tenth of the deliveries. Chosen: above it the recording's times
// are not those of the deliveries, as in a bag that was written anew.
constexpr double kMaxScatter = 0.5;
// For a median; chosen: fixes of 1 Hz in the five seconds before a map is begun.
constexpr std::size_t kMinMessages = 3;
constexpr double kLargestParameter = 10.0;  // s, of the time offsets (PreprocessingConfig::schema)

/// The usual delay (s) from stamp to delivery; empty if there is none.
std::optional<double> steady_delay(const TopicStatistics& topic) {
  const std::vector<double>& delays = topic.delays;
  const bool is_stamped = topic.newest != 0;
  if (!is_stamped || delays.size() < kMinMessages) return std::nullopt;
  if (quantile(delays, 0.9) - quantile(delays, 0.1) > kMaxScatter) return std::nullopt;
  return median(delays);
}

}  // namespace

void check_clock(const TopicStatistics& sensor, const TopicStatistics& points,
                 const std::string& parameter, double configured, InputReport& report) {
  const auto delay = steady_delay(sensor);
  const auto delay_of_points = steady_delay(points);
  if (!delay || !delay_of_points) return;
  const double ahead = *delay_of_points - *delay + configured;
  if (std::abs(ahead) < kMaxDifference) return;
  const std::string text =
      formatted("its stamps are %.1f s %s those of the points that came at the same time",
                std::abs(ahead), ahead > 0.0 ? "ahead of" : "behind");
  if (std::abs(configured - ahead) <= kLargestParameter) {
    add_fault(report, text,
              formatted("synchronise the clocks, or set %s to %.1f (to a tenth of a second)",
                        parameter.c_str(), configured - ahead));
    return;
  }
  const bool points_are_wrong = std::abs(*delay_of_points) > std::abs(*delay);
  add_fault(report, text,
            std::string(points_are_wrong ? "the LiDAR's" : "its") +
                " driver must stamp by the computer's clock, or the clock of the sensor must be "
                "set by PTP or NTP");
}

}  // namespace lidar_mapping::preprocessing
