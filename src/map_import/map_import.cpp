// SPDX-License-Identifier: BSD-3-Clause
#include "map_import.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/geodetic.hpp"
#include "lidar_mapping/common/parallel.hpp"
#include "lidar_mapping/common/text.hpp"

#include "imported_session.hpp"
#include "places.hpp"
#include "visible_cloud.hpp"

namespace lidar_mapping::map_import {

namespace {

/// Places whose clouds are computed together. Chosen: several for each thread, 10 MB of clouds.
constexpr std::size_t kBatch = 16;
/// Points that a place has to see. Chosen: min_tested_points of loop closing, with which a place is
/// judged.
constexpr std::size_t kFewestPoints = 300;
/// m from the origin, up to which the session keeps the map's coordinates. Chosen: that of
/// check_range() in src/map/files/map_files.cpp, up to which floats hold the centimetre.
constexpr double kFarFromOrigin = 1e5;
constexpr double kMetresPerKm = 1000.0;  // by definition
/// m. Chosen: a number that is easy to add.
constexpr double kRoundOrigin = 1000.0;

double farthest(const Eigen::AlignedBox3d& bounds) {
  return std::max(bounds.min().cwiseAbs().maxCoeff(), bounds.max().cwiseAbs().maxCoeff());
}

/// Of the session's frame in that of the map. The places decide: a stray point may lie anywhere.
Eigen::Vector3d origin_of(const std::vector<Place>& places) {
  Eigen::AlignedBox3d bounds;
  for (const Place& place : places) bounds.extend(place.T_map_base.translation);
  if (farthest(bounds) <= kFarFromOrigin) return Eigen::Vector3d::Zero();
  return kRoundOrigin * (bounds.center() / kRoundOrigin).array().round().matrix();
}

class Import {
 public:
  Import(const ImportOptions& options, session::Session& session, const ImportLine& report,
         const ImportProgress& progress)
      : options_(options),
        report_(report),
        progress_(progress),
        tiles_(session.directory(), options.resolution),
        writer_(session) {}

  void run() {
    // Read first, so that an unreadable file is reported at once.
    std::optional<Trajectory> trajectory;
    if (!options_.trajectory.empty()) trajectory = read_trajectory(options_.trajectory);
    read_map();
    const std::vector<Place> places =
        trajectory ? places_along(*trajectory, options_.spacing) : places_on_the_ground();
    if (places.empty()) refuse_places();
    describe(origin_of(places));
    add_key_frames(places);
    if (writer_.key_frames() == 0) refuse_places();
    writer_.finish();
    report_(formatted(
        "key frames: %zu, %.0f points each", writer_.key_frames(),
        static_cast<double>(writer_.points()) / static_cast<double>(writer_.key_frames())));
  }

 private:
  void read_map() {
    const std::vector<std::filesystem::path> files = map_files(options_.map);
    for (const auto& file : files) {
      read_points(file, [this](const std::vector<MapPoint>& points) { tiles_.add(points); });
    }
    if (tiles_.points() == 0) {
      throw InputError("the map " + options_.map.string() + " has no points");
    }
    tiles_.finish();
    report_(formatted("map: %llu points in %zu files, %llu after thinning to %g m",
                      static_cast<unsigned long long>(tiles_.points()), files.size(),
                      static_cast<unsigned long long>(tiles_.thinned()), options_.resolution));
  }

  std::vector<Place> places_on_the_ground() {
    const std::vector<OpenCell> ground = find_open_ground(ground_cells(tiles_));
    if (ground.empty()) {
      throw InputError("no ground is found in " + options_.map.string() +
                       " (level, 40 m^2 and more, with 2 m free above it); give the poses of the "
                       "drive that made the map with --trajectory");
    }
    report_(formatted("ground: %.0f m^2", static_cast<double>(ground.size()) *  //
                                              kGroundCell * kGroundCell));
    return places_on_ground(ground, options_.spacing, options_.base_height);
  }

