#pragma once

#include <optional>
#include <string>

#include "lidar_mapping/preprocessing/extrinsics.hpp"
#include "lidar_mapping/preprocessing/heading_check.hpp"
#include "lidar_mapping/preprocessing/local_frame.hpp"
#include "lidar_mapping/preprocessing/sensor_stream.hpp"

namespace lidar_mapping::preprocessing {

/// What became of a fix: refused with a sentence why, or taken.
struct FixVerdict {
  Insertion insertion = Insertion::kRefused;
  std::string problem;
};

/// GNSS fixes as a track in the local frame.
class GnssTrack {
 public:
  GnssTrack(const PreprocessingConfig& config, const Extrinsics& extrinsics);

  FixVerdict add(GnssFix fix, const std::string& frame_id);
  /// The antenna at `stamp` between two good fixes, with its lever arm; no orientation yet.
  std::optional<GnssPosition> at(Stamp stamp) const;
  /// Whether R_enu_base may be used at this position (imu_orientation).
  bool trusts_heading(const GnssPosition& position, const Eigen::Quaterniond& R_enu_base,
                      bool backwards);

  const SensorStream<LocalFix>& stream() const { return stream_; }
  const HeadingCheck& heading_check() const { return heading_check_; }
  std::optional<GeodeticDatum> datum() const { return local_frame_.datum(); }
  void give_up_if_silent() { stream_.give_up_if_silent(); }
  /// Forgets the fixes; the datum stays.
  void clear();

 private:
  PreprocessingConfig config_;
  const Extrinsics& extrinsics_;
  LocalFrame local_frame_;
  SensorStream<LocalFix> stream_;
  HeadingCheck heading_check_;
};

}  // namespace lidar_mapping::preprocessing
