// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "lidar_mapping/front_end/front_end.hpp"
#include "lidar_mapping/session/session.hpp"

namespace lidar_mapping::pipeline {

/// Where a session that was broken off is gone on with. The front end keeps a map of its
/// surroundings, which died with its process: it drives the last stretch once more to have it
/// again, and what it says of that stretch is thrown away.
struct ResumePoint {
  KeyFrame first;  ///< of the stretch
  KeyFrame last;   ///< of the session

  bool from_beginning() const { return first.index == 0; }
};

/// None for a session without key frames. The stretch is `way` (m) long, or begins with the first
/// key frame, as it always does with `whole`.
std::optional<ResumePoint> resume_point_of(const session::Session& session, double way, bool whole);

/// Makes what the front end says of the drive go on from the last key frame of a session.
class ResumedOdometry {
 public:
  explicit ResumedOdometry(ResumePoint point) : point_(std::move(point)) {}

  /// False for a scan in front of the stretch, which the front end must not see.
  bool wants(Stamp stamp) const { return stamp >= point_.first.stamp || point_.from_beginning(); }
  /// False for a scan that the session has already; otherwise pose and key frame are made those of
  /// the session's run. Throws InputError if the recording is not the session's, and
  /// ResumeFailure where the stretch came out otherwise than before.
  bool takes(front_end::FrontEndResult& result);

 private:
  void join(const front_end::FrontEndResult& result);

  ResumePoint point_;
  Pose T_session_front_end_;
  bool has_begun_ = false;
  bool is_joined_ = false;
  std::optional<KeyFrame> newest_;  ///< of the front end
  Pose T_first_;                    ///< what the front end said of the first key frame
  KeyFrameIndex index_offset_ = 0;
  std::uint32_t segment_offset_ = 0;
};

}  // namespace lidar_mapping::pipeline
