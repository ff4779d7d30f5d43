// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Where an interrupted session is resumed. The local map of the front end was lost with its
/// process. Therefore the front end repeats the last section of the drive to rebuild it, and its
/// results for that section are discarded.
struct ResumePoint {
  KeyFrame first;  ///< First key frame of the section.
  KeyFrame last;   ///< Last key frame of the session.

  bool from_beginning() const { return first.index == 0; }
};

/// None for a session without key frames. The section has a path length of `path_length` (m), or
/// begins with the first key frame if the session is shorter or `whole` is set.
std::optional<ResumePoint> resume_point_of(const session::Session& session, double path_length,
                                           bool whole);

/// Continues the odometry of a session: transforms the results of the front end so that they follow
/// the last key frame of the session.
class ResumedOdometry {
 public:
  explicit ResumedOdometry(ResumePoint point) : point_(std::move(point)) {}

  /// False for a scan before the section, which the front end must not process.
  bool needs(Stamp stamp) const { return stamp >= point_.first.stamp || point_.from_beginning(); }
  /// Returns false for a scan that the session has already. Otherwise pose and key frame of
  /// `result` are transformed to the run of the session. Throws InputError if the recording is not
  /// that of the session, and ResumeFailure if the repeated section ends at another pose than
  /// before.
  bool accepts(front_end::FrontEndResult& result);

 private:
  void align_to_session(const front_end::FrontEndResult& result);

  ResumePoint point_;
  Pose T_session_front_end_;
  bool has_begun_ = false;
  bool is_aligned_ = false;
  std::optional<KeyFrame> newest_;  ///< Newest key frame of the front end.
  Pose T_first_;  ///< Pose of the front end at the first key frame of the section.
  KeyFrameIndex index_offset_ = 0;
  std::uint32_t segment_offset_ = 0;
};

}  // namespace lidar_mapping::pipeline
