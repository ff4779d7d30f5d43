// SPDX-License-Identifier: BSD-3-Clause
#include "hypotheses.hpp"

#include <algorithm>
#include <cmath>

#include "place_search.hpp"

namespace lidar_mapping::localization {

std::size_t Hypotheses::size() const {
  return static_cast<std::size_t>(
      std::count_if(all_.begin(), all_.end(),
                    [](const Hypothesis& hypothesis) { return hypothesis.is_possible(); }));
}

const Hypothesis* Hypotheses::best() const {
  const auto best = std::max_element(
      all_.begin(), all_.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.log_odds() < b.log_odds(); });
  return best == all_.end() ? nullptr : &*best;
}

double Hypotheses::probability() const {
  const Hypothesis* const likeliest = best();
  if (likeliest == nullptr) return 0.0;
  double odds = 1.0;
  for (const Hypothesis& hypothesis : all_) odds += std::exp(hypothesis.log_odds());
  return std::exp(likeliest->log_odds()) / odds;
}

void Hypotheses::move(const Pose& T_previous_base, const Covariance6& covariance) {
  for (Hypothesis& hypothesis : all_) hypothesis.move(T_previous_base, covariance);
}

void Hypotheses::update(const ScanPoints& points, MapSurfaces& map, MapMatcher& matcher,
                        double distance) {
  for (Hypothesis& hypothesis : all_) hypothesis.update(points, map, matcher, distance);
  all_.erase(std::remove_if(all_.begin(), all_.end(),
                            [](const Hypothesis& hypothesis) { return hypothesis.is_refuted(); }),
             all_.end());
  compare(distance);
  merge();
}

/// What all places leave unexplained, such as a truck beside the vehicle, tells nothing.
void Hypotheses::compare(double distance) {
  double best = 0.0;
  for (const Hypothesis& hypothesis : all_) {
    best = std::max(best, hypothesis.match().agreement.agreement);
  }
  for (Hypothesis& hypothesis : all_) hypothesis.compare(best, distance);
  const auto least = std::min_element(
      all_.begin(), all_.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.deficit() < b.deficit(); });
  if (least == all_.end()) return;
  const double that_of_best = least->deficit();
  for (Hypothesis& hypothesis : all_) hypothesis.reduce_deficit(that_of_best);
}

/// Hypotheses that matches have led to one place become one.
void Hypotheses::merge() {
  std::vector<Hypothesis> kept;
  for (const Hypothesis& next : all_) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Hypothesis& other) {
      return is_same_place(other.estimate().T_map_base, next.estimate().T_map_base);
    });
    if (same == kept.end()) {
      kept.push_back(next);
    } else {
      same->absorb(next);
    }
  }
  all_ = std::move(kept);
}

void Hypotheses::begin_search() {
  for (Hypothesis& hypothesis : all_) hypothesis.begin_search();
}

void Hypotheses::verify(const PoseEstimate& verified) {
  const auto same = std::find_if(all_.begin(), all_.end(), [&](const Hypothesis& other) {
    return is_same_place(other.estimate().T_map_base, verified.T_map_base);
  });
  if (same == all_.end()) {
    all_.emplace_back(verified);
  } else if (!same->is_found()) {
    same->verify(verified);
  }
}

void Hypotheses::keep_near(const Pose& T_map_base, double distance) {
  const auto is_far = [&](const Hypothesis& hypothesis) {
    const Eigen::Vector3d between =
        hypothesis.estimate().T_map_base.translation - T_map_base.translation;
    return between.head<2>().norm() > distance;
  };
  all_.erase(std::remove_if(all_.begin(), all_.end(), is_far), all_.end());
}

}  // namespace lidar_mapping::localization
