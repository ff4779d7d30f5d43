// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/tracking_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lidar_mapping::pipeline {

namespace {

constexpr Stamp kGap = from_seconds(1.0);

constexpr std::array kDoubts = {Doubt::kDoubtful, Doubt::kDegraded, Doubt::kRepeated,
                                Doubt::kDegenerate, Doubt::kLost};

constexpr double kAllowedShare = 0.01;
constexpr double kLeastAllowed = 0.5;  // m

double squared(double value) { return value * value; }

}  // namespace

const char* to_string(Doubt doubt) {
  switch (doubt) {
    case Doubt::kDoubtful:
      return "doubtful";
    case Doubt::kDegraded:
      return "degraded";
    case Doubt::kRepeated:
      return "repeated";
    case Doubt::kDegenerate:
      return "degenerate";
    case Doubt::kLost:
      break;
  }
  return "lost";
}

std::optional<Doubt> doubt_of_state(const std::string& state) {
  const auto* found = std::find_if(kDoubts.begin(), kDoubts.end(),
                                   [&](Doubt doubt) { return state == to_string(doubt); });
  if (found == kDoubts.end()) return std::nullopt;
  return *found;
}

void TrackingSummary::add(const TrackedStep& step) {
  go_on_to(step);
  if (step.doubt) {
    DoubtfulStretch& stretch = stretch_for(*step.doubt, step);
    stretch.end = step.stamp;
    ++stretch.scans;
    if (step.probability >= 0.0 &&
        (stretch.lowest_probability < 0.0 || step.probability < stretch.lowest_probability)) {
      stretch.lowest_probability = step.probability;
    }
    stretch.way = way_ - stretch.way_begin;
    const auto place = static_cast<std::size_t>(&stretch - stretches_.data());
    stretch.expected_error = std::sqrt(variance_ - variances_before_[place]);
  }
  last_ = step;
}

void TrackingSummary::go_on_to(const TrackedStep& step) {
  ++scans_;
  way_before_ = way_;
  variance_before_ = variance_;
  const double before = last_ ? last_->unobserved_stddev : 0.0;
  if (last_) way_ += (step.p_odom_base - last_->p_odom_base).norm();
  // A front end that was started again begins at 0.
  const bool is_new = step.unobserved_stddev < before;
  variance_ += squared(step.unobserved_stddev) - (is_new ? 0.0 : squared(before));
}

DoubtfulStretch& TrackingSummary::stretch_for(Doubt doubt, const TrackedStep& step) {
  const auto newest = std::find_if(stretches_.rbegin(), stretches_.rend(),
                                   [&](const auto& stretch) { return stretch.doubt == doubt; });
  if (newest != stretches_.rend() && step.stamp - newest->end <= kGap) return *newest;
  DoubtfulStretch stretch;
  stretch.doubt = doubt;
  stretch.begin = step.stamp;
  stretch.way_begin = way_before_;
  stretch.place = step.p_odom_base;
  stretches_.push_back(stretch);
  variances_before_.push_back(variance_before_);
  return stretches_.back();
}

double allowed_error(double way) { return std::max(kLeastAllowed, kAllowedShare * way); }

}  // namespace lidar_mapping::pipeline
