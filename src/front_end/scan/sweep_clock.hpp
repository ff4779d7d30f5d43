// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <deque>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::front_end {

/// Estimates the time between sweeps. A spinning sensor turns regularly. If its stamps are
/// irregular all the same (because the driver stamps a scan when a packet arrives), the error of
/// the time between two stamps, multiplied by the speed, is an error of the prediction. In this
/// case whole turns of the sensor are counted instead. Three conditions must hold: a sweep takes
/// most of the time to the next one (or its points have no times), the sweeps are in phase with a
/// period, and the stamps scatter about this period without drifting away. Otherwise the stamps are
/// used as they are.
class SweepClock {
 public:
  /// The time from the middle of the previous sweep to the middle of this one, s; 0 for the first
  /// sweep. The middle lies `reference` s after the stamp, and the sweep lasts `duration` s (0: not
  /// known).
  double advance(Stamp stamp, double reference, double duration);

  /// Standard deviation of the stamps, s, if turns are counted instead of them; otherwise 0.
  double jitter() const { return jitter_; }

 private:
  struct Sweep {
    double middle = 0.0;  ///< s after the first in the window
    double duration = 0.0;
    double turn = 0.0;  ///< number of the turn, if a period is known
  };
  /// The line fitted to the sweeps of the window: middle over number of turns.
  struct Fit {
    double period = 0.0;  ///< s; 0: no period is known
    double period_sigma = 0.0;
    double begin = 0.0;     ///< of turn 0, s
    double scatter = 0.0;   ///< root mean square of the residuals, s
    double duration = 0.0;  ///< mean of the sweeps
  };

  void begin_window(Stamp stamp, double reference, double duration);
  void analyze_steps();
  bool is_irregular() const;
  bool is_drifting(bool was_active) const;
  void find_period();
  void search_period(double min_period, double typical_period);
  static std::complex<double> phase_sum(const std::deque<Sweep>& sweeps, double period);
  static double phase_power(const std::deque<Sweep>& sweeps, double period);
  void count_turns(double period);
  void fit();
  double turns_of_last() const;

  std::deque<Sweep> window_;
  std::vector<double> steps_;  ///< between the sweeps of the window, s
  Stamp window_stamp_ = 0;     ///< the reference of the window's times
  Fit fit_;
  double median_step_ = 0.0;    ///< median of the window, s
  double step_variance_ = 0.0;  ///< of the steps about integer multiples of the median, s^2
  Stamp stamp_ = 0;
  double reference_ = 0.0;
  double jitter_ = 0.0;
};

}  // namespace lidar_mapping::front_end
