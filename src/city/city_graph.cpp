// SPDX-License-Identifier: BSD-3-Clause
#include "city_graph.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/new_folder.hpp"
#include "lidar_mapping/common/order_statistics.hpp"
#include "lidar_mapping/common/sorted_values.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::city {

namespace {

namespace fs = std::filesystem;
using pipeline::SessionPart;
using session::Session;

// m, median distance of a drive's poses from its positions up to which its own map counts as turned
// to East-North-Up. Chosen: above the noise of any receiver, far below the error of a map that is
// not.
constexpr double kAlignedDistance = 10.0;
// Loops with positions at both ends. Chosen: the median of fewer may be that of a false loop.
constexpr std::size_t kMinLoopsWithGnss = 3;

std::optional<GeodeticDatum> first_datum(const std::vector<fs::path>& sessions) {
  for (const fs::path& path : sessions) {
    const Session session = Session::open(path, Session::Access::kRead);
    if (session.datum() && !session.gnss().empty()) return session.datum();
  }
  return std::nullopt;
}

/// A loop between two drives with the indices of the city.
struct DriveLoop {
  std::size_t a = 0;
  std::size_t b = 0;
  Loop loop;
};

class CityGraph {
 public:
  CityGraph(const std::vector<fs::path>& sessions, const std::vector<PairLoops>& loops,
            const std::optional<GeodeticDatum>& datum, const back_end::BackEndConfig& config)
      : config_(config) {
    city_.datum = datum ? datum : first_datum(sessions);
    for (const fs::path& path : sessions) add_drive(path);
    for (const PairLoops& pair : loops) add_loops(pair);
  }

  JoinedCity join() {
    leave_out_contradicting_gnss();
    std::vector<int> parts = solve();
    for (std::size_t worst = contradicting_drive(usages_); worst < usages_.size();
         worst = contradicting_drive(usages_)) {
      detach(worst);
      parts = solve();
    }
    keep_largest_part(parts);
    for (const DriveLoop& loop : loops_) {
      if (is_in_city(loop.loop.from) && is_in_city(loop.loop.to)) city_.loops.push_back(loop.loop);
    }
    return std::move(city_);
  }

 private:
  void add_drive(const fs::path& path);
  void add_loops(const PairLoops& pair);
  std::size_t drive_of(const std::string& name) const;
  std::optional<Eigen::Quaterniond> heading_at(std::size_t drive, Stamp stamp) const;
  std::vector<GnssDisagreement> disagreements() const;
  void leave_out_contradicting_gnss();
  std::vector<int> solve();
  void add_to(back_end::BackEnd& back_end, std::size_t drive) const;
  void count_usage(const back_end::BackEnd& back_end);
  void detach(std::size_t drive);
  void keep_largest_part(const std::vector<int>& parts);
  bool is_in_city(KeyFrameIndex index) const { return kept_.count(index) > 0; }

