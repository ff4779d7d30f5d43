// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include "lidar_mapping/common/errors.hpp"

#include "session_impl.hpp"
#include "session_schema.hpp"

namespace lidar_mapping::session {

namespace {

constexpr double kHighest = 1e6;  // m above the ellipsoid; chosen: only damage is to be found

std::optional<Eigen::Vector3d> vector_property(const Database& database, const std::string& name) {
  Statement row = database.query("SELECT value FROM properties WHERE name = ?", {name});
  if (!row.step()) return std::nullopt;
  const Blob values = row.read_blob(3);
  return Eigen::Vector3d(values[0], values[1], values[2]);
}

}  // namespace

std::vector<KeyFrame> Session::key_frames() const {
  return impl_->all<KeyFrame>("SELECT " + columns_of_key_frames(impl_->database) +
                              " FROM key_frames ORDER BY key_frame");
}

std::optional<KeyFrame> Session::key_frame(KeyFrameIndex index) const {
  Statement row = impl_->database.query(
      "SELECT " + columns_of_key_frames(impl_->database) + " FROM key_frames WHERE key_frame = ?",
      {std::int64_t{index}});
  if (!row.step()) return std::nullopt;
  return from_row<KeyFrame>(row);
}

std::size_t Session::key_frame_count() const {
  Statement row = impl_->database.query("SELECT COUNT(*) FROM key_frames");
  return row.step() ? static_cast<std::size_t>(row.read_integer()) : 0;
}

std::vector<Loop> Session::loops() const {
  if (!has_loop_decisions(impl_->database)) {
    return impl_->all<Loop>("SELECT *, 'auto' FROM loops ORDER BY id");
  }
  return impl_->all<Loop>(
      "SELECT loops.*, COALESCE(decision, 'auto') FROM loops "
      "LEFT JOIN loop_decisions USING (from_key_frame, to_key_frame) ORDER BY id");
}

std::vector<LoopVerdict> Session::verdicts() const {
  return impl_->all<LoopVerdict>("SELECT * FROM loop_verdicts ORDER BY id");
}

std::vector<GnssPosition> Session::gnss() const {
  return impl_->all<GnssPosition>("SELECT * FROM gnss ORDER BY stamp");
}

std::vector<ImuSample> Session::imu() const {
  return impl_->all<ImuSample>("SELECT * FROM imu ORDER BY stamp");
}

std::vector<Floor> Session::floors() const {
  return impl_->all<Floor>("SELECT * FROM floors ORDER BY stamp");
}

std::vector<ScanRecord> Session::scans() const {
  return impl_->all<ScanRecord>("SELECT " + columns_of_scans(impl_->database) +
                                " FROM scans ORDER BY stamp");
}

std::vector<ScanOdometry> Session::odometry() const {
  return impl_->all<ScanOdometry>("SELECT " + columns_of_odometry(impl_->database) +
                                  " FROM odometry ORDER BY stamp");
}

KeyFramePoses Session::poses() const {
  KeyFramePoses poses;
  // While this statement lives, both see the session as it was when the first one began.
  Statement newest = impl_->database.query("SELECT MAX(revision) FROM poses");
  if (!newest.step()) return poses;
  poses.revision =
      static_cast<std::uint32_t>(newest.read_integer(0, std::numeric_limits<std::uint32_t>::max()));
  Statement row = impl_->database.query(
      "SELECT key_frame, stamp, x, y, z, qx, qy, qz, qw FROM poses WHERE revision = ? "
      "ORDER BY key_frame",
      {std::int64_t{poses.revision}});
  while (row.step()) poses.poses.push_back(from_row<KeyFramePose>(row));
  return poses;
}

std::optional<bool> Session::poses_in_enu() const {
  Statement row = impl_->database.query("SELECT value FROM properties WHERE name = ?", {kInEnu});
  if (!row.step()) return std::nullopt;
  return row.read_integer() != 0;
}

std::vector<RevisionRecord> Session::revisions() const {
  return impl_->all<RevisionRecord>("SELECT * FROM revisions ORDER BY revision");
}

std::string Session::run_id() const {
  Statement row = impl_->database.query("SELECT value FROM properties WHERE name = 'run_id'");
  return row.step() ? row.read_text() : std::string();
}

std::optional<GeodeticDatum> Session::datum() const {
  const std::optional<Eigen::Vector3d> values = vector_property(impl_->database, "datum");
  if (!values) return std::nullopt;
  const bool is_on_earth = std::abs(values->x()) <= 90.0 && std::abs(values->y()) <= 360.0 &&
                           std::abs(values->z()) <= kHighest;
  if (!is_on_earth) {
    throw FileError((impl_->directory / "session.db").string() +
                    ": its datum is no place on Earth; the session is damaged");
  }
  return GeodeticDatum{values->x(), values->y(), values->z()};
}

std::optional<Eigen::Vector3d> Session::sensor_origin() const {
  return vector_property(impl_->database, "sensor_origin");
}

std::map<std::string, std::string> Session::configurations() const {
  std::map<std::string, std::string> result;
  Statement row = impl_->database.query("SELECT stage, yaml FROM configurations");
  while (row.step()) {
    const std::string stage = row.read_text();
    result[stage] = row.read_text();
  }
  return result;
}

}  // namespace lidar_mapping::session
