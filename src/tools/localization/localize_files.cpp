// SPDX-License-Identifier: BSD-3-Clause
#include "localization/localize_files.hpp"

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/geodetic.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/common/trajectory.hpp"
#include "lidar_mapping/common/units.hpp"
#include "lidar_mapping/common/utm.hpp"

namespace lidar_mapping::tools {

namespace {

namespace fs = std::filesystem;
using localization::LocalizationResult;

constexpr const char* kHead =
    "stamp,state,probability,x,y,z,qx,qy,qz,qw,stddev_x,stddev_y,stddev_z,stddev_roll_deg,"
    "stddev_pitch_deg,stddev_yaw_deg,agreement,coverage,hypotheses,path,segment";
constexpr const char* kHeadOnEarth = ",latitude_deg,longitude_deg,altitude_m,easting,northing";

// By definition: the empty cells of a scan without a pose.
constexpr const char* kNoPose = ",,,,,,,,,,,,,";
constexpr const char* kNoPlaceOnEarth = ",,,,,";

std::string pose_cells(const LocalizationResult& result) {
  const Eigen::Vector3d& p = result.T_map_base.translation;
  const Eigen::Quaterniond& q = result.T_map_base.rotation;
  const Vector6d stddev = result.covariance.diagonal().cwiseSqrt();
  return formatted(",%.4f,%.4f,%.4f,%.9f,%.9f,%.9f,%.9f", p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
                   q.w()) +
         formatted(",%.4f,%.4f,%.4f,%.4f,%.4f,%.4f", stddev[0], stddev[1], stddev[2],
                   stddev[3] * kDegPerRad, stddev[4] * kDegPerRad, stddev[5] * kDegPerRad);
}

/// The position of base_link on the Earth.
class EarthCells {
 public:
  explicit EarthCells(const GeodeticDatum& datum) : datum_(datum), utm_(datum) {}

  std::string of(const Eigen::Vector3d& p_enu) const {
    const Eigen::Vector3d geodetic = geodetic_positions(datum_, {p_enu}).front();
    const Eigen::Vector3d utm = utm_.from_enu(p_enu);
    return formatted(",%.9f,%.9f,%.4f,%.4f,%.4f", geodetic.y(), geodetic.x(), geodetic.z(), utm.x(),
                     utm.y());
  }

 private:
  GeodeticDatum datum_;
  UtmFrame utm_;
};

std::string row(const LocalizedScan& scan, const std::optional<EarthCells>& earth) {
  const LocalizationResult& result = scan.result;
  const bool has_pose = localization::has_pose(result.state);
  std::string text = seconds_text(result.stamp) + ',' + localization::to_string(result.state) +
                     formatted(",%.4f", result.probability);
  text += has_pose ? pose_cells(result) : kNoPose;
  text += formatted(",%.4f,%.4f,%zu,%.4f,%u", result.agreement, result.coverage, result.hypotheses,
                    scan.path, scan.segment);
  if (earth) text += has_pose ? earth->of(result.T_map_base.translation) : kNoPlaceOnEarth;
  return text + ",\"" + result.reason + "\"\n";
}

Trajectory in_map(const std::vector<LocalizedScan>& scans) {
  Trajectory trajectory;
  for (const LocalizedScan& scan : scans) {
    if (!localization::has_pose(scan.result.state)) continue;
    trajectory.poses.push_back({scan.result.stamp, scan.result.T_map_base});
  }
  return trajectory;
}

Trajectory by_odometry(const std::vector<LocalizedScan>& scans) {
  Trajectory trajectory;
  for (const LocalizedScan& scan : scans) {
    trajectory.poses.push_back({scan.result.stamp, scan.T_odom_base});
  }
  return trajectory;
}

}  // namespace

void check_session_folder(const fs::path& session, const fs::path& results) {
  check_new_folder(session);
  const fs::path from_session =
      fs::weakly_canonical(fs::absolute(results))
          .lexically_relative(fs::weakly_canonical(fs::absolute(session)));
  if (from_session.empty() || *from_session.begin() == "..") return;
  throw FileError("the results in " + results.string() + " would lie in the new session " +
                  session.string() + "; name another folder with -o or --extend");
}

std::string localization_csv(const std::vector<LocalizedScan>& scans,
                             const std::optional<GeodeticDatum>& datum) {
  std::optional<EarthCells> earth;
  if (datum) earth.emplace(*datum);
  std::string text = std::string(kHead) + (earth ? kHeadOnEarth : "") + ",reason\n";
  for (const LocalizedScan& scan : scans) text += row(scan, earth);
  return text;
}

void write_localization(const fs::path& folder, const std::vector<LocalizedScan>& scans,
                        const std::optional<GeodeticDatum>& datum) {
  const fs::path trajectories = folder / "trajectory";
  write_text_atomically(trajectories / "localized.tum", to_tum(in_map(scans)));
  write_text_atomically(trajectories / "laser_odom_scans.tum", to_tum(by_odometry(scans)));
  write_text_atomically(folder / "localization.csv", localization_csv(scans, datum));
}

}  // namespace lidar_mapping::tools
