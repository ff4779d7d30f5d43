// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/voxel_index.hpp"

namespace lidar_mapping::registration {

/// Mean and covariance of the points of a voxel.
struct Gaussian {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();        ///< m, relative to the map's origin
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2
  int count = 0;                                         ///< number of points; 0: nothing there
};

/// How a voxel's points become a plane with a weight.
struct PlaneModel {
  int min_points = 5;         ///< a voxel with fewer has no plane
  double sigma = 0.015;       ///< m: of a point on a perfect plane
  double prior_points = 1.5;  ///< number of points of an isotropic blob, the prior doubt
  double prior_sigma = 0.15;  ///< m: standard deviation of that blob
  double line_ratio = 0.2;    ///< below this ratio of the two large eigenvalues it is distrusted
  double line_floor = 0.01;   ///< up to this ratio of them it is a line and no plane
  /// m: standard deviation along the middle axis that noise alone may have.
  double least_breadth = 0.03;
  double sure_breadth = 0.05;  ///< m: from this on it is the surface's own
  /// Thickness to breadth: up to this, what the sensor's rings see one by one is thin.
  double thin_ratio = 0.1;
  double thick_ratio = 0.3;  ///< thickness to breadth: from this on it is a bush
};

/// Plane of a voxel, scaled so that normal . p - offset is the distance of p in standard
/// deviations. A voxel without a plane has a normal of zero.
struct WeightedPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< 1/m: unit normal by standard deviation
  float offset = 0.0F;  ///< without unit; points are relative to the map's origin
};

/// Gaussians in a grid of voxels, in one flat hash table that is never rebuilt: points are added
/// one by one, and voxels that are far away are deleted by a hand that moves on through the table.
///
/// Points are floats relative to origin(), which stays near the sensor and is moved in whole
/// voxels, so that no precision is lost however far the drive goes. Sums are kept relative to the
/// voxel's centre and do not change when the origin moves. Planes are computed when they are asked
/// for and again when the voxel has grown by a tenth. One thread at a time uses a map.
///
/// A thin plate has two sides that are not in one place: a floor above the ceiling of the storey
/// below, a wall between two rooms. Where it is known from where points were seen, a voxel has a
/// Gaussian for each side of its plane, and a point finds the side that it can see.
class GaussianVoxelMap {
 public:
  /// A table for `capacity` voxels of edge `resolution` (m), rounded up to a power of two.
  GaussianVoxelMap(double resolution, std::size_t capacity, const PlaneModel& model = {});

  /// Edge of a voxel, m.
  double resolution() const { return resolution_; }
  /// Number of Gaussians; a voxel with two sides has two.
  std::size_t size() const { return size_; }
  /// The voxel whose lower corner is the origin, counted from that of the map's frame.
  const Eigen::Vector3i& origin_cell() const { return origin_cell_; }
  /// Where the origin is in the map's frame, m.
  Eigen::Vector3d origin() const { return resolution_ * origin_cell_.cast<double>(); }
  /// Moves the origin. The Gaussians stay where they are in the map's frame.
  void set_origin_cell(const Eigen::Vector3i& cell) { origin_cell_ = cell; }

  /// Deletes all Gaussians and the count of dropped points; the origin stays.
  void clear();
  /// Empties the map and goes on with voxels of another edge (m), in the same memory; the origin is
  /// to be set anew.
  void restart(double resolution);
  /// Adds `count` points, seen from `viewpoint` (all m, relative to the origin); those that find
  /// the table full are dropped and counted.
  void insert(const float* x, const float* y, const float* z, std::size_t count,
              const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt);
  /// Lets the hand pass over `share` (0 to 1) of the table and deletes what is farther than
  /// `radius` from `center` (m, relative to the origin).
  void forget_beyond(const Eigen::Vector3f& center, float radius, double share);
  /// Points that found no room since the map was cleared.
  std::size_t dropped_points() const { return dropped_points_; }
  /// Angle between neighbouring rings of the sensor, rad, about the map's z axis; 0 for none. Where
  /// a voxel is crossed by one ring at a time, the height of points in a bush is that of the ring,
  /// which goes along with the sensor: there such voxels say nothing about the height.
  void set_ring_spacing(double angle) { ring_spacing_ = static_cast<float>(angle); }

