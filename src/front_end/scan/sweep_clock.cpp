// SPDX-License-Identifier: BSD-3-Clause
#include "scan/sweep_clock.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::front_end {
namespace {

/// Number of sweeps from which the period is estimated, and the number that is enough to decide
/// whether a sweep is a full turn. Chosen: a drift of the period shows within 64 sweeps (see
/// kMinScatterRatioToStart), and 16 are over in two seconds.
constexpr std::size_t kWindow = 64;
constexpr std::size_t kMinSweeps = 16;
/// After a gap of this length (s) the estimation starts again: the period may have changed. Chosen:
/// over longer ones an error of a hundredth of the period adds up to half a turn (at 10 Hz).
constexpr double kMaxGap = 5.0;
/// Standard deviation of the stamps, as a fraction of the period, below which they are used as they
/// are: the error of the prediction is this fraction of the distance between two scans. Chosen:
/// 4 cm at 10 m/s and 10 Hz, which a match easily corrects.
constexpr double kMinJitterFraction = 0.04;
/// Power of the mean phase vector of n sweeps: its squared length times n. It exceeds c with a
/// probability of exp(-c) if there is no such period. The first limit is for the test whether a
/// sweep is a full turn, the second for the best of about three hundred periods. Chosen: one in
/// ten windows without a period passes either.
constexpr double kMinPhasePower = 2.5;
constexpr double kMinBestPhasePower = 8.0;
/// Periods are searched between these multiples of a sweep's duration. Chosen: a sweep lasts a turn
/// (with some columns more or less) or, as of a sensor that sees one side, half of it.
constexpr double kMinPeriodFactor = 0.95;
constexpr double kMaxPeriodFactor = 2.1;
/// If the duration is not known, from this multiple of the median step. Chosen: the median of few
/// scattered steps is off by a tenth of the period.
constexpr double kMinMedianFactor = 0.75;
/// No period is searched if the mean step is longer than this many median steps, as in a log whose
/// scans were stored in bursts: the number of periods to try grows with the ratio, to millions.
/// Chosen: every second scan may be missing.
constexpr double kMaxMeanStep = 2.0;
/// Variance of the steps divided by that of the stamps: nearly 2 if the stamps scatter about a
/// regular grid. If the period drifts, the ratio is smaller and falls with time (1 over 16 scans,
/// 0.2 over 64); so it is with scans that are taken on request. The first limit applies before
/// counting begins, the second while turns are counted. Chosen between 1 and 2, and below 1.
constexpr double kMinScatterRatioToStart = 1.3;
constexpr double kMinScatterRatioToContinue = 0.8;

/// A stamp that is later than expected by this fraction of the period belongs to a later turn.
/// Chosen above a half: a missing scan is rarer than a stamp error of half a period, and one that
/// is overlooked is found with the next scan.
constexpr double kMissingScanFraction = 0.6;

double phase_angle(double seconds, double period) { return 2.0 * kPi * seconds / period; }

}  // namespace

void SweepClock::begin_window(Stamp stamp, double reference, double duration) {
  window_.clear();
  window_stamp_ = stamp;
  window_.push_back({reference, duration, 0.0});
  fit_ = {};
  jitter_ = 0.0;
}

double SweepClock::advance(Stamp stamp, double reference, double duration) {
  const bool is_first = window_.empty();
  const double stamp_interval = to_seconds(stamp - stamp_) + reference - reference_;
  const double reference_change = reference - reference_;
  stamp_ = stamp;
  reference_ = reference;
  const bool is_of_other_kind = !is_first && (duration > 0.0) != (window_.back().duration > 0.0);
  if (is_first || is_of_other_kind || stamp_interval > kMaxGap) {
    begin_window(stamp, reference, duration);
    return is_first ? 0.0 : stamp_interval;
  }
  window_.push_back({to_seconds(stamp - window_stamp_) + reference, duration, 0.0});
  if (window_.size() > kWindow) window_.pop_front();
  const bool was_active = std::exchange(jitter_, 0.0) > 0.0;
  analyze_steps();
  if (fit_.period > 0.0) {
    window_.back().turn = turns_of_last();
    fit();
  } else if (window_.size() >= kMinSweeps && is_irregular()) {
    find_period();
  }
  if (fit_.period == 0.0) return stamp_interval;
  if (fit_.scatter < kMinJitterFraction * fit_.period || is_drifting(was_active)) {
    fit_ = {};
    return stamp_interval;
  }
  jitter_ = fit_.scatter;
  const double turns = window_.back().turn - window_[window_.size() - 2].turn;
  // If a sweep is a full turn, its duration is more precise than a few scattered stamps.
  const bool is_whole_turn =
      std::abs(fit_.period - fit_.duration) < 2.0 * fit_.period_sigma + 0.002 * fit_.period;
  return turns * (is_whole_turn ? fit_.duration : fit_.period) + reference_change;
}

/// Missing scans give steps of several turns.
void SweepClock::analyze_steps() {
  steps_.clear();
  for (std::size_t i = 1; i < window_.size(); ++i) {
    steps_.push_back(window_[i].middle - window_[i - 1].middle);
  }
  median_step_ = quantile_of_range(steps_.begin(), steps_.end(), 0.5);
  step_variance_ = 0.0;
  for (const double step : steps_) {
    const double deviation = step - median_step_ * std::max(1.0, std::round(step / median_step_));
    step_variance_ += deviation * deviation / static_cast<double>(steps_.size());
  }
}

