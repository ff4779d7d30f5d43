// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace lidar_mapping::registration {

/// Points of a sweep as the matcher reads them: coordinates in arrays of their own, sorted into
/// time slices. Each slice is filled up to a whole number of vector lanes with points that match
/// nothing.
class NdtPoints {
 public:
  /// Points of nearly the same time: [begin, end) of the arrays.
  struct Slice {
    std::size_t begin = 0;  ///< index of its first point
    std::size_t end = 0;    ///< index behind its last one, with the filling
    float time = 0.0F;      ///< mean of its points, s after the reference time
  };

  /// Takes new points, in m. `s` are seconds after the reference time of the match, zero for points
  /// of one instant; all four have equal length. Slices are equally long in time; their order
  /// inside is that of the input. `viewpoint` is where the sensor was, in the frame of the points,
  /// if that is known.
  void assign(const std::vector<float>& x, const std::vector<float>& y, const std::vector<float>& z,
              const std::vector<float>& s,
              const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt);
  /// Takes every `step`th point of `points`.
  void assign_thinned(const NdtPoints& points, std::size_t step);

  /// Number of points without the filling.
  std::size_t size() const { return size_; }
  /// Length of the arrays.
  std::size_t padded_size() const { return x_.size(); }
  /// In the order of their times, without gaps between them.
  const std::vector<Slice>& slices() const { return slices_; }
  /// m, with the filling.
  const std::vector<float>& x() const { return x_; }
  /// m, with the filling.
  const std::vector<float>& y() const { return y_; }
  /// m, with the filling.
  const std::vector<float>& z() const { return z_; }
  /// Times: seconds after the reference time, with the filling.
  const std::vector<float>& s() const { return s_; }
  /// Where the sensor was, in the frame of the points (m), if that is known.
  const std::optional<Eigen::Vector3f>& viewpoint() const { return viewpoint_; }

 private:
  void clear();
  void push(float x, float y, float z, float s);
  void close_slice(std::size_t begin);

  std::size_t size_ = 0;
  std::vector<float> x_, y_, z_, s_;
  std::optional<Eigen::Vector3f> viewpoint_;
  std::vector<Slice> slices_;
  std::vector<std::size_t> order_;  ///< scratch of assign()
};

}  // namespace lidar_mapping::registration
