// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/session/session.hpp"

#include <cmath>
#include <limits>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"

#include "session_impl.hpp"
#include "session_schema.hpp"

namespace lidar_mapping::session {

namespace {

namespace fs = std::filesystem;

// Chosen: readers of an older one have time to finish; each takes space.
constexpr std::int64_t kKeptRevisions = 10;

std::string indented(const std::string& yaml) {
  std::string text = yaml.empty() ? "" : "  ";
  for (std::size_t i = 0; i < yaml.size(); ++i) {
    text += yaml[i];
    if (yaml[i] == '\n' && i + 1 < yaml.size() && yaml[i + 1] != '\n') text += "  ";
  }
  return text;
}

}  // namespace

Session::Batch::Batch(Session& session)
    : transaction_(std::make_unique<Transaction>(session.impl_->database)) {}
Session::Batch::~Batch() = default;
void Session::Batch::commit() { transaction_->commit(); }

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;
Session::~Session() = default;

Session Session::create(const fs::path& root, std::time_t now) {
  return create_in(make_run_folder(root, now));
}

Session Session::create_in(const fs::path& directory) {
  if (fs::exists(directory / "session.db")) {
    throw FileError(directory.string() +
                    " holds a session already; name another folder or resume it");
  }
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) throw FileError("cannot make " + directory.string() + ": " + error.message());
  Session session(std::make_unique<Impl>(directory, Database::Mode::kCreate));
  create_tables(session.impl_->database);
  return session;
}

Session Session::open(const fs::path& directory, Access access) {
  const auto mode = access == Access::kRead ? Database::Mode::kRead : Database::Mode::kWrite;
  const fs::path found = find_session(directory);
  Session session(std::make_unique<Impl>(found, mode));
  if (access == Access::kWrite && is_empty(session.impl_->database)) {
    create_tables(session.impl_->database);
  }
  check_tables(session.impl_->database, found / "session.db");
  if (access == Access::kWrite) upgrade_tables(session.impl_->database);
  return session;
}

const fs::path& Session::directory() const { return impl_->directory; }
CloudStore& Session::clouds() const { return impl_->clouds; }

void Session::add_key_frame(const KeyFrame& key_frame) {
  Statement known = impl_->database.query("SELECT 1 FROM key_frames WHERE key_frame = ?",
                                          {std::int64_t{key_frame.index}});
  if (known.step()) {
    throw InputError("key frame " + std::to_string(key_frame.index) +
                     " is in the session already; one run must not use an index twice");
  }
  const Cells cells = to_cells(key_frame);  // before its cloud is written: it may be refused
  if (key_frame.cloud && !impl_->clouds.is_cached(key_frame.index, key_frame.cloud)) {
    impl_->clouds.put(key_frame.index, key_frame.cloud);
  }
  impl_->insert("INSERT", "key_frames", cells);
}

void Session::add_loop(const Loop& loop) {
  impl_->insert("INSERT OR REPLACE", "loops", to_cells(loop));
}

void Session::set_loop_decision(KeyFrameIndex from, KeyFrameIndex to, LoopDecision decision) {
  impl_->insert("INSERT OR REPLACE", "loop_decisions",
                {std::int64_t{from}, std::int64_t{to}, std::string(to_string(decision))});
}

void Session::add_verdict(const LoopVerdict& verdict) {
  impl_->insert("INSERT", "loop_verdicts", to_cells(verdict));
}

void Session::add_gnss(const GnssPosition& position) {
  impl_->insert("INSERT OR IGNORE", "gnss", to_cells(position));
}

void Session::add_imu(const ImuSample& sample_base) {
  impl_->insert("INSERT OR IGNORE", "imu", to_cells(sample_base));
}

/// A number that is none would be read back as 0.
void Session::add_floor(const Floor& floor) {
  if (!std::isfinite(floor.offset)) {
    throw InputError("a floor at a distance of " + std::to_string(floor.offset) +
                     " cannot be stored in a session");
  }
  impl_->insert("INSERT OR IGNORE", "floors", to_cells(floor));
}

void Session::add_scan(const ScanRecord& scan) {
  impl_->insert("INSERT OR IGNORE", "scans", to_cells(scan));
}

void Session::add_odometry(const ScanOdometry& scan) {
  impl_->insert("INSERT OR IGNORE", "odometry", to_cells(scan));
  impl_->newest_drive.reset();
}

void Session::add_odometry(Stamp stamp, const Pose& T_odom_base) {
  if (!impl_->newest_drive) {
    Statement newest = impl_->database.query("SELECT COALESCE(MAX(drive), 0) FROM odometry");
    constexpr std::int64_t kLargest = std::numeric_limits<std::uint32_t>::max();
    impl_->newest_drive =
        newest.step() ? static_cast<std::uint32_t>(newest.read_integer(0, kLargest)) : 0U;
  }
  const ScanOdometry scan{stamp, T_odom_base, *impl_->newest_drive};
  impl_->insert("INSERT OR IGNORE", "odometry", to_cells(scan));
}

void Session::set_poses(const KeyFramePoses& poses, const RevisionRecord& record,
                        std::optional<bool> in_enu) {
  if (!poses.whole) {
    throw InputError("the session keeps whole sets of poses only; revision " +
                     std::to_string(poses.revision) + " is a part");
  }
  Transaction transaction(impl_->database);
  const std::int64_t revision = poses.revision;
  impl_->database.run("DELETE FROM poses WHERE revision = ?", {revision});
  for (const KeyFramePose& pose : poses.poses) {
    Cells cells = to_cells(pose);
    cells.insert(cells.begin(), revision);
    impl_->insert("INSERT", "poses", cells);
  }
  impl_->database.run("DELETE FROM poses WHERE revision <= ?", {revision - kKeptRevisions});
  if (in_enu) {
    impl_->insert("INSERT OR REPLACE", "properties", {kInEnu, std::int64_t{*in_enu ? 1 : 0}});
  } else {
    impl_->database.run("DELETE FROM properties WHERE name = ?", {kInEnu});
  }
  set_revision(record);
  transaction.commit();
}

void Session::set_revision(const RevisionRecord& record) {
  impl_->insert("INSERT OR REPLACE", "revisions", to_cells(record));
}

void Session::set_run_id(const std::string& run_id) {
  impl_->insert("INSERT OR REPLACE", "properties", {"run_id", run_id});
}

void Session::set_datum(const GeodeticDatum& datum) {
  const Blob values{datum.latitude_deg, datum.longitude_deg, datum.altitude_m};
  impl_->insert("INSERT OR REPLACE", "properties", {"datum", values});
}

void Session::set_sensor_origin(const Eigen::Vector3d& p_base_sensor) {
  impl_->insert("INSERT OR REPLACE", "properties", {"sensor_origin", to_blob(p_base_sensor)});
}

void Session::set_configuration(const std::string& stage, const std::string& yaml) {
  impl_->insert("INSERT OR REPLACE", "configurations", {stage, yaml});
  std::string text;
  for (const auto& [name, fields] : configurations()) text += name + ":\n" + indented(fields);
  write_text_atomically(impl_->directory / "config.yaml", text);
}

}  // namespace lidar_mapping::session
