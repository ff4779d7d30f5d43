// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar_mapping/common/floor.hpp"
#include "lidar_mapping/common/key_frame.hpp"
#include "lidar_mapping/common/loop.hpp"
#include "lidar_mapping/common/sensor_data.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

namespace lidar_mapping::session {

/// What the front end said of one scan.
struct ScanRecord {
  Stamp stamp = 0;
  std::string state;  ///< tracking, degenerate, doubtful, degraded, lost or repeated
  double fitness = 0.0;
  double overlap = 0.0;
  double seconds = 0.0;
  std::int64_t scans_dropped = 0;  ///< since the start of the run
  /// Of the way since the start, from directions that nothing observed, m; 0: not known.
  double unobserved_stddev = 0.0;
  /// What the sensor's elevations lack, as far as it was known then, rad (ElevationShift).
  double elevation_shift = 0.0;
  /// That its step is right (FrontEndStatus::probability); negative: not known.
  double probability = -1.0;
};

/// What one optimisation did.
struct RevisionRecord {
  std::uint32_t revision = 0;
  std::size_t key_frames = 0;
  std::size_t loops_used = 0;
  std::size_t loops_refused = 0;
  std::size_t gnss_used = 0;
  std::size_t gnss_refused = 0;
  double cost_before = 0.0;
  double cost_after = 0.0;
  double seconds = 0.0;
};

/// Everything that is kept of a drive, in a folder of its own: session.db (SQLite) and
/// key_frames/000123.pcd (doc/session.md describes both). What an add_ function returned from is on
/// the disk whole; a killed process leaves nothing half written. Nothing is ever overwritten.
/// One thread at a time calls it, except clouds(), which any thread may use. All functions throw
/// FileError where the disk or the database says no; the session stays as it was.
class Session {
 public:
  enum class Access { kRead, kWrite };

  /// Makes one event of what is added while it lives: after commit() all of it is kept, without it
  /// nothing. Not for set_poses(), which is an event of its own.
  class Batch {
   public:
    explicit Batch(Session& session);
    ~Batch();
    void commit();

   private:
    class Impl;
    std::unique_ptr<Impl> impl_;
  };

  /// A new folder root/2011-10-03_12-55-34 (with -2, -3 ... where that exists), and a link
  /// root/latest to it. Missing parents are made.
  static Session create(const std::filesystem::path& root, std::time_t now);
  /// A session in `directory`, which must not hold one already; other files in it are left alone.
  static Session create_in(const std::filesystem::path& directory);
  /// An existing one. With kWrite it goes on; only one process at a time may write.
  static Session open(const std::filesystem::path& directory, Access access);

  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;
  ~Session();

  const std::filesystem::path& directory() const;
  CloudStore& clouds() const;

  /// Writes the cloud (if it has one that clouds() does not hold) and then the row. Throws
  /// InputError if the index is known.
  void add_key_frame(const KeyFrame& key_frame);
  /// A loop between the same two key frames takes the place of the older one.
  void add_loop(const Loop& loop);
  /// What a person said of the loop between the two; it stays when the loop is replaced.
  void set_loop_decision(KeyFrameIndex from, KeyFrameIndex to, LoopDecision decision);
  void add_verdict(const LoopVerdict& verdict);
  // Of two data with the same stamp the first stays.
  void add_gnss(const GnssPosition& position);
  void add_imu(const ImuSample& sample_base);
  void add_floor(const Floor& floor);
  void add_scan(const ScanRecord& scan);
  /// T_odom_base of a scan.
  void add_odometry(Stamp stamp, const Pose& T_odom_base);
  /// All poses of a revision. The last ten revisions are kept.
  void set_poses(const KeyFramePoses& poses, const RevisionRecord& record);

  /// Name of the run as it stands in messages; empty if unknown.
  void set_run_id(const std::string& run_id);
  void set_datum(const GeodeticDatum& datum);
  /// Where the LiDAR is in base_link, m: rays start there.
  void set_sensor_origin(const Eigen::Vector3d& p_base_sensor);
  /// The fields of one stage as YAML. Also written to config.yaml.
  void set_configuration(const std::string& stage, const std::string& yaml);

  std::vector<KeyFrame> key_frames() const;  ///< by index, without clouds
  /// Without its cloud; none if the index is not known. Costs a look-up, however long the drive is.
  std::optional<KeyFrame> key_frame(KeyFrameIndex index) const;
  std::size_t key_frame_count() const;
  std::vector<Loop> loops() const;  ///< in the order in which they came
  std::vector<LoopVerdict> verdicts() const;
  std::vector<GnssPosition> gnss() const;
  std::vector<ImuSample> imu() const;
  std::vector<Floor> floors() const;
  std::vector<ScanRecord> scans() const;
  std::vector<std::pair<Stamp, Pose>> odometry() const;
  KeyFramePoses poses() const;  ///< of the newest revision; revision 0 and empty if there is none
  std::vector<RevisionRecord> revisions() const;
  std::string run_id() const;
  std::optional<GeodeticDatum> datum() const;
  std::optional<Eigen::Vector3d> sensor_origin() const;
  std::map<std::string, std::string> configurations() const;

 private:
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A session in `directory`, which must be empty or not be there: it appears when `fill` has
/// returned, and nothing is left where that threw.
Session create_filled(const std::filesystem::path& directory,
                      const std::function<void(Session&)>& fill);
/// The same in a new folder as Session::create() names them.
Session create_filled(const std::filesystem::path& root, std::time_t now,
                      const std::function<void(Session&)>& fill);

/// Finds the session that `path` means: a session's folder, or a root with a link `latest`. Throws
/// FileError if there is none.
std::filesystem::path find_session(const std::filesystem::path& path);

}  // namespace lidar_mapping::session
