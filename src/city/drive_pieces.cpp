// SPDX-License-Identifier: BSD-3-Clause
#include "drive_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>

#include "lidar_mapping/loop_closing/key_frame_preparation.hpp"

namespace lidar_mapping::city {

namespace {

// m of path. Chosen: a piece has several key frames also at the spacing of a motorway, and the box
// of a winding one does not cover other streets.
constexpr double kPieceLength = 100.0;
// m of path between two places whose appearance is kept. Chosen: half of the reach of a view's
// match (15 m), so that a place of another drive always has one within reach.
constexpr double kPlaceSpacing = 7.0;
// Steps per unit of a key, as in coarse_key.cpp.
constexpr float kStepsPerUnit = 128.0F;
// The largest number of a byte, by its format.
constexpr float kMaxStep = 255.0F;

AppearanceKey rounded(const loop_closing::SpectrumDescriptor::Key& key) {
  AppearanceKey result{};
  for (std::size_t i = 0; i < result.size(); ++i) {
    const float steps = std::floor(key[static_cast<Eigen::Index>(i)] * kStepsPerUnit + 0.5F);
    result[i] = static_cast<std::uint8_t>(std::clamp(steps, 0.0F, kMaxStep));
  }
  return result;
}

/// Positions by GNSS, earth-centred and earth-fixed at height 0, by the stamp of the key frame.
std::map<Stamp, Eigen::Vector3d> earth_positions(const session::Session& session) {
  std::map<Stamp, Eigen::Vector3d> result;
  const auto datum = session.datum();
  if (!datum) return result;
  const GeographicLib::LocalCartesian local(datum->latitude_deg, datum->longitude_deg,
                                            datum->altitude_m);
  for (const GnssPosition& position : session.gnss()) {
    const Eigen::Vector3d& p = position.p_enu_antenna;
    double latitude = 0.0, longitude = 0.0, height = 0.0;
    local.Reverse(p.x(), p.y(), 0.0, latitude, longitude, height);
    Eigen::Vector3d earth;
    GeographicLib::Geocentric::WGS84().Forward(latitude, longitude, 0.0, earth.x(), earth.y(),
                                               earth.z());
    result.emplace(position.stamp, earth);
  }
  return result;
}

/// Cuts a drive into pieces, key frame by key frame.
class PieceCutter {
 public:
  explicit PieceCutter(const session::Session& session)
      : session_(session), positions_(earth_positions(session)), preparation_({}) {}

  void add(const KeyFrame& key_frame) {
    const bool begins = begins_piece(key_frame);
    if (begins) begin_piece(key_frame);
    pieces_.back().last = key_frame.index;
    const auto position = positions_.find(key_frame.stamp);
    if (position != positions_.end()) extend_box(pieces_.back(), position->second);
    if (begins || travelled_ - last_place_ >= kPlaceSpacing) add_place(key_frame.index);
    before_ = key_frame;
  }
  std::vector<Piece> take() { return std::move(pieces_); }

 private:
  bool begins_piece(const KeyFrame& key_frame) {
    if (!before_ || before_->segment != key_frame.segment) return true;
    travelled_ += (key_frame.T_odom_base.translation - before_->T_odom_base.translation).norm();
    return travelled_ - piece_begin_ >= kPieceLength;
  }

  void begin_piece(const KeyFrame& key_frame) {
    pieces_.emplace_back();
    pieces_.back().first = key_frame.index;
    piece_begin_ = travelled_;
  }

  static void extend_box(Piece& piece, const Eigen::Vector3d& position) {
    if (!piece.box) piece.box.emplace();
    piece.box->extend(position);
  }

  void add_place(KeyFrameIndex index) {
    const PointCloudPtr cloud = session_.clouds().cloud(index);
    if (!cloud || cloud->points.empty()) return;
    const auto prepared = preparation_.prepare(*cloud);
    pieces_.back().places.push_back(rounded(prepared.appearance->descriptor.key()));
    last_place_ = travelled_;
  }

  const session::Session& session_;
  const std::map<Stamp, Eigen::Vector3d> positions_;
  loop_closing::KeyFramePreparation preparation_;
  std::vector<Piece> pieces_;
  std::optional<KeyFrame> before_;
  double travelled_ = 0.0;
  double piece_begin_ = 0.0;
  double last_place_ = 0.0;
};

}  // namespace

double distance_between(const AppearanceKey& a, const AppearanceKey& b) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::int32_t difference = a[i] - b[i];
    sum += difference * difference;
  }
  return std::sqrt(static_cast<double>(sum)) / static_cast<double>(kStepsPerUnit);
}

DrivePieces describe_drive(const session::Session& session, const std::string& name) {
  PieceCutter cutter(session);
  for (const KeyFrame& key_frame : session.key_frames()) cutter.add(key_frame);
  return {name, cutter.take()};
}

}  // namespace lidar_mapping::city
