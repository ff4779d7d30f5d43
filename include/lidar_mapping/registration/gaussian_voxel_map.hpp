// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "lidar_mapping/common/voxel_index.hpp"
#include "lidar_mapping/registration/voxel_table.hpp"

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
  double line_ratio =
      0.2;  ///< middle to largest eigenvalue: from this on the plane has full weight
  double line_floor = 0.01;  ///< up to this ratio the points are a line, and the weight is zero
  /// m: standard deviation along the middle axis that noise alone may cause; weight zero.
  double least_breadth = 0.03;
  double sure_breadth = 0.05;  ///< m: from this on the breadth is that of a surface; full weight
  /// Thickness to breadth: up to this, what isolated rings hit is a plane.
  double thin_ratio = 0.1;
  double thick_ratio = 0.3;  ///< thickness to breadth: from this on it is a bush

  /// Of voxels of several metres, whose planes are thick. Its sigma (m) is chosen so that the
  /// weight of a distant point still depends on its distance.
  static PlaneModel coarse() {
    PlaneModel model;
    model.sigma = 0.1;
    return model;
  }
};

/// Plane of a voxel, scaled so that normal . p - offset is the distance of p in standard
/// deviations. A voxel without a plane has a normal of zero.
struct WeightedPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< 1/m: unit normal by standard deviation
  float offset = 0.0F;  ///< without unit; points are relative to the map's origin
};

/// Gaussians in a grid of voxels, in one flat hash table that is not rebuilt by itself: points are
/// added one by one, and voxels that are far away are removed in small portions (remove_beyond()).
///
/// Points are floats relative to origin(), which stays near the sensor and is moved in whole
/// voxels, so that no precision is lost however long the path is. Sums are stored relative to the
/// voxel's centre and do not change when the origin moves. Planes are computed on demand, and again
/// when the voxel has 10 % more points. One thread at a time uses a map.
///
/// A thin plate has two sides that are not in one place: a floor above the ceiling of the storey
/// below, a wall between two rooms. Where insert() knows the viewpoint, a voxel has a Gaussian for
/// each side of its plane, and a point is matched with the side that faces the sensor.
class GaussianVoxelMap {
 public:
  /// A table for `capacity` voxels of edge `resolution` (m), rounded up to a power of two.
  GaussianVoxelMap(double resolution, std::size_t capacity, const PlaneModel& model = {});

  /// Edge of a voxel, m.
  double resolution() const { return resolution_; }
  /// Number of Gaussians; a voxel with two sides has two.
  std::size_t size() const { return table_.size(); }
  /// Where the origin is in the map's frame, m.
  Eigen::Vector3d origin() const { return resolution_ * origin_cell_.cast<double>(); }
  /// Moves the origin to the lower corner of this voxel of the map's frame. The Gaussians do not
  /// move in that frame.
  void set_origin_cell(const VoxelIndex& cell) { origin_cell_ = cell; }

  /// Deletes all Gaussians and the count of dropped points; the origin stays.
  void clear();
  /// Empties the map, changes the voxels' edge (m) and resets the origin; the memory is reused.
  void restart(double resolution);
  /// Adds `count` points, observed from `viewpoint` (all m, relative to the origin). Points for
  /// which the full table has no voxel are dropped and counted.
  void insert(const float* x, const float* y, const float* z, std::size_t count,
              const std::optional<Eigen::Vector3f>& viewpoint = std::nullopt);
  /// Computes the planes of the voxels that these points are in, as a match with them does. A voxel
  /// has two sides only behind that: what is inserted before any match has to be followed by it.
  void update_planes(const float* x, const float* y, const float* z, std::size_t count,
                     const Eigen::Vector3f& viewpoint);
  /// Visits the next `fraction` (0 to 1) of the table and removes voxels farther than `radius` from
  /// `center` (m, relative to the origin).
  void remove_beyond(const Eigen::Vector3f& center, float radius, double fraction);
  /// Number of points that were dropped since the map was cleared.
  std::size_t dropped_points() const { return dropped_points_; }
  /// Angle between neighbouring rings of the sensor, rad, about the map's z axis; 0 for none. Where
  /// a voxel is crossed by one ring at a time, the points in a bush have the height of the ring,
  /// which moves with the sensor. Such voxels give no information about the height.
  void set_ring_spacing(double angle) { ring_spacing_ = static_cast<float>(angle); }

  /// The voxels as they are stored, for those who keep a part of them elsewhere. A key is that of
  /// the voxel in the map's frame, whatever the origin, and has one more bit, which
  /// voxel_index(key) ignores, for the second side. A voxel that is put back with its key is the
  /// same as before, bit for bit, with its plane.
  VoxelTable& table() { return table_; }
  /// The voxels as they are stored.
  const VoxelTable& table() const { return table_; }

  /// Where the search for a voxel starts; `cell` counts from the origin's voxel.
  VoxelTable::Slot slot_of(const VoxelIndex& cell) const {
    return table_.slot_of(voxel_key(cell + origin_cell_));
  }
  /// Asks the processor to fetch a slot that plane() will be called with.
  void prefetch(const VoxelTable::Slot& slot) const { table_.prefetch(slot); }
  /// The plane of a voxel relative to the origin, that of the side observed first.
  WeightedPlane plane(const VoxelIndex& cell) {
    return plane(cell, slot_of(cell), Eigen::Vector3f::Zero());
  }
  /// The plane of the side of a voxel that faces a sensor in the direction `view` (of any length).
  WeightedPlane plane(const VoxelIndex& cell, const VoxelTable::Slot& slot,
                      const Eigen::Vector3f& view);
  /// The Gaussian of a voxel relative to the origin; its count is 0 where there is none.
  Gaussian gaussian(const VoxelIndex& cell) const;
  /// All voxels, relative to the origin, in the order of their cells.
  std::vector<Gaussian> gaussians() const;

 private:
  VoxelIndex cell_of(VoxelKey key) const { return voxel_index(key) - origin_cell_; }
  void add_point(VoxelSums* voxel, float px, float py, float pz);
  VoxelSums* observed_side(const VoxelTable::Slot& slot, const Eigen::Vector3f& view);
  VoxelSums* with_plane(const VoxelTable::Slot& slot, const Eigen::Vector3f& view);
  double ring_isolation(const Eigen::Vector3f& view) const;
  void update_plane(VoxelSums& voxel, double isolation) const;
  Gaussian gaussian_of(const VoxelSums& voxel) const;

  double resolution_;
  float inverse_resolution_;
  PlaneModel model_;
  VoxelTable table_;
  VoxelIndex origin_cell_ = VoxelIndex::Zero();
  float ring_spacing_ = 0.0F;
  std::size_t dropped_points_ = 0;
};

}  // namespace lidar_mapping::registration
