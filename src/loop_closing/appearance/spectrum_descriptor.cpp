// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/loop_closing/spectrum_descriptor.hpp"

#include <cmath>
#include <complex>

#include <unsupported/Eigen/FFT>

#include "lidar_mapping/common/units.hpp"

namespace lidar_mapping::loop_closing {

namespace {

// Of 1 m. Chosen: the width of the view (120 m) and more, a power of two for the FFT.
constexpr int kBins = 128;
constexpr int kDirections = SpectrumDescriptor::kDirections;    // over half a turn
constexpr int kFrequencies = SpectrumDescriptor::kFrequencies;  // per direction
using Spectra = Eigen::Matrix<float, kFrequencies, kDirections>;

/// Histogram of the cells' distances along a direction; each cell is shared between the two nearest
/// bins.
std::vector<float> projected_histogram(const std::vector<Eigen::Vector2f>& cells, double angle) {
  const Eigen::Vector2f direction(static_cast<float>(std::cos(angle)),
                                  static_cast<float>(std::sin(angle)));
  std::vector<float> histogram(kBins, 0.0F);
  for (const auto& cell : cells) {
    const float position = cell.dot(direction) + static_cast<float>(kBins) / 2.0F;
    const int bin = static_cast<int>(position);
    const float fraction = position - static_cast<float>(bin);
    histogram[bin] += 1.0F - fraction;
    histogram[bin + 1] += fraction;
  }
  return histogram;
}

Spectra magnitude_spectra(const std::vector<Eigen::Vector2f>& cells) {
  Eigen::FFT<float> fft;
  std::vector<std::complex<float>> spectrum;
  Spectra spectra;
  for (int d = 0; d < kDirections; ++d) {
    fft.fwd(spectrum, projected_histogram(cells, kPi * d / kDirections));
    for (int f = 0; f < kFrequencies; ++f) spectra(f, d) = std::sqrt(std::abs(spectrum[f + 1]));
  }
  return spectra;
}

/// Position of the peak of a parabola through three equidistant values, in steps from the middle
/// one.
double parabola_peak(double left, double middle, double right) {
  const double curvature = left - 2.0 * middle + right;
  return curvature < 0.0 ? 0.5 * (left - right) / curvature : 0.0;
}

}  // namespace

SpectrumDescriptor::SpectrumDescriptor(const std::vector<Eigen::Vector2f>& cells) {
  if (cells.empty()) return;
  Spectra spectra = magnitude_spectra(cells);
  spectra.colwise() -= spectra.rowwise().mean().eval();
  const float norm = spectra.norm();
  if (norm > 0.0F) values_ = (spectra / norm).cast<Eigen::half>();
}

SpectrumDescriptor::Key SpectrumDescriptor::key() const {
  Eigen::FFT<float> fft;
  std::vector<float> row(kDirections);
  std::vector<std::complex<float>> spectrum;
  Key key;
  for (int f = 0; f < kFrequencies; ++f) {
    for (int d = 0; d < kDirections; ++d) row[d] = static_cast<float>(values_(f, d));
    fft.fwd(spectrum, row);
    for (int h = 0; h < kHarmonics; ++h) key[f * kHarmonics + h] = std::abs(spectrum[h + 1]);
  }
  return key;
}

SpectrumDescriptor::Comparison SpectrumDescriptor::compare(const SpectrumDescriptor& other) const {
  const Spectra own = values_.cast<float>();
  // Twice side by side, so that each circular shift is one block.
  Eigen::Matrix<float, kFrequencies, 2 * kDirections> own_twice;
  own_twice << own, own;
  const Spectra of_other = other.values_.cast<float>();
  Eigen::Matrix<float, kDirections, 1> similarity;
  for (int shift = 0; shift < kDirections; ++shift) {
    similarity[shift] =
        own_twice.block<kFrequencies, kDirections>(0, shift).cwiseProduct(of_other).sum();
  }
  int best = 0;
  similarity.maxCoeff(&best);
  const double peak = parabola_peak(similarity[(best + kDirections - 1) % kDirections],
                                    similarity[best], similarity[(best + 1) % kDirections]);
  const double yaw = (best + peak) * kPi / kDirections;
  return {similarity[best], yaw < 0.0 ? yaw + kPi : yaw};
}

}  // namespace lidar_mapping::loop_closing
