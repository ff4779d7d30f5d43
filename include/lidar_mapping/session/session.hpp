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
#include "lidar_mapping/common/usage_counts.hpp"
#include "lidar_mapping/session/cloud_store.hpp"

namespace lidar_mapping::session {

class Transaction;

/// The front end's status of one scan.
struct ScanRecord {
  Stamp stamp = 0;                 ///< stamp of the scan
  std::string state;               ///< tracking, degenerate, doubtful, degraded, lost or repeated
  double fitness = 0.0;            ///< mean squared distance of the paired points, m^2
  double overlap = 0.0;            ///< fraction of the points with a partner, 0 to 1
  double seconds = 0.0;            ///< computing time of the scan
  std::int64_t scans_dropped = 0;  ///< number of scans not matched since the start
  /// Standard deviation of the distance travelled since the start, as far as it comes from
  /// directions that were not observed, m; 0: not known.
  double unobserved_stddev = 0.0;
  /// Error of the sensor's elevation angles as estimated at this scan, rad
  /// (FrontEndStatus::elevation_shift).
  double elevation_shift = 0.0;
  /// Probability that the step to this scan is correct (FrontEndStatus::probability), if known.
  std::optional<double> probability;
};

/// The pose of one scan by odometry.
struct ScanOdometry {
  Stamp stamp = 0;   ///< stamp of the scan
  Pose T_odom_base;  ///< pose of base_link
  /// Number of the drive that the scan is of, if several were merged: the poses of one drive are
  /// those of one vehicle, while drives may overlap in time. The drives of a session of an older
  /// version all have the number 0.
  std::uint32_t drive = 0;
};

/// The result of one optimisation in figures, as in OptimizationReport.
struct RevisionRecord : UsageCounts {
  std::uint32_t revision = 0;  ///< number of the optimisation, increasing
  std::size_t key_frames = 0;  ///< number of key frames in the graph
  double cost_before = 0.0;    ///< chi2 before the optimisation, without unit
  double cost_after = 0.0;     ///< chi2 after the optimisation, without unit
  double seconds = 0.0;        ///< computing time
};

/// All stored data of a drive, in a folder of its own: session.db (SQLite) and files such as
/// key_frames/000123.pcd (doc/session.md describes both). When an add_ or set_ function returns,
/// its data are stored completely; a process that is killed leaves no partial data. Existing data
/// of sensors are never overwritten. The class may be called from one thread at a time, except
/// clouds(), which is thread-safe. All functions throw FileError if disk or database fail. Data
/// that could not be read back, such as a coordinate that is not finite, are refused with
/// InputError. The session is then unchanged.
class Session {
 public:
  /// How a session is opened.
  enum class Access {
    kRead,  ///< only reading; another process may write at the same time
    kWrite  ///< reading and writing; only one process at a time
  };

  /// A transaction: the data added during the lifetime of this object are stored together by
  /// commit(), or not at all without it. set_poses() must not be called meanwhile: it is a
  /// transaction of its own.
  class Batch {
   public:
    /// Begins the transaction. The session must outlive it.
    explicit Batch(Session& session);
    /// Discards the data unless commit() was called.
    ~Batch();
    /// Stores the data.
    void commit();

   private:
    std::unique_ptr<Transaction> transaction_;
  };

  /// Creates a session in a new folder such as root/2011-10-03_12-55-34 (with -2, -3 ... if that
  /// exists), and a link root/latest to it. Missing parent folders are created.
  static Session create(const std::filesystem::path& root, std::time_t now);
  /// Creates a session in `directory`, which must not contain one. Other files in the folder are
  /// not touched.
  static Session create_in(const std::filesystem::path& directory);
  /// Opens an existing session. A session of an older version is read as it is, and upgraded if it
  /// is opened for writing.
  static Session open(const std::filesystem::path& directory, Access access);

  /// Takes over the session of another object, which must not be used afterwards.
  Session(Session&&) noexcept;
  /// Closes this session and takes over the other one.
  Session& operator=(Session&&) noexcept;
  /// Closes the session.
  ~Session();

  /// Folder of the session.
  const std::filesystem::path& directory() const;
  /// The clouds of the key frames.
  CloudStore& clouds() const;