  back_end::BackEndConfig config_;
  JoinedCity city_;
  std::vector<SessionPart> parts_;                             ///< of the drives
  std::vector<std::map<Stamp, Eigen::Quaterniond>> headings_;  ///< R_enu_base, where it is known
  std::vector<DriveLoop> loops_;
  std::vector<LoopUsage> usages_;
  std::set<KeyFrameIndex> kept_;
  pipeline::PartOffsets next_;
  std::set<Stamp> stamps_;
};

/// Orientations of the key frames in East-North-Up by the drive's own map; empty if that is not
/// turned to it. The axes of two datums in one town differ by a small fraction of a degree.
std::map<Stamp, Eigen::Quaterniond> headings_of(const Session& session, Stamp offset) {
  const std::map<Stamp, GnssPosition> positions = pipeline::by_stamp(session.gnss());
  std::map<Stamp, Eigen::Quaterniond> headings;
  std::vector<double> distances;
  for (const KeyFramePose& pose : session.poses().poses) {
    headings.emplace(pose.stamp + offset, pose.T_map_base.rotation);
    const auto position = positions.find(pose.stamp);
    if (position == positions.end()) continue;
    const Eigen::Vector3d p_enu = position->second.p_enu_base(pose.T_map_base.rotation);
    distances.push_back((p_enu - pose.T_map_base.translation).head<2>().norm());
  }
  if (distances.empty() || median(distances) > kAlignedDistance) return {};
  return headings;
}

void CityGraph::add_drive(const fs::path& path) {
  const Session session = Session::open(path, Session::Access::kRead);
  JoinedDrive drive;
  drive.name = drive_name(path);
  drive.session = path;
  drive.offsets = next_;
  drive.offsets.stamp = pipeline::unique_stamp_offset(pipeline::stamps_of(session), stamps_);
  stamps_.merge(pipeline::stamps_of(session, drive.offsets.stamp));
  const std::vector<GnssPosition> gnss = pipeline::gnss_in_frame_of(city_.datum, session);
  if (gnss.empty() && !session.gnss().empty()) {
    drive.notices.push_back("the datum of its GNSS positions is not known; they are left out");
  }
  parts_.push_back(pipeline::read_part(session, drive.offsets, gnss));
  headings_.push_back(headings_of(session, drive.offsets.stamp));
  drive.key_frames = parts_.back().key_frames;
  drive.has_gnss = drive.uses_gnss = !gnss.empty();
  if (!drive.key_frames.empty()) next_ = pipeline::offsets_behind(drive.key_frames);
  city_.drives.push_back(std::move(drive));
}

std::size_t CityGraph::drive_of(const std::string& name) const {
  for (std::size_t i = 0; i < city_.drives.size(); ++i) {
    if (city_.drives[i].name == name) return i;
  }
  throw InputError("loops with a drive '" + name +
                   "' that is not among the sessions; name its session, or leave the loops out");
}

/// The key frame with this index of the city; null if the drive does not have it.
const KeyFrame* find_key_frame(const SessionPart& part, KeyFrameIndex index) {
  const auto found = find_index(part.key_frames, index);
  return found != part.key_frames.end() ? &*found : nullptr;
}

void CityGraph::add_loops(const PairLoops& pair) {
  const std::size_t a = drive_of(pair.a), b = drive_of(pair.b);
  for (Loop loop : pair.loops) {
    loop.from += city_.drives[a].offsets.index;
    loop.to += city_.drives[b].offsets.index;
    loop.stamp += city_.drives[b].offsets.stamp;
    if (!find_key_frame(parts_[a], loop.from) || !find_key_frame(parts_[b], loop.to)) {
      throw InputError("loops between '" + pair.a + "' and '" + pair.b +
                       "' name key frames that the sessions do not have; search them again");
    }
    loops_.push_back({a, b, loop});
  }
}

/// Where GNSS places the newer key frame of a loop, relative to where GNSS of the other drive and
/// the loop place it, with the claimed accuracy of both positions.
struct LoopOffset {
  Eigen::Vector2d offset;
  double stddev_a;
  double stddev_b;
};

GnssDisagreement median_of(std::size_t a, std::size_t b, const std::vector<LoopOffset>& offsets) {
  std::vector<double> east, north, stddev_a, stddev_b;
  for (const LoopOffset& entry : offsets) {
    east.push_back(entry.offset.x());
    north.push_back(entry.offset.y());
    stddev_a.push_back(entry.stddev_a);
    stddev_b.push_back(entry.stddev_b);
  }
  return {a, b, {median(east), median(north)}, allowed_offset(median(stddev_a), median(stddev_b))};
}

std::optional<Eigen::Quaterniond> CityGraph::heading_at(std::size_t drive, Stamp stamp) const {
  const auto found = headings_[drive].find(stamp);
  if (found == headings_[drive].end()) return std::nullopt;
  return found->second;
}

std::vector<GnssDisagreement> CityGraph::disagreements() const {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<LoopOffset>> offsets;
  for (const auto& [a, b, loop] : loops_) {
    const Stamp stamp_a = find_key_frame(parts_[a], loop.from)->stamp;
    const Stamp stamp_b = find_key_frame(parts_[b], loop.to)->stamp;
    const auto position_a = parts_[a].gnss.find(stamp_a);
    const auto position_b = parts_[b].gnss.find(stamp_b);
    const auto R_enu_a = heading_at(a, stamp_a), R_enu_b = heading_at(b, stamp_b);
    if (position_a == parts_[a].gnss.end() || position_b == parts_[b].gnss.end()) continue;
    if (!R_enu_a || !R_enu_b) continue;
    const Eigen::Vector3d by_loop =
        position_a->second.p_enu_base(*R_enu_a) + *R_enu_a * loop.T_from_to.translation;
    const Eigen::Vector3d by_gnss = position_b->second.p_enu_base(*R_enu_b);
    offsets[{a, b}].push_back({(by_gnss - by_loop).head<2>(),
                               horizontal_stddev(position_a->second.covariance),
                               horizontal_stddev(position_b->second.covariance)});
  }
  std::vector<GnssDisagreement> result;
  for (const auto& [pair, values] : offsets) {
    if (values.size() < kMinLoopsWithGnss) continue;
    result.push_back(median_of(pair.first, pair.second, values));
  }
  return result;
}

void CityGraph::leave_out_contradicting_gnss() {
  for (const ContradictingGnss& bad : contradicting_gnss(disagreements())) {
    JoinedDrive& drive = city_.drives[bad.drive];
    parts_[bad.drive].gnss.clear();
    drive.uses_gnss = false;
    drive.notices.push_back(formatted(
        "its GNSS positions are not used: according to loops they are %.1f m away from those of "
        "%s; they contradict %zu drives and agree with %zu",
        bad.offset, city_.drives[bad.other_drive].name.c_str(), bad.contradicted, bad.confirmed));
  }
}

void CityGraph::add_to(back_end::BackEnd& back_end, std::size_t drive) const {
  for (const KeyFrame& key_frame : city_.drives[drive].key_frames) {
    back_end.add_key_frame(key_frame);
    add_measurements(parts_[drive], key_frame.stamp, back_end);
  }
  for (const auto& [newer, loop] : parts_[drive].loops) back_end.add_loop(loop);
}

/// Solves the graph of the drives that are not detached; the connected part of each key frame.
std::vector<int> CityGraph::solve() {
  back_end::BackEnd back_end(config_);
  for (std::size_t drive = 0; drive < city_.drives.size(); ++drive) add_to(back_end, drive);
  // The graph refuses loops of key frames that it does not have.
  for (const DriveLoop& loop : loops_) back_end.add_loop(loop.loop);
  back_end.apply(*back_end::solve(*back_end.problem(true)));
  count_usage(back_end);
  return back_end.parts();
}

void CityGraph::count_usage(const back_end::BackEnd& back_end) {
  std::set<std::pair<KeyFrameIndex, KeyFrameIndex>> used;
  for (const auto& [loop, is_used] : back_end.loops()) {
    if (is_used) used.emplace(loop.from, loop.to);
  }
  usages_.assign(city_.drives.size(), {});
  for (const auto& [a, b, loop] : loops_) {
    if (city_.drives[a].key_frames.empty() || city_.drives[b].key_frames.empty()) continue;
    const bool is_used = used.count({loop.from, loop.to}) > 0;
    for (const std::size_t drive : {a, b}) {
      ++(is_used ? usages_[drive].used : usages_[drive].refused);
    }
  }
  for (std::size_t drive = 0; drive < usages_.size(); ++drive) {
    if (city_.drives[drive].state == DriveState::kJoined) {
      city_.drives[drive].loops = usages_[drive];
    }
  }
}

void CityGraph::detach(std::size_t drive_number) {
  JoinedDrive& drive = city_.drives[drive_number];
  drive.state = DriveState::kDetached;
  drive.notices.push_back(
      formatted("it contradicts the other drives: the graph refuses %zu of its loops to them and "
                "uses %zu; the report of this drive may show the cause",
                drive.loops.refused, drive.loops.used));
  drive.left_out = drive.key_frames.size();
  drive.key_frames.clear();
}

/// Leaves out all key frames that nothing joins to the part with the most of them.
void CityGraph::keep_largest_part(const std::vector<int>& parts) {
  if (parts.empty()) return;
  std::map<int, std::size_t> sizes;
  for (const int part : parts) ++sizes[part];
  const auto largest = std::max_element(
      sizes.begin(), sizes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  std::size_t node = 0;
  for (JoinedDrive& drive : city_.drives) {
    std::vector<KeyFrame> kept;
    for (const KeyFrame& key_frame : drive.key_frames) {
      if (parts[node++] == largest->first) kept.push_back(key_frame);
    }
    for (const KeyFrame& key_frame : kept) kept_.insert(key_frame.index);
    if (drive.state == DriveState::kDetached) continue;
    drive.left_out = drive.key_frames.size() - kept.size();
    drive.key_frames = std::move(kept);
    if (drive.left_out == 0) continue;
    if (drive.key_frames.empty()) drive.state = DriveState::kUnconnected;
    drive.notices.push_back(
        formatted("neither a loop nor GNSS connects %zu of its %zu key frames to the city",
                  drive.left_out, drive.left_out + drive.key_frames.size()));
  }
}

}  // namespace

std::string drive_name(const fs::path& session) { return folder_path(session).filename().string(); }

const char* to_string(DriveState state) {
  switch (state) {
    case DriveState::kJoined:
      return "joined";
    case DriveState::kDetached:
      return "detached";
    case DriveState::kUnconnected:
      break;
  }
  return "unconnected";
}

JoinedCity join_drives(const std::vector<fs::path>& sessions, const std::vector<PairLoops>& loops,
                       const std::optional<GeodeticDatum>& datum,
                       const back_end::BackEndConfig& config) {
  return CityGraph(sessions, loops, datum, config).join();
}

}  // namespace lidar_mapping::city