  [[noreturn]] void refuse_places() const {
    if (options_.trajectory.empty()) {
      throw InputError("no place on the ground of " + options_.map.string() +
                       " sees enough of the map; give a denser map, or the poses of the drive that "
                       "made it with --trajectory");
    }
    throw InputError("no pose of " + options_.trajectory + " is in the map " +
                     options_.map.string() + "; both have to be in the same frame");
  }

  /// Decides on the frame of the session, and writes what belongs to it as a whole.
  void describe(const Eigen::Vector3d& origin) {
    const auto beside = options_.datum ? std::nullopt : datum_beside(options_.map);
    const std::optional<GeodeticDatum> datum = options_.datum ? options_.datum : beside;
    if (datum && !is_place(*datum)) {
      throw InputError(
          "the datum is no place on Earth; give latitude and longitude in degrees, and "
          "the height in m");
    }
    if (datum && !origin.isZero()) {
      throw InputError("the map " + options_.map.string() + " lies " +
                       std::to_string(std::lround(origin.norm())) +
                       " m from its datum, so it is in no East-North-Up frame; leave the datum "
                       "out");
    }
    if (datum) {
      report_(formatted("datum: %.9f %.9f deg, %.3f m", datum->latitude_deg, datum->longitude_deg,
                        datum->altitude_m));
    }
    if (!origin.isZero()) {
      report_(formatted("the session's coordinates are those of the map minus %.0f %.0f %.0f",
                        origin.x(), origin.y(), origin.z()));
    }
    report_stray_points(origin);
    writer_.describe(options_, origin, p_base_lidar(), datum);
  }

  void report_stray_points(const Eigen::Vector3d& origin) {
    const Eigen::AlignedBox3d& bounds = tiles_.bounds();
    if (farthest({bounds.min() - origin, bounds.max() - origin}) <= kFarFromOrigin) return;
    const std::uint64_t stray =
        tiles_.points_outside({origin.array() - kFarFromOrigin, origin.array() + kFarFromOrigin});
    report_(
        formatted("points that lie more than %.0f km from the places, of which none sees "
                  "them: %llu after thinning; remove them from the map if they are strays",
                  kFarFromOrigin / kMetresPerKm, static_cast<unsigned long long>(stray)));
  }

  Eigen::Vector3d p_base_lidar() const {
    return {0.0, 0.0, options_.sensor_height - options_.base_height};
  }

  std::vector<PointTilePtr> tiles_around(const Place& place) {
    std::vector<PointTilePtr> tiles;
    for (const PointTileIndex& index :
         tiles_.indices_around(place.T_map_base * p_base_lidar(), kSight)) {
      tiles.push_back(tiles_.tile(index));
    }
    return tiles;
  }

  void add_key_frames(const std::vector<Place>& places) {
    for (std::size_t begin = 0; begin < places.size(); begin += kBatch) {
      const std::size_t count = std::min(kBatch, places.size() - begin);
      std::vector<std::vector<PointTilePtr>> tiles;
      for (std::size_t i = 0; i < count; ++i) tiles.push_back(tiles_around(places[begin + i]));
      std::vector<PointCloud> clouds(count);
      parallel_chunks(count, 1, options_.threads, [&](std::size_t i, std::size_t) {
        clouds[i] = visible_cloud(tiles[i], places[begin + i].T_map_base, p_base_lidar(),
                                  options_.resolution);
      });
      for (std::size_t i = 0; i < count; ++i) {
        if (clouds[i].size() >= kFewestPoints) writer_.add(places[begin + i], std::move(clouds[i]));
      }
      progress_(begin + count, places.size());
    }
  }

  const ImportOptions& options_;
  const ImportLine& report_;
  const ImportProgress& progress_;
  PointTiles tiles_;
  SessionWriter writer_;
};

}  // namespace

void import_map(const ImportOptions& options, session::Session& session, const ImportLine& report,
                const ImportProgress& progress) {
  Import(options, session, report, progress).run();
}

}  // namespace lidar_mapping::map_import