  /// Stores a key frame and its cloud. The cloud is not written if it is empty (null) or in the
  /// cache of clouds() already. Throws InputError if the index is stored already.
  void add_key_frame(const KeyFrame& key_frame);
  /// Stores a loop. It replaces an older loop between the same two key frames.
  void add_loop(const Loop& loop);
  /// Stores the decision of a person on the loop between two key frames. It is kept if the loop is
  /// replaced.
  void set_loop_decision(KeyFrameIndex from, KeyFrameIndex to, LoopDecision decision);
  /// Stores the verdict on a candidate or loop; earlier verdicts are kept.
  void add_verdict(const LoopVerdict& verdict);
  /// Stores a GNSS position, unless there is one with the same stamp.
  void add_gnss(const GnssPosition& position);
  /// Stores an IMU sample in the axes of base_link, unless there is one with the same stamp.
  void add_imu(const ImuSample& sample_base);
  /// Stores a floor in base_link, unless there is one with the same stamp.
  void add_floor(const Floor& floor);
  /// Stores the status of a scan, unless there is one with the same stamp.
  void add_scan(const ScanRecord& scan);
  /// Stores the pose of a scan by odometry, unless there is one with the same stamp.
  void add_odometry(const ScanOdometry& scan);
  /// The same for a scan of the drive that the session knows last.
  void add_odometry(Stamp stamp, const Pose& T_odom_base);
  /// Stores all poses of a revision and the figures of its optimisation, and whether the poses lie
  /// in East-North-Up, if that is known. The poses of the last ten revisions are kept. Throws
  /// InputError if `poses` are not those of the whole map.
  void set_poses(const KeyFramePoses& poses, const RevisionRecord& record,
                 std::optional<bool> in_enu = std::nullopt);
  /// Stores the figures of an optimisation whose poses are not stored.
  void set_revision(const RevisionRecord& record);

  /// Stores the name of the run as in messages.
  void set_run_id(const std::string& run_id);
  /// Stores the geodetic origin of the map.
  void set_datum(const GeodeticDatum& datum);
  /// Stores the position of the LiDAR in base_link (m), where the rays of the points start.
  void set_sensor_origin(const Eigen::Vector3d& p_base_sensor);
  /// Stores the parameters of one stage as YAML. All stages are also written to config.yaml.
  void set_configuration(const std::string& stage, const std::string& yaml);

  /// All key frames by increasing index, without clouds.
  std::vector<KeyFrame> key_frames() const;
  /// One key frame without its cloud; empty if the index is unknown. The time does not depend on
  /// the length of the drive.
  std::optional<KeyFrame> key_frame(KeyFrameIndex index) const;
  /// Number of key frames.
  std::size_t key_frame_count() const;
  /// All loops with the decisions on them, in the order in which they were stored.
  std::vector<Loop> loops() const;
  /// All verdicts in the order in which they were stored.
  std::vector<LoopVerdict> verdicts() const;
  /// All GNSS positions by stamp.
  std::vector<GnssPosition> gnss() const;
  /// All IMU samples by stamp.
  std::vector<ImuSample> imu() const;
  /// All floors by stamp.
  std::vector<Floor> floors() const;
  /// The status of all scans by stamp.
  std::vector<ScanRecord> scans() const;
  /// T_odom_base of all scans by stamp.
  std::vector<ScanOdometry> odometry() const;
  /// The poses T_map_base of the newest revision that has stored ones; empty with revision 0 if
  /// there is none.
  KeyFramePoses poses() const;
  /// Whether these poses lie in East-North-Up (see map_datum.hpp); empty if unknown, as in a
  /// session of an older version.
  std::optional<bool> poses_in_enu() const;
  /// The figures of all optimisations by revision, also of those whose poses are not stored.
  std::vector<RevisionRecord> revisions() const;
  /// Name of the run; empty if unknown.
  std::string run_id() const;
  /// Geodetic origin of the positions of GNSS; empty if unknown. The poses may lie elsewhere:
  /// map_datum.hpp has the origin of the map.
  std::optional<GeodeticDatum> datum() const;
  /// Position of the LiDAR in base_link, m; empty if unknown.
  std::optional<Eigen::Vector3d> sensor_origin() const;
  /// Parameters as YAML by the name of the stage.
  std::map<std::string, std::string> configurations() const;

 private:
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Creates a session in `directory`, which must be empty or not exist, and stores data in it by
/// `fill`. The session appears when `fill` has returned; if it throws, nothing is left.
Session create_filled(const std::filesystem::path& directory,
                      const std::function<void(Session&)>& fill);
/// The same in a new folder with a name as by Session::create().
Session create_filled(const std::filesystem::path& root, std::time_t now,
                      const std::function<void(Session&)>& fill);

/// The folder of the session at `path`: the path itself, or the link `latest` in it. Throws
/// FileError if there is no session.
std::filesystem::path find_session(const std::filesystem::path& path);

}  // namespace lidar_mapping::session
