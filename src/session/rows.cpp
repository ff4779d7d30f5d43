#include "rows.hpp"

namespace lidar_mapping::session {

namespace {

void append(Cells& cells, const std::optional<Eigen::Quaterniond>& rotation) {
  if (rotation) {
    session::append(cells, *rotation);
  } else {
    cells.insert(cells.end(), 4, nullptr);
  }
}

std::optional<Eigen::Quaterniond> take_optional_quaternion(Statement& row) {
  if (!row.next_is_null()) return row.take_quaternion();
  row.skip(4);
  return std::nullopt;
}

KeyFrameIndex take_index(Statement& row) { return static_cast<KeyFrameIndex>(row.take_integer()); }
std::size_t take_count(Statement& row) { return static_cast<std::size_t>(row.take_integer()); }

Blob to_blob(const std::vector<Eigen::Vector3d>& vectors) {
  Blob blob;
  for (const Eigen::Vector3d& vector : vectors) {
    blob.insert(blob.end(), vector.data(), vector.data() + 3);
  }
  return blob;
}

std::vector<Eigen::Vector3d> to_vectors(const Blob& blob) {
  std::vector<Eigen::Vector3d> vectors;
  for (std::size_t i = 0; i + 3 <= blob.size(); i += 3) {
    vectors.emplace_back(blob[i], blob[i + 1], blob[i + 2]);
  }
  return vectors;
}

}  // namespace

Cells to_cells(const KeyFrame& key_frame) {
  Cells cells{std::int64_t{key_frame.index}, std::int64_t{key_frame.segment}, key_frame.stamp};
  session::append(cells, key_frame.T_odom_base);
  cells.emplace_back(session::to_blob(key_frame.motion_covariance));
  cells.emplace_back(to_blob(key_frame.degenerate_directions));
  cells.emplace_back(std::int64_t(key_frame.cloud ? key_frame.cloud->size() : 0));
  return cells;
}

KeyFrame read_key_frame(Statement& row) {
  KeyFrame key_frame;
  key_frame.index = take_index(row);
  key_frame.segment = static_cast<std::uint32_t>(row.take_integer());
  key_frame.stamp = row.take_integer();
  key_frame.T_odom_base = row.take_pose();
  key_frame.motion_covariance = to_matrix<Covariance6>(row.take_blob());
  key_frame.degenerate_directions = to_vectors(row.take_blob());
  return key_frame;
}

Cells to_cells(const Loop& loop) {
  Cells cells{std::int64_t{loop.from}, std::int64_t{loop.to}, loop.stamp};
  session::append(cells, loop.T_from_to);
  cells.emplace_back(session::to_blob(loop.covariance));
  cells.emplace_back(loop.fitness);
  cells.emplace_back(loop.overlap);
  cells.emplace_back(std::string(to_string(loop.source)));
  return cells;
}

Loop read_loop(Statement& row) {
  row.skip(1);
  Loop loop;
  loop.from = take_index(row);
  loop.to = take_index(row);
  loop.stamp = row.take_integer();
  loop.T_from_to = row.take_pose();
  loop.covariance = to_matrix<Covariance6>(row.take_blob());
  loop.fitness = row.take_real();
  loop.overlap = row.take_real();
  loop.source = loop_source_from(row.take_text());
  return loop;
}

Cells to_cells(const LoopVerdict& verdict) {
  return {std::int64_t{verdict.from},
          std::int64_t{verdict.to},
          verdict.stamp,
          std::string(to_string(verdict.source)),
          std::string(to_string(verdict.verdict)),
          verdict.reason,
          verdict.distance,
          verdict.fitness,
          verdict.overlap,
          verdict.free_space_violation,
          verdict.horizontal_eigenvalue,
          verdict.innovation};
}

LoopVerdict read_verdict(Statement& row) {
  row.skip(1);
  LoopVerdict verdict;
  verdict.from = take_index(row);
  verdict.to = take_index(row);
  verdict.stamp = row.take_integer();
  verdict.source = loop_source_from(row.take_text());
  verdict.verdict = verdict_from(row.take_text());
  verdict.reason = row.take_text();
  verdict.distance = row.take_real();
  verdict.fitness = row.take_real();
  verdict.overlap = row.take_real();
  verdict.free_space_violation = row.take_real();
  verdict.horizontal_eigenvalue = row.take_real();
  verdict.innovation = row.take_real();
  return verdict;
}

Cells to_cells(const GnssPosition& position) {
  Cells cells{position.stamp};
  session::append(cells, position.p_enu_antenna);
  cells.emplace_back(session::to_blob(position.covariance));
  session::append(cells, position.p_base_antenna);
  append(cells, position.R_enu_base);
  return cells;
}

GnssPosition read_gnss(Statement& row) {
  GnssPosition position;
  position.stamp = row.take_integer();
  position.p_enu_antenna = row.take_vector();
  position.covariance = to_matrix<Eigen::Matrix3d>(row.take_blob());
  position.p_base_antenna = row.take_vector();
  position.R_enu_base = take_optional_quaternion(row);
  return position;
}

Cells to_cells(const ImuSample& sample) {
  Cells cells{sample.stamp};
  session::append(cells, sample.angular_velocity);
  session::append(cells, sample.linear_acceleration);
  append(cells, sample.orientation);
  return cells;
}

ImuSample read_imu(Statement& row) {
  ImuSample sample;
  sample.stamp = row.take_integer();
  sample.angular_velocity = row.take_vector();
  sample.linear_acceleration = row.take_vector();
  sample.orientation = take_optional_quaternion(row);
  return sample;
}

Cells to_cells(const Floor& floor) {
  Cells cells{floor.stamp, std::int64_t{floor.found ? 1 : 0}};
  session::append(cells, floor.normal);
  cells.emplace_back(floor.offset);
  cells.emplace_back(session::to_blob(floor.covariance));
  cells.emplace_back(std::int64_t{floor.inliers});
  return cells;
}

Floor read_floor(Statement& row) {
  Floor floor;
  floor.stamp = row.take_integer();
  floor.found = row.take_integer() != 0;
  floor.normal = row.take_vector();
  floor.offset = row.take_real();
  floor.covariance = to_matrix<Eigen::Matrix3d>(row.take_blob());
  floor.inliers = static_cast<int>(row.take_integer());
  return floor;
}

Cells to_cells(const ScanRecord& scan) {
  return {scan.stamp, scan.state, scan.fitness, scan.overlap, scan.seconds, scan.scans_dropped};
}

ScanRecord read_scan(Statement& row) {
  ScanRecord scan;
  scan.stamp = row.take_integer();
  scan.state = row.take_text();
  scan.fitness = row.take_real();
  scan.overlap = row.take_real();
  scan.seconds = row.take_real();
  scan.scans_dropped = row.take_integer();
  return scan;
}

std::pair<Stamp, Pose> read_odometry(Statement& row) {
  const Stamp stamp = row.take_integer();
  return {stamp, row.take_pose()};
}

KeyFramePose read_pose(Statement& row) {
  KeyFramePose pose;
  pose.index = take_index(row);
  pose.stamp = row.take_integer();
  pose.T_map_base = row.take_pose();
  return pose;
}

Cells to_cells(const RevisionRecord& record) {
  return {std::int64_t{record.revision},
          std::int64_t(record.key_frames),
          std::int64_t(record.loops_used),
          std::int64_t(record.loops_refused),
          std::int64_t(record.gnss_used),
          std::int64_t(record.gnss_refused),
          record.cost_before,
          record.cost_after,
          record.seconds};
}

RevisionRecord read_revision(Statement& row) {
  RevisionRecord record;
  record.revision = static_cast<std::uint32_t>(row.take_integer());
  record.key_frames = take_count(row);
  record.loops_used = take_count(row);
  record.loops_refused = take_count(row);
  record.gnss_used = take_count(row);
  record.gnss_refused = take_count(row);
  record.cost_before = row.take_real();
  record.cost_after = row.take_real();
  record.seconds = row.take_real();
  return record;
}

}  // namespace lidar_mapping::session
