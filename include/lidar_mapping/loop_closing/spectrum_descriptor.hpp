// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// What a place looks like from above, whatever the position within it and the heading: magnitude
/// spectra of the occupancy, projected on 60 directions (Radon transform; doc/loop_closing.md).
class SpectrumDescriptor {
 public:
  static constexpr int kFrequencies = 40;
  static constexpr int kDirections = 60;
  static constexpr int kHarmonics = 8;
  using Key = Eigen::Matrix<float, kFrequencies * kHarmonics, 1>;

  SpectrumDescriptor() = default;
  /// Of the centres of occupied cells of 1 m (m, within 60 m of the origin).
  explicit SpectrumDescriptor(const std::vector<Eigen::Vector2f>& cells);

  /// Does not change when the vehicle is turned, and little when it is shifted.
  Key key() const;

  struct Comparison {
    double similarity = 0.0;  ///< at most 1
    double yaw = 0.0;         ///< of the other in this, modulo pi, rad in [0, pi)
  };
  Comparison compare(const SpectrumDescriptor& other) const;

 private:
  /// Half precision: 4.8 kB. A column per direction.
  Eigen::Matrix<Eigen::half, kFrequencies, kDirections> values_ =
      Eigen::Matrix<Eigen::half, kFrequencies, kDirections>::Zero();
};

}  // namespace lidar_mapping::loop_closing