  /// Where the search for a voxel starts.
  struct Place {
    VoxelKey key;        ///< of the voxel in the map's frame
    std::uint32_t slot;  ///< first slot of the table that may hold it
  };
  /// Where to look for a voxel; `cell` counts from the origin's voxel.
  Place place_of(const Eigen::Vector3i& cell) const { return place_of(key_of(cell)); }
  /// Asks the processor to fetch a place that plane() will be asked for.
  void prefetch(const Place& place) const { __builtin_prefetch(&voxels_[place.slot]); }
  /// The plane of a voxel relative to the origin, that of the side seen first.
  WeightedPlane plane(const Eigen::Vector3i& cell) {
    return plane(cell, place_of(cell), Eigen::Vector3f::Zero());
  }
  /// The plane of a voxel whose front a sensor sees that lies in the direction `view` (of any
  /// length) from it.
  WeightedPlane plane(const Eigen::Vector3i& cell, const Place& place, const Eigen::Vector3f& view);
  /// The Gaussian of a voxel relative to the origin; its count is 0 where there is none.
  Gaussian gaussian(const Eigen::Vector3i& cell) const;
  /// All voxels, relative to the origin, in the order of their cells.
  std::vector<Gaussian> gaussians() const;

 private:
  /// One cache line. Sums are relative to the voxel's centre.
  struct alignas(64) Voxel {
    VoxelKey key = 0;  ///< 0 marks an empty slot
    std::array<float, 3> sum{};
    std::array<float, 6> products{};  ///< xx xy xz yy yz zz
    std::array<float, 3> normal{};    ///< until there is a plane the last point's view
    float offset = 0.0F;
    std::uint16_t count = 0;
    std::uint16_t count_at_plane : 15;
    std::uint16_t has_front : 1;  ///< the normal points to where the plane is seen from

    Voxel() : count_at_plane(0), has_front(0) {}
  };

  VoxelKey key_of(const VoxelIndex& cell) const;
  VoxelIndex cell_of(VoxelKey key) const;
  Place place_of(VoxelKey key) const { return {key, slot_of(key)}; }
  std::uint32_t slot_of(VoxelKey key) const {
    return static_cast<std::uint32_t>(fibonacci_hash(key) >> hash_shift_);
  }
  std::optional<std::uint32_t> find(const Place& place) const;
  Voxel* find_or_add(const Place& place);
  void add_point(Voxel* voxel, float px, float py, float pz);
  Voxel* side_seen(const Place& place, const Eigen::Vector3f& view);
  Voxel* with_plane(const Place& place, const Eigen::Vector3f& view);
  double loneliness(const Eigen::Vector3f& view) const;
  static void turn_to_front(Voxel& voxel, const Eigen::Vector3f& view);
  static bool is_behind(const Voxel& voxel, const Eigen::Vector3f& view);
  void erase(std::uint32_t slot);
  void update_plane(Voxel& voxel, double lone_rings) const;
  Gaussian gaussian_of(const Voxel& voxel) const;

  double resolution_;
  float inverse_resolution_;
  PlaneModel model_;
  Eigen::Vector3i origin_cell_ = Eigen::Vector3i::Zero();
  std::vector<Voxel> voxels_;
  /// Slots that have been used since the table was empty, up to a number beyond which all of it is
  /// cleared.
  std::vector<std::uint32_t> used_;
  std::size_t most_listed_ = 0;
  std::uint32_t mask_ = 0;
  std::size_t most_voxels_ = 0;
  int hash_shift_ = 0;
  std::uint32_t hand_ = 0;
  float ring_spacing_ = 0.0F;
  std::size_t size_ = 0;
  std::size_t dropped_points_ = 0;
};

}  // namespace lidar_mapping::registration
