// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/tracking_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lidar_mapping::pipeline {

namespace {

constexpr Stamp kGap = from_seconds(1.0);

// In the order of the values of Doubt.
constexpr std::array kNames = {"doubtful", "degraded", "repeated", "degenerate", "lost"};

// Of the path length. Chosen: what is visible in a map.
constexpr double kAllowedFraction = 0.01;
constexpr double kMinAllowedError = 0.5;  // m; chosen: matches of loops converge from more

double squared(double value) { return value * value; }

}  // namespace

const char* to_string(Doubt doubt) { return kNames[static_cast<std::size_t>(doubt)]; }

std::optional<Doubt> doubt_of_state(const std::string& state) {
  const auto* found = std::find(kNames.begin(), kNames.end(), state);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Doubt>(found - kNames.begin());
}

void TrackingSummary::add(const TrackedStep& step) {
  advance_to(step);
  if (step.doubt) {
    DoubtfulSection& section = section_for(*step.doubt, step);
    section.end = step.stamp;
    ++section.scans;
    if (step.probability) {
      section.lowest_probability =
          std::min(section.lowest_probability.value_or(*step.probability), *step.probability);
    }
    section.path_length = path_length_ - section.path_begin;
    const auto index = static_cast<std::size_t>(&section - sections_.data());
    section.expected_error = std::sqrt(variance_ - variances_before_[index]);
  }
  last_ = step;
}

void TrackingSummary::advance_to(const TrackedStep& step) {
  ++scans_;
  path_length_before_ = path_length_;
  variance_before_ = variance_;
  const bool continues = last_ && !step.begins_drive && step.drive == last_->drive;
  const double before = continues ? last_->unobserved_stddev : 0.0;
  if (continues) path_length_ += (step.p_odom_base - last_->p_odom_base).norm();
  // After a restart the front end begins at 0.
  const bool is_new = step.unobserved_stddev < before;
  variance_ += squared(step.unobserved_stddev) - (is_new ? 0.0 : squared(before));
}

DoubtfulSection& TrackingSummary::section_for(Doubt doubt, const TrackedStep& step) {
  const auto newest =
      std::find_if(sections_.rbegin(), sections_.rend(), [&](const DoubtfulSection& section) {
        return section.doubt == doubt && section.drive == step.drive;
      });
  if (newest != sections_.rend() && step.stamp - newest->end <= kGap) return *newest;
  DoubtfulSection section;
  section.doubt = doubt;
  section.drive = step.drive;
  section.begin = step.stamp;
  section.path_begin = path_length_before_;
  section.position = step.p_odom_base;
  sections_.push_back(section);
  variances_before_.push_back(variance_before_);
  return sections_.back();
}

double allowed_error(double path_length) {
  return std::max(kMinAllowedError, kAllowedFraction * path_length);
}

}  // namespace lidar_mapping::pipeline
