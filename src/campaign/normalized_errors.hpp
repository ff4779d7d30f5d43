// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "lidar_mapping/common/covariance.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/front_end/front_end.hpp"

namespace lidar_mapping::campaign {

/// Mean normalised error squared of motions (NEES; Bar-Shalom, Li, Kirubarajan 2001), each divided
/// by its six degrees of freedom: 1 where the covariances are honest, above 1 where they are too
/// small.
class NormalizedErrors {
 public:
  /// One motion: the true one, the claimed one, and the covariance in the axes of its end.
  void add(const Pose& truth, const Pose& claim, const Covariance6& covariance);
  std::size_t count() const { return count_; }
  std::optional<double> mean() const;  ///< none where nothing was added

 private:
  std::size_t count_ = 0;
  double sum_ = 0.0;
};

/// The motions that the front end claims: from scan to scan, and from key frame to key frame.
class MotionErrors {
 public:
  /// The next final result and the true pose at its stamp. A step counts if it is called tracking,
  /// an edge if it is not doubtful, both only within a segment and without an open direction.
  void add(const front_end::FrontEndResult& result, const Pose& T_map_base);
  const NormalizedErrors& steps() const { return steps_; }
  const NormalizedErrors& edges() const { return edges_; }

 private:
  struct Known {
    std::uint32_t segment = 0;
    Pose truth;
    Pose claim;
  };
  void add_edge(const KeyFrame& key_frame, const Known& known);

  std::optional<Known> last_scan_;
  std::optional<Known> last_key_frame_;
  NormalizedErrors steps_;
  NormalizedErrors edges_;
};

}  // namespace lidar_mapping::campaign
