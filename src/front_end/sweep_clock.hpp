// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <vector>

#include "lidar_mapping/common/stamp.hpp"

namespace lidar_mapping::front_end {

/// The time between sweeps. A spinning sensor turns regularly; where stamps scatter all the same (a
/// driver that stamps when a packet happens to arrive), a prediction over the time between two
/// stamps is off by its error times the speed. Then whole turns are counted instead. Three things
/// have to be so: a sweep takes most of the time to the next, sweeps are in phase with a period,
/// and the stamps scatter about it without wandering off. All other stamps are taken as they are.
class SweepClock {
 public:
  /// The time from the middle of the sweep before to that of this one, s; 0 for the first. The
  /// middle lies `reference` s after the stamp, the sweep lasts `duration` s (0: not known).
  double advance(Stamp stamp, double reference, double duration);

  /// Scatter of the stamps, s, where turns are counted instead of them; 0 elsewhere.
  double jitter() const { return jitter_; }

 private:
  struct Sweep {
    double middle = 0.0;  ///< s after the first in the window
    double duration = 0.0;
    double turn = 0.0;  ///< if a period is known
  };
  /// The line through the sweeps of the window: middles over turns.
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
  static double phase_power(const std::deque<Sweep>& sweeps, double period);
  void count_turns(double period);
  void fit();
  double turns_of_last() const;

  std::deque<Sweep> window_;
  std::vector<double> steps_;  ///< between the sweeps of the window, s
  Stamp window_stamp_ = 0;     ///< from which the window's times count
  Fit fit_;
  double median_step_ = 0.0;    ///< median of the window, s
  double step_variance_ = 0.0;  ///< of steps about whole multiples of that, s^2
  Stamp stamp_ = 0;
  double reference_ = 0.0;
  double jitter_ = 0.0;
};

}  // namespace lidar_mapping::front_end
