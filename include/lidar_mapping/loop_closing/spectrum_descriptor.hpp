// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::loop_closing {

/// Descriptor of a location in a bird's-eye view that hardly depends on the position within the
/// location: magnitude spectra of the occupied cells projected onto 60 directions (Radon transform;
/// doc/loop_closing.md). A rotation of the vehicle shifts the directions circularly.
class SpectrumDescriptor {
 public:
  /// Spatial frequencies, 1/128 to 40/128 per m. Chosen: higher ones (below 3.2 m) are the noise of
  /// the cells of 1 m.
  static constexpr int kFrequencies = 40;
  /// Directions over half a turn, 3 degrees apart. Chosen: at 20 m that is the edge of a cell.
  static constexpr int kDirections = 60;
  /// Harmonics over the directions in a key. Chosen: higher ones differ between passes of one
  /// place.
  static constexpr int kHarmonics = 8;
  /// Feature vector for a fast search.
  using Key = Eigen::Matrix<float, kFrequencies * kHarmonics, 1>;

  SpectrumDescriptor() = default;
  /// Computes the descriptor from the centres of occupied cells of 1 m, in m, within 60 m of the
  /// origin.
  explicit SpectrumDescriptor(const std::vector<Eigen::Vector2f>& cells);

  /// The key does not change if the vehicle is rotated, and changes little if it is shifted.
  Key key() const;

  /// The result of comparing two descriptors.
  struct Comparison {
    double similarity = 0.0;  ///< largest correlation over all rotations, at most 1
    double yaw = 0.0;         ///< heading of the other in this one, known modulo pi, in [0, pi) rad
  };
  /// Finds the rotation for which both descriptors agree best.
  Comparison compare(const SpectrumDescriptor& other) const;

 private:
  /// One column per direction, in half precision: 4.8 kB.
  Eigen::Matrix<Eigen::half, kFrequencies, kDirections> values_ =
      Eigen::Matrix<Eigen::half, kFrequencies, kDirections>::Zero();
};

}  // namespace lidar_mapping::loop_closing