/// A sensor that does not spin has no regular period: its sweeps are shorter than their distance.
/// The variance of a step contains the errors of two stamps.
bool SweepClock::is_irregular() const {
  const double duration = window_.back().duration;
  const bool may_spin = duration == 0.0 || median_step_ < kMaxPeriodFactor * duration;
  return may_spin && step_variance_ > 2.0 * kMinJitterFraction * kMinJitterFraction * median_step_ *
                                          median_step_;
}

bool SweepClock::is_drifting(bool was_active) const {
  const double min_ratio = was_active ? kMinScatterRatioToContinue : kMinScatterRatioToStart;
  return step_variance_ < min_ratio * fit_.scatter * fit_.scatter;
}

void SweepClock::find_period() {
  const bool has_durations = window_.back().duration > 0.0;
  // First test whether a sweep is a full turn. Only a few sweeps are used, because the duration may
  // differ from the period by a few columns.
  std::deque<Sweep> latest(window_.end() - kMinSweeps, window_.end());
  double mean_duration = 0.0;
  for (const Sweep& sweep : latest) {
    mean_duration += sweep.duration / static_cast<double>(kMinSweeps);
  }
  if (has_durations && phase_power(latest, mean_duration) > kMinPhasePower) {
    window_ = std::move(latest);
    return count_turns(mean_duration);
  }
  if (!has_durations) return search_period(kMinMedianFactor * median_step_, median_step_);
  if (window_.size() == kWindow) search_period(kMinPeriodFactor * mean_duration, mean_duration);
}

void SweepClock::search_period(double min_period, double typical_period) {
  const double length = window_.back().middle - window_.front().middle;
  if (length > kMaxMeanStep * median_step_ * static_cast<double>(steps_.size())) return;
  // The step is so fine that over the window it changes the phase by a quarter of a turn.
  const double step = 0.25 * typical_period * typical_period / length;
  double best = 0.0;
  double best_power = kMinBestPhasePower;
  for (double period = min_period; period < kMaxPeriodFactor * typical_period; period += step) {
    const double power = phase_power(window_, period);
    if (power < best_power) continue;
    best_power = power;
    best = period;
  }
  if (best > 0.0) count_turns(best);
}

std::complex<double> SweepClock::phase_sum(const std::deque<Sweep>& sweeps, double period) {
  std::complex<double> sum;
  for (const Sweep& sweep : sweeps) sum += std::polar(1.0, phase_angle(sweep.middle, period));
  return sum;
}

double SweepClock::phase_power(const std::deque<Sweep>& sweeps, double period) {
  return std::norm(phase_sum(sweeps, period)) / static_cast<double>(sweeps.size());
}

/// Assigns a turn to all sweeps of the window, from their mean phase. A sweep whose stamp is off by
/// more than half a turn falls into the turn of its neighbour: of the two, the one that is farther
/// from the middle of that turn belongs to the turn before it or after it.
void SweepClock::count_turns(double period) {
  const double begin = std::arg(phase_sum(window_, period)) / (2.0 * kPi) * period;
  for (Sweep& sweep : window_) sweep.turn = std::round((sweep.middle - begin) / period);
  for (std::size_t i = 1; i < window_.size(); ++i) {
    Sweep& before = window_[i - 1];
    Sweep& sweep = window_[i];
    if (sweep.turn != before.turn) continue;
    const bool is_early = sweep.middle + before.middle > 2.0 * (begin + period * sweep.turn);
    (is_early ? sweep.turn : before.turn) += is_early ? 1.0 : -1.0;
  }
  fit();
}

/// The turn of the last sweep according to the line so far: the next turn, unless a scan must be
/// missing.
double SweepClock::turns_of_last() const {
  const double turn = (window_.back().middle - fit_.begin) / fit_.period;
  const double next = window_[window_.size() - 2].turn + 1.0;
  return turn < next + kMissingScanFraction ? next : std::round(turn);
}

void SweepClock::fit() {
  fit_ = {};
  const auto count = static_cast<double>(window_.size());
  double turn = 0.0;
  double middle = 0.0;
  for (const Sweep& sweep : window_) {
    turn += sweep.turn / count;
    middle += sweep.middle / count;
    fit_.duration += sweep.duration / count;
  }
  double squares = 0.0;
  double products = 0.0;
  for (const Sweep& sweep : window_) {
    squares += (sweep.turn - turn) * (sweep.turn - turn);
    products += (sweep.turn - turn) * (sweep.middle - middle);
  }
  if (squares == 0.0) return;
  fit_.period = products / squares;
  fit_.begin = middle - fit_.period * turn;
  double residuals = 0.0;
  for (const Sweep& sweep : window_) {
    const double residual = sweep.middle - fit_.begin - fit_.period * sweep.turn;
    residuals += residual * residual;
  }
  fit_.scatter = std::sqrt(residuals / count);
  fit_.period_sigma = fit_.scatter / std::sqrt(squares);
}

}  // namespace lidar_mapping::front_end
